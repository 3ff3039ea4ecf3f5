//! Shadows of the project's own scenes against rays on the CPU: through the holes of leaves, of a figure that moves,
//! and of every kind of light with every kind of filter.
//!
//! The oracle (`umbragraph-score`) knows nothing of shadow maps: triangles in the world, skinned by the joints of the
//! pose, texels of alpha masks, and rays to the lights. It is asked at points that the camera sees on what stands
//! still, away from the edges of shadows, where no map of finite resolution can be right.

use crate::common::gpu::{Host, render_frame, scene};
use crate::common::{With, check_file, root};
use glam::{DVec2, DVec3};
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::scene::material::AlphaMode;
use umbragraph::scene::{Draw, Scene};
use umbragraph_score::Rays;
use umbragraph_score::rays::Seen;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

const SIZE: [u32; 2] = [480, 270];

/// The cosine between a surface's normal and the direction to a light that it faces well.
const FACING: std::ops::Range<f64> = 0.3..1.1;

/// Whether a point sees a light; `None` where that does not shine, whatever stands between.
fn is_lit(rays: &Rays<'_>, triangle: u32, point: DVec3, light: &Light) -> Option<bool> {
    let (to_light, distance) = incidence(light, point)?;
    Some(!rays.is_blocked(triangle, point, to_light, [1e-3, distance]))
}

/// The unit direction to a light and how far away it is, less the lamp itself; `None` outside of its cone and range,
/// and close to their ends.
fn incidence(light: &Light, at: DVec3) -> Option<(DVec3, f64)> {
    const LAMP: f64 = 0.03;
    let offset = light.position - at;
    let cosine = -offset.normalize().dot(light.direction);
    let is_reached = light.range <= 0.0 || offset.length() < 0.95 * f64::from(light.range);
    match light.kind {
        LightKind::Directional => return Some((-light.direction, f64::INFINITY)),
        LightKind::Spot { outer_angle, .. } if cosine < f64::from(outer_angle).cos() + 0.02 => return None,
        _ => {}
    }
    is_reached.then_some((offset.normalize(), offset.length() - LAMP))
}

/// A point, the pixel that shows it, and whether light reaches it.
struct Point {
    pixel: [u32; 2],
    at: DVec3,
    triangle: u32,
    is_lit: bool,
}

/// Points that a camera sees on what stands still and faces a light so well, on a grid of pixels, so far away from
/// edges of shadows in some directions.
fn points_in_view(
    (scene, rays): (&Scene, &Rays<'_>),
    input: &FrameInput,
    light: &Light,
    step: u32,
    (margin, directions): (f64, u32),
    facing: std::ops::Range<f64>,
) -> Vec<Point> {
    let world_from_clip = (input.camera.clip(false) * input.camera.view()).inverse();
    let draws: Vec<Draw> = scene.draws().collect();
    let mut points = Vec::new();
    for y in (step / 2..SIZE[1]).step_by(step as usize) {
        for x in (step / 2..SIZE[0]).step_by(step as usize) {
            let ndc = DVec2::new(
                (f64::from(x) + 0.5) / f64::from(SIZE[0]) * 2.0 - 1.0,
                1.0 - (f64::from(y) + 0.5) / f64::from(SIZE[1]) * 2.0,
            );
            let origin = input.camera.position;
            let direction = (world_from_clip.project_point3(ndc.extend(0.5)) - origin).normalize();
            let Some(seen) = rays.seen(origin, direction, [0.0, 14.0]) else { continue };
            let at = origin + direction * seen.distance;
            let Seen { triangle, normal, .. } = seen;
            let draw = draws[rays.triangle(triangle).draw as usize];
            let faces_it =
                incidence(light, at).is_some_and(|(to_light, _)| facing.contains(&normal.dot(to_light)));
            if draw.dynamic || scene.is_alpha_masked(draw) || !faces_it || !seen.counts {
                continue;
            }
            let (across, along) = normal.any_orthonormal_pair();
            let mut around = (0..directions).map(|turn| {
                let (sin, cos) = (f64::from(turn) * std::f64::consts::TAU / f64::from(directions)).sin_cos();
                at + (across * cos + along * sin) * margin
            });
            let Some(lit) = is_lit(rays, triangle, at, light) else { continue };
            if around.all(|other| is_lit(rays, triangle, other, light) == Some(lit)) {
                points.push(Point { pixel: [x, y], at, triangle, is_lit: lit });
            }
        }
    }
    points
}

fn shadow_term(gpu: &Gpu, scene: &Scene, input: &FrameInput) -> Picture {
    let parameters =
        [("debug_view", "\"shadow_term\""), ("far", "[6, 16, 60]"), ("resolution", "2048"), ("blend", "0")];
    let with = With { parameters: &parameters, size: Some(SIZE), ..With::default() };
    render_frame(gpu, check_file("pipelines/nebula.json", &with).plan(), scene, input)
}

fn is_lit_in(picture: &Picture, point: &Point) -> bool {
    value_in(picture, point) >= 128
}

fn value_in(picture: &Picture, point: &Point) -> u8 {
    let [x, y] = point.pixel;
    picture.bytes()[((y * SIZE[0] + x) * 4) as usize]
}

fn input(scene: &Scene, time: f64) -> FrameInput {
    scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), time)
}

