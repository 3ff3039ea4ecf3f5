//! A frame of each of the five systems and of the flagship at 1920 × 1080: the GPU's time of each pass, by timestamps,
//! and the processor's, on whatever adapter there is.
//!
//! Each pipeline draws `examples/scenes/courtyard.glb` with its defaults, `lore` with each of its presets as well;
//! times are the minimum of several frames after the first. Passes that take less than a hundredth of a millisecond on
//! both are summed in one line. Beside them are what the systems claim of themselves, on a desktop GPU (`lore`: an RTX
//! 3070, maps and lighting; `mantis`: fitting on the processor, casters, and the part of shading that filters with nine
//! taps).
//!
//! Lines `ratio frame/… VALUE` divide our time on the processor by the one that a system claims. A GPU in software gets no
//! such line: the claims are of hardware.
//!
//! `cargo bench --bench frame`

#[path = "../tests/common/mod.rs"]
mod common;

use std::collections::BTreeMap;
use std::time::Duration;

use common::gpu::{Host, scene};
use common::{With, check_file, root};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};

const SIZE: [u32; 2] = [1920, 1080];

/// Below it a pass has no line of its own.
const SMALL: Duration = Duration::from_micros(10);

/// A pipeline, a preset, and what is claimed of passes: the processor's time or the GPU's in milliseconds.
type Subject = (&'static str, Option<&'static str>, &'static [(&'static str, Clock, f64)]);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Clock {
    Processor,
    Gpu,
}

const SUBJECTS: [Subject; 10] = [
    (
        "mantis",
        None,
        &[("fit", Clock::Processor, 0.02), ("casters", Clock::Gpu, 2.5), ("shade", Clock::Gpu, 0.3)],
    ),
    ("awsm", None, &[]),
    ("nebula", None, &[]),
    ("caracal", None, &[]),
    ("lore", None, &[]),
    ("lore", Some("low"), &[("casters", Clock::Gpu, 0.8), ("shade", Clock::Gpu, 0.3)]),
    ("lore", Some("medium"), &[("casters", Clock::Gpu, 1.2), ("shade", Clock::Gpu, 0.5)]),
    ("lore", Some("high"), &[("casters", Clock::Gpu, 1.8), ("shade", Clock::Gpu, 0.9)]),
    ("lore", Some("ultra"), &[("casters", Clock::Gpu, 1.5), ("shade", Clock::Gpu, 1.2)]),
    ("umbra", None, &[]),
];

/// The times of a pass: of the processor and of the GPU.
type Times = [Duration; 2];

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    println!("milliseconds on {} at {} by {}", gpu.name, SIZE[0], SIZE[1]);
    let scene = scene(&root().join("examples/scenes/courtyard.glb"));
    for (pipeline, preset, claims) in SUBJECTS {
        let (order, passes) = measure(&gpu, &scene, pipeline, preset);
        let name = preset.map_or_else(|| pipeline.to_owned(), |preset| format!("{pipeline}_{preset}"));
        println!("\n{name:28}{:>12}{:>12}", "processor", "GPU");
        let line = |name: &str, [processor, gpu]: Times, claim: &str| {
            let [processor, gpu] = [processor, gpu].map(|time| time.as_secs_f64() * 1e3);
            println!("  {name:26}{processor:12.3}{gpu:12.3}{claim}");
        };
        let sum = |times: &mut dyn Iterator<Item = Times>| {
            times.fold([Duration::ZERO; 2], |[a, b], [c, d]| [a + c, b + d])
        };
        let is_claimed = |pass: &str| claims.iter().find(|(begin, ..)| pass.starts_with(begin));
        let is_small =
            |pass: &str| is_claimed(pass).is_none() && passes[pass].iter().all(|time| *time < SMALL);
        for pass in order.iter().filter(|pass| !is_small(pass)) {
            let clocks = |clock| if clock == Clock::Processor { "processor" } else { "GPU" };
            let claim = is_claimed(pass).map_or_else(String::new, |(_, clock, claim)| {
                format!("  claim {claim} ({})", clocks(*clock))
            });
            line(pass, passes[pass], &claim);
        }
        let small = order.iter().filter(|pass| is_small(pass));
        if small.clone().next().is_some() {
            line("others", sum(&mut small.map(|pass| passes[pass])), "");
        }
        line("all", sum(&mut passes.values().copied()), "");
        for (begin, _, claim) in claims.iter().filter(|(_, clock, _)| *clock == Clock::Processor) {
            let named = passes.iter().filter(|(pass, _)| pass.starts_with(begin));
            let [processor, _] = sum(&mut named.map(|(_, times)| *times));
            println!("ratio frame/{name}/{begin} {:.2}", processor.as_secs_f64() * 1e3 / claim);
        }
    }
}

/// The passes in their order, and the least time of each.
fn measure(
    gpu: &Gpu,
    scene: &Scene,
    pipeline: &str,
    preset: Option<&str>,
) -> (Vec<String>, BTreeMap<String, Times>) {
    let with = With { preset, size: Some(SIZE), ..With::default() };
    let outcome = check_file(&format!("pipelines/{pipeline}.json"), &with);
    let mut host = Host::new(gpu, &outcome, scene);
    let input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
    host.picture(&input);
    host.executor.measure_times(true);
    if !host.executor.measure_gpu_times(true) {
        println!("the adapter has no timestamps: the GPU's times are missing");
    }
    let mut order = Vec::new();
    let mut least: BTreeMap<String, Times> = BTreeMap::new();
    for _ in 0..gpu.frames() {
        host.frame(&input);
        let mut now: BTreeMap<String, Times> = BTreeMap::new();
        order = host.executor.times().map(|(name, _)| name.to_owned()).collect();
        for (name, time) in host.executor.times() {
            now.insert(name.to_owned(), [time, Duration::ZERO]);
        }
        for one in host.executor.gpu_times() {
            now.entry(one.pass).or_default()[1] += one.time;
        }
        for (name, times) in now {
            let least = least.entry(name).or_insert([Duration::MAX; 2]);
            *least = [least[0].min(times[0]), least[1].min(times[1])];
        }
    }
    (order, least)
}
