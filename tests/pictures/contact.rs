//! Contact shadows of `pipelines/awsm.json`, which march towards lights in the depth of the picture.
//!
//! The oracle marches too, in 64 bits, in the depth that was read back: what it finds has to be in the picture, but for
//! pixels in which a step falls so close to an edge that the digits decide.

use crate::common::gpu::{Host, import, scene};
use crate::common::{Outcome, With, check_file, check_with, root};
use glam::{DVec2, DVec3};
use umbragraph::executor::read_back;
use umbragraph::frame::{Camera, FrameInput, Light, LightKind, Projection};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::truth::{self, Scores, TruthScene};

const AWSM: &str = "pipelines/awsm.json";
const SIZE: [u32; 2] = [320, 180];
const CONTACT_TERM: (&str, &str) = ("debug_view", "\"contact_term\"");

/// A pipeline that is `awsm` but for some of its passes and resources.
fn changed(changes: &str, with: &With<'_>) -> Outcome {
    let text = format!(r#"{{ "format": 1, "name": "changed", "extends": "{AWSM}", {changes} }}"#);
    check_with("changed.json", &text, with)
}

fn figure() -> Scene {
    scene(&root().join("examples/scenes/figure.glb"))
}

fn light(kind: LightKind) -> Light {
    let position = DVec3::new(2.4, 2.9, 2.6);
    Light::new("light", kind)
        .position(position)
        .direction((DVec3::new(-0.3, 0.5, -0.4) - position).normalize())
        .intensity(60.0)
        .range(20.0)
        .property("cast_shadow")
        .property("contact_shadow")
}

fn frame(scene: &Scene, light: Light) -> FrameInput {
    scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0).lights(vec![light])
}

/// The share of pixels whose grey differs by more than so much.
fn differing(a: &Picture, b: &[f64], by: f64) -> f64 {
    let pixels = a.rgba_pixels().zip(b);
    let count = pixels.filter(|(pixel, b)| (f64::from(pixel[0]) / 255.0 - **b).abs() > by).count();
    count as f64 / b.len() as f64
}