fn share(count: usize, of: usize) -> f64 {
    count as f64 / of.max(1) as f64
}

#[test]
fn sunlight_falls_through_the_holes_of_leaves_and_nowhere_else() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/foliage.glb"));
    let (input, pose) = (input(&scene, 0.0), scene.pose(0.0));
    let sun = &input.lights[0];
    let points = points_in_view((&scene, &Rays::new(&scene, &pose)), &input, sun, 3, (0.02, 4), FACING);
    let picture = shadow_term(&gpu, &scene, &input);
    let agree = points.iter().filter(|point| is_lit_in(&picture, point) == point.is_lit).count();
    let shadowed = points.iter().filter(|point| !point.is_lit).count();
    assert!(shadowed > 100 && points.len() > 1000, "{shadowed} of {} points", points.len());
    assert!(share(agree, points.len()) > 0.97, "{agree} of {} points", points.len());
    // Where whole cards would throw a shadow, but the leaves that are cut out of them do not.
    let mut without_holes = scene.clone();
    without_holes.materials.iter_mut().for_each(|material| material.alpha_mode = AlphaMode::Opaque);
    let whole = Rays::new(&without_holes, &pose);
    let is_shadowed = |point: &Point| is_lit(&whole, point.triangle, point.at, sun) == Some(false);
    let through: Vec<&Point> = points.iter().filter(|point| point.is_lit && is_shadowed(point)).collect();
    let lit = through.iter().filter(|point| is_lit_in(&picture, point)).count();
    assert!(through.len() > 100, "{} points are lit through holes", through.len());
    assert!(share(lit, through.len()) > 0.9, "{lit} of {} points", through.len());
}

#[test]
fn the_shadow_of_a_skinned_figure_follows_its_joints() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/figure.glb"));
    let mut seen: Vec<(Vec<Point>, Picture)> = Vec::new();
    for time in [0.0, 1.5] {
        let input = input(&scene, time);
        let rays = Rays::new(&scene, &scene.pose(time));
        let points = points_in_view((&scene, &rays), &input, &input.lights[0], 3, (0.01, 4), FACING);
        let picture = shadow_term(&gpu, &scene, &input);
        let agree = points.iter().filter(|point| is_lit_in(&picture, point) == point.is_lit).count();
        assert!(points.len() > 1000, "{} points", points.len());
        assert!(share(agree, points.len()) > 0.99, "at {time}: {agree} of {} points", points.len());
        seen.push((points, picture));
    }
    let [(before, first), (after, second)] = seen.as_slice() else { panic!("two times") };
    // Where the shadow has come or gone.
    let moved: Vec<(&Point, &Point)> = before
        .iter()
        .filter_map(|point| Some((point, after.iter().find(|other| other.pixel == point.pixel)?)))
        .filter(|(point, other)| point.is_lit != other.is_lit)
        .collect();
    let agree = moved.iter().filter(|(point, other)| {
        is_lit_in(first, point) == point.is_lit && is_lit_in(second, other) == other.is_lit
    });
    assert!(moved.len() > 20, "only {} points change between light and shadow", moved.len());
    assert!(share(agree.count(), moved.len()) > 0.9, "of {} points", moved.len());
}

