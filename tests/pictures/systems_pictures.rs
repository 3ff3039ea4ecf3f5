//! Pictures of the systems that are data only: against ray-traced truth where that is at hand, and of their traps.

use crate::common::gpu::{render, scene};
use crate::common::{With, check_file, root};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::truth::{self, TruthScene};

const MANTIS: &str = "pipelines/mantis.json";
const CARACAL: &str = "pipelines/caracal.json";
const LORE: &str = "pipelines/lore.json";
const MIXTURE: &str = "tests/systems/mixture.json";

/// Renders the shadow term of a truth scene, holds it to the limits and compares it with a plain reference.
#[track_caller]
fn meets_the_limits(
    pipeline: &str,
    name: &str,
    file: Option<&str>,
    parameters: &[(&str, &str)],
    reference: f64,
) {
    let Some(truth) = TruthScene::find(name) else { return };
    let Some(gpu) = gpu::device() else { return };
    let (width, height) = truth.size();
    let mut all = vec![("debug_view", "\"shadow_term\"")];
    all.extend_from_slice(parameters);
    let with = With { file, parameters: &all, size: Some([width, height]), ..With::default() };
    let picture = render(&gpu, &check_file(pipeline, &with), &scene(&truth.glb_path()));
    let scores = truth::evaluate(&truth, &picture).expect("a picture of the scene's size");
    if let Err(broken) = truth::check(&scores, &truth.hard_limits().expect("limits")) {
        panic!("{pipeline} on {name}: {broken}");
    }
    let iou = scores.band(0).expect("every pixel is in band 0").intersection_over_union().unwrap_or(0.0);
    assert!(iou > reference, "{pipeline} on {name} reaches {iou}, a plain reference {reference}");
}

#[test]
fn each_tuned_system_beats_a_reference_on_small_things() {
    meets_the_limits(MANTIS, "contact_sun", Some("pipelines/params/mantis_contact_sun.json"), &[], 0.984);
    meets_the_limits(CARACAL, "contact_sun", Some("pipelines/params/caracal_contact_sun.json"), &[], 0.984);
    meets_the_limits(LORE, "contact_sun", Some("pipelines/params/lore_contact_sun.json"), &[], 0.984);
}

#[test]
fn each_tuned_system_beats_a_reference_on_a_landscape() {
    meets_the_limits(
        MANTIS,
        "terrain_dem_sun",
        Some("pipelines/params/mantis_terrain_dem_sun.json"),
        &[],
        0.992,
    );
    meets_the_limits(
        CARACAL,
        "terrain_dem_sun",
        Some("pipelines/params/caracal_terrain_dem_sun.json"),
        &[],
        0.992,
    );
    meets_the_limits(LORE, "terrain_dem_sun", Some("pipelines/params/lore_terrain_dem_sun.json"), &[], 0.992);
}

#[test]
fn a_mixture_that_no_code_was_written_for_meets_the_limits() {
    meets_the_limits(MIXTURE, "contact_sun", None, &[("far", "[2.5, 5]")], 0.984);
    meets_the_limits(MIXTURE, "terrain_dem_sun", None, &[("far", "[250, 700, 1500]")], 0.992);
}

fn courtyard(gpu: &Gpu, pipeline: &str, parameters: &[(&str, &str)], features: &[(&str, &str)]) -> Picture {
    let with = With { parameters, features, size: Some([256, 144]), ..With::default() };
    render(gpu, &check_file(pipeline, &with), &scene(&root().join("examples/scenes/courtyard.glb")))
}

/// The mean of a channel.
fn mean(picture: &Picture, channel: usize) -> f64 {
    let sum: f64 = picture.rgba_pixels().map(|pixel| f64::from(pixel[channel])).sum();
    sum / picture.rgba_pixels().count() as f64
}

#[test]
fn cascades_are_chosen_by_the_distance_along_the_view_axis() {
    let Some(gpu) = gpu::device() else { return };
    for (pipeline, end) in [(MANTIS, ""), (CARACAL, ""), (LORE, ", 5000")] {
        // The first cascade is tinted red, the third blue.
        let blue_over_red = |far: &str| {
            let far = format!("[{far}{end}]");
            let picture = courtyard(&gpu, pipeline, &[("debug_view", "\"cascades\""), ("far", &far)], &[]);
            mean(&picture, 2) / mean(&picture, 0)
        };
        let (first, third) = (blue_over_red("2000, 3000, 4000"), blue_over_red("0.2, 0.3, 4000"));
        assert!(third > 1.5 * first, "{pipeline}: {first} in the first, {third} in the third");
    }
}

#[test]
fn both_depth_conventions_shadow_the_same_pixels() {
    let Some(gpu) = gpu::device() else { return };
    for pipeline in [MANTIS, CARACAL, LORE, MIXTURE] {
        let parameters = [("debug_view", "\"shadow_term\"")];
        let [forward, reverse] =
            ["false", "true"].map(|value| courtyard(&gpu, pipeline, &parameters, &[("reverse_z", value)]));
        let pairs = forward.rgba_pixels().zip(reverse.rgba_pixels());
        let different = pairs.filter(|(a, b)| a[0].abs_diff(b[0]) > 32).count();
        assert!(different * 500 < 256 * 144, "{pipeline}: {different} pixels differ");
        let shadowed = forward.rgba_pixels().filter(|pixel| pixel[3] == 255 && pixel[0] < 128).count();
        assert!(shadowed > 1000, "{pipeline}: {shadowed} pixels are shadowed");
    }
}

