//! Casters that stay where they are, drawn into maps that outlive frames: the same pictures as without, and fewer draws.

mod common;

use std::sync::Arc;

use common::gpu::{Host, import, read, scene};
use common::{Outcome, With, check_file, root};
use glam::{DQuat, DVec3, Vec3};
use umbragraph::compiler::PlanOptions;
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};

const SIZES: [[u32; 2]; 2] = [[96, 64], [64, 80]];

fn figure() -> Scene {
    scene(&root().join("examples/scenes/figure.glb"))
}

fn pipeline(path: &str, parameters: &[(&str, &str)], features: &[(&str, &str)]) -> Outcome {
    check_file(path, &With { parameters, features, size: Some(SIZES[0]), ..With::default() })
}

fn lamp(name: &str, kind: LightKind, position: DVec3) -> Light {
    Light {
        name: name.to_owned(),
        kind,
        position,
        direction: DVec3::new(0.1, -1.0, -0.2).normalize(),
        color: Vec3::ONE,
        intensity: 40.0,
        range: 12.0,
        properties: vec!["cast_shadow".into()],
        angular_diameter: 0.0,
        radius: 0.0,
        priority: 1.0,
    }
}

/// What happens in a frame: the camera and the lights move and rest in turns, lights come and go, one changes its kind.
fn frame(scene: &Scene, at: u64, [width, height]: [u32; 2]) -> FrameInput {
    let mut input = scene.frame_input(f64::from(width) / f64::from(height), time(at));
    let walked = (at / 16).min(3) as f64 + if at / 16 < 3 { (at % 16) as f64 / 16.0 } else { 0.0 };
    input.camera.position += DVec3::new(0.6 * walked, 0.0, -0.2 * walked);
    input.camera.rotation = DQuat::from_rotation_y(0.05 * walked) * input.camera.rotation;
    for light in &mut input.lights {
        // The sun stays at first, then jumps, and moves at last.
        let angle = [0.0, 0.0, 0.3, 0.3 + 0.01 * at as f64][(at / 30).min(3) as usize];
        light.direction = DQuat::from_rotation_y(angle) * light.direction;
    }
    let spot = LightKind::Spot { inner_angle: 0.3, outer_angle: 0.6 };
    let center = input.scene_bounds.center();
    let places = (0..4).map(|step| center + DVec3::new(f64::from(step) - 1.5, 3.0, 1.5));
    for (number, place) in (0..4_u64).zip(places) {
        // Some are there in some frames only, and tiles change places.
        if !(at / 8 + number).is_multiple_of(3) {
            let kind = if (at / 24 + number).is_multiple_of(4) { LightKind::Point } else { spot };
            let mut light = lamp(&format!("lamp {number}"), kind, place);
            light.position.x += if number == 1 { 0.02 * at as f64 } else { 0.0 };
            light.priority = if (at / 20).is_multiple_of(2) { 1.0 } else { 1.0 + number as f32 };
            input.lights.push(light);
        }
    }
    FrameInput { index: at, ..input }
}

/// The animation runs, and rests for some frames.
fn time(at: u64) -> f64 {
    at.saturating_sub(at / 40 * 10).max(if at % 40 > 30 { at / 40 * 30 + 30 } else { 0 }) as f64 / 24.0
}

/// A host in a frame; its picture.
fn play(host: &mut Host<'_>, scene: &Scene, at: u64, size: [u32; 2]) -> Vec<[u8; 4]> {
    if [host.target.width(), host.target.height()] != size {
        let data_sizes = std::mem::take(&mut host.options.data_sizes);
        host.options = PlanOptions { data_sizes, ..PlanOptions::new(size[0], size[1]) };
        let plan = host.outcome.checked.plan_again(&host.options, &host.outcome.sources).expect("a plan");
        host.target = import(host.gpu, &plan, "target");
        pollster::block_on(host.executor.set_plan(Arc::new(plan), Some(&host.scene))).expect("a plan");
    }
    host.scene.update(&host.gpu.queue, scene, &scene.pose(time(at)));
    host.frame(&frame(scene, at, size));
    read(host.gpu, &host.target).rgba_pixels().collect()
}