/// Holds `pipelines/awsm.json` to the rays for some lights of a scene, one at a time, with every kind of filter. The
/// filter is no wider than the margin around the points, so that it sees nothing but light there, or nothing but
/// shadow, if not for what is so thin that it passes between the rays.
#[track_caller]
fn filters_agree_with_rays(name: &str, lights: &[&str]) {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join(format!("examples/scenes/{name}.glb")));
    let input = input(&scene, 0.0);
    let rays = Rays::new(&scene, &scene.pose(0.0));
    let lights = input.lights.iter().filter(|light| lights.contains(&&*light.name));
    let sets: Vec<_> = lights
        .map(|light| (light, points_in_view((&scene, &rays), &input, light, 7, (0.18, 8), FACING)))
        .collect();
    assert!(!sets.is_empty());
    for filter in ["\"hard\"", "\"grid_pcf\"", "\"poisson16\"", "\"vogel\""] {
        let with = With {
            parameters: &[("debug_view", "\"shadow_term\""), ("filter_radius", "0.12")],
            features: &[("light_filter", filter)],
            size: Some(SIZE),
            ..With::default()
        };
        let outcome = check_file("pipelines/awsm.json", &with);
        let mut host = Host::new(&gpu, &outcome, &scene);
        for (light, points) in &sets {
            let picture = host.picture(&input.clone().lights(vec![(*light).clone()]));
            let value = |point: &Point| value_in(&picture, point);
            let agree = points.iter().filter(|point| (value(point) >= 128) == point.is_lit).count();
            let whole = |point: &&Point| if point.is_lit { value(point) >= 250 } else { value(point) <= 5 };
            let whole = points.iter().filter(whole).count();
            let (agree, whole) = (share(agree, points.len()), share(whole, points.len()));
            let what = format!("{} with {filter}: of {} points", light.name, points.len());
            println!("{what} {agree:.4} agree, {whole:.4} have no trace of another");
            assert!(points.len() > 100 && agree > 0.997 && whole > 0.92, "{what} {agree}, {whole}");
        }
    }
}

#[test]
fn a_lamp_shadows_a_room_as_rays_do_with_every_filter() {
    filters_agree_with_rays("interior", &["floor lamp"]);
}

#[test]
fn a_sun_and_a_spot_shadow_a_stage_as_rays_do_with_every_filter() {
    filters_agree_with_rays("figure", &["sun", "stage spot"]);
}

#[test]
fn what_light_grazes_does_not_shadow_itself() {
    let Some(gpu) = gpu::device() else { return };
    let scene = scene(&root().join("examples/scenes/interior.glb"));
    let all = input(&scene, 0.0);
    // It shines along the ceiling.
    let light = all.lights.iter().find(|light| light.name == "stair spot").expect("the light");
    let input = all.clone().lights(vec![light.clone()]);
    let rays = Rays::new(&scene, &scene.pose(0.0));
    let mut points = points_in_view((&scene, &rays), &input, light, 6, (0.3, 8), 0.02..0.2);
    points.retain(|point| point.is_lit);
    assert!(points.len() > 100, "{} points", points.len());
    for filter in ["\"grid_pcf\"", "\"poisson16\""] {
        let with = With {
            parameters: &[("debug_view", "\"shadow_term\"")],
            features: &[("light_filter", filter)],
            size: Some(SIZE),
            ..With::default()
        };
        let picture = Host::new(&gpu, &check_file("pipelines/awsm.json", &with), &scene).picture(&input);
        let lit: f64 = points.iter().map(|point| f64::from(value_in(&picture, point)) / 255.0).sum();
        let mean = lit / points.len() as f64;
        println!("{filter}: {mean:.4} of the light");
        assert!(mean > 0.98, "{filter}: {mean} of the light, at {} points", points.len());
    }
}
