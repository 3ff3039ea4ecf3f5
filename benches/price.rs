//! Price of shadows in `pipelines/umbra.json` at 1920 × 1080, on whatever adapter there is.
//!
//! The price is the GPU's time of shading and of the passes of the shadow term, minus the time of the same passes in a
//! frame without shadows. Ambient occlusion, bloom and FXAA are off; materials are shaded alike in both. Draws of the
//! maps have a column of their own. Variants are drawn in turn, so that other work on the machine meets all of them;
//! times are the minimum of several frames after the first. Lines `ratio price/SCENE VALUE` divide the price of a variant
//! by that of the variant "filters".
//!
//! `cargo bench --profile dev --bench price` (the profile does not change what a GPU or a software driver does)
//!
//! Environment variables: `PRICE_TEMPLATES` names folders of templates, separated by commas, each of which adds variants
//! (a checkout of an older commit, or one under work); `PRICE_SIZE` is the width and height, `PRICE_SCENES` the scenes,
//! `PRICE_FRAMES` the number of frames.

#[path = "../tests/common/mod.rs"]
mod common;

use std::env;
use std::path::{Path, PathBuf};
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

/// The variant that others are divided by.
const FILTERS: usize = 2;

/// Times of the maps' draws, and of shading with the passes of the shadow term.
type Times = [Duration; 2];

/// A variant that is drawn.
struct Variant {
    name: String,
    outcome: Outcome,
}

fn main() {
    let Some(gpu) = gpu::device() else {
        println!("there is no graphics adapter");
        return;
    };
    let words = |name: &str, default: &str| {
        let words = env::var(name).unwrap_or_else(|_| default.to_owned());
        words.split(',').filter(|word| !word.is_empty()).map(str::to_owned).collect::<Vec<_>>()
    };
    let size: Vec<u32> = words("PRICE_SIZE", "1920,1080").iter().flat_map(|word| word.parse()).collect();
    let [width, height] = size[..] else { panic!("PRICE_SIZE is no width and height: {size:?}") };
    let frames = env::var("PRICE_FRAMES").ok().and_then(|text| text.parse().ok());
    let folders = words("PRICE_TEMPLATES", "");
    println!("milliseconds on {} at {width} by {height}", gpu.name);
    println!("{:10} {:24} {:>10} {:>10} {:>10}", "scene", "variant", "maps", "shading", "price");
    for name in words("PRICE_SCENES", "courtyard,interior,foliage") {
        let scene = scene(&root().join(format!("examples/scenes/{name}.glb")));
        let input = scene.frame_input(f64::from(width) / f64::from(height), 0.0);
        let variants = variants(&folders, [width, height]);
        let mut hosts: Vec<_> =
            variants.iter().map(|variant| Host::new(&gpu, &variant.outcome, &scene)).collect();
        for host in &mut hosts {
            host.picture(&input);
            if !host.executor.measure_gpu_times(true) {
                println!("the adapter has no timestamps");
                return;
            }
        }
        let mut least = vec![[Duration::MAX; 2]; hosts.len()];
        for _ in 0..frames.unwrap_or(gpu.frames().max(5)) {
            for (host, least) in hosts.iter_mut().zip(&mut least) {
                host.frame(&input);
                let now = times(host);
                *least = [least[0].min(now[0]), least[1].min(now[1])];
            }
        }
        let price = |index: usize| least[index][1].saturating_sub(least[0][1]);
        for (index, (variant, [maps, shading])) in variants.iter().zip(&least).enumerate() {
            let [maps, shading, price] = [*maps, *shading, price(index)].map(milliseconds);
            println!("{name:10} {:24} {maps:10.2} {shading:10.2} {price:10.2}", variant.name);
        }
        for (index, variant) in variants.iter().enumerate().skip(FILTERS + 1) {
            let ratio = milliseconds(price(index)) / milliseconds(price(FILTERS));
            println!("ratio price/{name}/{} {ratio:.2}", variant.name);
        }
    }
}

/// The variants with the project's templates, and those that draw shadows with each of the folders.
fn variants(folders: &[String], size: [u32; 2]) -> Vec<Variant> {
    let one = |name: &str, features: &[Setting], templates: &[(String, String)]| {
        let features: Vec<Setting> = EFFECTS_OFF.iter().chain(features).copied().collect();
        let templates: Vec<(&str, &str)> =
            templates.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
        let with = With { features: &features, templates: &templates, size: Some(size), ..With::default() };
        Variant { name: name.to_owned(), outcome: check_file("pipelines/umbra.json", &with) }
    };
    let mut variants: Vec<_> = VARIANTS.iter().map(|(name, features)| one(name, features, &[])).collect();
    for folder in folders {
        let templates = templates(Path::new(folder));
        for (name, features) in &VARIANTS[FILTERS..] {
            let last =
                Path::new(folder).file_name().map_or_else(String::new, |name| name.display().to_string());
            variants.push(one(&format!("{name} of {last}"), features, &templates));
        }
    }
    variants
}

/// The templates of a folder, by their names.
fn templates(folder: &Path) -> Vec<(String, String)> {
    let mut folders = vec![PathBuf::new()];
    let mut found = Vec::new();
    while let Some(below) = folders.pop() {
        for entry in std::fs::read_dir(folder.join(&below)).expect("a folder").flatten() {
            let name = below.join(entry.file_name());
            let text = name.to_string_lossy().replace('\\', "/");
            if entry.path().is_dir() {
                folders.push(name);
            } else if text.ends_with(".jinja") || text.ends_with(".axes.json") {
                found.push((text, std::fs::read_to_string(entry.path()).expect("a template")));
            }
        }
    }
    found
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

fn times(host: &mut Host<'_>) -> Times {
    let mut times = [Duration::ZERO; 2];
    for one in host.executor.gpu_times() {
        let name = one.pass.as_str();
        let is_shading = ["shade", "transparent", "gather", "denoise", "depth_bounds"];
        if name.contains("casters") {
            times[0] += one.time;
        } else if is_shading.iter().any(|begin| name.starts_with(begin)) {
            times[1] += one.time;
        }
    }
    times
}
