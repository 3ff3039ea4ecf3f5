//! Lights of every kind through one interface: `pipelines/awsm.json`.

use std::sync::Arc;

use crate::common::gpu::{Host, read, scene};
use crate::common::host::{published, quiet_frame};
use crate::common::{Outcome, With, check_file, root, with_small_maps};
use glam::{DVec3, Vec3};
use umbragraph::Executor;
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::scene::Scene;
use umbragraph::wgpu_types::Limits;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;
use umbragraph_test_support::property;
use umbragraph_test_support::truth::{self, BandScore, Scores, TruthScene};

const AWSM: &str = "pipelines/awsm.json";
const SHADOW_TERM: (&str, &str) = ("debug_view", "\"shadow_term\"");

fn interior() -> Scene {
    scene(&root().join("examples/scenes/interior.glb"))
}

/// A small picture with small maps.
fn small(parameters: &[(&str, &str)], features: &[(&str, &str)]) -> Outcome {
    let all = with_small_maps(parameters);
    check_file(AWSM, &With { parameters: &all, features, size: Some([160, 120]), ..With::default() })
}

fn light(name: &str, kind: LightKind, position: [f64; 3]) -> Light {
    Light::new(name.to_owned(), kind)
        .position(DVec3::from(position))
        .intensity(60.0)
        .range(14.0)
        .property("cast_shadow")
}

fn spot(name: &str, position: [f64; 3]) -> Light {
    light(name, LightKind::Spot { inner_angle: 0.5, outer_angle: 0.7 }, position)
}

fn lamp(name: &str, position: [f64; 3]) -> Light {
    light(name, LightKind::Point, position)
}

/// A scene in other light.
fn lit_by(scene: &Scene, lights: Vec<Light>) -> FrameInput {
    scene.frame_input(160.0 / 120.0, 0.0).lights(lights)
}

/// The lights of a scene.
fn lights_of(scene: &Scene) -> Vec<Light> {
    scene.frame_input(1.0, 0.0).lights
}

/// The scores of a filter on a truth scene, after holding them to the limits. Biases are automatic; ranges come from
/// the scene's file.
#[track_caller]
fn scores(name: &str, filter: &str, features: &[(&str, &str)]) -> Option<Scores> {
    let truth = TruthScene::find(name)?;
    let gpu = gpu::device()?;
    let (width, height) = truth.size();
    let mut all = vec![("light_filter", filter)];
    all.extend_from_slice(features);
    let file = format!("pipelines/params/awsm_{name}.json");
    let with = With {
        file: root().join(&file).exists().then_some(&file),
        parameters: &[SHADOW_TERM],
        features: &all,
        size: Some([width, height]),
        ..With::default()
    };
    let outcome = check_file(AWSM, &with);
    let scene = scene(&truth.glb_path());
    let input = scene.frame_input(f64::from(width) / f64::from(height), 0.0);
    let picture = Host::new(&gpu, &outcome, &scene).picture(&input);
    let scores = truth::evaluate(&truth, &picture).expect("a picture of the scene's size");
    let limits = if filter == HARD { truth.hard_limits() } else { truth.soft_limits() };
    if let Err(broken) = truth::check(&scores, &limits.expect("limits")) {
        panic!("{name}: {broken}");
    }
    Some(scores)
}

const HARD: &str = "\"hard\"";

#[test]
fn hard_shadows_match_rays_without_a_bias_per_scene() {
    for (name, min, reference) in
        [("contact_sun", 0.994, 0.984), ("terrain_dem_sun", 0.998, 0.992), ("room_point", 0.9965, 0.995)]
    {
        for reverse in ["true", "false"] {
            let Some(scores) = scores(name, HARD, &[("reverse_z", reverse)]) else { return };
            let iou = scores.band(0).and_then(BandScore::intersection_over_union).unwrap_or(0.0);
            println!("{name}, reverse depth {reverse}: IoU {iou:.4}, a plain reference has {reference}");
            assert!(iou >= min, "{name} reaches {iou}");
        }
    }
}

#[test]
fn soft_shadows_match_rays_with_one_set_of_parameters() {
    for (name, max, reference) in
        [("contact_sun", 0.005, 0.0061), ("terrain_dem_sun", 0.0035, 0.0040), ("room_point", 0.011, 0.0135)]
    {
        let Some(scores) = scores(name, "\"pcss\"", &[]) else { return };
        let error = scores.soft.expect("a soft mask").mean_error;
        println!("{name}: mean error {error:.4}, a plain reference has {reference}");
        assert!(error <= max, "{name} has {error}");
    }
}

