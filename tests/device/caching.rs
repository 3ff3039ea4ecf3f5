//! Casters that stay where they are, drawn into maps that outlive frames: the same pictures as without, and fewer
//! draws.

use std::sync::Arc;

use crate::common::gpu::{Host, import, read, scene};
use crate::common::{Outcome, With, check_file, check_with, root};
use glam::{DQuat, DVec3};
use umbragraph::executor::{PassCounts, read_back};
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::scene::Scene;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

const SIZES: [[u32; 2]; 2] = [[96, 64], [64, 80]];

fn figure() -> Scene {
    scene(&root().join("examples/scenes/figure.glb"))
}

fn pipeline(path: &str, parameters: Settings<'_>, features: Settings<'_>) -> Outcome {
    check_file(path, &With { parameters, features, size: Some(SIZES[0]), ..With::default() })
}

fn lamp(name: &str, kind: LightKind, position: DVec3) -> Light {
    Light::new(name.to_owned(), kind)
        .position(position)
        .direction(DVec3::new(0.1, -1.0, -0.2).normalize())
        .intensity(40.0)
        .range(12.0)
        .property("cast_shadow")
}

/// The input of a frame: camera and lights move and rest in turns, lights come and go, one changes its kind.
fn frame(scene: &Scene, at: u64, [width, height]: [u32; 2]) -> FrameInput {
    let mut input = scene.frame_input(f64::from(width) / f64::from(height), time(at));
    let walked = (at / 16).min(3) as f64 + if at / 16 < 3 { (at % 16) as f64 / 16.0 } else { 0.0 };
    input.camera.position += DVec3::new(0.6 * walked, 0.0, -0.2 * walked);
    input.camera.rotation = DQuat::from_rotation_y(0.05 * walked) * input.camera.rotation;
    if at == 28 || at == 90 {
        // A cut, and back.
        input.camera.position += DVec3::new(25.0, 3.0, -8.0);
    }
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
    input.index(at)
}

/// The animation runs, and rests for some frames.
fn time(at: u64) -> f64 {
    at.saturating_sub(at / 40 * 10).max(if at % 40 > 30 { at / 40 * 30 + 30 } else { 0 }) as f64 / 24.0
}

/// A host in a frame; its picture.
fn play(host: &mut Host<'_>, scene: &Scene, at: u64, size: [u32; 2]) -> Vec<[u8; 4]> {
    if [host.target.width(), host.target.height()] != size {
        let data_sizes = std::mem::take(&mut host.options.data_sizes);
        host.options = PlanOptions::new(size[0], size[1]).data_sizes(data_sizes);
        let plan = host.outcome.checked.plan_again(&host.options, &host.outcome.sources).expect("a plan");
        host.target = import(host.gpu, &plan, "target");
        host.executor.set_plan(Arc::new(plan)).expect("a plan");
    }
    host.scene.update(&host.gpu.queue, scene, &scene.pose(time(at)));
    host.frame(&frame(scene, at, size));
    read(host.gpu, &host.target).rgba_pixels().collect()
}

/// The counts of the passes of static casters.
fn static_casters<'a>(host: &'a Host<'_>) -> impl Iterator<Item = (&'a str, PassCounts)> {
    host.executor.pass_counts().filter(|(name, _)| name.ends_with(".static"))
}

/// Names of parameters or features, with their values.
type Settings<'a> = &'a [(&'a str, &'a str)];

/// Two cascades, cubes and tiles of few texels.
const SMALL_MAPS: Settings<'_> = &[
    ("far", "[4, 40]"),
    ("cascade_side", "128"),
    ("cube_side", "64"),
    ("atlas_min_side", "128"),
    ("atlas_max_side", "512"),
    ("tile_max_side", "128"),
    ("tile_min_side", "16"),
];

const HARD: Settings<'_> = &[("light_filter", "\"hard\"")];

