//! The flagship with its defaults: against ray-traced truth, at every scale, in the first frame after a cut, and how
//! many texels a fit to what is seen gives.

use crate::common::gpu::{Host, read, scene};
use crate::common::host::published;
use crate::common::{Outcome, With, check_file, check_with, root};
use glam::{DMat3, DMat4, DQuat, DVec3};
use umbragraph::executor::read_back;
use umbragraph::frame::{Camera, FrameInput, Projection};
use umbragraph::scene::Scene;
use umbragraph::scene::node::LocalTransform;
use umbragraph_score::{Rays, Rendered, Scores, Truth};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;
use umbragraph_test_support::truth::{self, BandScore, TruthScene};

const UMBRA: &str = "pipelines/umbra.json";
const SHADOW_TERM: (&str, &str) = ("debug_view", "\"shadow_term\"");

fn umbra(parameters: &[(&str, &str)], features: &[(&str, &str)], size: [u32; 2]) -> Outcome {
    let mut all = vec![SHADOW_TERM];
    all.extend_from_slice(parameters);
    check_file(UMBRA, &With { parameters: &all, features, size: Some(size), ..With::default() })
}

fn courtyard() -> Scene {
    scene(&root().join("examples/scenes/courtyard.glb"))
}

/// Masks of truth scenes with the defaults: the intersection over union that hard shadows have to reach, in bands 0 and
/// 2, and the mean error that soft ones may have.
#[test]
fn defaults_agree_with_ray_traced_shadows() {
    const SIZE: [u32; 2] = [512, 512];
    let outcomes = [&[("light_filter", "\"hard\"")][..], &[]].map(|features| umbra(&[], features, SIZE));
    for (name, min, max) in
        [("contact_sun", 0.995, 0.005), ("terrain_dem_sun", 0.997, 0.0035), ("room_point", 0.9965, 0.011)]
    {
        let Some(truth) = TruthScene::find(name) else { return };
        let Some(gpu) = gpu::device() else { return };
        let scene = scene(&truth.glb_path());
        let input = scene.frame_input(1.0, 0.0);
        let [hard, soft] = outcomes.each_ref().map(|outcome| {
            let picture = Host::new(&gpu, outcome, &scene).picture(&input);
            truth::evaluate(&truth, &picture).expect("a picture of the scene's size")
        });
        let iou = |band| hard.band(band).and_then(BandScore::intersection_over_union).unwrap_or(0.0);
        let error = soft.soft.expect("a soft mask").mean_error;
        println!("{name}: IoU {:.4}, {:.4} off the edges; mean error {error:.4}", iou(0), iou(2));
        assert!(iou(0) >= min && iou(2) >= 0.9998 && error <= max, "{name}");
    }
}

/// Edges of hard shadows that run between texels: nine texels place them better than four.
#[test]
fn smooth_edges_are_nearer_to_those_of_rays() {
    const SIZE: [u32; 2] = [320, 180];
    let Some(gpu) = gpu::device() else { return };
    let scene = courtyard();
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let rays = Rays::new(&scene, &scene.pose(0.0));
    let truth = Truth::new(&rays, &input.camera, SIZE);
    let light = truth.light(&input.lights[0]).expect("a usable light");
    let [stepped, smooth] = ["false", "true"].map(|smooth| {
        let outcome = umbra(&[("smooth_edges", smooth)], &[("light_filter", "\"hard\"")], SIZE);
        let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
        let scores = Scores::of(&truth, &light, Rendered::new(picture.bytes()));
        scores.band(0).leaking + scores.band(0).acne
    });
    println!("{stepped} pixels differ from rays, {smooth} with smooth edges");
    assert!(smooth * 20 < stepped * 19, "{stepped} and {smooth} pixels differ from rays");
}

