//! `pipelines/nebula.json`: what is asserted of its defaults, of any setting, and of the traps that it avoids.

use crate::common::gpu::{executor, import, read, render, render_frame, scene};
use crate::common::host::{floats, published};
use crate::common::{With, check_file, root};
use umbragraph::Frame;
use umbragraph::frame::FrameInput;
use umbragraph::low_level::expression::Value;
use umbragraph::scene::Scene;
use umbragraph::scene::gpu::SceneResources;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;

const NEBULA: &str = "pipelines/nebula.json";

fn courtyard() -> Scene {
    scene(&root().join("examples/scenes/courtyard.glb"))
}

fn numbers(outcome: &crate::common::Outcome, name: &str) -> Vec<f64> {
    outcome.plan().pipeline.parameters[name].value.numbers().unwrap()
}

#[test]
fn the_defaults_are_those_of_the_system() {
    let outcome = check_file(NEBULA, &With::default());
    let plan = outcome.plan();
    let maps = plan.resources["maps"].size.unwrap();
    let resolution = numbers(&outcome, "resolution")[0] as u32;
    assert_eq!(
        (maps.width, maps.height, maps.layers),
        (resolution, resolution, 4),
        "one layer for each cascade"
    );
    assert_eq!(numbers(&outcome, "far"), [32.0, 128.0, 512.0, 2048.0]);
    let bias = numbers(&outcome, "constant_bias")[0];
    assert!(0.0 < bias && bias < 10.0);
    assert!(numbers(&outcome, "slope_bias")[0] > 0.0);
    assert!(numbers(&outcome, "normal_offset")[0] < 4.0);
    assert_eq!(plan.pipeline.features["reverse_z"].value, Value::Bool(true));
}

#[test]
fn default_cascades_increase_reach_1_km_and_blend_over_1_m() {
    let outcome = check_file(NEBULA, &With::default());
    let mut frame = courtyard().frame_input(1.0, 0.0);
    frame.camera.projection =
        umbragraph::frame::Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 5000.0 };
    let data = published(outcome.plan(), "fit", &frame);
    assert_eq!(data.views().len(), 4, "one view for each cascade");
    let (far, blend) = (floats(&data, "far"), floats(&data, "blend_start"));
    assert!(far.windows(2).all(|pair| pair[0] < pair[1]) && far[3] >= 1000.0);
    assert!(far.iter().zip(&blend).all(|(far, blend)| far - blend >= 1.0), "{far:?} {blend:?}");
    for (at, far) in far.iter().enumerate() {
        assert!((blend[at] - far * 0.95).abs() < 1e-3 * far, "the blend starts at 0.95 of the far distance");
    }
}

#[test]
fn an_identity_camera_gives_finite_other_matrices() {
    let outcome = check_file(NEBULA, &With::default());
    let mut frame = courtyard().frame_input(1.0, 0.0);
    frame.camera.position = Default::default();
    frame.camera.rotation = Default::default();
    let data = published(outcome.plan(), "fit", &frame);
    assert!(!data.views().is_empty());
    for view in data.views() {
        assert!(view.clip_from_world.is_finite());
        assert_ne!(view.clip_from_world, glam::DMat4::IDENTITY);
    }
}

#[test]
fn the_number_of_far_distances_is_the_number_of_cascades() {
    for (far, count) in [("[50]", 1), ("[10, 50]", 2), ("[10, 20, 50]", 3)] {
        let outcome = check_file(NEBULA, &With { parameters: &[("far", far)], ..With::default() });
        assert_eq!(outcome.plan().resources["maps"].size.unwrap().layers, count);
    }
}

#[test]
fn far_distances_must_increase_and_numbers_stay_in_range() {
    let codes = |name: &str, value: &str| {
        check_file(NEBULA, &With { parameters: &[(name, value)], ..With::default() }).codes()
    };
    assert_eq!(codes("far", "[32, 32]"), ["UG0205"]);
    assert_eq!(codes("far", "[32, 16]"), ["UG0205"]);
    assert_eq!(codes("far", "[]"), ["UG0204"]);
    assert_eq!(codes("far", "[1, 2, 3, 4, 5]"), ["UG0204"]);
    assert_eq!(codes("resolution", "8"), ["UG0204"]);
    assert_eq!(codes("resolution", "100.5"), ["UG0203"]);
    assert_eq!(codes("constant_bias", "-1"), ["UG0204"]);
    assert_eq!(codes("fit", "\"loose\""), ["UG0107"]);
    let nearly_equal = codes("far", "[32, 32.0000000001]");
    assert!(!nearly_equal.is_empty(), "equal once they are rounded to 32 bits");
}

#[test]
fn the_blend_is_of_the_far_distance_or_of_the_range() {
    let frame = courtyard().frame_input(1.0, 0.0);
    let start = |of: &str| {
        let outcome = check_file(NEBULA, &With { parameters: &[("blend_of", of)], ..With::default() });
        floats(&published(outcome.plan(), "fit", &frame), "blend_start")[1]
    };
    assert!((start("\"far\"") - 128.0 * 0.95).abs() < 1e-3);
    assert!((start("\"range\"") - (128.0 - 96.0 * 0.05)).abs() < 1e-3);
}