#[test]
fn beyond_the_cascades_and_with_shadows_off_all_is_lit() {
    let Some(gpu) = gpu::device() else { return };
    let is_lit = |picture: Picture| picture.rgba_pixels().all(|pixel| pixel[3] == 0 || pixel[0] == 255);
    let term = ("debug_view", "\"shadow_term\"");
    for pipeline in [MANTIS, CARACAL] {
        assert!(is_lit(courtyard(&gpu, pipeline, &[term, ("far", "[0.11, 0.12, 0.13]")], &[])), "{pipeline}");
    }
    assert!(is_lit(courtyard(&gpu, LORE, &[term, ("far", "[0.11, 0.12, 0.13, 0.14]")], &[])));
    assert!(is_lit(courtyard(&gpu, LORE, &[term, ("max_distance", "0")], &[])));
    assert!(is_lit(courtyard(&gpu, CARACAL, &[term, ("shadows", "false")], &[])));
    assert!(!is_lit(courtyard(&gpu, CARACAL, &[term], &[])));
}

#[test]
fn deferred_and_forward_lighting_show_the_same() {
    let Some(gpu) = gpu::device() else { return };
    // At most one pixel of ten thousand. Depth that is not reversed has fewer digits far away: positions found from it
    // are centimetres off at 200 m, where edges of shadows then lie in another pixel.
    for (filter, reverse, allowed) in
        [("\"hard\"", "true", 3), ("\"grid5\"", "true", 3), ("\"hard\"", "false", 36)]
    {
        let (parameters, features) = ([("shadow_filter", filter)], [("reverse_z", reverse)]);
        let [deferred, forward] = [LORE, "tests/systems/lore_forward.json"]
            .map(|pipeline| courtyard(&gpu, pipeline, &parameters, &features));
        let count = deferred.differing(&forward, 2);
        assert!(count <= allowed, "{filter}, {reverse}: {count} pixels differ");
    }
}

#[test]
fn quality_presets_render_the_courtyard_each_differently() {
    let Some(gpu) = gpu::device() else { return };
    let courtyard = scene(&root().join("examples/scenes/courtyard.glb"));
    let mut terms: Vec<Picture> = Vec::new();
    for preset in ["low", "medium", "high", "ultra"] {
        let parameters = &[("debug_view", "\"shadow_term\"")];
        let with = With { preset: Some(preset), parameters, size: Some([192, 108]), ..With::default() };
        let picture = render(&gpu, &check_file(LORE, &with), &courtyard);
        let shadowed = picture.rgba_pixels().filter(|pixel| pixel[3] == 255 && pixel[0] < 64).count();
        assert!(shadowed > 1500, "{preset}: {shadowed} pixels are shadowed");
        if let Some(first) = terms.first() {
            let close =
                picture.rgba_pixels().zip(first.rgba_pixels()).filter(|(a, b)| a[0].abs_diff(b[0]) < 96);
            assert!(close.count() > 192 * 108 * 9 / 10, "{preset} is of the same scene");
        }
        for other in &terms {
            assert!(picture.differing(other, 2) > 100, "{preset} is another");
        }
        terms.push(picture);
    }
}

#[test]
fn mixed_map_sizes_shadow_alike_in_array_and_textures() {
    let Some(gpu) = gpu::device() else { return };
    let parameters =
        [("debug_view", "\"shadow_term\""), ("resolutions", "[512, 1024, 256, 64]"), ("border", "2")];
    let [textures, array] =
        ["false", "true"].map(|value| courtyard(&gpu, LORE, &parameters, &[("map_array", value)]));
    assert!(textures.differing(&array, 2) * 10_000 <= 256 * 144);
    let finer =
        [("debug_view", "\"shadow_term\""), ("resolutions", "[512, 1024, 1024, 1024]"), ("border", "2")];
    assert!(textures.differing(&courtyard(&gpu, LORE, &finer, &[]), 2) > 100, "each has its own size");
}

#[test]
fn the_preset_clean_takes_the_acne_of_caracal_away() {
    let Some(gpu) = gpu::device() else { return };
    let courtyard = scene(&root().join("examples/scenes/courtyard.glb"));
    // The face of the tower, which the sun grazes.
    let grey = |preset: Option<&str>| {
        let parameters = &[("debug_view", "\"shadow_term\"")];
        let with = With { preset, parameters, size: Some([320, 180]), ..With::default() };
        let picture = render(&gpu, &check_file(CARACAL, &with), &courtyard);
        let pixels: Vec<[u8; 4]> = picture.rgba_pixels().collect();
        let part = (56..68).flat_map(|y| (126..137).map(move |x| y * 320 + x));
        part.filter(|at| pixels[*at][0] < 250).count()
    };
    let (usual, clean) = (grey(None), grey(Some("clean")));
    assert!(usual > 40 && clean < usual / 4, "{usual} grey pixels, {clean} with the preset");
}