/// Lit in the shader of every material, or in one pass over what was drawn of surfaces: shadows lie in the same pixels.
#[test]
fn deferred_and_forward_shading_show_the_same() {
    const SIZE: [u32; 2] = [256, 144];
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/figure.glb"));
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let cases = [("false", "shadow_term"), ("false", "off"), ("true", "shadow_term"), ("true", "off")];
    for (visibility_first, view) in property::part(cases, 4) {
        let picture = |deferred| {
            let view = format!("\"{view}\"");
            let with = With {
                parameters: &[("debug_view", &view), ("cascade_side", "1024")],
                features: &[
                    ("light_filter", "\"hard\""),
                    ("deferred", deferred),
                    ("visibility_first", visibility_first),
                ],
                size: Some(SIZE),
                ..With::default()
            };
            Host::new(&gpu, &check_file(UMBRA, &with), &scene).picture(&input)
        };
        let count = picture("true").differing(&picture("false"), 3);
        assert!(count * 2000 <= 256 * 144, "{visibility_first}, {view}: {count} pixels differ");
    }
}

/// A scene and all that it is looked at with, so many times as large.
fn scaled(scene: &Scene, scale: f64) -> Scene {
    let mut scene = scene.clone();
    for node in scene.nodes.iter_mut().filter(|node| node.parent.is_none()) {
        node.local = LocalTransform::Matrix(DMat4::from_scale(DVec3::splat(scale)) * node.local.matrix());
    }
    for camera in &mut scene.cameras {
        if let Projection::Perspective { near, far, .. } = &mut camera.projection {
            *near *= scale;
            *far *= scale;
        }
    }
    scene
}

#[test]
fn scenes_of_every_scale_are_shadowed_alike() {
    const SIZE: [u32; 2] = [240, 135];
    let Some(gpu) = gpu::device() else { return };
    let courtyard = courtyard();
    for (features, what) in [(&[("light_filter", "\"hard\"")][..], "hard"), (&[], "as it comes")] {
        let outcome = umbra(&[], features, SIZE);
        let scores = [1.0, 0.01, 100.0].map(|scale| {
            let scene = scaled(&courtyard, scale);
            let input = scene.frame_input(16.0 / 9.0, 0.0);
            let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
            let rays = Rays::new(&scene, &scene.pose(0.0));
            let truth = Truth::new(&rays, &input.camera, SIZE);
            let light = truth.light(&input.lights[0]).expect("a usable light");
            let scores = Scores::of(&truth, &light, Rendered::new(picture.bytes()));
            (scores.iou().expect("shadows"), scores.mean_error.mean().expect("a light with an extent"))
        });
        println!("{what}: {scores:.4?}");
        // Where edges are soft, their width is what is scored; where half of the light arrives is a matter of noise.
        let differ = |(iou, error): &(f64, f64)| {
            if features.is_empty() { (error - scores[0].1).abs() } else { (iou - scores[0].0).abs() }
        };
        assert!(scores[1..].iter().all(|other| differ(other) <= 0.002), "{what}: {scores:?}");
        assert!(scores[0].0 > 0.9, "{what}: {scores:?}");
    }
}

/// A camera somewhere in a scene, or within a wall of it, that looks anywhere.
fn camera(numbers: &mut Random, input: &FrameInput) -> Camera {
    let mut random = || numbers.unit();
    let size = DVec3::new(30.0, 12.0, 30.0);
    let position = DVec3::new(random() - 0.5, random() * 0.6, random() - 0.5) * size + DVec3::Y * 0.3;
    let (turn, tilt) = (random() * std::f64::consts::TAU, (random() - 0.7) * 1.2);
    let rotation = DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(tilt);
    let projection = match (random() * 5.0) as u32 {
        0 => Projection::Orthographic { half_height: 0.5 + 10.0 * random(), near: -20.0, far: 100.0 },
        _ => Projection::Perspective {
            vertical_fov: 0.3 + random(),
            near: 0.02 + 0.2 * random(),
            far: if random() < 0.5 { 200.0 } else { 1e5 },
        },
    };
    input.camera.position(position).rotation(rotation).projection(projection)
}

