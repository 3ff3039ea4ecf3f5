//! Bounds of depth around receivers (the feature `depth_bounds`): the same picture bit for bit, with fewer reads of the maps.

use umbragraph::frame::FrameInput;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

use crate::common::gpu::{Host, scene};
use crate::common::{Outcome, With, check_file, check_with, read, root, with_small_maps};

const SIZE: [u32; 2] = [320, 180];
const BOUNDS: (&str, &str) = ("depth_bounds", "true");
const FILTERS: (&str, &str) = ("depth_bounds", "false");
const PCSS: (&str, &str) = ("light_filter", "\"pcss\"");
const SHADOW_TERM: (&str, &str) = ("debug_view", "\"shadow_term\"");

type Setting<'a> = (&'a str, &'a str);

/// A template's name, a text in it, and what stands in its place.
type Edit = (&'static str, &'static str, &'static str);

fn outcome(pipeline: &str, parameters: &[Setting<'_>], features: &[Setting<'_>], edits: &[Edit]) -> Outcome {
    let mut texts: Vec<(&str, String)> = Vec::new();
    for (name, before, after) in edits {
        let known = texts.iter().position(|(other, _)| other == name).unwrap_or_else(|| {
            texts.push((name, read(&format!("shaders-templates/{name}"))));
            texts.len() - 1
        });
        let text = &mut texts[known].1;
        assert!(text.contains(before), "{name} has no {before:?}");
        *text = text.replace(before, after);
    }
    let templates: Vec<(&str, &str)> = texts.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let with = With { parameters, features, templates: &templates, size: Some(SIZE), ..With::default() };
    check_file(&format!("pipelines/{pipeline}.json"), &with)
}

/// A scene, and lights as large as they are times a factor.
fn input(name: &str, larger: f32) -> (umbragraph::scene::Scene, FrameInput) {
    let scene = scene(&root().join(format!("examples/scenes/{name}.glb")));
    let mut input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
    for light in &mut input.lights {
        light.radius *= larger;
        light.angular_diameter *= larger;
    }
    (scene, input)
}

fn picture(gpu: &Gpu, outcome: &Outcome, scene: &str, larger: f32) -> Picture {
    let (scene, input) = input(scene, larger);
    Host::new(gpu, outcome, &scene).picture(&input)
}

/// Number of pixels that differ between filters alone and filters with bounds.
fn differing(
    gpu: &Gpu,
    pipeline: &str,
    scene: &str,
    larger: f32,
    parameters: &[Setting<'_>],
    edits: &[Edit],
) -> usize {
    let parameters = [&[SHADOW_TERM], parameters].concat();
    let of = |bounds, edits: &[Edit]| {
        picture(gpu, &outcome(pipeline, &parameters, &[PCSS, bounds], edits), scene, larger)
    };
    of(FILTERS, &[]).differing(&of(BOUNDS, edits), 0)
}

#[test]
fn bounds_change_no_pixel() {
    let Some(gpu) = gpu::device() else { return };
    let small = with_small_maps(&[]);
    for (pipeline, name, larger, parameters) in [
        ("umbra", "courtyard", 1.0, &small[..]),
        ("umbra", "foliage", 6.0, &small[..]),
        ("umbra", "figure", 3.0, &small[..]),
        ("umbra", "interior", 1.0, &[][..]),
        ("umbra", "interior", 6.0, &small[..]),
        ("awsm", "interior", 2.0, &small[..]),
    ] {
        assert_eq!(differing(&gpu, pipeline, name, larger, parameters, &[]), 0, "{pipeline} with {name}");
    }
}

#[test]
fn bounds_hold_for_forward_depth_and_odd_maps() {
    let Some(gpu) = gpu::device() else { return };
    // Sides that no block divides; faces and layers of a few texels; an atlas with one tile.
    for (side, cube, atlas) in [("100", "100", "64"), ("16", "16", "64"), ("300", "72", "256")] {
        let parameters = [
            ("cascade_side", side),
            ("cube_side", cube),
            ("atlas_min_side", atlas),
            ("atlas_max_side", atlas),
            ("tile_max_side", "64"),
            ("tile_min_side", "16"),
            SHADOW_TERM,
        ];
        for (name, reverse) in [("courtyard", "false"), ("interior", "false"), ("interior", "true")] {
            let of = |bounds| {
                let features = [PCSS, bounds, ("reverse_z", reverse)];
                picture(&gpu, &outcome("awsm", &parameters, &features, &[]), name, 4.0)
            };
            let differ = of(FILTERS).differing(&of(BOUNDS), 0);
            assert_eq!(differ, 0, "{name} with sides {side}, {cube} and {atlas}, reverse {reverse}");
        }
    }
}

#[test]
fn bounds_hold_where_two_cascades_are_mixed() {
    let Some(gpu) = gpu::device() else { return };
    let mixed = r#"{
        "format": 1, "name": "mixed", "extends": "pipelines/umbra.json",
        "shared_settings": { "shadowed": { "settings": { "axes": { "cascade_blend": "mix" } } } }
    }"#;
    let parameters = [&[SHADOW_TERM], &with_small_maps(&[])[..]].concat();
    let of = |text: &str, bounds| {
        let features = [PCSS, bounds];
        let with = With { parameters: &parameters, features: &features, size: Some(SIZE), ..With::default() };
        picture(&gpu, &check_with("mixed.json", text, &with), "courtyard", 4.0)
    };
    let mixed_filters = of(mixed, FILTERS);
    assert_eq!(mixed_filters.differing(&of(mixed, BOUNDS), 0), 0);
    let umbra = r#"{ "format": 1, "name": "umbra", "extends": "pipelines/umbra.json" }"#;
    assert!(mixed_filters.differing(&of(umbra, FILTERS), 0) > 0, "the picture has no mixed cascades");
}

#[test]
fn lights_of_no_extent_or_no_number_are_as_before() {
    let Some(gpu) = gpu::device() else { return };
    let small = with_small_maps(&[]);
    for larger in [0.0, f32::NAN] {
        let differ = differing(&gpu, "umbra", "courtyard", larger, &small, &[]);
        assert_eq!(differ, 0, "lights {larger} times as large");
    }
}

#[test]
fn planted_faults_of_bounds_show_in_a_picture() {
    const BUILD: &str = "depth_bounds.wgsl.jinja";
    const LOOKUP: &str = "lib/shadow/depth_bounds.wgsl.jinja";
    let Some(gpu) = gpu::device() else { return };
    let small = with_small_maps(&[]);
    let parameters = [&[SHADOW_TERM], &small[..]].concat();
    let of = |bounds, edits: &[Edit]| {
        picture(&gpu, &outcome("umbra", &parameters, &[PCSS, bounds], edits), "courtyard", 6.0)
    };
    let right = of(FILTERS, &[]);
    for edit in [
        // A window without the neighbours of its block.
        (BUILD, "at < 9; at++", "at < 1; at++"),
        // A search that ends half way.
        (LOOKUP, "return Certainty(-1.0, distance)", "return Certainty(-1.0, 0.5 * distance)"),
        // Depth the wrong way round.
        (BUILD, "select(-depth, depth, reverse_z)", "select(depth, -depth, reverse_z)"),
    ] {
        let differ = right.differing(&of(BOUNDS, &[edit]), 0);
        println!("{differ} pixels differ with {}", edit.2);
        assert!(differ > 0, "no pixel shows the fault {}", edit.2);
    }
}

/// Reads of the maps and of their bounds by each pixel that faces the light, in the place of the shadow term.
fn reads(gpu: &Gpu, scene: &str, bounds: Setting<'_>) -> Vec<u8> {
    const COUNT: [Edit; 4] = [
        (
            "lib/shadow/receiver_plane.wgsl.jinja",
            "fn gather_depths(backing: u32, corner: vec2<f32>, layer: u32) -> vec4<f32> {",
            "var<private> reads: f32;\nfn gather_depths(backing: u32, corner: vec2<f32>, layer: u32) -> vec4<f32> {\n reads += 1.0;",
        ),
        (
            "lib/shadow/depth_bounds.wgsl.jinja",
            "    let block = vec2<i32>(texel)",
            "    reads += 1.0;\n    let block = vec2<i32>(texel)",
        ),
        (
            "lit.wgsl.jinja",
            "cosine <= 0.0 && debug_mode != SHADOW_TERM && debug_mode != CONTACT_TERM",
            "cosine <= 0.0",
        ),
        (
            "lit.wgsl.jinja",
            "return vec3<f32>(select(1.0, arrived / max(sent, 1e-30), sent > 0.0));",
            "return vec3<f32>((reads + 0.25) / 255.0);",
        ),
    ];
    let parameters = [SHADOW_TERM];
    let features = [PCSS, bounds, ("fxaa", "false")];
    let picture = picture(gpu, &outcome("umbra", &parameters, &features, &COUNT), scene, 1.0);
    picture.rgba_pixels().filter(|pixel| pixel[3] > 0 && pixel[0] > 0).map(|pixel| pixel[0]).collect()
}

#[test]
fn receivers_that_are_lit_or_dark_end_after_few_reads() {
    let Some(gpu) = gpu::device() else { return };
    println!("reads of a pixel that faces the light: mean before, mean with bounds, part with at most 8");
    for (name, max_ratio, min_few) in [("courtyard", 0.5, 0.7), ("foliage", 0.65, 0.45)] {
        let mean =
            |reads: &[u8]| reads.iter().map(|&reads| f64::from(reads)).sum::<f64>() / reads.len() as f64;
        let before = reads(&gpu, name, FILTERS);
        let after = reads(&gpu, name, BOUNDS);
        let few = after.iter().filter(|&&reads| reads <= 8).count() as f64 / after.len() as f64;
        println!("{name}: {:.1}, {:.1}, {few:.3}", mean(&before), mean(&after));
        assert!(mean(&after) <= max_ratio * mean(&before), "{name}: {} and {}", mean(&before), mean(&after));
        assert!(few >= min_few, "{name}: {few} of the pixels end after eight reads");
    }
}

#[test]
fn bounds_that_are_off_cost_nothing() {
    let cost = |features: &[Setting<'_>]| {
        let outcome = outcome("umbra", &[], features, &[]);
        let plan = outcome.plan();
        let bounds = plan.passes.iter().filter(|pass| pass.name.starts_with("depth_bounds")).count();
        (plan.passes.len(), bounds, plan.bytes)
    };
    let off = cost(&[FILTERS]);
    let on = cost(&[BOUNDS]);
    assert_eq!(off.1, 0);
    assert_eq!(on.1, 9);
    assert_eq!(on.0, off.0 + 9);
    assert!(on.2 > off.2);
    // A filter that has no use for bounds, and moments, make none.
    for other in [("light_filter", "\"poisson16\""), ("light_filter", "\"hard\"")] {
        assert_eq!(cost(&[other, BOUNDS]), cost(&[other, FILTERS]), "{other:?}");
    }
}
