//! The price of shadows in `pipelines/umbra.json`, on whatever adapter there is.
//!
//! The price is the GPU time of shading and of the passes of the shadow term, minus the time of the same passes without
//! shadows. Drawing the maps is not part of it. Ambient occlusion, bloom and FXAA are off. The variants are drawn in turn,
//! so that other work on the machine slows all of them. Each time is the minimum of several frames after the first.
//!
//! A GPU draws 1920 × 1080; a software driver draws a quarter of the pixels.
//!
//! `cargo bench --bench price`

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "measure.rs"]
mod measure;

use std::time::Duration;

use common::gpu::{Host, scene};
use common::{Outcome, With, check_file, root};
use umbragraph_test_support::gpu;

type Setting = (&'static str, &'static str);

/// Effects that cost the same with and without shadows.
const EFFECTS_OFF: [Setting; 3] = [("ambient_occlusion", "false"), ("bloom", "false"), ("fxaa", "false")];

/// A name, and features over [`EFFECTS_OFF`]. The first has no shadows.
const VARIANTS: [(&str, &[Setting]); 4] = [
    ("without", &[("spot_shadows", "false"), ("point_shadows", "false"), ("directional_shadows", "false")]),
    ("hard", &[("light_filter", "\"hard\"")]),
    ("filters", &[("depth_bounds", "false")]),
    ("bounds", &[("depth_bounds", "true")]),
];

/// The indices of the variants in [`VARIANTS`].
const WITHOUT: usize = 0;
const FILTERS: usize = 2;
const BOUNDS: usize = 3;

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    let is_software = gpu.adapter.get_info().device_type == umbragraph::wgpu::DeviceType::Cpu;
    let size = if is_software { [960, 540] } else { [1920, 1080] };
    println!("on {}", gpu.name);
    let mut rows = Vec::new();
    for name in ["courtyard", "interior", "foliage"] {
        let scene = scene(&root().join(format!("examples/scenes/{name}.glb")));
        let input = scene.frame_input(f64::from(size[0]) / f64::from(size[1]), 0.0);
        let outcomes = VARIANTS.map(|(_, features)| variant(features, size));
        let mut hosts: Vec<_> = outcomes.iter().map(|outcome| Host::new(&gpu, outcome, &scene)).collect();
        for host in &mut hosts {
            host.picture(&input);
            if !host.executor.measure_gpu_times(true) {
                println!("the adapter has no timestamps");
                return;
            }
        }
        let mut least = [Duration::MAX; VARIANTS.len()];
        for _ in 0..gpu.frames() {
            for (host, least) in hosts.iter_mut().zip(&mut least) {
                host.frame(&input);
                *least = (*least).min(shading(host));
            }
        }
        let price = least.map(|time| time.saturating_sub(least[WITHOUT]).as_secs_f64() * 1e3);
        let ratio = price[BOUNDS] / price[FILTERS];
        println!("ratio price/{name} {ratio:.2}");
        let cells = price[WITHOUT + 1..].iter().map(|price| format!("{price:.1} ms"));
        let row = [format!("{name}, {} × {}", size[0], size[1])].into_iter().chain(cells);
        let row: Vec<String> = row.chain([format!("{ratio:.2}")]).collect();
        rows.push(<[String; 5]>::try_from(row).expect("a cell for each head"));
    }
    measure::table(["scene", "hard", "PCSS 16 + 16", "with `depth_bounds`", "ratio to PCSS"], &rows);
}

/// Plans `umbra` with features over [`EFFECTS_OFF`].
fn variant(features: &[Setting], size: [u32; 2]) -> Outcome {
    let features: Vec<Setting> = EFFECTS_OFF.iter().chain(features).copied().collect();
    check_file("pipelines/umbra.json", &With { features: &features, size: Some(size), ..With::default() })
}

/// Returns the GPU time of shading and of the passes of the shadow term in the last frame.
fn shading(host: &mut Host<'_>) -> Duration {
    let counted = ["shade", "transparent", "gather", "denoise", "depth_bounds"];
    let times = host.executor.gpu_times();
    let of_shading = times.into_iter().filter(|one| counted.iter().any(|begin| one.pass.starts_with(begin)));
    of_shading.map(|one| one.time).sum()
}
