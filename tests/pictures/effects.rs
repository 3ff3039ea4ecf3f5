//! Effects of `pipelines/effects/` against closed forms, and what they cost where they are off.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::common::gpu::{Host, import, scene};
use crate::common::{Outcome, SMALL_MAPS, With, check_file, check_with, root};
use glam::DVec3;
use serde_json::json;
use umbragraph::executor::{DryRun, read_back};
use umbragraph::frame::Camera;
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::scene::{NoFiles, Scene, from_slice, interface};
use umbragraph_test_support::glb::container;
use umbragraph_test_support::{gpu, property};

const SIZE: [u32; 2] = [320, 240];

/// As far as can be, and in more directions and steps than the defaults.
const FINE: [(&str, &str); 3] =
    [("occlusion_radius", "1000"), ("occlusion_slices", "8"), ("occlusion_steps", "16")];

/// A floor, and a wall of a height that stands on it along the first axis; without a height only the floor.
fn corner(height: f32) -> Scene {
    let mut binary = Vec::new();
    let floor = [[-50.0, 0.0, 0.0], [-50.0, 0.0, 50.0], [50.0, 0.0, 0.0], [50.0, 0.0, 50.0]];
    let wall = [[-50.0, height, 0.0], [-50.0, 0.0, 0.0], [50.0, height, 0.0], [50.0, 0.0, 0.0]];
    for corner in floor.iter().chain(&wall) {
        binary.extend(corner.iter().flat_map(|value| value.to_le_bytes()));
    }
    let square = |at: usize| json!({ "primitives": [{ "attributes": { "POSITION": at }, "mode": 5 }] });
    let accessor = |at: usize| {
        json!({
            "bufferView": 0, "byteOffset": 48 * at, "componentType": 5126, "count": 4, "type": "VEC3",
            "min": [-50, 0, 0], "max": [50, height, 50],
        })
    };
    let document = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": if height > 0.0 { vec![0, 1] } else { vec![0] } }],
        "nodes": [{ "mesh": 0 }, { "mesh": 1 }], "meshes": [square(0), square(1)],
        "accessors": [accessor(0), accessor(1)],
        "bufferViews": [{ "buffer": 0, "byteLength": binary.len() }], "buffers": [{ "byteLength": binary.len() }],
    });
    from_slice("corner.glb", &container(&document.to_string(), &binary), &NoFiles)
        .unwrap_or_else(|error| panic!("{error:?}"))
}

/// The ambient occlusion that the flagship finds, by pixel.
fn occlusion(scene: &Scene, camera: &Camera, features: &[(&str, &str)]) -> Option<Vec<f32>> {
    let gpu = gpu::device()?;
    let text = json!({
        "format": 1, "name": "seen", "extends": "umbra.json",
        "resources": { "occlusion": { "texture": { "lifetime": "imported" } } },
    });
    let parameters: Vec<_> = SMALL_MAPS.iter().copied().chain(FINE).collect();
    let with = With { parameters: &parameters, features, size: Some(SIZE), ..With::default() };
    let outcome = check_with("pipelines/seen.json", &text.to_string(), &with);
    let mut host = Host::new(&gpu, &outcome, scene);
    host.imports.push(("occlusion", import(&gpu, outcome.plan(), "occlusion")));
    let mut input = scene.frame_input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0);
    input.camera = *camera;
    host.frame(&input);
    let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, &host.imports[0].1)).expect("texels");
    Some(texels.values.iter().map(|texel| texel[0]).collect())
}

fn camera(position: [f64; 3], target: [f64; 3]) -> Camera {
    Camera::look_at(position, target, 0.8, f64::from(SIZE[0]) / f64::from(SIZE[1]))
}