/// After each of 200 cuts the first frame is that of a run that has seen nothing else.
#[test]
fn the_first_frame_after_a_cut_is_that_of_a_fresh_run() {
    let Some(gpu) = gpu::device() else { return };
    let scene = courtyard();
    let outcome = umbra(&[("cascade_side", "512")], &[], [96, 54]);
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let mut running = Host::new(&gpu, &outcome, &scene);
    running.picture(&input);
    let mut numbers = Random(property::seed());
    let cameras: Vec<Camera> = (0..200).map(|_| camera(&mut numbers, &input)).collect();
    let mut shadowed = 0;
    for camera in property::part(cameras, 40) {
        let cut = input.clone().camera(camera);
        assert!(!running.frame(&cut), "sizes that change");
        let picture = read(&gpu, &running.target);
        let fresh = Host::new(&gpu, &outcome, &scene).picture(&cut);
        assert_eq!(picture.bytes(), fresh.bytes(), "{camera:?}");
        shadowed +=
            usize::from(picture.bytes().chunks_exact(4).any(|pixel| pixel[3] == 255 && pixel[0] == 0));
    }
    assert!(shadowed > 1, "{shadowed} pictures have shadows");
}

/// Two hundred walks out of a wall: the camera stands within it, or just before it, and then in front; what it saw
/// there is none of the range that it sees now.
#[test]
fn a_walk_out_of_a_wall_leaves_no_trace_in_the_next_frame() {
    let Some(gpu) = gpu::device() else { return };
    let scene = courtyard();
    let outcome = umbra(&[("cascade_side", "512")], &[], [96, 54]);
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let rays = Rays::new(&scene, &scene.pose(0.0));
    let mut running = Host::new(&gpu, &outcome, &scene);
    running.picture(&input);
    let mut numbers = Random(property::seed().wrapping_add(1));
    let mut walks = Vec::new();
    while walks.len() < 200 {
        let before = camera(&mut numbers, &input);
        let back = before.rotation * DVec3::Z;
        // Behind the camera there is a wall not far away, into which it is put; it walks out of it the way it looks.
        let Some(wall) = rays.seen(before.position, back, [0.1, 40.0]) else { continue };
        let place = |distance: f64| before.position(before.position + back * distance);
        walks.push([wall.distance + 0.05, wall.distance - 0.02, wall.distance - 0.5].map(place));
    }
    for walk in property::part(walks, 50) {
        for camera in walk {
            let step = input.clone().camera(camera);
            assert!(!running.frame(&step), "sizes that change");
            let picture = read(&gpu, &running.target);
            let fresh = Host::new(&gpu, &outcome, &scene).picture(&step);
            assert_eq!(picture.bytes(), fresh.bytes(), "{camera:?}");
        }
    }
}

/// A view of the sky, of a single depth, or of a wall close to the camera leaves the shadows whole.
#[test]
fn a_view_of_nothing_or_of_one_depth_is_fitted_too() {
    let Some(gpu) = gpu::device() else { return };
    let scene = courtyard();
    let outcome = umbra(&[("cascade_side", "512")], &[("light_filter", "\"hard\"")], [96, 54]);
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let mut host = Host::new(&gpu, &outcome, &scene);
    let mut term = |camera: Camera| host.picture(&input.clone().camera(camera));
    let up = DQuat::from_rotation_x(1.5);
    let sky = term(input.camera.position(DVec3::new(0.0, 300.0, 0.0)).rotation(up));
    assert!(sky.bytes().chunks_exact(4).all(|pixel| pixel[3] == 0), "nothing is hit");
    // Straight down, so that the ground has one depth.
    let down = DQuat::from_mat3(&DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y));
    let projection = Projection::Orthographic { half_height: 0.4, near: 0.0, far: 50.0 };
    let ground = term(Camera::new(DVec3::new(1.0, 3.0, 9.0), down, projection, 16.0 / 9.0));
    let rays = Rays::new(&scene, &scene.pose(0.0));
    let camera = Camera::new(DVec3::new(1.0, 3.0, 9.0), down, projection, 16.0 / 9.0);
    let truth = Truth::new(&rays, &camera, [96, 54]);
    let light = truth.light(&input.lights[0]).expect("a usable light");
    let scores = Scores::of(&truth, &light, Rendered::new(ground.bytes()));
    assert!(scores.hit > 5000 && scores.band(1).leaking + scores.band(1).acne < 20, "{scores:?}");
}

