//! Extensions of a system as data alone: files of `pipelines/extended`.

use crate::common::gpu::{Host, read, render, render_frame, scene};
use crate::common::{With, check_file, root, with_small_maps};
use umbragraph::frame::{FrameInput, LightKind};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

const SIZE: [u32; 2] = [256, 144];
const TERM: (&str, &str) = ("debug_view", "\"shadow_term\"");
const LORE: &str = "pipelines/lore.json";

fn load(name: &str) -> Scene {
    scene(&root().join("examples/scenes").join(name))
}

fn extended(name: &str) -> String {
    format!("pipelines/extended/{name}.json")
}

fn draw(
    gpu: &Gpu,
    path: &str,
    scene: &Scene,
    parameters: &[(&str, &str)],
    features: &[(&str, &str)],
) -> Picture {
    let with = With { parameters, features, size: Some(SIZE), ..With::default() };
    render(gpu, &check_file(path, &with), scene)
}

/// The visibility of the light where there is geometry, 0 to 255.
fn term(picture: &Picture) -> Vec<f64> {
    picture.rgba_pixels().filter(|pixel| pixel[3] == 255).map(|pixel| f64::from(pixel[0])).collect()
}

fn partly(term: &[f64]) -> usize {
    term.iter().filter(|lit| (16.0..240.0).contains(*lit)).count()
}

fn mean_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / a.len() as f64
}

#[test]
fn each_addition_to_a_system_takes_at_most_fifty_lines() {
    let of_lore = ["lore_pcss", "lore_evsm", "lore_vsm", "lore_local_lights", "lore_temporal"];
    for name in of_lore {
        let text = std::fs::read_to_string(root().join(extended(name))).expect("a file");
        assert!(text.lines().count() <= 50, "{name} has {} lines", text.lines().count());
        assert!(
            text.contains("\"extends\": \"../lore.json\"")
                || text.contains("\"extends\": \"lore_evsm.json\"")
        );
        check_file(&extended(name), &With::default()).plan();
    }
}

/// With the colors of surfaces in 16 bits and the planes of triangles beside them; a noise of the world would take
/// another cell where a surface lies between two, so the filter is hard.
#[test]
fn a_list_of_lights_shows_the_same_deferred_and_forward() {
    let Some(gpu) = gpu::device() else { return };
    let interior = load("interior.glb");
    for reverse in ["true", "false"] {
        let features = [("light_filter", "\"hard\""), ("reverse_z", reverse)];
        let [forward, deferred] = ["pipelines/awsm.json", &extended("awsm_deferred")].map(|path| {
            let with = With { features: &features, size: Some([640, 360]), ..With::default() };
            let outcome = check_file(path, &with);
            Host::new(&gpu, &outcome, &interior).picture(&interior.frame_input(640.0 / 360.0, 0.0))
        });
        let differing = forward.differing(&deferred, 2);
        println!("reverse_z {reverse}: {differing} of {} pixels differ by more than 2 levels", 640 * 360);
        // Depth that is not reversed has few digits, and planes as much slack.
        let allowed = if reverse == "true" { 640 * 360 / 10_000 } else { 640 * 360 / 200 };
        assert!(differing <= allowed, "{differing} pixels differ, reverse_z {reverse}");
    }
}

#[test]
fn deferred_lights_have_contact_shadows_and_visibility_first() {
    let Some(gpu) = gpu::device() else { return };
    let interior = load("interior.glb");
    let parameters = with_small_maps(&[]);
    for more in [("contact_shadows", "true"), ("visibility_first", "true")] {
        let features = [("light_filter", "\"hard\""), more];
        let [forward, deferred] = ["pipelines/awsm.json", &extended("awsm_deferred")].map(|path| {
            let with =
                With { parameters: &parameters, features: &features, size: Some(SIZE), ..With::default() };
            let outcome = check_file(path, &with);
            Host::new(&gpu, &outcome, &interior).picture(&interior.frame_input(256.0 / 144.0, 0.0))
        });
        let differing = forward.differing(&deferred, 2);
        assert!(differing <= 4, "{more:?}: {differing} pixels differ");
    }
}

#[test]
fn penumbrae_are_as_wide_as_the_sun_and_hard_where_things_stand() {
    let Some(gpu) = gpu::device() else { return };
    let courtyard = load("courtyard.glb");
    let mut input = courtyard.frame_input(256.0 / 144.0, 0.0);
    input.lights.iter_mut().for_each(|light| light.angular_diameter = 0.0);
    let of = |angle: &str| {
        let parameters = [TERM, ("sun_angle", angle), ("filter_radius", "0.5")];
        let with = With { parameters: &parameters, size: Some(SIZE), ..With::default() };
        term(&render_frame(&gpu, check_file(&extended("lore_pcss"), &with).plan(), &courtyard, &input))
    };
    let widths = ["0", "0.01", "0.04"].map(|angle| partly(&of(angle)));
    println!("pixels partly lit by the sun's angle: {widths:?}");
    assert!(widths[0] * 5 < widths[1] * 4 && widths[1] * 5 < widths[2] * 4, "{widths:?}");
    let single = term(&draw(&gpu, LORE, &courtyard, &[TERM, ("shadow_filter", "\"hard\"")], &[]));
    let sharp = mean_difference(&of("0"), &single);
    assert!(sharp < 6.0, "without an angle shadows are those of one comparison: {sharp}");
}