#[test]
fn forward_and_reverse_depth_agree_with_every_filter() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    for filter in property::part(FILTERS, 3) {
        let picture = |reverse| {
            let features = [("reverse_z", reverse), ("light_filter", filter)];
            let parameters = [("local_light_radius", "0.05")];
            let with = With {
                parameters: &parameters,
                features: &features,
                size: Some([640, 360]),
                ..With::default()
            };
            Host::new(&gpu, &check_file(AWSM, &with), &scene).picture(&scene.frame_input(640.0 / 360.0, 0.0))
        };
        let differing = picture("true").differing(&picture("false"), 2);
        println!("{filter}: {differing} of {} pixels differ", 640 * 360);
        assert!(differing <= 640 * 360 / 10_000, "{filter}: {differing} pixels differ");
    }
}

/// Every value of the feature `light_filter`.
const FILTERS: [&str; 7] =
    [HARD, "\"grid_pcf\"", "\"poisson9\"", "\"poisson16\"", "\"poisson64\"", "\"vogel\"", "\"pcss\""];

#[test]
fn a_disabled_kind_of_shadow_takes_no_memory_and_no_pass() {
    let all = small(&[], &[]);
    let bytes = |outcome: &Outcome| outcome.plan().bytes;
    for (feature, texture, pass) in [
        ("spot_shadows", "atlas", "spot_casters"),
        ("point_shadows", "cubes", "point_casters"),
        ("directional_shadows", "layers", "directional_casters"),
    ] {
        let without = small(&[], &[(feature, "false")]);
        let taken = all.plan().resources[texture].bytes;
        assert!(taken > 0);
        assert!(!without.plan().resources.contains_key(texture), "{feature}");
        assert!(without.plan().passes.iter().all(|planned| planned.name != pass), "{feature}");
        assert_eq!(bytes(&all) - bytes(&without), taken, "{feature}");
    }
}

#[test]
fn the_order_of_the_lights_changes_nothing() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    let outcome = small(&[], &[]);
    let mut lights = lights_of(&scene);
    assert!(lights.len() > 5);
    let first = Host::new(&gpu, &outcome, &scene).picture(&lit_by(&scene, lights.clone()));
    for _ in 0..3 {
        lights.rotate_left(2);
        lights.swap(0, 3);
        let again = Host::new(&gpu, &outcome, &scene).picture(&lit_by(&scene, lights.clone()));
        assert_eq!(first.differing(&again, 0), 0);
    }
}

#[test]
fn every_light_throws_a_shadow_of_its_own() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    let outcome = small(&[], &[]);
    let mut host = Host::new(&gpu, &outcome, &scene);
    let lights = lights_of(&scene);
    let all = host.picture(&lit_by(&scene, lights.clone()));
    for at in 0..lights.len() {
        let mut fewer = lights.clone();
        fewer[at].properties.clear();
        let without = host.picture(&lit_by(&scene, fewer));
        let differing = all.differing(&without, 2);
        assert!(differing > 20, "{}: {differing} pixels", lights[at].name);
    }
}

#[test]
fn unusable_lights_and_cameras_give_no_invalid_pixel() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    let outcome = small(&[], &[]);
    let mut host = Host::new(&gpu, &outcome, &scene);
    let plain = host.picture(&lit_by(&scene, lights_of(&scene)));
    let mut lights = lights_of(&scene);
    lights.push(lamp("nowhere", [0.0; 3]).position(DVec3::NAN));
    lights.push(spot("nothing", [0.0; 3]).direction(DVec3::ZERO));
    lights.push(lamp("short", [0.0, 2.0, 4.0]).range(0.0));
    lights.push(lamp("nan", [0.0, 2.0, 4.0]).intensity(f32::NAN));
    let with = host.picture(&lit_by(&scene, lights));
    assert_eq!(plain.differing(&with, 0), 0);
    for kind in [
        LightKind::Spot { inner_angle: 0.0, outer_angle: 0.0 },
        LightKind::Spot { inner_angle: 1.0, outer_angle: std::f32::consts::PI },
        LightKind::Spot { inner_angle: f32::NAN, outer_angle: f32::NAN },
    ] {
        let lights =
            vec![light("odd", kind, [0.0, 2.0, 1.0]), lamp("far", [0.0, 2.0, 1.0]).range(f32::INFINITY)];
        let picture = host.picture(&lit_by(&scene, lights));
        assert!(picture.rgba_pixels().all(|pixel| pixel[3] == 255), "{kind:?}");
    }
    let mut broken = lit_by(&scene, lights_of(&scene));
    broken.camera.rotation = glam::DQuat::from_xyzw(f64::NAN, 0.0, 0.0, 0.0);
    host.picture(&broken);
    broken.filter_bounds = vec![("casters".into(), umbragraph::frame::Bounds::EMPTY)];
    broken.scene_bounds = umbragraph::frame::Bounds::EMPTY;
    host.picture(&broken);
}