/// The width of a texel of the nearest cascade, along both axes, as a pipeline has it.
fn nearest_texel(
    gpu: &Gpu,
    features: &[(&str, &str)],
    lights: &str,
    input: &FrameInput,
    scene: &Scene,
) -> [f32; 2] {
    // A pass that shows what cascades are.
    const SHOWN: &str = "{% include \"lib/fullscreen.wgsl.jinja\" %}\n{% include \"lib/light_list.wgsl.jinja\" %}\n\
        @fragment fn show(covered: Covered) -> @location(0) vec4<f32> { return lights.map[lights.cube_end].texels; }\n";
    let text = format!(
        r#"{{ "format": 1, "name": "shown", "extends": "umbra.json",
  "resources": {{ "shown": {{ "texture": {{ "format": "rgba32float", "size": [1, 1], "lifetime": "imported" }} }} }},
  "passes": {{ "show": {{ "fullscreen": {{ "shader": "shown.wgsl.jinja", "bind": {{ "lights": "&{lights}" }}, "color": [{{ "to": "&shown" }}] }} }} }} }}"#
    );
    let axes = r#"{ "inherits": ["lib/light_list.wgsl.jinja"], "axes": {} }"#;
    let templates = [("shown.wgsl.jinja", SHOWN), ("shown.axes.json", axes)];
    let parameters = [("lambda", "0.5")];
    let parameters = if features.is_empty() { &[][..] } else { &parameters };
    let with =
        With { parameters, features, templates: &templates, size: Some([320, 180]), ..With::default() };
    let outcome = check_with("pipelines/shown.json", &text, &with);
    let mut host = Host::new(gpu, &outcome, scene);
    host.imports.push(("shown", crate::common::gpu::import(gpu, outcome.plan(), "shown")));
    host.picture(input);
    let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, &host.imports[0].1)).expect("numbers");
    let [x, y, ..] = texels.values[0];
    [1.0 / x.abs(), 1.0 / y.abs()]
}

#[test]
fn what_is_nearest_has_twice_the_texels_of_practical_splits() {
    let Some(gpu) = gpu::device() else { return };
    let scene = courtyard();
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let seen = nearest_texel(&gpu, &[], "fitted_lights", &input, &scene);
    let features = [("whole_range", "true")];
    let practical = nearest_texel(&gpu, &features, "lights", &input, &scene);
    let linear = [0, 1].map(|axis| practical[axis] / seen[axis]);
    println!("texels of {seen:?} m in place of {practical:?} m: {:.2} times as many", linear[0] * linear[1]);
    assert!(
        linear[0] * linear[1] >= 2.0 && linear.iter().all(|times| *times > 1.3),
        "{seen:?} {practical:?}"
    );
}

/// The CPU culls against the whole range: no caster that a fitted cascade needs is left out.
#[test]
fn views_of_the_cpu_hold_the_whole_range_of_the_camera() {
    let outcome = umbra(&[], &[], [96, 54]);
    let scene = courtyard();
    let input = scene.frame_input(16.0 / 9.0, 0.0);
    let data = published(outcome.plan(), "directional", &input);
    let (_, far) = input.camera.projection.depth_range();
    assert_eq!(data.views().len(), 4);
    for view in data.views() {
        for depth in [1.0_f64, 10.0, 60.0] {
            for corner in input.camera.slice_corners(depth.min(far)) {
                let within = corner.clamp(input.scene_bounds.min, input.scene_bounds.max);
                let clip = view.clip_from_world.project_point3(within);
                assert!(clip.truncate().abs().max_element() <= 1.0, "{depth} m: {clip}");
            }
        }
    }
}
