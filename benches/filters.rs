//! Shadow filters of `pipelines/awsm.json` at 1920 × 1080: the time of each on each kind of light, on whatever adapter
//! there is.
//!
//! The figure of `examples/scenes/figure.glb` fills the picture; one light shines. Timestamps give the time that the GPU
//! takes to draw the maps, to write and blur moments, and to shade all pixels with the filter in it: the minimum of several
//! frames. Lines `ratio filters/KIND/FILTER VALUE` are moments and shading, divided by shading
//! with the filter "hard" in the same run.
//!
//! The claims beside are what other systems say of theirs, on a desktop GPU of 2020 at 1920 × 1080 with four cascades:
//! 9 taps 0.3 ms; grids of 3 × 3, 5 × 5 and 7 × 7 and a disc of 64 taps 0.3, 0.5, 0.9 and 1.2 ms.
//!
//! `cargo bench --bench filters`

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "measure.rs"]
mod measure;

use std::time::Duration;

use common::gpu::{Host, scene};
use common::{With, check_file, root};
use glam::DVec3;
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};

const SIZE: [u32; 2] = [1920, 1080];

type Setting = (&'static str, &'static str);

const MOMENTS: &[Setting] = &[("moment_cascades", "\"all\""), ("moment_spots", "true")];

/// A filter to measure: name, features, parameters, and the time in milliseconds that another system claims for it
/// (`None` if unknown).
type Filter = (&'static str, &'static [Setting], &'static [Setting], Option<f64>);

const FILTERS: [Filter; 13] = [
    ("hard", &[("light_filter", "\"hard\"")], &[], None),
    ("grid_3", &[("light_filter", "\"grid_pcf\"")], &[("grid_pcf_side", "3")], Some(0.3)),
    ("grid_5", &[("light_filter", "\"grid_pcf\"")], &[("grid_pcf_side", "5")], Some(0.5)),
    ("grid_7", &[("light_filter", "\"grid_pcf\"")], &[("grid_pcf_side", "7")], Some(0.9)),
    ("poisson_9", &[("light_filter", "\"poisson9\"")], &[], Some(0.3)),
    ("poisson_16", &[("light_filter", "\"poisson16\"")], &[], None),
    ("poisson_64", &[("light_filter", "\"poisson64\"")], &[], Some(1.2)),
    ("vogel_16", &[("light_filter", "\"vogel\"")], &[], None),
    (
        "pcss_16_16",
        &[("light_filter", "\"pcss\"")],
        &[("local_light_radius", "0.1"), ("sun_angle", "0.05")],
        None,
    ),
    ("evsm2_fp32", &[("moment_filter", "\"evsm2\""), ("moment_precision", "\"fp32\"")], MOMENTS, None),
    ("evsm4_fp32", &[("moment_filter", "\"evsm4\""), ("moment_precision", "\"fp32\"")], MOMENTS, None),
    ("evsm4_fp16", &[("moment_filter", "\"evsm4\""), ("moment_precision", "\"fp16\"")], MOMENTS, None),
    ("msm", &[("moment_filter", "\"msm\"")], MOMENTS, None),
];

/// The times for rendering shadow maps, for computing moments, and for shading.
#[derive(Clone, Copy)]
struct Times([Duration; 3]);

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    println!("on {}", gpu.name);
    let scene = scene(&root().join("examples/scenes/figure.glb"));
    let kinds = [
        ("spot", LightKind::Spot { inner_angle: 0.45, outer_angle: 0.6 }),
        ("point", LightKind::Point),
        ("sun", LightKind::Directional),
    ];
    let mut rows = FILTERS.map(|(name, .., claim)| {
        let claim = claim.map_or_else(String::new, |claim| format!("{claim:.1}"));
        [name.to_owned(), String::new(), String::new(), String::new(), claim]
    });
    for (at, (kind_name, kind)) in kinds.into_iter().enumerate() {
        let mut hard = None;
        for (row, (name, features, parameters, _)) in rows.iter_mut().zip(FILTERS) {
            // Cubes have no moments.
            if kind == LightKind::Point && parameters == MOMENTS {
                continue;
            }
            let Some(Times(times)) = times(&gpu, &scene, kind, features, parameters) else {
                println!("the adapter has no timestamps");
                return;
            };
            let [_, moments, shading] = times.map(|time| time.as_secs_f64() * 1e3);
            let least = *hard.get_or_insert(shading);
            let ratio = (moments + shading) / least;
            println!("ratio filters/{kind_name}/{name} {ratio:.2}");
            let moments = if moments > 0.0 { format!("{moments:.2} + ") } else { String::new() };
            row[1 + at] = format!("{moments}{shading:.2} ({ratio:.1})");
        }
    }
    measure::table(["filter", "spot", "point light", "sun, four cascades", "claimed"], &rows);
}

fn times(
    gpu: &Gpu,
    scene: &Scene,
    kind: LightKind,
    features: &[Setting],
    parameters: &[Setting],
) -> Option<Times> {
    let with = With { parameters, features, size: Some(SIZE), ..With::default() };
    let outcome = check_file("pipelines/awsm.json", &with);
    let mut host = Host::new(gpu, &outcome, scene);
    let input = frame(scene, kind);
    host.picture(&input);
    if !host.executor.measure_gpu_times(true) {
        return None;
    }
    let mut min = Times([Duration::MAX; 3]);
    for _ in 0..gpu.frames() {
        host.frame(&input);
        let mut now = [Duration::ZERO; 3];
        for one in host.executor.gpu_times() {
            let name = one.pass.as_str();
            let part = if name.ends_with("casters") {
                0
            } else if name.starts_with("write_") || name.starts_with("blur_") {
                1
            } else if name == "shade" {
                2
            } else {
                continue;
            };
            now[part] += one.time;
        }
        for (min, now) in min.0.iter_mut().zip(now) {
            *min = (*min).min(now);
        }
    }
    Some(min)
}

/// Returns the frame input for the figure under a single light.
fn frame(scene: &Scene, kind: LightKind) -> FrameInput {
    let mut input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
    let position = DVec3::new(2.4, 2.9, 2.6);
    input.lights = vec![
        Light::new("lamp", kind)
            .position(position)
            .direction((DVec3::new(-0.3, 0.5, -0.4) - position).normalize())
            .intensity(if kind == LightKind::Directional { 3.0 } else { 45.0 })
            .range(20.0)
            .property("cast_shadow"),
    ];
    input
}
