//! Shadow masks against ray-traced truth, where that is at hand (`../shared/truth`, or `UMBRAGRAPH_TRUTH`).

use crate::common::gpu::{render, scene};
use crate::common::{With, check_file};
use umbragraph_test_support::gpu;
use umbragraph_test_support::truth::{self, TruthScene};

/// Renders the shadow term of a truth scene and holds it to the limits.
#[track_caller]
fn meets_the_limits(pipeline: &str, name: &str, parameters: &[(&str, &str)], reference_iou: f64) {
    let Some(truth) = TruthScene::find(name) else { return };
    let Some(gpu) = gpu::device() else { return };
    let (width, height) = truth.size();
    let mut all = vec![("debug_view", "\"shadow_term\"")];
    all.extend_from_slice(parameters);
    let with = With { parameters: &all, size: Some([width, height]), ..With::default() };
    let outcome = check_file(pipeline, &with);
    let picture = render(&gpu, &outcome, &scene(&truth.glb_path()));
    let scores = truth::evaluate(&truth, &picture).expect("a picture of the scene's size");
    let limits = truth.hard_limits().expect("limits");
    if let Err(broken) = truth::check(&scores, &limits) {
        panic!("{pipeline} on {name}: {broken}");
    }
    let whole = scores.band(0).expect("every pixel is in band 0");
    let iou = whole.intersection_over_union().unwrap_or(0.0);
    println!("{pipeline} on {name}: IoU {iou:.4}, a plain reference has {reference_iou}");
    assert!(iou > reference_iou, "{pipeline} on {name} reaches {iou}, a plain reference {reference_iou}");
}

#[test]
fn nebula_beats_a_plain_reference_on_a_landscape() {
    meets_the_limits("pipelines/nebula.json", "terrain_dem_sun", &[], 0.992);
}

#[test]
fn nebula_beats_a_plain_reference_on_small_things() {
    meets_the_limits("pipelines/nebula.json", "contact_sun", &[("far", "[3, 6, 12, 30]")], 0.984);
}

#[test]
fn nebula_meets_the_limits_with_spheres_and_with_larger_maps() {
    meets_the_limits("pipelines/nebula.json", "terrain_dem_sun", &[("fit", "\"sphere\"")], 0.975);
    meets_the_limits(
        "pipelines/nebula.json",
        "contact_sun",
        &[("far", "[2, 4, 8, 30]"), ("resolution", "4096")],
        0.984,
    );
}
