//! Levels of detail of casters: each cascade is drawn with the one that it asks for, or the last that there is.

use crate::common::gpu::{Host, import};
use crate::common::{With, check_file, check_with};
use glam::{DQuat, DVec3};
use serde_json::json;
use umbragraph::executor::read_back;
use umbragraph::frame::{FrameInput, Light, LightKind};
use umbragraph::scene::{NoFiles, Scene, from_slice};
use umbragraph_test_support::glb::container;
use umbragraph_test_support::gpu;

/// The map of each cascade over boards above each other. The boards are `count` levels of detail of one node, from
/// `first` on.
fn maps(first: usize, count: usize) -> Option<Vec<Vec<f32>>> {
    const MAPS: [&str; 4] = ["map_0", "map_1", "map_2", "map_3"];
    let gpu = gpu::device()?;
    let scene = boards(first, count);
    let imported = json!({ "texture": { "lifetime": "imported" } });
    let resources: serde_json::Map<_, _> =
        MAPS.map(|name| (name.to_owned(), imported.clone())).into_iter().collect();
    let text =
        json!({ "format": 1, "name": "seen", "extends": "lore.json", "resources": resources }).to_string();
    // A depth that does not depend on what there is.
    let parameters = [
        ("resolutions", "[64, 64, 64, 64]"),
        ("border", "2"),
        ("caster_cull", "\"none\""),
        ("pull_to_casters", "false"),
        ("fit", "\"sphere\""),
    ];
    let with = With { parameters: &parameters, size: Some([64, 64]), ..With::default() };
    let outcome = check_with("pipelines/seen.json", &text, &with);
    let mut host = Host::new(&gpu, &outcome, &scene);
    host.imports.extend(MAPS.map(|name| (name, import(&gpu, outcome.plan(), name))));
    host.frame(&frame(&scene));
    let read = |(_, texture): &(&str, wgpu::Texture)| {
        let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, texture)).expect("texels");
        texels.values.iter().map(|texel| texel[0]).collect()
    };
    Some(host.imports.iter().map(read).collect())
}

/// A floor, and a board whose levels of detail lie at heights of their own, the finest highest.
fn boards(first: usize, count: usize) -> Scene {
    let mut binary = Vec::new();
    for (height, side) in [(0.0, 200.0), (6.0, 190.0), (4.0, 180.0), (2.0, 170.0_f32)] {
        for [x, z] in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
            binary.extend([x * side, height, z * side].iter().flat_map(|value: &f32| value.to_le_bytes()));
        }
    }
    let mesh = |at: usize| json!({ "primitives": [{ "attributes": { "POSITION": at }, "mode": 5 }] });
    let accessor = |at: usize| {
        json!({
            "bufferView": 0, "byteOffset": 48 * at, "componentType": 5126, "count": 4, "type": "VEC3",
            "min": [-200, 0, -200], "max": [200, 6, 200],
        })
    };
    let mut finest = json!({ "mesh": first });
    if count > 1 {
        finest["extensions"] = json!({ "MSFT_lod": { "ids": (2..=count).collect::<Vec<_>>() } });
    }
    let levels = (first + 1..first + count).map(|mesh| json!({ "mesh": mesh }));
    let nodes: Vec<_> = [finest, json!({ "mesh": 0 })].into_iter().chain(levels).collect();
    let document = json!({
        "asset": { "version": "2.0" }, "extensionsUsed": ["MSFT_lod"],
        "scenes": [{ "nodes": [0, 1] }], "nodes": nodes,
        "meshes": (0..4).map(mesh).collect::<Vec<_>>(),
        "accessors": (0..4).map(accessor).collect::<Vec<_>>(),
        "bufferViews": [{ "buffer": 0, "byteLength": binary.len() }],
        "buffers": [{ "byteLength": binary.len() }],
    });
    from_slice("boards.glb", &container(&document.to_string(), &binary), &NoFiles)
        .unwrap_or_else(|error| panic!("{error:?}"))
}