/// Plays the same frames cached and not; how many views of static casters were drawn, and of how many.
fn compare(
    gpu: &Gpu,
    path: &str,
    parameters: &[(&str, &str)],
    more: &[(&str, &str)],
    frames: u64,
) -> [usize; 2] {
    let scene = figure();
    let cached = [more, &[("cached", "true")]].concat();
    let outcomes = [pipeline(path, parameters, more), pipeline(path, parameters, &cached)];
    let [mut plain, mut kept] = outcomes.each_ref().map(|outcome| Host::new(gpu, outcome, &scene));
    let mut counts = [0, 0];
    let mut shown: Vec<Vec<[u8; 4]>> = Vec::new();
    for at in 0..frames {
        let size = SIZES[usize::from((50..70).contains(&at))];
        let pictures = [play(&mut plain, &scene, at, size), play(&mut kept, &scene, at, size)];
        let differing = pictures[0].iter().zip(&pictures[1]).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 0, "{path} in frame {at}");
        for (_, [drawn, left]) in kept.executor.redrawn() {
            counts = [counts[0] + drawn, counts[1] + drawn + left];
        }
        let [picture, _] = pictures;
        shown.push(picture);
    }
    shown.dedup();
    assert!(shown.len() as u64 > frames / 3, "pictures that move: {} of {frames}", shown.len());
    counts
}

#[test]
fn cascades_in_layers_are_the_same_cached_over_120_frames() {
    let Some(gpu) = gpu::device() else { return };
    let parameters = [("far", "[4, 10, 40]"), ("resolution", "128"), ("fit", "\"sphere\"")];
    let [drawn, all] = compare(&gpu, "pipelines/nebula.json", &parameters, &[], 120);
    assert_eq!(all, 3 * 120);
    assert!(drawn * 10 < all * 8, "{drawn} of {all}");
}

#[test]
fn spots_cubes_and_cascades_are_the_same_cached_over_120_frames() {
    let Some(gpu) = gpu::device() else { return };
    let parameters = [
        ("far", "[4, 40]"),
        ("cascade_side", "128"),
        ("cube_side", "64"),
        ("atlas_min_side", "128"),
        ("atlas_max_side", "512"),
        ("tile_max_side", "128"),
        ("tile_min_side", "16"),
    ];
    let features = [("light_filter", "\"hard\"")];
    let [drawn, all] = compare(&gpu, "pipelines/awsm.json", &parameters, &features, 120);
    assert!(drawn * 10 < all * 8, "{drawn} of {all}");
}

#[test]
fn maps_of_mixed_sizes_are_the_same_cached() {
    let Some(gpu) = gpu::device() else { return };
    let parameters = [("resolutions", "[128, 128, 64, 64]")];
    for map_array in ["false", "true"] {
        let features = [("map_array", map_array)];
        // The camera rests from frame 48 on: until then a tight fit is another in each frame.
        let [drawn, all] = compare(&gpu, "pipelines/lore.json", &parameters, &features, 64);
        assert!(drawn < all, "{drawn} of {all}");
    }
}

#[test]
fn where_nothing_moves_nothing_is_drawn_and_nothing_created() {
    let Some(gpu) = gpu::device() else { return };
    let scene = figure();
    let outcome = pipeline("pipelines/nebula.json", &[("resolution", "128")], &[("cached", "true")]);
    let mut host = Host::new(&gpu, &outcome, &scene);
    let input = scene.frame_input(1.5, 0.0);
    let drawn = |host: &Host<'_>| host.executor.redrawn().map(|(_, [drawn, _])| drawn).sum::<usize>();
    host.frame(&input);
    assert!(drawn(&host) > 0);
    let mut created = Vec::new();
    for at in 0..10 {
        // The figure moves, and what stays where it is is not drawn.
        host.scene.update(&gpu.queue, &scene, &scene.pose(f64::from(at) / 10.0));
        host.frame(&input);
        assert_eq!(drawn(&host), 0);
        read(&gpu, &host.target);
        created.push(host.executor.statistics());
    }
    assert_eq!(created[2], created[9]);
}