#[test]
fn ambient_occlusion_of_a_plane_is_none() {
    let floor = corner(0.0);
    for features in [&[][..], &[("msaa", "true")], &[("reverse_z", "false")], &[("deferred", "true")]] {
        // From above, and so flat that the horizon is in the picture.
        for camera in [camera([0.0, 4.0, 9.0], [0.0, 0.0, 5.0]), camera([0.3, 1.0, 30.0], [0.0, 0.8, 0.0])] {
            let Some(seen) = occlusion(&floor, &camera, features) else { return };
            let least = seen.iter().copied().fold(1.0, f32::min);
            assert!(least > 0.995, "{least} of ambient light arrives at a floor, with {features:?}");
        }
    }
}

/// Beside an infinitely long wall of height H, at a distance d, (1 + d / √(d² + H²)) / 2 of the light of the upper
/// half arrives.
#[test]
fn ambient_occlusion_beside_a_wall_follows_its_form() {
    const HEIGHT: f64 = 0.3;
    let scene = corner(HEIGHT as f32);
    let (eye, target) = (DVec3::new(0.0, 3.0, 3.0), DVec3::new(0.0, 0.0, 0.4));
    let Some(seen) = occlusion(&scene, &camera(eye.to_array(), target.to_array()), &[]) else { return };
    let forward = (target - eye).normalize();
    let up = forward.cross(DVec3::Y).normalize().cross(forward);
    let mut wrong = false;
    for distance in [0.06, 0.1, 0.2, 0.3, 0.5, 0.8] {
        let place = DVec3::new(0.0, 0.0, distance) - eye;
        let height = place.dot(up) / (place.dot(forward) * 0.4_f64.tan());
        let row = ((0.5 - 0.5 * height) * f64::from(SIZE[1])) as usize;
        let columns = 152..168;
        let count = columns.len() as f64;
        let mean =
            columns.map(|column| f64::from(seen[row * SIZE[0] as usize + column])).sum::<f64>() / count;
        let wanted = 0.5 * (1.0 + distance / distance.hypot(HEIGHT));
        wrong |= (mean - wanted).abs() > 0.05;
        println!("{distance} m from the wall: {mean:.3} of the light, by its form {wanted:.3}");
    }
    assert!(!wrong, "a value is more than 0.05 off");
}

/// Effects of the flagship: the feature, the use of its subgraph, and the textures and buffers of its own.
const EFFECTS: [(&str, &str, &[&str]); 8] = [
    (
        "ambient_occlusion",
        "ambient_occlusion.",
        &["ambient_occlusion.noisy", "ambient_occlusion.smooth", "occlusion"],
    ),
    ("fog", "fog", &[]),
    ("temporal", "temporal.", &["temporal.gathered", "temporal.gathered@-1", "temporal.motion"]),
    (
        "depth_of_field",
        "depth_of_field.",
        &[
            "depth_of_field.behind",
            "depth_of_field.front",
            "depth_of_field.half",
            "depth_of_field.rows",
            "depth_of_field.tiles",
        ],
    ),
    ("bloom", "bloom.", &["bloom.chain"]),
    ("film", "film.", &["shown"]),
    (
        "auto_exposure",
        "auto_exposure.",
        &[
            "auto_exposure.adapted",
            "auto_exposure.adapted@-1",
            "auto_exposure.exposure",
            "auto_exposure.histogram",
        ],
    ),
    (
        "environment",
        "environment_light.",
        &["environment", "environment_light.sharp", "irradiance", "reflections"],
    ),
];

fn resources(outcome: &Outcome) -> BTreeSet<&str> {
    outcome
        .plan()
        .resources
        .iter()
        .filter(|(_, one)| one.size.is_some() || one.bytes > 0)
        .map(|(name, _)| name.as_str())
        .collect()
}

