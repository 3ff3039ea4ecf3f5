//! A frame of each of the five systems and of the flagship at 1920 × 1080: the GPU's time of each pass, by timestamps,
//! and the processor's, on whatever adapter there is.
//!
//! Each pipeline draws `examples/scenes/courtyard.glb` with its defaults, `lore` with each of its presets as well, and
//! `umbra` with rays beside maps (`hybrid`) and in place of them (`rays`);
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
#[path = "measure.rs"]
mod measure;

use std::collections::BTreeMap;
use std::time::Duration;

use common::gpu::{Host, scene};
use common::{With, check_file, root};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};

const SIZE: [u32; 2] = [1920, 1080];

/// The time below which a pass gets no line of its own, if both its CPU and its GPU time are shorter.
const SMALL: Duration = Duration::from_micros(10);

/// A pipeline to measure.
struct Subject {
    pipeline: &'static str,
    preset: Option<&'static str>,
    /// The filter of the lights' shadows; `None` for the default.
    filter: Option<&'static str>,
    /// The times in milliseconds that the original system claims for its passes.
    claims: &'static [(&'static str, Clock, f64)],
}

impl Subject {
    const fn new(pipeline: &'static str) -> Self {
        Self { pipeline, preset: None, filter: None, claims: &[] }
    }

    const fn preset(self, preset: &'static str) -> Self {
        Self { preset: Some(preset), ..self }
    }

    const fn filter(self, filter: &'static str) -> Self {
        Self { filter: Some(filter), ..self }
    }

    const fn claims(self, claims: &'static [(&'static str, Clock, f64)]) -> Self {
        Self { claims, ..self }
    }

    fn name(&self) -> String {
        [Some(self.pipeline), self.preset, self.filter].into_iter().flatten().collect::<Vec<_>>().join("_")
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Clock {
    Processor,
    Gpu,
}

const SUBJECTS: [Subject; 12] = [
    Subject::new("mantis").claims(&[
        ("fit", Clock::Processor, 0.02),
        ("casters", Clock::Gpu, 2.5),
        ("shade", Clock::Gpu, 0.3),
    ]),
    Subject::new("awsm"),
    Subject::new("nebula"),
    Subject::new("caracal"),
    Subject::new("lore"),
    Subject::new("lore").preset("low").claims(&[("casters", Clock::Gpu, 0.8), ("shade", Clock::Gpu, 0.3)]),
    Subject::new("lore").preset("medium").claims(&[("casters", Clock::Gpu, 1.2), ("shade", Clock::Gpu, 0.5)]),
    Subject::new("lore").preset("high").claims(&[("casters", Clock::Gpu, 1.8), ("shade", Clock::Gpu, 0.9)]),
    Subject::new("lore").preset("ultra").claims(&[("casters", Clock::Gpu, 1.5), ("shade", Clock::Gpu, 1.2)]),
    Subject::new("umbra"),
    Subject::new("umbra").filter("hybrid"),
    Subject::new("umbra").filter("rays"),
];

/// Prefixes of the names of passes that render shadow maps.
const MAPS: [&str; 4] = ["casters", "spot_casters", "point_casters", "directional_casters"];

/// The CPU time and the GPU time of a pass.
type Times = [Duration; 2];

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    println!("on {}", gpu.name);
    let mut rows = Vec::new();
    let scene = scene(&root().join("examples/scenes/courtyard.glb"));
    // `cargo bench --bench frame -- umbra` measures what has the word in its name.
    let only = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    for subject in SUBJECTS {
        let name = subject.name();
        if only.as_ref().is_some_and(|only| !name.contains(only)) {
            continue;
        }
        let (order, passes) = times(&gpu, &scene, &subject);
        let claims = subject.claims;
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
        let all = sum(&mut passes.values().copied());
        line("all", all, "");
        let part = |begins: &[&str]| {
            let named = |pass: &&String| begins.iter().any(|begin| pass.starts_with(begin));
            let milliseconds = sum(&mut passes.keys().filter(named).map(|pass| passes[pass]))
                .map(|time| time.as_secs_f64() * 1e3);
            (milliseconds, claims.iter().find(|(pass, ..)| begins.contains(pass)))
        };
        let gpu_time = |begins: &[&str]| match part(begins) {
            ([_, time], Some((.., Clock::Gpu, claim))) => format!("{time:.2} ({:.1})", time / claim),
            ([_, time], _) => format!("{time:.2}"),
        };
        rows.push([
            name.replace('_', ", "),
            format!("{:.2}", all[0].as_secs_f64() * 1e3),
            gpu_time(&MAPS),
            gpu_time(&["shade"]),
            format!("{:.2}", all[1].as_secs_f64() * 1e3),
        ]);
        for (begin, _, claim) in claims.iter().filter(|(_, clock, _)| *clock == Clock::Processor) {
            let named = passes.iter().filter(|(pass, _)| pass.starts_with(begin));
            let [processor, _] = sum(&mut named.map(|(_, times)| *times));
            println!("ratio frame/{name}/{begin} {:.2}", processor.as_secs_f64() * 1e3 / claim);
        }
    }
    measure::table(["pipeline", "CPU, all", "maps", "surfaces and lighting", "all"], &rows);
}

/// Returns the names of the passes in order, and the shortest times of each.
fn times(gpu: &Gpu, scene: &Scene, subject: &Subject) -> (Vec<String>, BTreeMap<String, Times>) {
    let word = subject.filter.map(|filter| format!("\"{filter}\""));
    let filter = word.as_deref().map(|word| ("light_filter", word));
    let with =
        With { preset: subject.preset, features: filter.as_slice(), size: Some(SIZE), ..With::default() };
    let outcome = check_file(&format!("pipelines/{}.json", subject.pipeline), &with);
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
