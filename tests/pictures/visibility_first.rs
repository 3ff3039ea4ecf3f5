//! Visibility that is gathered for each pixel before shading reads it, in `pipelines/awsm.json`: as if the maps were
//! sampled in the shading, but for the edges of things and what is thinner than three pixels, since surfaces are found
//! from depth.

use crate::common::gpu::{Host, scene};
use crate::common::{With, check_file, root};
use umbragraph::frame::FrameInput;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::truth::{self, BandScore, TruthScene};

const AWSM: &str = "pipelines/awsm.json";
const SIZE: [u32; 2] = [480, 270];

/// The visibility of the interior's lights, and notices.
fn shadow_term(parameters: &[(&str, &str)], features: &[(&str, &str)]) -> Option<(Picture, Vec<String>)> {
    let gpu = gpu::device()?;
    let mut all = vec![("debug_view", "\"shadow_term\"")];
    all.extend_from_slice(parameters);
    let with = With { parameters: &all, features, size: Some(SIZE), ..With::default() };
    let scene = scene(&root().join("examples/scenes/interior.glb"));
    let input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
    let outcome = check_file(AWSM, &with);
    let mut host = Host::new(&gpu, &outcome, &scene);
    let picture = host.picture(&input);
    Some((picture, host.notices()))
}

/// The share of pixels whose grey differs by more than so much.
fn differing(a: &Picture, b: &Picture, by: u8) -> f64 {
    let pixels = a.rgba_pixels().zip(b.rgba_pixels());
    let count = pixels.filter(|(a, b)| a[0].abs_diff(b[0]) > by).count();
    count as f64 / f64::from(SIZE[0] * SIZE[1])
}

#[test]
fn what_is_gathered_first_is_what_the_shading_would_find() {
    // Far away forward depth has few digits; of four samples the shading sees all, and the pass before it the first.
    for (filter, msaa, reverse, limit) in [
        ("\"hard\"", "false", "true", 0.03),
        ("\"hard\"", "false", "false", 0.05),
        ("\"poisson16\"", "false", "true", 0.04),
        ("\"hard\"", "true", "true", 0.11),
    ] {
        let picture = |first: &str| {
            let features = [
                ("rotate_taps", "false"),
                ("light_filter", filter),
                ("visibility_first", first),
                ("msaa", msaa),
                ("reverse_z", reverse),
            ];
            shadow_term(&[("local_light_radius", "0.05")], &features).map(|(picture, _)| picture)
        };
        let (Some(inline), Some(first)) = (picture("false"), picture("true")) else { return };
        let share = differing(&inline, &first, 12);
        println!(
            "{filter}, multisampled {msaa}, reverse {reverse}: {:.2} % of the pixels differ",
            100.0 * share
        );
        assert!(share > 0.0 && share < limit, "{filter}: {share}");
    }
}

#[test]
fn what_is_gathered_first_agrees_with_ray_traced_masks() {
    for (name, min) in [("contact_sun", 0.9935), ("terrain_dem_sun", 0.998), ("room_point", 0.996)] {
        let Some(truth) = TruthScene::find(name) else { return };
        let Some(gpu) = gpu::device() else { return };
        let (width, height) = truth.size();
        let file = format!("pipelines/params/awsm_{name}.json");
        let with = With {
            file: root().join(&file).exists().then_some(&file),
            parameters: &[("debug_view", "\"shadow_term\"")],
            features: &[("light_filter", "\"hard\""), ("visibility_first", "true")],
            size: Some([width, height]),
            ..With::default()
        };
        let scene = scene(&truth.glb_path());
        let input: FrameInput = scene.frame_input(f64::from(width) / f64::from(height), 0.0);
        let picture = Host::new(&gpu, &check_file(AWSM, &with), &scene).picture(&input);
        let scores = truth::evaluate(&truth, &picture).expect("a picture of the scene's size");
        let iou = scores.band(0).and_then(BandScore::intersection_over_union).unwrap_or(0.0);
        println!("{name}: IoU {iou:.4}");
        assert!(iou >= min, "{name} reaches {iou}");
    }
}

#[test]
fn denoising_takes_the_grain_and_leaves_the_edges() {
    let picture = |denoise: &str, taps: &str| {
        let features = [("light_filter", "\"vogel\""), ("visibility_first", "true"), ("denoise", denoise)];
        let parameters = [("filter_radius", "0.3"), ("max_radius", "40"), ("vogel_taps", taps)];
        shadow_term(&parameters, &features).map(|(picture, _)| picture)
    };
    let Some(exact) = picture("false", "64") else { return };
    let error = |picture: &Picture| {
        let sum: u64 =
            picture.rgba_pixels().zip(exact.rgba_pixels()).map(|(a, b)| u64::from(a[0].abs_diff(b[0]))).sum();
        sum as f64 / f64::from(SIZE[0] * SIZE[1]) / 255.0
    };
    let (noisy, smooth) = (picture("false", "4").expect("one"), picture("true", "4").expect("one"));
    println!("mean error of four taps {:.4}, denoised {:.4}", error(&noisy), error(&smooth));
    assert!(error(&smooth) < 0.7 * error(&noisy));
}

#[test]
fn lights_without_a_slot_are_lit_and_named() {
    let Some((_, notices)) = shadow_term(&[("slot_capacity", "4")], &[("visibility_first", "true")]) else {
        return;
    };
    let notices = notices.join("\n");
    assert!(notices.contains("UG0621") && notices.contains("no more slots"), "{notices}");
}

#[test]
fn what_is_off_takes_no_memory() {
    let plan = |first, denoise| {
        let features = [("visibility_first", first), ("denoise", denoise)];
        let with = With { features: &features, without_aliasing: true, ..With::default() };
        check_file(AWSM, &with).plan().clone()
    };
    let layers = 640 * 480 * 4 * 2;
    let (off, first, smooth) = (plan("false", "true"), plan("true", "false"), plan("true", "true"));
    assert_eq!(first.bytes - off.bytes, layers);
    assert_eq!(smooth.bytes - first.bytes, layers);
    assert!(!off.resources.contains_key("visibility") && !first.resources.contains_key("denoised"));
}