/// Plays the same frames with and without a feature that keeps maps; how many views of static casters were drawn, and
/// of how many.
fn compare(
    gpu: &Gpu,
    (path, feature): (&str, &str),
    (parameters, more): (Settings<'_>, Settings<'_>),
    frames: u64,
) -> [u64; 2] {
    let scene = figure();
    let cached = [more, &[(feature, "true")]].concat();
    let outcomes = [pipeline(path, parameters, more), pipeline(path, parameters, &cached)];
    let [mut plain, mut kept] = outcomes.each_ref().map(|outcome| Host::new(gpu, outcome, &scene));
    let mut counts = [0, 0];
    let mut shown: Vec<Vec<[u8; 4]>> = Vec::new();
    for at in 0..frames {
        let size = SIZES[usize::from((50..70).contains(&at))];
        let pictures = [play(&mut plain, &scene, at, size), play(&mut kept, &scene, at, size)];
        let differing = pictures[0].iter().zip(&pictures[1]).filter(|(a, b)| a != b).count();
        assert_eq!(differing, 0, "{path} in frame {at}");
        for (_, PassCounts { views, kept, .. }) in static_casters(&kept) {
            counts = [counts[0] + views, counts[1] + views + kept];
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
    let [drawn, all] = compare(&gpu, ("pipelines/nebula.json", "cached"), (&parameters, &[]), 120);
    assert_eq!(all, 3 * 120);
    assert!(drawn * 10 < all * 8, "{drawn} of {all}");
}

#[test]
fn spots_cubes_and_cascades_are_the_same_cached_over_120_frames() {
    let Some(gpu) = gpu::device() else { return };
    let [drawn, all] = compare(&gpu, ("pipelines/awsm.json", "cached"), (SMALL_MAPS, HARD), 120);
    assert!(drawn * 10 < all * 8, "{drawn} of {all}");
}

#[test]
fn spots_and_cubes_are_kept_beside_fitted_cascades() {
    let Some(gpu) = gpu::device() else { return };
    let [drawn, all] = compare(&gpu, ("pipelines/umbra.json", "cached_local_lights"), (SMALL_MAPS, HARD), 60);
    assert!(drawn * 10 < all * 8, "{drawn} of {all}");
}

#[test]
fn maps_of_mixed_sizes_are_the_same_cached() {
    let Some(gpu) = gpu::device() else { return };
    let parameters = [("resolutions", "[128, 128, 64, 64]")];
    for map_array in ["false", "true"] {
        let features = [("map_array", map_array)];
        // The camera rests from frame 48 on: until then a tight fit is another in each frame.
        let [drawn, all] = compare(&gpu, ("pipelines/lore.json", "cached"), (&parameters, &features), 64);
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
    let drawn = |host: &Host<'_>| static_casters(host).map(|(_, counts)| counts.views).sum::<u64>();
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

/// The counts of all passes of casters in some frames together.
fn drawn(host: &Host<'_>) -> PassCounts {
    let mut sum = PassCounts::default();
    let casters = host
        .executor
        .pass_counts()
        .filter(|(name, _)| name.contains("casters") || name.starts_with("cached"));
    casters.for_each(|(_, counts)| sum += counts);
    sum
}

/// The texels and draws of frames of casters cached, and not.
fn saved(
    gpu: &Gpu,
    (path, sizes): (&str, &[(&'static str, &'static str)]),
    scene: &str,
    frames: &[(f64, DVec3)],
) -> [PassCounts; 2] {
    let scene = self::scene(&root().join("examples/scenes").join(scene));
    let mut parameters = vec![("fit", "\"sphere\""), ("far", "[8, 32, 128]"), ("scroll", "true")];
    parameters.extend(sizes);
    let outcomes = ["false", "true"].map(|cached| pipeline(path, &parameters, &[("cached", cached)]));
    outcomes.each_ref().map(|outcome| {
        let mut host = Host::new(gpu, outcome, &scene);
        let mut sum = PassCounts::default();
        for (at, (time, moved)) in frames.iter().enumerate() {
            host.scene.update(&gpu.queue, &scene, &scene.pose(*time));
            let mut input = scene.frame_input(1.5, *time);
            input.camera.position += *moved;
            while host.frame(&input) {}
            // Everything is drawn first.
            sum += if at == 0 { PassCounts::default() } else { drawn(&host) };
        }
        sum
    })
}

#[test]
fn a_mover_and_a_walking_camera_draw_a_small_part_of_cascades() {
    let Some(gpu) = gpu::device() else { return };
    draw_a_small_part(&gpu, ("pipelines/nebula.json", &[("resolution", "512")]), 1);
}

#[test]
fn a_mover_and_a_walking_camera_redraw_few_maps() {
    let Some(gpu) = gpu::device() else { return };
    let sizes = [
        ("cascade_side", "256"),
        ("cube_side", "64"),
        ("atlas_min_side", "128"),
        ("tile_min_side", "16"),
        ("atlas_max_side", "256"),
        ("tile_max_side", "64"),
    ];
    draw_a_small_part(&gpu, ("pipelines/awsm.json", &sizes), 3);
}

/// Compares one out of so many cases.
fn draw_a_small_part(gpu: &Gpu, subject: (&str, &[(&'static str, &'static str)]), out_of: u64) {
    let (path, _) = subject;
    let percent = |[all, cached]: [PassCounts; 2]| {
        let of = |cached: u64, all: u64| 100.0 * cached as f64 / all.max(1) as f64;
        (of(cached.texels, all.texels), of(cached.draws, all.draws), cached)
    };
    let still = vec![(0.5, DVec3::ZERO); 3];
    let mover: Vec<_> = (0..5).map(|at| (f64::from(at) / 5.0, DVec3::ZERO)).collect();
    // At 1.5 m a second, 30 frames a second.
    let walk: Vec<_> = (0..8).map(|at| (0.5, DVec3::new(0.015, 0.0, -0.0475) * f64::from(at))).collect();
    let cases = [
        ("nothing moves", "figure.glb", still, 0.0),
        ("one mover", "figure.glb", mover, 5.0),
        ("a walk", "courtyard.glb", walk, 10.0),
    ];
    for (what, scene, frames, most) in property::part(cases, out_of) {
        let (texels, draws, counts) = percent(saved(gpu, subject, scene, &frames));
        println!("{path}: {what}: {texels:.2} % of the texels, {draws:.1} % of the draws");
        assert!(texels <= most && (texels > 0.0) == (most > 0.0), "{path}: {what}: {texels} %");
        assert!(most > 0.0 || counts.draws == 0, "{path}: {what}: {counts:?}");
    }
}

/// The maps of a walk that scroll, against those that are drawn anew, and the pictures: what rounding moves alone
/// differs.
#[test]
fn maps_that_scroll_show_the_same_picture_but_for_rounding() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/courtyard.glb"));
    let parameters =
        [("fit", "\"sphere\""), ("far", "[8, 32, 128]"), ("scroll", "true"), ("resolution", "512")];
    let text = r#"{ "format": 1, "name": "seen", "extends": "nebula.json",
        "resources": { "maps": { "texture": { "lifetime": "imported" } } } }"#;
    let outcomes = ["false", "true"].map(|cached| {
        let features = [("cached", cached)];
        let with =
            With { parameters: &parameters, features: &features, size: Some(SIZES[0]), ..With::default() };
        check_with("pipelines/seen.json", text, &with)
    });
    let mut hosts = outcomes.each_ref().map(|outcome| Host::new(&gpu, outcome, &scene));
    hosts.iter_mut().for_each(|host| host.imports.push(("maps", import(&gpu, host.outcome.plan(), "maps"))));
    let (mut differing, mut all) = (0, 0);
    // All texels, those that are not equal, by more than four units in the last place, and by more than a
    // ten-thousandth.
    let mut texels = [0; 4];
    for at in 0..30 {
        let mut input = scene.frame_input(1.5, 0.5);
        let step = f64::from(at);
        input.camera.position += DVec3::new(0.04 * step, 0.0, -0.12 * step);
        input.camera.rotation = DQuat::from_rotation_y(0.008 * step) * input.camera.rotation;
        let [(fresh, map), (scrolled, moved)] = hosts.each_mut().map(|host| {
            host.frame(&input);
            let map = pollster::block_on(read_back(&gpu.device, &gpu.queue, &host.imports[0].1)).unwrap();
            (read(&gpu, &host.target).rgba_pixels().collect::<Vec<_>>(), map.values)
        });
        for ([a, ..], [b, ..]) in map.iter().zip(&moved) {
            let units = a.to_bits().abs_diff(b.to_bits());
            let counted = [true, units > 0, units > 4, (a - b).abs() > 1e-4];
            texels.iter_mut().zip(counted).for_each(|(sum, counted)| *sum += u64::from(counted));
        }
        all += fresh.len();
        let is_off = |(a, b): &(&[u8; 4], &[u8; 4])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 2);
        differing += fresh.iter().zip(&scrolled).filter(is_off).count();
    }
    let percent = 100.0 * differing as f64 / all as f64;
    let [last, more, far] = [1, 2, 3].map(|at| 100.0 * texels[at] as f64 / texels[0] as f64);
    println!(
        "{last:.1} % of the texels are not equal, {more:.2} % by more than four units in the last place, {far:.4} % by more than 0.0001"
    );
    println!("{percent:.4} % of the pixels differ");
    assert!(percent < 0.02 && more < 1.0 && far < 0.02, "{percent} %, {more} %, {far} %");
}

#[test]
fn at_a_cadence_movers_wait_and_moving_views_do_not() {
    let Some(gpu) = gpu::device() else { return };
    let scene = figure();
    let sizes = [("far", "[4, 10, 40]"), ("resolution", "128"), ("cadence", "[1, 2, 4]")];
    let parameters = [&sizes[..], &[("fit", "\"sphere\"")]].concat();
    let outcomes =
        ["false", "true"].map(|cached| pipeline("pipelines/nebula.json", &parameters, &[("cached", cached)]));
    let [mut plain, mut kept] = outcomes.each_ref().map(|outcome| Host::new(&gpu, outcome, &scene));
    let still = scene.frame_input(1.5, 0.0);
    let moving = |host: &Host<'_>| {
        let passes = host.executor.pass_counts();
        passes.filter(|(name, _)| name.ends_with(".moving")).map(|(_, counts)| counts.views).sum::<u64>()
    };
    let mut play = |time: f64, input: &FrameInput| {
        let pictures = [&mut plain, &mut kept].map(|host| {
            host.scene.update(&gpu.queue, &scene, &scene.pose(time));
            let mut input = input.clone();
            input.filter_bounds = scene.frame_input(1.5, time).filter_bounds;
            host.frame(&input);
            read(&gpu, &host.target).rgba_pixels().collect::<Vec<_>>()
        });
        (pictures[0] == pictures[1], moving(&kept))
    };
    play(0.0, &still);
    let drawn: Vec<u64> = (1..=8).map(|at| play(f64::from(at) / 24.0, &still).1).collect();
    assert!(drawn.iter().sum::<u64>() < 3 * 8 && drawn.iter().all(|views| *views >= 1), "{drawn:?}");
    // A camera that moves is not waited for.
    let mut moved = still.clone();
    moved.camera.position += DVec3::new(3.0, 0.0, 0.0);
    assert!(play(10.0 / 24.0, &moved).0, "the frame of a cut is as new as without");
    // And once everything rests, all is up to date after as many frames as the longest cadence.
    let last = (0..4).map(|_| play(11.0 / 24.0, &moved)).last();
    assert!(last.is_some_and(|(is_same, _)| is_same), "{last:?}");
    assert_eq!(play(11.0 / 24.0, &moved), (true, 0));
}