#[test]
fn wide_filters_see_nothing_of_the_neighbouring_tile() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    for filter in property::part(["\"grid_pcf\"", "\"poisson64\"", "\"vogel\"", "\"pcss\""], 2) {
        let outcome = small(
            &[
                ("filter_radius", "4"),
                ("max_radius", "40"),
                ("grid_pcf_side", "7"),
                ("local_light_radius", "0.4"),
                ("max_penumbra", "40"),
                ("max_search", "40"),
            ],
            &[("light_filter", filter)],
        );
        // The neighbour shines on nothing, since it has no color; its tile is full of blockers, or empty.
        let picture = |direction: DVec3| {
            let dark = |name| spot(name, [-0.3, 1.6, -0.6]).color(Vec3::ZERO).direction(direction);
            let lights = vec![spot("a", [0.6, 2.6, 0.6]), dark("dark"), dark("z")];
            Host::new(&gpu, &outcome, &scene).picture(&lit_by(&scene, lights))
        };
        let (full, empty) = (picture(DVec3::NEG_Y), picture(DVec3::Y));
        assert_eq!(full.differing(&empty, 0), 0, "{filter}");
    }
}

#[test]
fn two_texels_around_a_spots_cone_stay_free_for_taps() {
    let frame = quiet_frame();
    let LightKind::Spot { outer_angle, .. } = frame.lights[1].kind else { panic!("a spot") };
    let data = published(small(&[], &[]).plan(), "spots", &frame);
    let view = &data.views()[0];
    let side = f64::from(view.viewport.map_or(256, |viewport| viewport[2]));
    let right = view.view_from_world.inverse().transform_vector3(DVec3::X);
    let edge = view.position + view.forward + right * f64::from(outer_angle).tan();
    let clip = view.clip_from_world * edge.extend(1.0);
    let texels = (1.0 - clip.x / clip.w) * 0.5 * side;
    assert!((texels - 2.0).abs() < 1e-3, "{texels} of {side} texels");
}

#[test]
fn too_many_lights_are_reduced_by_importance_and_named() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    let outcome = small(
        &[
            ("cube_capacity", "12"),
            ("cube_side", "32"),
            ("atlas_max_side", "256"),
            ("tile_min_side", "16"),
            ("tile_max_side", "64"),
        ],
        &[("light_filter", "\"hard\"")],
    );
    let grid = |at: usize| [(at % 20) as f64 * 0.36 - 3.5, 2.5, (at / 20) as f64 * 0.6 - 3.0];
    let mut lights: Vec<Light> = (0..200).map(|at| spot(&format!("spot {at}"), grid(at))).collect();
    lights.extend((0..40).map(|at| lamp(&format!("lamp {at}"), grid(at * 5))));
    let mut host = Host::new(&gpu, &outcome, &scene);
    host.picture(&lit_by(&scene, lights.clone()));
    let notices = host.notices().join("\n");
    println!("{notices}");
    assert!(
        notices.contains("UG0621") && notices.contains("28 lights have no shadows, since"),
        "28 of 40 lamps have no cube: {notices}"
    );
    let lamps = (0..40).filter(|at| notices.contains(&format!("\"lamp {at}\""))).count();
    assert!(lamps == 24 && notices.contains("\"lamp 4\" and 4 more"), "two dozen are named: {notices}");
    // What is removed makes room within a frame.
    lights.retain(|light| !light.name.starts_with("spot 1") && !light.name.starts_with("lamp"));
    lights.truncate(16);
    host.picture(&lit_by(&scene, lights));
    assert!(host.notices().is_empty(), "{:?}", host.notices());
}