/// The contact shadow of each pixel from a march on the CPU: sixteen steps of 4 cm.
fn marched(depth: &[f64], camera: &Camera, light: &Light, strength: f64, fade: Option<f64>) -> Vec<f64> {
    const STEPS: usize = 16;
    let [width, height] = SIZE;
    let (near, far) = camera.projection.depth_range();
    let is_orthographic = camera.projection.is_orthographic();
    let (_, half) = camera.projection.picture(camera.aspect);
    // Along the view axis, from reverse depth.
    let distance = |x: u32, y: u32| {
        let depth = depth[(y * width + x) as usize];
        let parallel = depth * near + (1.0 - depth) * far;
        let perspective = 1.0 / (depth / near + (1.0 - depth) / far);
        (depth > 0.0).then_some(if is_orthographic { parallel } else { perspective })
    };
    let at = |x: u32, y: u32| {
        let Some(from) = distance(x, y) else { return 0.0 };
        let uv =
            DVec2::new((f64::from(x) + 0.5) / f64::from(width), (f64::from(y) + 0.5) / f64::from(height));
        let across = DVec2::new(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0) * half;
        let place = (across * if is_orthographic { 1.0 } else { from }).extend(-from);
        let to_view = camera.rotation.inverse();
        let offset = to_view * (light.position - camera.position) - place;
        let (to_light, room) = match light.kind {
            LightKind::Directional => (to_view * -light.direction, f64::INFINITY),
            _ => (offset.normalize(), offset.length()),
        };
        let mut hits = 0;
        for step in 0..STEPS {
            let along = 0.04 * (1.0 + step as f64);
            let place = place + to_light * along;
            let across = place.truncate() / (half * if is_orthographic { 1.0 } else { -place.z });
            let [u, v] = [0.5 + 0.5 * across.x, 0.5 - 0.5 * across.y];
            if along >= room || -place.z <= near || !(0.0..1.0).contains(&u) || !(0.0..1.0).contains(&v) {
                break;
            }
            let seen = distance((u * f64::from(width)) as u32, (v * f64::from(height)) as u32);
            if seen.is_some_and(|seen| (-place.z - seen) > 0.002 && (-place.z - seen) < 0.05) {
                if let Some(fade) = fade {
                    return 1.0 - strength * ((1.0 - step as f64 / STEPS as f64) / fade).min(1.0);
                }
                hits += 1;
            }
        }
        1.0 - strength * f64::from(hits) / STEPS as f64
    };
    (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect()
}

#[test]
fn the_march_finds_what_one_on_the_cpu_finds_in_the_same_depth() {
    let Some(gpu) = gpu::device() else { return };
    let scene = figure();
    let perspective = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0).camera;
    let orthographic =
        perspective.projection(Projection::Orthographic { half_height: 1.8, near: 0.1, far: 30.0 });
    let spot = LightKind::Spot { inner_angle: 0.45, outer_angle: 0.6 };
    for (form, fade) in [("\"proportional\"", None), ("\"first_hit\"", Some(0.5))] {
        let with = With {
            parameters: &[
                CONTACT_TERM,
                ("contact_form", form),
                ("contact_strength", "0.8"),
                ("contact_jitter", "0"),
            ],
            size: Some(SIZE),
            ..With::default()
        };
        let outcome =
            changed(r#""resources": { "depth": { "texture": { "lifetime": "imported" } } }"#, &with);
        for (kind, camera) in [
            (LightKind::Directional, perspective),
            (spot, perspective),
            (LightKind::Point, perspective),
            (LightKind::Directional, orthographic),
            (LightKind::Point, orthographic),
        ] {
            let input = frame(&scene, light(kind)).camera(camera);
            let mut host = Host::new(&gpu, &outcome, &scene);
            host.imports.push(("depth", import(&gpu, outcome.plan(), "depth")));
            let picture = host.picture(&input);
            let depth = read_back(&gpu.device, &gpu.queue, &host.imports[0].1);
            let depth = pollster::block_on(depth).expect("depth").values;
            let depth: Vec<f64> = depth.iter().map(|texel| f64::from(texel[0])).collect();
            let expected = marched(&depth, &camera, &input.lights[0], 0.8, fade);
            // Outside the cone nothing arrives, and no term is shown.
            let is_cone = matches!(kind, LightKind::Spot { .. });
            let expected: Vec<f64> = picture
                .rgba_pixels()
                .zip(expected)
                .map(|(pixel, value)| if is_cone && pixel == [255; 4] { 1.0 } else { value })
                .collect();
            let dark = expected.iter().filter(|value| **value > 0.0 && **value < 0.99).count();
            let share = differing(&picture, &expected, 0.01);
            println!("{form} {kind:?}: {dark} pixels in shadow, {:.3} % differ", 100.0 * share);
            assert!(dark > 500, "{form} {kind:?}: {dark} pixels in shadow");
            assert!(share < 0.002, "{form} {kind:?}: {share} of the pixels differ");
        }
    }
}

/// The scores of hard shadows from small maps and the biases that `awsm` had before it found its own.
fn scores(truth: &TruthScene, contact: &str) -> Scores {
    let gpu = gpu::device().expect("a device");
    let (width, height) = truth.size();
    let with = With {
        file: Some("pipelines/params/awsm_contact_sun.json"),
        parameters: &[
            ("debug_view", "\"shadow_term\""),
            ("cascade_side", "1024"),
            ("normal_offset", "0.5"),
            ("constant_bias", "0.0005"),
            ("slope_bias", "1.5"),
        ],
        preset: Some("fine_contact"),
        features: &[("light_filter", "\"hard\""), ("contact_shadows", contact)],
        size: Some([width, height]),
        ..With::default()
    };
    let scene = scene(&truth.glb_path());
    let input = scene.frame_input(f64::from(width) / f64::from(height), 0.0);
    let picture = Host::new(&gpu, &check_file(AWSM, &with), &scene).picture(&input);
    truth::evaluate(truth, &picture).expect("a picture of the scene's size")
}

#[test]
fn the_first_hit_halves_what_leaks_at_contacts_and_adds_no_acne() {
    let Some(truth) = TruthScene::find("contact_sun") else { return };
    if gpu::device().is_none() {
        return;
    }
    let [before, after] = ["false", "true"].map(|contact| scores(&truth, contact));
    let leak = |scores: &Scores| scores.contact_leak().expect("a mask of contacts");
    let acne = |scores: &Scores| {
        [0, 1, 2, 4].map(|band| scores.band(band).and_then(truth::BandScore::acne).unwrap_or(0.0))
    };
    println!("contact leak {:.4}, with contact shadows {:.4}", leak(&before), leak(&after));
    println!("acne by band {:.4?}, with contact shadows {:.4?}", acne(&before), acne(&after));
    assert!(leak(&before) >= 0.02 && leak(&after) <= 0.5 * leak(&before));
    for (before, after) in acne(&before).into_iter().zip(acne(&after)) {
        assert!(after <= before + 0.001, "{after} after {before}");
    }
}

#[test]
fn a_light_has_contact_shadows_only_where_it_asks_for_them() {
    let Some(gpu) = gpu::device() else { return };
    let scene = figure();
    let with =
        With { parameters: &[CONTACT_TERM, ("contact_strength", "1")], size: Some(SIZE), ..With::default() };
    let outcome = check_file(AWSM, &with);
    let dark = |properties: &[&'static str]| {
        let mut light = light(LightKind::Directional);
        light.properties = properties.iter().map(|word| (*word).into()).collect();
        let picture = Host::new(&gpu, &outcome, &scene).picture(&frame(&scene, light));
        picture.rgba_pixels().filter(|pixel| pixel[0] < 255 && pixel[3] == 255).count()
    };
    assert!(dark(&["cast_shadow", "contact_shadow"]) > 500);
    for without in [&["cast_shadow"][..], &["contact_shadow"], &[]] {
        assert_eq!(dark(without), 0, "{without:?}");
    }
}

#[test]
fn lights_without_a_slot_are_named_and_have_no_contact_shadows() {
    let Some(gpu) = gpu::device() else { return };
    let scene = figure();
    let parameters = [CONTACT_TERM, ("contact_strength", "1"), ("slot_capacity", "1")];
    let with = With { parameters: &parameters, size: Some(SIZE), ..With::default() };
    let outcome = check_file(AWSM, &with);
    let first = light(LightKind::Point).priority(9.0);
    let mut second = light(LightKind::Point).position([-2.4, 2.9, 2.6]);
    second.name = "second".into();
    let both = frame(&scene, first.clone()).lights(vec![second, first]);
    let mut host = Host::new(&gpu, &outcome, &scene);
    host.picture(&both);
    let notices = host.notices().join("\n");
    assert!(notices.contains("UG0621") && notices.contains("second"), "{notices}");
}

#[test]
fn the_first_of_four_samples_of_depth_is_marched_in() {
    let Some(gpu) = gpu::device() else { return };
    let scene = figure();
    let picture = |msaa| {
        let with = With {
            parameters: &[CONTACT_TERM, ("contact_strength", "1"), ("contact_form", "\"first_hit\"")],
            features: &[("msaa", msaa)],
            size: Some(SIZE),
            ..With::default()
        };
        let outcome = check_file(AWSM, &with);
        Host::new(&gpu, &outcome, &scene).picture(&frame(&scene, light(LightKind::Directional)))
    };
    let (one, four) = (picture("false"), picture("true"));
    let grey: Vec<f64> = one.rgba_pixels().map(|pixel| f64::from(pixel[0]) / 255.0).collect();
    let share = differing(&four, &grey, 0.1);
    println!("{:.2} % of the pixels differ", 100.0 * share);
    // Along edges, and where the first sample of a pixel sees another step.
    assert!(share > 0.0 && share < 0.03, "{share}");
}

#[test]
fn without_a_depth_that_can_be_read_a_diagnostic_says_so() {
    let with = With { features: &[("contact_shadows", "true")], ..With::default() };
    let gather = |bind: &str| {
        format!(
            r#""passes": {{ "gather": {{ "fullscreen": {{ "bind": {{ "picture_depth": {bind} }} }} }} }}"#
        )
    };
    for (changes, code, words) in [
        // Nothing is bound.
        (gather("null"), "UG0604", "picture_depth"),
        // No pass has drawn it before.
        (r#""passes": { "prepass": null }"#.to_owned(), "UG0207", "depth"),
        // No depth is in its format.
        (
            r#""resources": { "depth": { "texture": { "format": "stencil8" } } }"#.to_owned(),
            "UG0323",
            "depth",
        ),
        (
            r#""resources": { "depth": { "texture": { "format": "r32float" } } }"#.to_owned(),
            "UG0323",
            "depth",
        ),
    ] {
        let outcome = changed(&changes, &with);
        assert!(outcome.codes().contains(&code) && outcome.text().contains(words), "{}", outcome.text());
    }
}

#[test]
fn contact_shadows_that_are_off_take_no_memory_and_no_pass() {
    let plan = |contact| {
        let with =
            With { features: &[("contact_shadows", contact)], without_aliasing: true, ..With::default() };
        check_file(AWSM, &with).plan().clone()
    };
    let (on, off) = (plan("true"), plan("false"));
    // Eight lights in four bytes each four, for each of 640 by 480 pixels.
    assert_eq!(on.resources["visibility"].bytes, 640 * 480 * 4 * 2);
    assert!(!off.resources.contains_key("visibility"));
    assert_eq!(on.bytes - off.bytes, 640 * 480 * 4 * 2);
    let added = |pass: &&str| !off.passes.iter().any(|other| other.name == **pass);
    let names: Vec<&str> = on.passes.iter().map(|pass| pass.name.as_str()).collect();
    let added: Vec<&str> = names.iter().filter(|name| added(name)).copied().collect();
    assert_eq!(added, ["prepass", "gather.0", "gather.1", "shade_gathered"]);
}
