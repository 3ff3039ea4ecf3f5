//! What is published of lights, without a device: who has which map, how shaders find a place in it, and
//! what is said of those that have none.

mod common;

use std::sync::Arc;

use common::host::{crowded_frame, floats, published, quiet_frame, sunny_frame};
use common::{Outcome, With};
use glam::{DVec3, DVec4};
use umbragraph::compiler::CpuPasses;
use umbragraph::frame::{Light, LightKind};

const TEXT: &str = r#"{
    "format": 1, "name": "lights",
    "parameters": {
        "spot_capacity": { "type": "u32", "default": 8 },
        "cube_capacity": { "type": "u32", "default": 3 },
        "layer_capacity": { "type": "u32", "default": 8 },
        "cadence": { "type": "u32", "default": 1 },
        "hard_below": { "type": "f32", "default": 0 }
    },
    "passes": {
        "place": { "shadow_atlas": {
            "to": "placement", "descriptors": 64,
            "spots": { "min_side": 256, "max_side": 1024, "min_tile": 16, "max_tile": 256, "capacity": "spot_capacity" },
            "points": { "capacity": "cube_capacity" },
            "directional": { "capacity": "layer_capacity", "cascades": 4 }
        }, "side_effect": true },
        "directional": { "cascades": {
            "to": "layers", "placement": "placement", "layers": 8, "far": [8, 25, 70, 200], "resolution": 256, "cadence": "cadence"
        }, "side_effect": true },
        "list": { "light_list": {
            "to": "lights", "placement": "placement", "lights": 64, "descriptors": 64, "layers": "layers", "hard_below": "hard_below"
        }, "side_effect": true }
    }
}"#;

fn checked(parameters: &[(&str, &str)]) -> Outcome {
    common::check_with("lights.json", TEXT, &With { parameters, ..With::default() })
}

#[test]
fn descriptors_of_cascades_lead_where_their_views_draw() {
    let outcome = checked(&[]);
    let data = published(outcome.plan(), "directional", &sunny_frame());
    let rows = |name: &str| -> Vec<DVec4> {
        let all = floats(&data, name);
        all.chunks(4).map(|one| DVec4::from_array(std::array::from_fn(|at| one[at].into()))).collect()
    };
    let [x, y, z] = ["map.axis_x", "map.axis_y", "map.axis_z"].map(rows);
    let (texels, depths) = (rows("map.texels"), rows("map.depth"));
    assert_eq!(data.views().len(), 4);
    for (at, view) in data.views().iter().enumerate() {
        for place in [DVec3::ZERO, DVec3::new(5.0, 1.0, -2.0), DVec3::new(-3.0, 4.0, 9.0)] {
            let clip = view.clip_from_world.transform_point3(place);
            let drawn = DVec3::new(128.0 + 128.0 * clip.x, 128.0 - 128.0 * clip.y, clip.z);
            let place = place.extend(1.0);
            let found = DVec3::new(
                x[at].dot(place) * texels[at].x + texels[at].z,
                y[at].dot(place) * texels[at].y + texels[at].w,
                depths[at].x + depths[at].y * z[at].dot(place),
            );
            assert!(drawn.abs_diff_eq(found, 1e-3), "cascade {at}: {drawn} {found}");
        }
    }
}

#[test]
fn cascades_of_a_light_that_matters_little_wait_longer_by_as_much() {
    let outcome = checked(&[("cadence", "64")]);
    let cadences = |priority: f32| {
        let mut frame = sunny_frame();
        frame.lights[0].priority = priority;
        let data = published(outcome.plan(), "directional", &frame);
        let texels: Vec<f32> = floats(&data, "map.depth").chunks(4).take(4).map(|depth| depth[2]).collect();
        (data.cadences().to_vec(), texels)
    };
    for (priority, first) in [(1.0, 1.0), (0.0625, 4.0)] {
        let (found, texels) = cadences(priority);
        let wanted: Vec<u32> =
            texels.iter().map(|texel| 1 << ((first * texel / texels[0]).min(64.0) as u32).ilog2()).collect();
        assert_eq!(found, wanted, "{texels:?}");
    }
}

#[test]
fn a_light_says_how_hard_its_shadow_is_and_else_its_priority_does() {
    let outcome = checked(&[("hard_below", "2")]);
    let mut frame = quiet_frame();
    let near = frame.lights[1].position;
    frame.lights[0] = frame.lights[0].clone().property("pcss_shadow").property("contact_shadow");
    frame.lights[1] = frame.lights[1].clone().priority(9.0).property("hard_shadow");
    frame.lights[2].priority = 2.0;
    let lamp = |name: &'static str| Light::new(name, LightKind::Point).position(near).property("cast_shadow");
    frame.lights.extend([lamp("a"), lamp("b").property("soft_shadow"), lamp("c").property("contact_shadow")]);
    let data = published(outcome.plan(), "list", &frame);
    // Of the sun, the spots "far" and "near", and the lamps.
    let found: Vec<u32> = data.words("light.shadow").unwrap().chunks(4).take(6).map(|one| one[3]).collect();
    assert_eq!(found, [1 + 2 * 3, 0, 2, 2, 2 * 2, 1 + 2]);
}

#[test]
fn lights_of_one_name_have_maps_of_their_own_that_are_labelled() {
    let outcome = checked(&[]);
    let mut frame = quiet_frame();
    frame.lights.truncate(2);
    frame.lights[1].name = "Spot \u{e9}/1 of the long hall".into();
    frame.lights.push(frame.lights[1].clone().position(frame.lights[1].position + DVec3::X));
    let data = published(outcome.plan(), "place", &frame);
    assert_eq!(data.words("count"), Some([3].as_slice()));
    let tiles: Vec<&[u32]> = data.words("tile").unwrap().chunks(4).take(2).collect();
    assert!(tiles.iter().all(|tile| tile[2] > 0) && tiles[0] != tiles[1], "{tiles:?}");
    let labels = data.words("label").unwrap();
    let label =
        |at: usize| labels[4 * at..][..4].iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>();
    assert_eq!([label(0), label(1)], [*b"SPOT ?/1 OF THE "; 2]);
    assert_eq!(label(2), *b"SUN             ");
}

#[test]
fn no_more_room_is_wanted_than_the_pipeline_allows() {
    let outcome = checked(&[]);
    let mut passes = CpuPasses::new(Arc::new(outcome.plan().clone()));
    passes.run(&crowded_frame(), &[]).expect("data as declared");
    let wanted = passes.wanted_sizes().expect("more than one light of each kind");
    assert_eq!(wanted["placement.layer_count"], 8);
    assert_eq!(wanted["placement.cube_count"], 3);
    assert!(wanted["placement.atlas_side"] <= 1024);
}

#[test]
fn nothing_is_said_of_shadows_that_are_switched_off() {
    let lamp = Light::new("lamp", LightKind::Point).position(quiet_frame().lights[1].position);
    let mut frame = quiet_frame();
    frame.lights.truncate(2);
    frame.lights.push(lamp.property("cast_shadow"));
    for (off, kind) in [("spot_capacity", 0), ("cube_capacity", 1), ("layer_capacity", 2)] {
        let data = published(checked(&[(off, "0")]).plan(), "place", &frame);
        let kinds: Vec<u32> = data.words("entry").unwrap().chunks(4).take(2).map(|entry| entry[1]).collect();
        assert_eq!(data.words("count"), Some([2].as_slice()), "{off}");
        assert!(!kinds.contains(&kind) && data.notices().is_empty(), "{off}: {kinds:?} {:?}", data.notices());
    }
}
