//! Maps sampled in the shader of every material, or once for each pixel in a pass of its own that shading reads
//! (`visibility_first` of `pipelines/awsm.json`).
//!
//! For each of the two, with three filters: the bytes of WGSL of the shading's distinct modules and of all modules, the
//! time that naga takes to parse and validate the latter (the minimum of five), and the time of a frame of 1280 by 720
//! of the interior with its eight lights, from recording to its end on the device (the minimum of ten; the first
//! apart). Lines `ratio visibility/… VALUE` are the second way divided by the first.
//!
//! `cargo bench --bench visibility`

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "measure.rs"]
mod measure;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use common::gpu::{Host, scene};
use common::{Outcome, With, check_file, root};
use umbragraph_test_support::gpu::{self, Gpu};

const SIZE: [u32; 2] = [1280, 720];

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    println!("on {}", gpu.name);
    let mut rows = Vec::new();
    for filter in ["hard", "poisson16", "pcss"] {
        let [together, first] = ["false", "true"].map(|first| measure(&gpu, filter, first));
        let mut row = vec![filter.to_owned()];
        for (name, first, together) in [
            ("shading_bytes", first.shading_bytes as f64, together.shading_bytes as f64),
            ("bytes", first.bytes as f64, together.bytes as f64),
            ("naga", first.naga.as_secs_f64(), together.naga.as_secs_f64()),
            ("frame", first.frame.as_secs_f64(), together.frame.as_secs_f64()),
        ] {
            println!("ratio visibility/{name}/{filter} {:.3}", first / together);
            row.push(format!("{:.2}", first / together));
        }
        rows.push(row.try_into().expect("a cell for each head"));
    }
    measure::table(["filter", "WGSL of the shading", "all WGSL", "naga's time", "time of a frame"], &rows);
}

struct Measured {
    shading_bytes: usize,
    bytes: usize,
    naga: Duration,
    frame: Duration,
}

fn measure(gpu: &Gpu, filter: &str, first: &str) -> Measured {
    let filter_word = format!("\"{filter}\"");
    let with = With {
        parameters: &[("local_light_radius", "0.05")],
        features: &[("light_filter", &filter_word), ("visibility_first", first)],
        size: Some(SIZE),
        ..With::default()
    };
    let outcome = check_file("pipelines/awsm.json", &with);
    let shading = modules(&outcome, &|template| template == "lit.wgsl.jinja");
    let all = modules(&outcome, &|_| true);
    let bytes = |modules: &BTreeMap<[u8; 32], String>| modules.values().map(String::len).sum();
    let naga = (0..5).map(|_| timed(|| all.values().for_each(|text| validate(text)))).min();
    let scene = scene(&root().join("examples/scenes/interior.glb"));
    let input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
    let mut host = Host::new(gpu, &outcome, &scene);
    let cold = timed(|| drop(host.picture(&input)));
    let frame = (0..10).map(|_| {
        timed(|| {
            host.frame(&input);
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a device that answers");
        })
    });
    let measured = Measured {
        shading_bytes: bytes(&shading),
        bytes: bytes(&all),
        naga: naga.unwrap_or_default(),
        frame: frame.min().unwrap_or_default(),
    };
    println!(
        "{filter}, {}: {} modules of shading {} bytes, all {} modules {} bytes, naga {:.1} ms, frame {:.1} ms, first frames {:.0} ms",
        if first == "true" { "visibility first" } else { "maps in the shading" },
        shading.len(),
        measured.shading_bytes,
        all.len(),
        measured.bytes,
        measured.naga.as_secs_f64() * 1e3,
        measured.frame.as_secs_f64() * 1e3,
        cold.as_secs_f64() * 1e3,
    );
    measured
}

/// Returns the distinct shader sources of passes that use the selected templates, except for transparent surfaces.
fn modules(outcome: &Outcome, is_wanted: &dyn Fn(&str) -> bool) -> BTreeMap<[u8; 32], String> {
    let pipeline = &outcome.plan().pipeline;
    let mut modules = BTreeMap::new();
    for pass in pipeline.passes.iter().filter(|pass| pass.name != "transparent") {
        let Some(program) = pass.work().program() else { continue };
        let program = pipeline.program(program);
        if is_wanted(&program.template) {
            let variants = program.variants.iter().map(|variant| &variant.module);
            modules.extend(variants.map(|module| (module.hash, module.wgsl.to_string())));
        }
    }
    modules
}

fn validate(text: &str) {
    let module = naga::front::wgsl::parse_str(text).expect("WGSL");
    let flags = naga::valid::ValidationFlags::all();
    naga::valid::Validator::new(flags, naga::valid::Capabilities::all())
        .validate(&module)
        .expect("valid WGSL");
}

fn timed(mut what: impl FnMut()) -> Duration {
    let start = Instant::now();
    what();
    start.elapsed()
}
