//! Clustered lights: the pictures of shading by the lights that can reach a pixel are those of shading by all lights.

use std::f32::consts::FRAC_PI_2;
use std::f64::consts::TAU;

use crate::common::gpu::{Host, scene};
use crate::common::{Outcome, With, check_with, read, root, with_small_maps};
use glam::{DMat4, DQuat, DVec2, DVec3};
use serde_json::json;
use umbragraph::frame::{Camera, FrameInput, Light, LightKind, Projection};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

const SIZE: [u32; 2] = [160, 120];
const ASPECT: f64 = 160.0 / 120.0;

/// Lights around the origin: points, spots of any width in any direction, some without a range, and a sun.
fn lights(random: &mut Random, count: usize) -> Vec<Light> {
    let local = (0..count).map(|at| {
        let angle = 0.01 + random.unit() as f32 * (FRAC_PI_2 - 0.02);
        let kind = match at % 2 {
            0 => LightKind::Point,
            _ => LightKind::Spot { inner_angle: angle * random.unit() as f32, outer_angle: angle },
        };
        let place = DVec3::new(random.unit() * 20.0 - 10.0, random.unit() * 4.0, random.unit() * 20.0 - 10.0);
        let turn = DQuat::from_rotation_y(random.unit() * TAU) * DQuat::from_rotation_x(random.unit() * TAU);
        let color = DVec3::new(random.unit(), random.unit(), random.unit()).as_vec3();
        let light =
            Light::new(format!("light {at}"), kind).position(place).direction(turn * DVec3::Z).color(color);
        match at % 50 {
            49 => light.intensity(0.5),
            _ => light.intensity(20.0).range(0.2 + 3.0 * random.unit() as f32),
        }
    });
    let sun = Light::directional("sun", [0.3, -1.0, 0.2], [1.0; 3], 2.0).property("cast_shadow");
    local.chain([sun]).collect()
}

fn courtyard() -> Scene {
    scene(&root().join("examples/scenes/courtyard.glb"))
}

/// Plans a pipeline over another one, with clustered lights on or off.
fn checked(pipeline: &str, is_clustered: bool, with: &With<'_>) -> Outcome {
    let text = json!({
        "format": 1, "name": "many_lights", "extends": pipeline,
        "derived": { "clustered_lights": is_clustered }, "passes": {},
    });
    check_with("many_lights.json", &text.to_string(), with)
}

/// Draws a frame of the courtyard with clustered lights on or off.
fn picture(
    pipeline: &str,
    features: &[(&str, &str)],
    input: &FrameInput,
    is_clustered: bool,
) -> Option<Picture> {
    let gpu = gpu::device()?;
    let parameters = with_small_maps(&[("light_capacity", "400")]);
    let with = With { parameters: &parameters, features, size: Some(SIZE), ..With::default() };
    let outcome = checked(pipeline, is_clustered, &with);
    Some(Host::new(&gpu, &outcome, &courtyard()).picture(input))
}

/// Cameras of every projection, from places that the courtyard does not choose.
fn cameras(random: &mut Random) -> [Camera; 4] {
    let perspective = Projection::Perspective { vertical_fov: 0.9, near: 0.05, far: 300.0 };
    let endless = Projection::Perspective { vertical_fov: 1.6, near: 0.001, far: f64::INFINITY };
    let parallel = Projection::Orthographic { half_height: 6.0, near: -5.0, far: 60.0 };
    // Deferred shading takes no mirrored or oblique pictures, so this one is off centre alone.
    let moved = DMat4::from_translation(DVec3::new(0.3, -0.2, 0.0));
    let clip_from_view = moved * perspective.clip(ASPECT, false);
    let matrix = Projection::Matrix { clip_from_view, jitter: DVec2::new(0.004, -0.003) };
    let mut camera = |projection: Projection, pitch: f64| {
        let place =
            DVec3::new(random.unit() * 10.0 - 5.0, 1.0 + 5.0 * random.unit(), random.unit() * 10.0 - 5.0);
        let turn = DQuat::from_rotation_y(random.unit() * TAU) * DQuat::from_rotation_x(pitch);
        Camera::new(place, turn, projection, ASPECT)
    };
    [camera(perspective, -0.2), camera(endless, -0.5), camera(parallel, -0.7), camera(matrix, -0.3)]
}

#[test]
fn pictures_are_those_of_all_lights() {
    let mut random = Random(property::seed());
    let cases: [(&str, &[(&str, &str)]); 5] = [
        ("pipelines/awsm.json", &[("light_filter", "\"hard\""), ("msaa", "true")]),
        ("pipelines/umbra.json", &[]),
        ("pipelines/umbra.json", &[("deferred", "true"), ("visibility_first", "true")]),
        ("pipelines/umbra.json", &[("fog", "true")]),
        ("pipelines/umbra.json", &[("temporal", "true"), ("fog", "true"), ("half_resolution_fog", "true")]),
    ];
    let cameras = cameras(&mut random);
    let all_cases = cameras.iter().flat_map(|camera| cases.map(|case| (camera, case)));
    for (camera, (pipeline, features)) in property::part(all_cases, 6) {
        let input = courtyard().frame_input(ASPECT, 0.0).camera(*camera).lights(lights(&mut random, 300));
        let Some(all) = picture(pipeline, features, &input, false) else { return };
        let Some(clustered) = picture(pipeline, features, &input, true) else { return };
        let differing = clustered.differing(&all, 0);
        assert_eq!(differing, 0, "{pipeline} {features:?} from {:?}", camera.projection);
    }
}

#[test]
fn pixels_go_through_few_lights() {
    let Some(gpu) = gpu::device() else { return };
    let lights = lights(&mut Random(1), 300);
    // The debug view shows the number of lights that a pixel goes through, as a part of 512.
    let template = read("shaders-templates/lit.wgsl.jinja");
    let counted = template.replace(
        "if strength <= 0.0 ||",
        "arrived += 1.0;\n        sent = 512.0;\n        if true || strength <= 0.0 ||",
    );
    assert_ne!(counted, template, "the loop over lights has the text that is replaced");
    let means = [false, true].map(|is_clustered| {
        let with = With {
            parameters: &with_small_maps(&[("light_capacity", "400"), ("debug_view", "\"shadow_term\"")]),
            features: &[("light_filter", "\"hard\"")],
            templates: &[("lit.wgsl.jinja", counted.as_str())],
            size: Some(SIZE),
            ..With::default()
        };
        let outcome = checked("pipelines/awsm.json", is_clustered, &with);
        let input = courtyard().frame_input(ASPECT, 0.0).lights(lights.clone());
        let picture = Host::new(&gpu, &outcome, &courtyard()).picture(&input);
        picture.rgba_pixels().map(|pixel| f64::from(pixel[0])).sum::<f64>() / f64::from(SIZE[0] * SIZE[1])
    });
    println!("mean levels with all lights and with those of a cluster: {means:?}");
    assert!(means[1] > 0.0 && means[1] < 0.25 * means[0], "{means:?}");
}
