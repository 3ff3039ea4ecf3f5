//! Published light data, without a device: the map of each light, its place for shaders, and notices about lights
//! without one.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::common::host::{crowded_frame, floats, published, quiet_frame, sunny_frame};
use crate::common::{Outcome, With};
use glam::{DVec3, DVec4};
use umbragraph::frame::{Light, LightKind};
use umbragraph::low_level::compiler::CpuPasses;

const TEXT: &str = r#"{
    "format": 1, "name": "lights",
    "parameters": {
        "spot_capacity": { "type": "u32", "default": 8 },
        "described_spots": { "type": "u32", "default": 8 },
        "cube_capacity": { "type": "u32", "default": 3 },
        "layer_capacity": { "type": "u32", "default": 8 },
        "max_side": { "type": "u32", "default": 1024 },
        "cadence": { "type": "u32", "default": 1 },
        "radius": { "type": "f32", "default": 0 },
        "hard_below": { "type": "f32", "default": 0 }
    },
    "passes": {
        "place": { "shadow_atlas": {
            "to": "&placement", "descriptors": 64,
            "spots": { "min_side": 512, "max_side": "=max_side", "min_tile": 32, "max_tile": 256, "capacity": "=spot_capacity" },
            "points": { "capacity": "=cube_capacity" },
            "directional": { "capacity": "=layer_capacity", "cascades": 4 }
        }, "side_effect": true },
        "directional": { "cascades": {
            "to": "&layers", "placement": "&placement", "layers": 8, "far": [8, 25, 70, 200], "resolution": 256, "cadence": "=cadence"
        }, "side_effect": true },
        "fit": { "cascades": {
            "to": "&fitted", "far": [8, 25, 70, 200], "resolution": 256, "cadence": "=cadence"
        }, "side_effect": true },
        "spots": { "spot_shadows": {
            "to": "&tiles", "placement": "&placement", "capacity": "=described_spots", "shadow_filter": { "radius": "=radius", "min": 2, "max": 10 }
        }, "side_effect": true },
        "list": { "light_list": {
            "to": "&lights", "placement": "&placement", "lights": 64, "descriptors": 64, "layers": "&layers", "hard_below": "=hard_below",
            "slots": { "capacity": 2, "of": "contact-shadows" }
        }, "side_effect": true }
    }
}"#;

fn checked(parameters: &[(&str, &str)]) -> Outcome {
    crate::common::check_with("lights.json", TEXT, &With { parameters, ..With::default() })
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
fn cascades_of_a_minor_light_wait_longer() {
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
        if priority == 1.0 {
            let fitted = published(outcome.plan(), "fit", &sunny_frame());
            assert_eq!(fitted.cadences(), wanted, "{texels:?}");
        }
    }
}

#[test]
fn the_light_or_else_its_priority_sets_the_hardness() {
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
    for _ in 0..2 {
        let last = frame.lights.last().expect("a spot").clone();
        frame.lights.push(last.clone().position(last.position + DVec3::X));
    }
    let data = published(outcome.plan(), "place", &frame);
    assert_eq!(data.words("count"), Some([4].as_slice()));
    let tiles: BTreeSet<&[u32]> = data.words("tile").unwrap().chunks(4).take(3).collect();
    assert!(tiles.len() == 3 && tiles.iter().all(|tile| tile[2] >= 32), "{tiles:?}");
    let labels = data.words("label").unwrap();
    let label =
        |at: usize| labels[4 * at..][..4].iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>();
    assert_eq!([label(0), label(1), label(2)], [*b"SPOT ?/1 OF THE "; 3]);
    assert_eq!(label(3), *b"SUN             ");
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
    let data = passes.data("placement").expect("published data");
    let kinds = data.words("entry").unwrap().chunks(4).take(data.words("count").unwrap()[0] as usize);
    assert_eq!(kinds.filter(|entry| entry[1] == 0).count(), 8, "spots with tiles");
    let full = "more important lights take all shadow spots";
    assert!(data.notices().iter().any(|notice| notice.message.contains(full)), "{:?}", data.notices());
}

#[test]
fn spots_beyond_the_described_ones_have_no_shadows() {
    let outcome = checked(&[("described_spots", "4")]);
    let mut passes = CpuPasses::new(Arc::new(outcome.plan().clone()));
    passes.run(&crowded_frame(), &[]).expect("data as declared");
    let data = passes.data("tiles").expect("published data");
    assert_eq!((data.words("count"), data.views().len()), (Some([4].as_slice()), 4));
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
        assert_eq!(data.words("atlas_side"), Some([512].as_slice()), "the smallest that is allowed");
        assert!(!kinds.contains(&kind) && data.notices().is_empty(), "{off}: {kinds:?} {:?}", data.notices());
    }
}