#[test]
fn comparisons_are_made_without_derivatives() {
    let outcome = check_file(NEBULA, &With::default());
    let pipeline = &outcome.plan().pipeline;
    let forward = pipeline.programs.iter().find(|program| program.template == "forward.wgsl.jinja").unwrap();
    for variant in &forward.variants {
        assert!(variant.module.wgsl.contains("textureSampleCompareLevel("));
        assert!(!variant.module.wgsl.contains("textureSampleCompare("));
    }
}

fn shadow_term(gpu: &gpu::Gpu, parameters: &[(&str, &str)]) -> Picture {
    let mut all = vec![("debug_view", "\"shadow_term\"")];
    all.extend_from_slice(parameters);
    let with = With { parameters: &all, size: Some([256, 256]), ..With::default() };
    render(gpu, &check_file(NEBULA, &with), &courtyard())
}

fn shadowed(picture: &Picture) -> usize {
    picture.rgba_pixels().filter(|pixel| pixel[3] == 255 && pixel[0] < 128).count()
}

#[test]
fn beyond_the_last_cascade_everything_is_lit() {
    let Some(gpu) = gpu::device() else { return };
    let all = shadowed(&shadow_term(&gpu, &[]));
    let none = shadowed(&shadow_term(&gpu, &[("far", "[0.2]")]));
    assert!(all > 1000, "{all} pixels are shadowed");
    assert_eq!(none, 0, "the cascade ends in front of everything");
}

#[test]
fn forward_and_reverse_depth_give_the_same_picture() {
    let Some(gpu) = gpu::device() else { return };
    let scene = courtyard();
    for view in ["\"off\"", "\"shadow_term\""] {
        let picture = |reverse: &str| {
            let with = With {
                parameters: &[("debug_view", view)],
                features: &[("reverse_z", reverse)],
                size: Some([512, 512]),
                ..With::default()
            };
            render(&gpu, &check_file(NEBULA, &with), &scene)
        };
        let (forward, reverse) = (picture("false"), picture("true"));
        let differ = forward.rgba_pixels().zip(reverse.rgba_pixels()).filter(|(a, b)| a != b).count();
        let max = 512 * 512 / 10_000;
        println!("{view}: {differ} pixels differ, {max} may");
        assert!(differ <= max, "{view}: {differ} pixels differ, {max} may");
    }
}

#[test]
fn the_shadow_term_is_grey_with_alpha_where_there_is_geometry() {
    let Some(gpu) = gpu::device() else { return };
    let picture = shadow_term(&gpu, &[]);
    let mut sky = 0;
    for [red, green, blue, alpha] in picture.rgba_pixels() {
        assert!(red == green && green == blue);
        assert!(alpha == 255 || (alpha == 0 && red == 0), "{red} {alpha}");
        sky += usize::from(alpha == 0);
    }
    assert!(sky > 0);
}

#[test]
fn a_frame_without_a_light_is_lit_also_between_frames_with_one() {
    let Some(gpu) = gpu::device() else { return };
    let scene = courtyard();
    let with =
        With { parameters: &[("debug_view", "\"shadow_term\"")], size: Some([128, 128]), ..With::default() };
    let outcome = check_file(NEBULA, &with);
    let resources = SceneResources::new(&gpu.device, &gpu.queue, &scene, &scene.pose(0.0)).unwrap();
    let target = import(&gpu, outcome.plan(), "target");
    let mut executor = executor(&gpu, outcome.plan(), Some(&resources));
    let mut record = |frame: &FrameInput| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(frame).draws(&resources).imports(&[("target", &target)]))
            .unwrap();
        gpu.queue.submit([encoder.finish()]);
        shadowed(&read(&gpu, &target))
    };
    let lit = scene.frame_input(1.0, 0.0);
    assert!(record(&lit) > 0);
    let mut unlit = lit.clone();
    unlit.lights.clear();
    assert_eq!(record(&unlit), 0);
    assert!(record(&lit) > 0);
}

#[test]
fn frames_that_no_pass_could_use_are_drawn_without_a_panic() {
    let Some(gpu) = gpu::device() else { return };
    let scene = courtyard();
    let with = With { size: Some([64, 64]), ..With::default() };
    let outcome = check_file(NEBULA, &with);
    let sound = scene.frame_input(1.0, 0.0);
    let mut broken = vec![sound.clone(); 4];
    broken[0].camera.position = glam::DVec3::splat(f64::NAN);
    broken[1].lights[0].direction = glam::DVec3::ZERO;
    broken[2].camera.aspect = 0.0;
    broken[3].filter_bounds = vec![("casters".into(), umbragraph::frame::Bounds::EMPTY)];
    for frame in broken {
        let picture = render_frame(&gpu, outcome.plan(), &scene, &frame);
        assert!(
            picture.rgba_pixels().all(|pixel| pixel[3] == 255),
            "every pixel is written: {:?}",
            frame.camera
        );
    }
}