#[test]
fn blurred_moments_shadow_what_comparisons_do() {
    let Some(gpu) = gpu::device() else { return };
    let courtyard = load("courtyard.glb");
    let single = term(&draw(&gpu, LORE, &courtyard, &[TERM, ("shadow_filter", "\"hard\"")], &[]));
    let dark = |term: &[f64]| term.iter().filter(|lit| **lit < 64.0).count() as f64;
    for name in ["lore_evsm", "lore_vsm"] {
        let mut partial = Vec::new();
        for radius in ["0", "6"] {
            let parameters = [TERM, ("blur_radius", radius)];
            let moments = term(&draw(&gpu, &extended(name), &courtyard, &parameters, &[]));
            let (difference, part) = (mean_difference(&moments, &single), dark(&moments) / dark(&single));
            println!(
                "{name}, blurred by {radius}: {difference:.1} levels from one comparison, {part:.2} of its shadow"
            );
            assert!(
                difference < 16.0 && (0.7..1.2).contains(&part),
                "{name}, {radius}: {difference}, {part}"
            );
            partial.push(partly(&moments));
        }
        assert!(partial[1] > partial[0], "{name}: a blur is soft: {partial:?}");
    }
    // Other settings of the system still choose its comparisons.
    let with = [TERM, ("shadow_filter", "\"hard\"")];
    let again = draw(&gpu, &extended("lore_evsm"), &courtyard, &with, &[]);
    assert_eq!(term(&again), term(&draw(&gpu, LORE, &courtyard, &with, &[("map_array", "true")])));
}

#[test]
fn lamps_light_and_shadow_what_the_sun_leaves() {
    let Some(gpu) = gpu::device() else { return };
    let interior = load("interior.glb");
    let path = extended("lore_local_lights");
    let play = |input: &FrameInput| {
        let outcome = check_file(&path, &With { size: Some(SIZE), ..With::default() });
        Host::new(&gpu, &outcome, &interior).picture(input)
    };
    let input = interior.frame_input(256.0 / 144.0, 0.0);
    let lit = play(&input);
    let mean = |picture: &Picture| {
        picture.rgba_pixels().map(|pixel| f64::from(pixel[1])).sum::<f64>() / f64::from(SIZE[0] * SIZE[1])
    };
    let sun_alone = draw(&gpu, LORE, &interior, &[], &[]);
    let mut unshadowed = input.clone();
    unshadowed.lights.iter_mut().for_each(|light| light.properties.clear());
    unshadowed
        .lights
        .extend(input.lights.iter().filter(|light| light.kind == LightKind::Directional).cloned());
    unshadowed.lights.retain(|light| light.kind != LightKind::Directional || !light.properties.is_empty());
    let (lamps, sun, all) = (mean(&lit), mean(&sun_alone), mean(&play(&unshadowed)));
    println!(
        "mean green: {sun:.1} by the sun, {lamps:.1} with lamps, {all:.1} with lamps that cast no shadows"
    );
    assert!(sun + 5.0 < lamps && lamps + 1.0 < all, "{sun} {lamps} {all}");
    // Without lamps it is the system itself.
    let mut without = input;
    without.lights.retain(|light| light.kind == LightKind::Directional);
    assert_eq!(play(&without).differing(&sun_alone, 0), 0);
}

#[test]
fn a_visibility_that_gathers_loses_its_noise_and_follows_a_walk() {
    let Some(gpu) = gpu::device() else { return };
    let courtyard = load("courtyard.glb");
    let usual = [TERM, ("filter_radius", "4")];
    let outcome = check_file(
        &extended("lore_temporal"),
        &With { parameters: &usual, size: Some(SIZE), ..With::default() },
    );
    let fine = [TERM, ("filter_radius", "4"), ("shadow_filter", "\"poisson64\"")];
    let walk = |index: u64| {
        let mut input = courtyard.frame_input(256.0 / 144.0, 0.0);
        input.camera.position.z -= 0.01 * index.saturating_sub(24).min(8) as f64;
        input.index(index)
    };
    let mut host = Host::new(&gpu, &outcome, &courtyard);
    let mut errors = Vec::new();
    for index in 0..=64 {
        host.frame(&walk(index));
        if [0, 24, 32, 64].contains(&index) {
            let reference =
                check_file(LORE, &With { parameters: &fine, size: Some(SIZE), ..With::default() });
            let fine = Host::new(&gpu, &reference, &courtyard).picture(&walk(index));
            errors.push(mean_difference(&term(&read(&gpu, &host.target)), &term(&fine)));
        }
    }
    println!(
        "levels from sixty-four taps: {errors:.2?} in the first frame, after 24, after 8 of a walk, 32 later"
    );
    // A walk moves what was gathered by parts of pixels, which softens what is as thin as a pixel.
    assert!(errors[1] < 0.8 * errors[0] && errors[2] < 12.0 && errors[3] < 2.0 * errors[0], "{errors:?}");
}