#[test]
fn two_executors_on_one_plan_do_not_notice_one_another() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    let outcome = small(
        &[("cube_capacity", "2"), ("cube_side", "32"), ("atlas_max_side", "256"), ("light_capacity", "20")],
        &[("light_filter", "\"hard\"")],
    );
    let plan = Arc::new(outcome.plan().clone());
    let host = || {
        let mut host = Host::new(&gpu, &outcome, &scene);
        let executor = Executor::new(&gpu.device, &gpu.queue, plan.clone(), Some(&host.scene));
        host.executor = executor.expect("an executor");
        host
    };
    // Lights go around the room, in one way or the other.
    let frame = |at: usize, speed: f64| {
        let around = |light: usize| {
            let angle = light as f64 + speed * at as f64;
            [2.5 * angle.cos(), 1.5 + 0.1 * (light % 10) as f64, 2.5 * angle.sin()]
        };
        let spots = (0..18).map(|light| spot(&format!("spot {light}"), around(light)));
        lit_by(
            &scene,
            spots.chain((0..6).map(|light| lamp(&format!("lamp {light}"), around(light)))).collect(),
        )
    };
    let show = |host: &mut Host<'_>, at: usize, speed: f64| {
        host.frame(&frame(at, speed));
        (read(&gpu, &host.target), host.notices())
    };
    const FRAMES: usize = 4;
    let alone = |speed: f64| -> Vec<_> {
        let mut host = host();
        (0..FRAMES).map(|at| show(&mut host, at, speed)).collect()
    };
    let (left, right) = (alone(0.7), alone(-0.4));
    assert!(
        left.iter().any(|(_, notices)| *notices != left[0].1),
        "what is left out changes: {:?}",
        left[0].1
    );
    let (mut one, mut other) = (host(), host());
    for at in 0..FRAMES {
        for (host, speed, wanted) in [(&mut one, 0.7, &left[at]), (&mut other, -0.4, &right[at])] {
            let (picture, notices) = show(host, at, speed);
            assert_eq!(notices, wanted.1, "frame {at} at {speed}");
            assert_eq!(picture.differing(&wanted.0, 0), 0, "frame {at} at {speed}");
        }
    }
}

#[test]
fn lights_beyond_the_capacity_and_bounded_filters_are_notices() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    let outcome = small(
        &[("light_capacity", "4"), ("filter_radius", "0.5"), ("max_radius", "2"), ("far", "[4, 20]")],
        &[("light_filter", "\"grid_pcf\"")],
    );
    let mut lights: Vec<Light> =
        (0..8).map(|at| lamp(&format!("lamp {at}"), [at as f64 * 0.5 - 2.0, 2.0, 0.0])).collect();
    lights.push(spot("spot", [0.0, 2.0, 0.0]).priority(8.0));
    let sun = light("sun", LightKind::Directional, [0.0; 3]).priority(9.0);
    lights.push(sun.direction(DVec3::new(0.2, -1.0, 0.1).normalize()));
    let mut host = Host::new(&gpu, &outcome, &scene);
    host.picture(&lit_by(&scene, lights));
    let notices = host.notices().join("\n");
    for (code, words) in [
        ("UG0620", "6 lights are left out"),
        ("UG0622", "in cascade 0 of \"sun\""),
        ("UG0622", "m of \"spot\" (narrower)"),
        ("UG0622", "m of \"lamp "),
    ] {
        let mut lines = notices.lines();
        let found = lines.any(|notice| notice.starts_with(code) && notice.contains(words));
        assert!(found, "{code} {words}: {notices}");
    }
    let left_out = notices.lines().find(|notice| notice.starts_with("UG0620")).expect("seen above");
    assert!(
        left_out.contains("lamp") && !left_out.contains("spot") && !left_out.contains("sun"),
        "{left_out}"
    );
}