#[test]
fn only_usable_casting_lights_have_maps_of_allowed_sizes() {
    let mut frame = quiet_frame();
    let mut plain = frame.lights[1].clone();
    plain.name = "plain".into();
    plain.properties.clear();
    let mut broken = frame.lights[1].clone().position(DVec3::NAN);
    broken.name = "broken".into();
    frame.lights.extend([plain, broken]);
    let data = published(checked(&[]).plan(), "place", &frame);
    assert_eq!(data.words("count"), Some([3].as_slice()), "the sun and two spots");
    let sides: Vec<u32> = data.words("tile").unwrap().chunks(4).take(2).map(|tile| tile[2]).collect();
    assert_eq!(sides, [32, 256], "of the spots \"far\" and \"near\"");
    assert_eq!(data.words("atlas_side"), Some([512].as_slice()));
}

#[test]
fn lights_with_less_than_they_ask_for_are_named_with_the_reason() {
    let mut frame = crowded_frame();
    frame.lights.retain(|light| light.kind != LightKind::Directional);
    let is_spot = |light: &Light| matches!(light.kind, LightKind::Spot { .. });
    frame.lights.truncate(frame.lights.iter().position(|light| light.name == "lamp 4").expect("a lamp"));
    assert_eq!(frame.lights.iter().filter(|light| is_spot(light)).count(), 5);
    let data = published(checked(&[("max_side", "512")]).plan(), "place", &frame);
    let notices: Vec<&str> = data.notices().iter().map(|notice| &*notice.message).collect();
    let [smaller, none] = notices[..] else { panic!("{notices:?}") };
    assert!(
        smaller.starts_with(
            "2 lights have smaller shadow maps than they ask for, since the shadow atlas is full: \"spot"
        ),
        "{smaller}"
    );
    assert!(smaller.ends_with("(128 instead of 256 texels)"), "{smaller}");
    assert!(
        none.starts_with("1 light has no shadows, since more important lights take all shadow cubes: \"lamp"),
        "{none}"
    );
}

#[test]
fn notices_about_ten_thousand_unnamed_lights_stay_short() {
    let mut frame = quiet_frame();
    let mut light = frame.lights[1].clone().property("contact_shadow");
    light.name = "".into();
    frame.lights.extend(std::iter::repeat_n(light, 10_000));
    for (pass, count) in [("place", 1), ("list", 2)] {
        let data = published(checked(&[]).plan(), pass, &frame);
        let notices: Vec<&str> = data.notices().iter().map(|notice| &*notice.message).collect();
        assert!(notices.len() >= count, "{pass}: {notices:?}");
        let is_short = |notice: &&str| notice.len() < 1_000 && notice.ends_with(" more");
        assert!(notices.iter().all(is_short), "{pass}: {notices:?}");
    }
}

#[test]
fn slots_are_for_lights_that_ask_for_one_and_are_seen() {
    let mut frame = quiet_frame();
    let contact = |light: Light, name: &'static str| {
        let mut light = light.property("contact_shadow");
        light.name = name.into();
        light
    };
    let near = frame.lights[1].clone();
    let behind = frame.camera.position - 60.0 * frame.camera.forward();
    frame.lights.extend([
        contact(near.clone().position(behind), "behind"),
        contact(near.clone(), "seen"),
        contact(near.clone().priority(3.0), "weighty"),
        contact(near.priority(0.1), "slight"),
    ]);
    let data = published(checked(&[]).plan(), "list", &frame);
    // The sun, and then the spots "behind", "far", "near", "seen", "slight" and "weighty".
    let slots: Vec<u32> = data.words("light.shadow").unwrap().chunks(4).take(7).map(|one| one[2]).collect();
    assert_eq!(slots, [u32::MAX, u32::MAX, u32::MAX, u32::MAX, 1, u32::MAX, 0]);
    assert_eq!(data.words("slot").unwrap()[..3], [6, 4, u32::MAX]);
    let notices: Vec<&str> = data.notices().iter().map(|notice| &*notice.message).collect();
    assert!(notices.len() == 1 && notices[0].ends_with("no more slots: slight"), "{notices:?}");
}

#[test]
fn bounds_of_a_filter_are_noticed_where_shaders_filter() {
    let notices =
        |radius| published(checked(&[("radius", radius)]).plan(), "spots", &quiet_frame()).notices().len();
    assert_eq!([notices("0"), notices("0.1")], [0, 1]);
}
