//! Many lights in `pipelines/umbra.json`, on whatever adapter there is: the GPU time of shading by all lights, and of
//! shading by the lights that can reach a pixel (`clustered_lights`) with the pass that finds them.
//!
//! The lights have a range of 2 m, cast no shadows, and stand at random in the courtyard beside its own. The variants are
//! drawn in turn, so that other work on the machine slows all of them. Each time is the minimum of several frames after
//! the first.
//!
//! `cargo bench --bench lights`

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "measure.rs"]
mod measure;

use std::time::Duration;

use common::gpu::{Host, scene};
use common::{With, check_with, root};
use serde_json::json;
use umbragraph::frame::{Light, LightKind};
use umbragraph_test_support::gpu;
use umbragraph_test_support::random::Random;

const SIZE: [u32; 2] = [640, 360];
const COUNTS: [usize; 3] = [10, 100, 1000];

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    println!("on {}", gpu.name);
    let courtyard = scene(&root().join("examples/scenes/courtyard.glb"));
    let outcomes = [false, true].map(|is_clustered| {
        let with = With { parameters: &[("light_capacity", "1024")], size: Some(SIZE), ..With::default() };
        let text = json!({
            "format": 1, "name": "many_lights", "extends": "pipelines/umbra.json",
            "derived": { "clustered_lights": is_clustered }, "passes": {},
        });
        check_with("many_lights.json", &text.to_string(), &with)
    });
    let mut hosts: Vec<_> = outcomes.iter().map(|outcome| Host::new(&gpu, outcome, &courtyard)).collect();
    let mut first = None;
    let mut rows = Vec::new();
    for count in COUNTS {
        let mut input = courtyard.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
        input.lights.extend(lamps(count));
        let mut least = [Duration::MAX; 2];
        for host in &mut hosts {
            host.picture(&input);
            if !host.executor.measure_gpu_times(true) {
                println!("the adapter has no timestamps");
                return;
            }
        }
        for _ in 0..gpu.frames() {
            for (host, least) in hosts.iter_mut().zip(&mut least) {
                host.frame(&input);
                *least = (*least).min(shading(host));
            }
        }
        let times = least.map(|time| time.as_secs_f64() * 1e3);
        let of_ten = *first.get_or_insert(times);
        let ratios = [times[0] / of_ten[0], times[1] / of_ten[1]];
        println!("ratio lights/{count} {:.2}", ratios[1]);
        rows.push([
            format!("{count}"),
            format!("{:.1} ms", times[0]),
            format!("{:.2}", ratios[0]),
            format!("{:.1} ms", times[1]),
            format!("{:.2}", ratios[1]),
        ]);
    }
    measure::table(["lights", "all", "ratio to 10", "clustered", "ratio to 10"], &rows);
}

/// Lights of 2 m range at random places; every third is a spot.
fn lamps(count: usize) -> impl Iterator<Item = Light> {
    let mut random = Random(5);
    (0..count).map(move |at| {
        let kind = if at % 3 == 0 {
            LightKind::Spot { inner_angle: 0.2, outer_angle: 0.3 + 0.9 * random.unit() as f32 }
        } else {
            LightKind::Point
        };
        let place = [random.unit() * 24.0 - 12.0, 0.2 + 2.8 * random.unit(), random.unit() * 24.0 - 12.0];
        let color = [random.unit() as f32, random.unit() as f32, random.unit() as f32];
        Light::new(format!("lamp {at}"), kind).position(place).color(color).intensity(3.0).range(2.0)
    })
}

/// Returns the GPU time of shading and of the search for lights in the last frame.
fn shading(host: &mut Host<'_>) -> Duration {
    let counted = ["shade", "transparent", "cluster_lights"];
    let times = host.executor.gpu_times();
    let of_shading = times.into_iter().filter(|one| counted.iter().any(|begin| one.pass.starts_with(begin)));
    of_shading.map(|one| one.time).sum()
}