#[test]
fn no_filter_shows_the_seams_of_a_cube() {
    let Some(truth) = TruthScene::find("room_point") else { return };
    let Some(gpu) = gpu::device() else { return };
    let (width, height) = truth.size();
    let scene = scene(&truth.glb_path());
    for (filter, side) in [
        ("\"grid_pcf\"", "3"),
        ("\"grid_pcf\"", "5"),
        ("\"grid_pcf\"", "7"),
        ("\"poisson9\"", "3"),
        ("\"poisson16\"", "3"),
        ("\"poisson64\"", "3"),
        ("\"vogel\"", "3"),
    ] {
        let with = With {
            parameters: &[
                SHADOW_TERM,
                ("filter_radius", "0.02"),
                ("min_radius", "1"),
                ("grid_pcf_side", side),
            ],
            features: &[("light_filter", filter)],
            size: Some([width, height]),
            ..With::default()
        };
        let outcome = check_file(AWSM, &with);
        let picture = Host::new(&gpu, &outcome, &scene).picture(&scene.frame_input(1.0, 0.0));
        let scores = truth::evaluate(&truth, &picture).expect("a picture of the scene's size");
        // Away from the edges of shadows nothing is half lit, whatever face it lies on.
        let away = scores.band(4).expect("pixels away from edges");
        let iou = away.intersection_over_union().unwrap_or(0.0);
        println!("{filter} {side}: {iou:.5}");
        assert!(iou > 0.999, "{filter} {side}: {iou}");
    }
}

#[test]
fn a_figure_that_moves_takes_its_shadow_along() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/figure.glb"));
    let outcome = check_file(
        AWSM,
        &With {
            parameters: &[SHADOW_TERM, ("far", "[4, 8, 16, 40]"), ("cascade_side", "512")],
            features: &[("light_filter", "\"hard\"")],
            size: Some([240, 240]),
            ..With::default()
        },
    );
    let mut host = Host::new(&gpu, &outcome, &scene);
    // A low sun lays the shadow on the wall, to the left of the figure.
    let frame = |time| {
        let mut input = scene.frame_input(1.0, time);
        input.lights.retain(|light| light.kind == LightKind::Directional);
        input.lights[0].direction = DVec3::new(-0.7, -0.2, -1.0).normalize();
        input
    };
    let rest = host.picture(&frame(0.0));
    host.scene.update(&gpu.queue, &scene, &scene.pose(1.2));
    let waving = host.picture(&frame(1.2));
    // On the wall, which does not move itself, and where only shadows can differ.
    let wall = |picture: &Picture| -> Vec<[u8; 4]> {
        picture
            .rgba_pixels()
            .enumerate()
            .filter(|(at, _)| at / 240 < 135 && at % 240 < 105)
            .map(|(_, pixel)| pixel)
            .collect()
    };
    let moved = wall(&rest).iter().zip(wall(&waving)).filter(|(a, b)| a[0].abs_diff(b[0]) > 60).count();
    assert!(moved > 30, "{moved} pixels of the wall");
    host.scene.update(&gpu.queue, &scene, &scene.pose(4.0));
    let back = host.picture(&frame(4.0));
    assert!(rest.differing(&back, 8) < 60, "the animation ends where it began");
}

#[test]
fn cutouts_let_light_through_and_water_receives_shadows() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/foliage.glb"));
    let size = Some([320, 208]);
    let with = |parameters| With { parameters, size, ..With::default() };
    let term = check_file(AWSM, &with(&[SHADOW_TERM, ("far", "[6, 12, 24, 60]")]));
    let input = scene.frame_input(320.0 / 208.0, 0.0);
    let picture = Host::new(&gpu, &term, &scene).picture(&input);
    // Below the trees the lawn is speckled: neither all lit nor all dark.
    let lawn: Vec<u8> = picture
        .rgba_pixels()
        .enumerate()
        .filter(|(at, _)| (120..150).contains(&(at / 320)) && (30..110).contains(&(at % 320)))
        .map(|(_, pixel)| pixel[0])
        .collect();
    let dark = lawn.iter().filter(|value| **value < 60).count();
    let lit = lawn.iter().filter(|value| **value > 200).count();
    assert!(dark > 40 && lit > 200, "{dark} dark and {lit} lit of {}", lawn.len());
    let shaded = check_file(AWSM, &with(&[("far", "[6, 12, 24, 60]")]));
    let mut host = Host::new(&gpu, &shaded, &scene);
    let with_shadows = host.picture(&input);
    let mut light = input.clone();
    light.lights[0].properties.clear();
    let without = host.picture(&light);
    let water = |at: usize| (160..185).contains(&(at / 320)) && (5..95).contains(&(at % 320));
    let darker = (with_shadows.rgba_pixels().zip(without.rgba_pixels()).enumerate())
        .filter(|(at, (a, b))| water(*at) && a[2] + 6 < b[2])
        .count();
    assert!(darker > 30, "{darker} pixels of the pool lie in a shadow");
}