#[test]
fn effects_that_are_off_cost_nothing() {
    let plan = |on: &str| {
        let features = EFFECTS.map(|(name, ..)| (name, if name == on { "true" } else { "false" }));
        check_file("pipelines/umbra.json", &With { features: &features, ..With::default() })
    };
    let off = plan("");
    for (feature, begins, own) in EFFECTS {
        let on = plan(feature);
        let rest: Vec<_> = on.order().into_iter().filter(|name| !name.starts_with(begins)).collect();
        assert_eq!(rest, off.order(), "{feature}");
        assert!(rest.len() < on.order().len(), "{feature}");
        let added: Vec<_> = resources(&on).difference(&resources(&off)).copied().collect();
        assert_eq!(added, own, "{feature}");
    }
    let phone = check_file("pipelines/umbra.json", &With { preset: Some("phone"), ..With::default() });
    let is_effect = |name: &&str| EFFECTS.iter().any(|(_, begins, _)| name.starts_with(begins));
    assert!(!phone.order().iter().any(is_effect), "{:?}", phone.order());
}

/// Each pair of effects, and each effect with each other feature that changes the picture; not those that exclude each
/// other.
fn pairs() -> Vec<[&'static str; 2]> {
    let others = ["msaa", "deferred", "visibility_first", "fxaa"];
    let all: Vec<&str> = EFFECTS.iter().map(|(name, ..)| *name).chain(others).collect();
    let pairs =
        all.iter().enumerate().flat_map(|(at, first)| all[at + 1..].iter().map(|second| [*first, *second]));
    // Many samples are taken of every pixel, or over frames.
    let excluded = [["temporal", "msaa"], ["msaa", "deferred"]];
    pairs.filter(|pair| !excluded.contains(pair)).collect()
}

/// The plan of the flagship with these alone of all effects.
fn with_pair(pair: [&str; 2], size: Option<[u32; 2]>) -> Outcome {
    let all = EFFECTS.iter().map(|(name, ..)| *name).chain(["msaa", "deferred", "visibility_first", "fxaa"]);
    let features: Vec<_> =
        all.map(|name| (name, if pair.contains(&name) { "true" } else { "false" })).collect();
    let parameters = if size.is_some() { SMALL_MAPS } else { &[] };
    check_file("pipelines/umbra.json", &With { parameters, features: &features, size, ..With::default() })
}

#[test]
fn each_effect_goes_with_each_other() {
    let mut dry_run = pollster::block_on(DryRun::new(&TargetProfile::webgpu())).expect("a device");
    for pair in pairs() {
        let outcome = with_pair(pair, None);
        let order = outcome.order();
        for (feature, begins, _) in EFFECTS {
            let is_on = pair.contains(&feature);
            assert_eq!(order.iter().any(|name| name.starts_with(begins)), is_on, "{feature} of {pair:?}");
        }
        let mut plan = outcome.plan().clone();
        let hosts = &mut Arc::make_mut(&mut plan.pipeline).hosts;
        hosts.insert(interface::GEOMETRY.into(), interface::any_scene().any_filter());
        let said = pollster::block_on(dry_run.run(&Arc::new(plan)));
        assert!(said.is_empty(), "{pair:?}: {said:?}");
    }
}

/// One pair of twelve is drawn; the seed says which.
#[test]
fn pairs_of_effects_draw_a_picture() {
    let Some(gpu) = gpu::device() else { return };
    let figure = scene(&root().join("examples/scenes/figure.glb"));
    // The environment is a picture of the host's.
    let pairs: Vec<_> = pairs().into_iter().filter(|pair| !pair.contains(&"environment")).collect();
    for pair in property::part(pairs, 12) {
        let outcome = with_pair(pair, Some([96, 54]));
        let mut host = Host::new(&gpu, &outcome, &figure);
        let picture = host.picture(&figure.frame_input(96.0 / 54.0, 0.0));
        let levels: BTreeSet<u8> = picture.rgba_pixels().map(|[red, ..]| red).collect();
        println!("{pair:?}: {} levels", levels.len());
        assert!(levels.len() > 60, "{pair:?}: the picture has the levels {levels:?}");
    }
}
