//! A frame that goes on for long while everything about it changes: nothing grows, and nothing of the past is left.
//!
//! A figure walks under the flagship while live values, toggles, sizes, plans and lights change at random. The memory of the
//! process and of the device, and the time of a frame, are fitted by a line over the second half of the run. At the end
//! the picture equals that of a fresh start. Ordinarily it is forty frames; `cargo xtask soak` goes on
//! for an hour.

use std::sync::Arc;
use std::time::{Duration, Instant};

use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::scene::Scene;
use umbragraph::scene::gpu::SceneResources;
use umbragraph::{Executor, Frame, Library, Options, Pipeline, Plan};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::common::gpu::{import, read, scene};
use crate::common::root;

/// So long the run goes on, in seconds.
const SECONDS: &str = "UMBRAGRAPH_LONG_RUN";
const FRAMES: usize = 40;
/// One of so many frames is measured.
const MEASURED: usize = 5;

/// The flagship with small maps, and a pass that can be switched off between frames.
const TEXT: &str = r#"{
  "format": 1, "name": "long_run", "extends": "umbragraph:umbra.json",
  "toggles": { "tint": { "default": false } },
  "passes": { "tint": {
    "toggle": "tint", "after": ["present"],
    "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target", "blend": "add" }] }
  } }
}"#;

/// Everything that changes from frame to frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    size: [u32; 2],
    is_hard: bool,
    is_tinted: bool,
    strength: f32,
    lamps: usize,
}

const LAST: State = State { size: [96, 54], is_hard: false, is_tinted: false, strength: 1.0, lamps: 2 };

impl State {
    fn changed(self, random: &mut Random) -> Self {
        match random.below(10) {
            0 => Self { size: [64 + 8 * random.below(8) as u32, 40 + 4 * random.below(8) as u32], ..self },
            1 => Self { is_hard: !self.is_hard, ..self },
            2 => Self { is_tinted: !self.is_tinted, ..self },
            3 | 4 => Self { strength: random.below(20) as f32 * 0.1, ..self },
            5 => Self { lamps: random.below(7), ..self },
            _ => self,
        }
    }

    fn options(self) -> Options {
        let [width, height] = self.size;
        let filter = if self.is_hard { "hard" } else { "pcss" };
        let small = Options::new(width, height).set("cascade_side", 128).set("cube_side", 32);
        small.set("atlas_min_side", 128).set("atlas_max_side", 512).feature("light_filter", filter)
    }

    fn input(self, scene: &Scene, frame: usize) -> FrameInput {
        let [width, height] = self.size.map(f64::from);
        let mut input = scene.frame_input(width / height, 0.04 * frame as f64);
        let lamps = (0..self.lamps).map(|at| {
            let around = at as f64 + 0.05 * frame as f64;
            Light::new(format!("lamp {at}"), LightKind::Point)
                .position([2.0 * around.cos(), 1.5, 2.0 * around.sin()])
                .intensity(20.0)
                .range(8.0)
                .property("cast_shadow")
        });
        input.lights.extend(lamps);
        input.index(frame as u64)
    }
}

struct Run<'a> {
    gpu: &'a Gpu,
    pipeline: &'a Pipeline,
    scene: &'a Scene,
    meshes: SceneResources,
    executor: Executor,
    options: Options,
    target: wgpu::Texture,
}

impl<'a> Run<'a> {
    fn new(gpu: &'a Gpu, pipeline: &'a Pipeline, scene: &'a Scene, state: State) -> Self {
        let meshes = SceneResources::new(&gpu.device, &gpu.queue, scene, &scene.pose(0.0)).expect("a scene");
        let options = state.options();
        let plan = planned(pipeline, &options);
        let target = import(gpu, &plan, "target");
        let executor = Executor::new(&gpu.device, &gpu.queue, plan, Some(&meshes));
        let executor = executor.unwrap_or_else(|error| panic!("{error}"));
        Self { gpu, pipeline, scene, meshes, executor, options, target }
    }

    fn plan(&mut self, options: Options) {
        let plan = planned(self.pipeline, &options);
        self.target = import(self.gpu, &plan, "target");
        self.executor.set_plan(plan).unwrap_or_else(|error| panic!("{error}"));
        self.options = options;
    }