#[test]
fn several_samples_smooth_the_edges_and_nothing_else() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    let picture = |msaa| {
        let outcome = small(&[], &[("msaa", msaa)]);
        Host::new(&gpu, &outcome, &scene).picture(&lit_by(&scene, lights_of(&scene)))
    };
    let (one, four) = (picture("false"), picture("true"));
    let edges = one.differing(&four, 8);
    assert!(edges > 300 && edges < 160 * 120 / 3, "{edges} pixels differ");
}

#[test]
fn atlas_and_arrays_grow_with_the_lights_and_shrink_later() {
    let Some(gpu) = gpu::device() else { return };
    let scene = interior();
    let parameters = [("tile_max_side", "256"), ("moment_cascades", "\"all\"")];
    let outcome = small(&parameters, &[("light_filter", "\"hard\"")]);
    let mut host = Host::new(&gpu, &outcome, &scene);
    let sizes = |host: &Host<'_>| {
        let size = |name: &str| host.executor.plan().resources[name].size.unwrap();
        let moments = size("cascade_moments");
        (
            size("atlas").width,
            size("cubes").layers,
            size("layers").layers,
            moments.width * moments.height * moments.layers,
        )
    };
    assert_eq!(sizes(&host), (256, 6, 4, 4 * 256 * 256), "little is taken before anything is seen");
    host.picture(&lit_by(&scene, lights_of(&scene)));
    assert_eq!(
        sizes(&host),
        (512, 18, 1, 4 * 16 * 16),
        "three lamps, spots that want more than one small atlas, no sun"
    );
    let mut few: Vec<Light> = lights_of(&scene).into_iter().take(1).collect();
    let calm = (0..200).take_while(|_| !host.frame(&lit_by(&scene, few.clone()))).count();
    assert!((10..150).contains(&calm), "{calm} frames");
    few.push(light("sun", LightKind::Directional, [0.0; 3]));
    host.picture(&lit_by(&scene, few));
    assert!(sizes(&host).0 <= 256, "{:?}", sizes(&host));
    assert_eq!((sizes(&host).1, sizes(&host).2, sizes(&host).3), (6, 4, 4 * 256 * 256));
}

#[test]
fn lights_lie_in_a_storage_buffer_or_else_a_uniform_block() {
    let Some(gpu) = gpu::device() else { return };
    let limits = Limits { max_storage_buffers_per_shader_stage: 0, ..gpu.device.limits() };
    let without = gpu.with_limits(limits);
    let flags = gpu.adapter.get_downlevel_capabilities().flags;
    let [usual, small_one] = [&gpu, &without].map(|gpu| {
        let profile = TargetProfile::webgpu().on_device(&gpu.device.limits(), flags);
        awsm_on(Some(profile))
    });
    let storage = |outcome: &Outcome| {
        let variants = outcome.checked.pipeline.as_ref().unwrap().programs.iter().flat_map(|it| &it.variants);
        let texts: Vec<&str> = variants.map(|variant| variant.module.wgsl.as_ref()).collect();
        ["var<storage, read> lights", "var<uniform> lights"]
            .map(|words| texts.iter().any(|text| text.contains(words)))
    };
    assert_eq!(storage(&usual), [true, false]);
    assert_eq!(storage(&small_one), [false, true]);
    let scene = interior();
    let input = scene.frame_input(160.0 / 120.0, 0.0);
    let one = Host::new(&gpu, &usual, &scene).picture(&input);
    let other = Host::new(&without, &small_one, &scene).picture(&input);
    assert_eq!(one.differing(&other, 1), 0);
}

/// A small picture for a profile.
fn awsm_on(profile: Option<TargetProfile>) -> Outcome {
    let parameters = [("cube_side", "128"), ("atlas_max_side", "1024"), ("tile_max_side", "256")];
    check_file(AWSM, &With { parameters: &parameters, profile, size: Some([160, 120]), ..With::default() })
}