/// Two lamps over the figure's scene, one of which is small in the picture.
fn near_and_far(scene: &Scene, at: u64, aside: f64) -> FrameInput {
    let mut input = scene.frame_input(1.5, at as f64 / 24.0);
    let center = input.scene_bounds.center();
    let ahead = input.camera.rotation * DVec3::NEG_Z;
    let spot = LightKind::Spot { inner_angle: 0.3, outer_angle: 0.6 };
    input.lights.retain(|light| light.kind == LightKind::Directional);
    input.lights.push(lamp("near", spot, center + DVec3::Y * 3.0));
    let mut far = lamp("far", spot, center + ahead * 60.0 + DVec3::new(aside, 6.0, 0.0));
    far.range = 8.0;
    input.lights.push(far);
    input.index(at)
}

#[test]
fn maps_of_minor_lights_wait_unless_the_light_moves() {
    let Some(gpu) = gpu::device() else { return };
    let scene = figure();
    let parameters = [SMALL_MAPS, &[("fit", "\"sphere\""), ("importance_cadence", "8")]].concat();
    let features = [HARD, &[("cached", "true")]].concat();
    let outcome = pipeline("pipelines/awsm.json", &parameters, &features);
    let mut host = Host::new(&gpu, &outcome, &scene);
    let drawn = |host: &Host<'_>, what: &str| {
        let passes = host.executor.pass_counts().filter(|(name, _)| name.starts_with(what));
        passes.filter(|(name, _)| name.ends_with(".moving")).map(|(_, counts)| counts.views).sum::<u64>()
    };
    let mut play = |at: u64, aside: f64| {
        host.scene.update(&gpu.queue, &scene, &scene.pose(time(at)));
        while host.frame(&near_and_far(&scene, at, aside)) {}
        [drawn(&host, "cached_spots"), drawn(&host, "cached_directional")]
    };
    // Sizes settle in the first two.
    let counts: Vec<_> = (0..18).map(|at| play(at, 0.0)).skip(2).collect();
    let sum = |what: usize| counts.iter().map(|counts| counts[what]).sum::<u64>();
    println!("in 16 frames spots are drawn {} times, cascades {} times", sum(0), sum(1));
    // The near one in each frame, the far one in its turn if anything moves in it at all.
    assert!((16..=16 + 8).contains(&sum(0)), "{counts:?}");
    // The first cascade in each frame; the second has texels some times as wide.
    assert!((17..=16 + 8).contains(&sum(1)), "{counts:?}");
    assert!(counts.iter().all(|counts| counts[0] >= 1 && counts[1] >= 1), "{counts:?}");
    // A lamp that moves is drawn in the same frame, whatever it matters.
    let moved: u64 = (18..22).map(|at| play(at, 0.1 * at as f64)[0]).sum();
    assert_eq!(moved, 8, "both in each frame");
}