    /// Draws a frame, again for as long as lights want other sizes.
    fn frame(&mut self, state: State, frame: usize) {
        let (gpu, input) = (self.gpu, state.input(self.scene, frame));
        self.meshes.update(&gpu.queue, self.scene, &self.scene.pose(input.time));
        let strength = self.executor.parameter::<f32>("occlusion_strength").expect("a live parameter");
        for _ in 0..16 {
            self.executor.set(strength, state.strength).expect("a strength");
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let (imports, toggles) = ([("target", &self.target)], [("tint", state.is_tinted)]);
            let given = Frame::new(&input).draws(&self.meshes).imports(&imports).toggles(&toggles);
            self.executor
                .record(&mut encoder, &given)
                .unwrap_or_else(|error| panic!("frame {frame}: {error}"));
            let Some(sizes) = self.executor.wanted_sizes() else {
                gpu.queue.submit([encoder.finish()]);
                gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
                return;
            };
            self.plan(self.options.clone().data_sizes(sizes));
        }
        panic!("frame {frame}: sizes that never settle");
    }

    fn picture(&self) -> Picture {
        read(self.gpu, &self.target)
    }
}

fn planned(pipeline: &Pipeline, options: &Options) -> Arc<Plan> {
    pipeline.plan(options).unwrap_or_else(|error| panic!("{error}"))
}

/// Bytes of the process that are in memory.
fn resident() -> f64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    pages.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok()).unwrap_or_default() * 4096.0
}

/// The slope of a line through measurements, and half of the width of its 95 % confidence interval.
fn slope(measured: &[(f64, f64)]) -> (f64, f64) {
    let count = measured.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| measured.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|one| one.0), mean(|one| one.1));
    let spread: f64 = measured.iter().map(|one| (one.0 - x).powi(2)).sum();
    let slope = measured.iter().map(|one| (one.0 - x) * (one.1 - y)).sum::<f64>() / spread;
    let rest: f64 = measured.iter().map(|one| (one.1 - y - slope * (one.0 - x)).powi(2)).sum();
    (slope, 1.96 * (rest / (count - 2.0).max(1.0) / spread).sqrt())
}

#[test]
fn a_line_has_the_slope_that_it_has() {
    let line: Vec<(f64, f64)> = (0..10).map(|at| (f64::from(at), 3.0 * f64::from(at) + 1.0)).collect();
    let (found, width) = slope(&line);
    assert!((found - 3.0).abs() < 1e-9 && width < 1e-6, "{found} ± {width}");
}

#[test]
fn a_long_run_grows_nothing_and_leaves_no_trace() {
    let Some(gpu) = gpu::device() else { return };
    let pipeline = Library::new().load_text("long_run.json", TEXT).unwrap_or_else(|error| panic!("{error}"));
    let scene = scene(&root().join("examples/scenes/figure.glb"));
    let length =
        std::env::var(SECONDS).ok().and_then(|seconds| seconds.parse().ok()).map(Duration::from_secs);
    let mut random = Random(property::seed());
    let (mut state, begin) = (LAST, Instant::now());
    let mut run = Run::new(&gpu, &pipeline, &scene, state);
    // The state in which all is measured is one and the same.
    let mut measured: [Vec<(f64, f64)>; 3] = Default::default();
    let mut frame = 0;
    while length.map_or(frame < FRAMES, |length| begin.elapsed() < length) {
        let is_measured = frame % MEASURED == 0;
        let next = if is_measured { LAST } else { state.changed(&mut random) };
        if next.options() != state.options() {
            run.plan(next.options());
        }
        state = next;
        let started = Instant::now();
        run.frame(state, frame);
        if is_measured {
            let device = gpu.device.generate_allocator_report().map_or(0, |one| one.total_allocated_bytes);
            let now = [resident(), device as f64, started.elapsed().as_secs_f64() * 1000.0];
            measured.iter_mut().zip(now).for_each(|(list, value)| list.push((frame as f64, value)));
        }
        frame += 1;
    }
    println!("{frame} frames in {:.0} s, on {}", begin.elapsed().as_secs_f64(), gpu.adapter.get_info().name);
    for (list, what) in measured.iter().zip(["bytes of the process", "bytes of the device", "milliseconds"]) {
        let half = &list[list.len() / 2..];
        let ((slope, width), level) = (slope(half), half.last().map_or(0.0, |one| one.1));
        println!("{what}: {level:.0} at the end, {slope:.3} ± {width:.3} a frame");
        // A run of an hour: nothing may be a tenth more for it.
        let is_flat = (slope - width) * (frame as f64) < 0.1 * level;
        assert!(length.is_none() || is_flat, "{what} grow by {slope} ± {width} a frame");
    }
    run.plan(LAST.options());
    run.frame(LAST, frame);
    let mut fresh = Run::new(&gpu, &pipeline, &scene, LAST);
    fresh.frame(LAST, frame);
    assert_eq!(run.picture().differing(&fresh.picture(), 0), 0, "the past is seen in the picture");
}
