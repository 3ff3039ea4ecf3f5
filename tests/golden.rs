//! Pictures of the project's own scene, held to references from Mesa's software driver.

mod common;

use common::gpu::{render, scene};
use common::{With, check_file, root};
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::{GoldenFolder, Tolerance};

#[track_caller]
fn matches_its_reference(name: &str, parameters: &[(&str, &str)]) {
    let Some(gpu) = gpu::device() else { return };
    let with = With { parameters, size: Some([480, 270]), ..With::default() };
    let outcome = check_file("pipelines/nebula.json", &with);
    let picture = render(&gpu, &outcome, &scene(&root().join("examples/scenes/courtyard.glb")));
    // Other drivers filter and rasterise a little differently along edges.
    let tolerance = Tolerance { per_channel: 6, failed_pixels: 480 * 270 / 200 };
    GoldenFolder::new(root().join("tests/golden")).check(name, &picture, &tolerance).expect_match();
}

#[test]
fn the_courtyard_is_lit() {
    matches_its_reference("courtyard", &[]);
}

#[test]
fn the_courtyard_as_shadow_term() {
    matches_its_reference("courtyard_shadow_term", &[("debug_view", "\"shadow_term\"")]);
}

#[test]
fn the_courtyard_tinted_by_cascade() {
    matches_its_reference(
        "courtyard_cascades",
        &[("debug_view", "\"cascades\""), ("far", "[8, 20, 50, 200]")],
    );
}