/// Random sequences of what can happen: at a cadence of k a picture is that of maps without a cache in each frame in
/// which the camera has moved or the light, and k frames after casters have moved last.
#[test]
fn whatever_comes_no_kept_map_is_older_than_its_cadence() {
    let Some(gpu) = gpu::device() else { return };
    let scene = figure();
    let (mut same, mut waited) = (0, 0);
    for run in property::part(0..50_u64, 10) {
        let mut random = Random(run);
        let mut next = |end: usize| random.below(end);
        let cadence = 2 << next(3);
        let list = format!("[{cadence}]");
        let parameters =
            [("far", "[4, 40]"), ("resolution", "256"), ("fit", "\"sphere\""), ("cadence", list.as_str())];
        let outcomes = ["false", "true"]
            .map(|cached| pipeline("pipelines/nebula.json", &parameters, &[("cached", cached)]));
        let [mut plain, mut kept] = outcomes.each_ref().map(|outcome| Host::new(&gpu, outcome, &scene));
        let (mut step, mut aside, mut turn, mut rested) = (0, 0.0, 0.0, 0);
        for at in 0..24 {
            let (moves, walks, turns) = (next(3) > 0 && at < 12, next(4) == 0, next(6) == 0);
            step += u64::from(moves);
            aside += if walks { 3.0 } else { 0.0 };
            turn += if turns { 0.2 } else { 0.0 };
            let mut input = scene.frame_input(1.5, step as f64 / 12.0).index(at);
            input.camera.position.x += aside;
            input
                .lights
                .iter_mut()
                .for_each(|light| light.direction = DQuat::from_rotation_y(turn) * light.direction);
            let pictures = [&mut plain, &mut kept].map(|host| {
                host.scene.update(&gpu.queue, &scene, &scene.pose(step as f64 / 12.0));
                host.frame(&input);
                read(&gpu, &host.target).rgba_pixels().collect::<Vec<_>>()
            });
            rested = if moves { 0 } else { rested + 1 };
            let is_due = walks || turns || rested >= cadence || at == 0;
            let is_same = pictures[0] == pictures[1];
            assert!(is_same || !is_due, "run {run}, frame {at}, cadence {cadence}");
            same += u64::from(is_same);
            waited += u64::from(!is_same);
        }
    }
    println!("{same} pictures were those without a cache, {waited} had a caster that waited");
    assert!(waited > 0, "something waits");
}