/// A binary glTF of a floor, and of a roof in three levels of detail with one, two and three primitives.
fn roof() -> Scene {
    let mut binary = Vec::new();
    for [x, y, z] in
        [[-200.0, 0.0, -200.0_f32], [-200.0, 0.0, 200.0], [200.0, 0.0, -200.0], [200.0, 0.0, 200.0]]
    {
        binary.extend([x, y, z].iter().flat_map(|value: &f32| value.to_le_bytes()));
    }
    let square = json!({ "attributes": { "POSITION": 0 }, "mode": 5 });
    let mesh = |count: usize| json!({ "primitives": vec![square.clone(); count] });
    let roof = |mesh: usize| json!({ "mesh": mesh, "translation": [0, 3, 0] });
    let mut finest = roof(0);
    finest["extensions"] = json!({ "MSFT_lod": { "ids": [2, 3] } });
    let document = json!({
        "asset": { "version": "2.0" }, "extensionsUsed": ["MSFT_lod"],
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [finest, { "mesh": 0 }, roof(1), roof(2)],
        "meshes": [mesh(1), mesh(2), mesh(3)],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
            "min": [-200, 0, -200], "max": [200, 0, 200],
        }],
        "bufferViews": [{ "buffer": 0, "byteLength": binary.len() }],
        "buffers": [{ "byteLength": binary.len() }],
    });
    from_slice("roof.glb", &container(&document.to_string(), &binary), &NoFiles)
        .unwrap_or_else(|error| panic!("{error:?}"))
}

fn frame(scene: &Scene) -> FrameInput {
    let mut input = scene.frame_input(1.0, 0.0);
    input.camera.position = DVec3::new(0.0, 1.5, 0.0);
    input.camera.rotation = DQuat::IDENTITY;
    input.lights = vec![
        Light::new("sun", LightKind::Directional)
            .direction(DVec3::new(0.1, -1.0, -0.2).normalize())
            .intensity(3.0)
            .property("cast_shadow"),
    ];
    input
}

/// The draws of each pass whose name begins so, by its name.
fn draws(levels: Option<&str>, features: &[(&str, &str)], begins: &str) -> Option<Vec<u64>> {
    let gpu = gpu::device()?;
    let scene = roof();
    let sizes = [("resolutions", "[64, 64, 64, 64]"), ("border", "2")];
    let parameters: Vec<_> =
        sizes.into_iter().chain(levels.map(|levels| ("caster_detail", levels))).collect();
    let with = With { parameters: &parameters, features, size: Some([64, 64]), ..With::default() };
    let outcome = check_file("pipelines/lore.json", &with);
    let mut host = Host::new(&gpu, &outcome, &scene);
    host.frame(&frame(&scene));
    let counts = host.executor.pass_counts().filter(|(name, _)| name.starts_with(begins));
    Some(counts.map(|(_, counts)| counts.draws).collect())
}

#[test]
fn each_cascade_has_the_level_of_its_own_or_the_last() {
    let Some(usual) = draws(None, &[], "casters") else { return };
    // The roof in its second level and in its third, which is its last; and the floor, which has one.
    assert_eq!(usual, [3, 4, 4, 4]);
    assert_eq!(draws(Some("[0, 0, 1, 255]"), &[], "casters"), Some(vec![2, 2, 3, 4]));
    // What is seen is as fine as can be.
    assert_eq!(draws(None, &[], "surfaces"), Some(vec![2]));
    // In one array all cascades are views of one pass; kept maps know levels, too.
    assert_eq!(draws(None, &[("map_array", "true")], "array_casters"), Some(vec![15]));
    let kept = draws(None, &[("cached", "true")], "cached_casters").unwrap_or_default();
    assert_eq!(kept.iter().filter(|draws| **draws > 0).copied().collect::<Vec<_>>(), [3, 4, 4, 4]);
}

/// The map of each cascade is, texel by texel, the one of a scene that has nothing but the level of the cascade.
#[test]
fn each_cascade_shows_the_level_of_its_own_or_the_last() {
    let Some(levels) = maps(1, 3) else { return };
    let alone: Vec<_> = (1..=3).filter_map(|mesh| maps(mesh, 1)).collect();
    for (cascade, map) in levels.iter().enumerate() {
        let shown: Vec<_> = (0..3).filter(|level| alone[*level][cascade] == *map).collect();
        assert_eq!(shown, [(cascade + 1).min(2)], "cascade {cascade}");
    }
}

#[test]
fn a_level_that_is_no_whole_number_is_a_diagnostic() {
    let with = |levels| With { parameters: levels, ..With::default() };
    let outcome = check_file("pipelines/lore.json", &with(&[("caster_detail", "[1, 2, 3, 256]")]));
    assert!(outcome.diagnostics.has_errors(), "{}", outcome.text());
    let text = crate::common::read("pipelines/lore.json")
        .replace("caster_detail[index]", "caster_detail[index] + 0.5");
    let outcome = crate::common::check_with("pipelines/lore.json", &text, &With::default());
    assert!(outcome.text().contains("levels of detail are whole numbers"), "{}", outcome.text());
}
