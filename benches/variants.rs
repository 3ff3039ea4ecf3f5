//! The cost of the shaders of `pipelines/awsm.json` before its first frame, by filter and by the features that are on.
//!
//! Each setting has a process of its own, with Mesa's cache off. It prints the distinct modules of the passes, their bytes as
//! WGSL and as SPIR-V with overrides resolved, and two times: to make all pipelines, and to draw the first frame, 64 by 36
//! pixels of the interior with its eight lights. On Linux the processor's time of all threads follows, without the kernel's.
//! Last comes each module of the last setting by itself.
//!
//! `cargo bench --bench variants`

#[path = "../tests/common/mod.rs"]
mod common;

use std::collections::BTreeMap;
use std::process::Command;
use std::time::{Duration, Instant};

use common::gpu::{Host, scene};
use common::{Outcome, With, check_file, root};
use naga::back::pipeline_constants::process_overrides;
use naga::back::spv;
use umbragraph::low_level::shader::ShaderModule;
use umbragraph_test_support::gpu;

/// The Mesa environment variable that disables the shader cache.
const NO_CACHE: &str = "MESA_SHADER_CACHE_DISABLE";

type Settings = &'static [(&'static str, &'static str)];

const SETTINGS: [(&str, Settings, Settings); 7] = [
    ("hard", &[("light_filter", "\"hard\"")], &[]),
    ("poisson16", &[], &[]),
    ("pcss", &[("light_filter", "\"pcss\"")], &[]),
    ("evsm4", &[], &[("moment_cascades", "\"last_two\""), ("moment_spots", "true")]),
    ("msm", &[("moment_filter", "\"msm\"")], &[("moment_cascades", "\"last_two\"")]),
    ("visibility_first", &[("light_filter", "\"pcss\""), ("visibility_first", "true")], &[]),
    (
        "pcss_evsm4_contact",
        &[("light_filter", "\"pcss\""), ("contact_shadows", "true")],
        &[("moment_cascades", "\"last_two\""), ("moment_spots", "true")],
    ),
];

/// The environment variable that selects the setting for a child process.
const ONE: &str = "UMBRAGRAPH_VARIANT";

fn main() {
    if let Ok(one) = std::env::var(ONE) {
        let setting = SETTINGS.iter().find(|setting| setting.0 == one);
        return draw(*setting.expect("a setting"));
    }
    println!(
        "| filter | modules | WGSL | SPIR-V | pipelines | first frame | CPU time |\n|---|---|---|---|---|---|---|"
    );
    for (name, ..) in SETTINGS {
        let itself = std::env::current_exe().expect("this program");
        // The driver reads its own when it is loaded.
        let status = Command::new(itself).env(NO_CACHE, "true").env(ONE, name).status().expect("a process");
        if !status.success() {
            std::process::exit(status.code().unwrap_or(1));
        }
    }
}

/// Renders the first frame of a setting, then measures its shader modules.
fn draw((name, features, parameters): (&str, Settings, Settings)) {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    let scene = scene(&root().join("examples/scenes/interior.glb"));
    let input = scene.frame_input(64.0 / 36.0, 0.0);
    let mut all = vec![("local_light_radius", "0.05")];
    all.extend_from_slice(parameters);
    let with = With { parameters: &all, features, size: Some([64, 36]), ..With::default() };
    let outcome = check_file("pipelines/awsm.json", &with);
    let start = Instant::now();
    let mut host = Host::new(&gpu, &outcome, &scene);
    host.settle(&input);
    let made = start.elapsed();
    let start = Instant::now();
    drop(host.picture(&input));
    let drawn = start.elapsed();
    let processor = processor_seconds().map_or("?".to_owned(), |seconds| format!("{seconds:.2} s"));
    let modules = modules(&outcome);
    let bytes: usize = modules.values().map(|module| module.wgsl.len()).sum();
    let words: usize = modules.values().map(spirv_bytes).sum();
    let count = modules.len();
    let kilobytes = |bytes: usize| format!("{} kB", bytes / 1000);
    println!(
        "| {} | {count} | {} | {} | {:.0} ms | {:.0} ms | {processor} |",
        name.replace('_', ", "),
        kilobytes(bytes),
        kilobytes(words),
        ms(made),
        ms(drawn)
    );
    if name == SETTINGS[SETTINGS.len() - 1].0 {
        println!("on {}", gpu.name);
        for module in modules.values() {
            let (text, words) = (module.wgsl.len(), spirv_bytes(module));
            println!("  {:26} {text:9} {words:9}", module.template);
        }
    }
}

/// Returns the user CPU time of all threads of this process in seconds; `None` if it cannot be read.
fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The second field is a name in parentheses, the fourteenth hundredths of a second.
    let hundredths: f64 = text.rsplit_once(')')?.1.split_whitespace().nth(11)?.parse().ok()?;
    Some(hundredths / 100.0)
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Returns the distinct shader modules of a pipeline's passes.
fn modules(outcome: &Outcome) -> BTreeMap<[u8; 32], ShaderModule> {
    let programs = &outcome.plan().pipeline.programs;
    let variants = programs.iter().flat_map(|program| &program.variants);
    variants.map(|variant| (variant.module.hash, ShaderModule::clone(&variant.module))).collect()
}

/// Returns the size in bytes of a module as SPIR-V, with the override constants of its pipeline.
fn spirv_bytes(module: &ShaderModule) -> usize {
    let parsed = naga::front::wgsl::parse_str(&module.wgsl).expect("WGSL");
    let flags = naga::valid::ValidationFlags::all();
    let validate = |module: &naga::Module| {
        naga::valid::Validator::new(flags, naga::valid::Capabilities::all()).validate(module).expect("valid")
    };
    let constants = module.constants.iter().map(|(name, value)| (name.clone(), *value)).collect();
    let info = validate(&parsed);
    let (resolved, info) = process_overrides(&parsed, &info, None, &constants).expect("constants");
    let words = spv::write_vec(&resolved, &info, &spv::Options::default(), None).expect("SPIR-V");
    words.len() * 4
}
