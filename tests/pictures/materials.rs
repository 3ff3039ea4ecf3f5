//! Materials of glTF files as pipelines show them: small files are written here, drawn, and read back.

use crate::common::gpu::render;
use crate::common::{With, check_file};
use serde_json::{Value, json};
use umbragraph::scene::{NoFiles, Scene, from_slice};
use umbragraph_test_support::glb::container;
use umbragraph_test_support::gpu::{self, Gpu};

const SIDE: u32 = 32;

/// Pipelines that light forward, from textures, and after visibility was stored, with their features.
const PATHS: [(&str, &[(&str, &str)]); 6] = [
    ("pipelines/nebula.json", &[]),
    ("pipelines/learn/30-deferred.json", &[]),
    ("pipelines/lore.json", &[]),
    ("pipelines/umbra.json", &[]),
    ("pipelines/umbra.json", &[("deferred", "true")]),
    ("pipelines/umbra.json", &[("visibility_first", "true")]),
];

/// A square of 2 m that faces a camera, in light along the view; `material` may name the textures of `images`, each of
/// two texels.
fn square(material: &Value, images: &[[[u8; 4]; 2]]) -> Scene {
    changed(material, images, |_| {})
}

/// The same with changes of the document. Accessor 2 has tangents along the first coordinate.
fn changed(material: &Value, images: &[[[u8; 4]; 2]], change: impl FnOnce(&mut Value)) -> Scene {
    let mut binary: Vec<u8> = Vec::new();
    let mut floats = |values: &[f32]| {
        binary.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    };
    floats(&[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, -1.0, 1.0, 0.0, 1.0, 1.0, 0.0]);
    floats(&[0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    floats(&[1.0, 0.0, 0.0, 1.0].repeat(4));
    let mut views = vec![json!({ "buffer": 0, "byteLength": 48 })];
    views.push(json!({ "buffer": 0, "byteOffset": 48, "byteLength": 32 }));
    views.push(json!({ "buffer": 0, "byteOffset": 80, "byteLength": 64 }));
    for [left, right] in images {
        let texels = image::RgbaImage::from_fn(2, 1, |x, _| image::Rgba(if x == 0 { *left } else { *right }));
        let mut png = std::io::Cursor::new(Vec::new());
        texels.write_to(&mut png, image::ImageFormat::Png).expect("a picture");
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": png.get_ref().len() }));
        binary.extend(png.into_inner());
        binary.resize(binary.len().next_multiple_of(4), 0);
    }
    let list = |count: usize, one: &dyn Fn(usize) -> Value| (0..count).map(one).collect::<Vec<_>>();
    let mut document = json!({
        "asset": { "version": "2.0" }, "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "directional", "intensity": 2 }] } },
        "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "mesh": 0 },
            { "camera": 0, "translation": [0, 0, 2.5] },
            { "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1, "zfar": 20 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "mode": 5, "material": 0 }] }],
        "materials": [material],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0] },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC4" },
        ],
        "samplers": [{ "magFilter": 9728, "minFilter": 9728, "wrapS": 33071 }],
        "textures": list(images.len(), &|at| json!({ "source": at, "sampler": 0 })),
        "images": list(images.len(), &|at| json!({ "bufferView": 3 + at })),
        "bufferViews": views,
        "buffers": [{ "byteLength": binary.len() }],
    });
    change(&mut document);
    from_slice("square.glb", &container(&document.to_string(), &binary), &NoFiles)
        .unwrap_or_else(|error| panic!("{error:?}"))
}

/// The colors left and right of the middle of a square, without tone mapping.
fn halves(gpu: &Gpu, (pipeline, features): (&str, &[(&str, &str)]), scene: &Scene) -> [[u8; 3]; 2] {
    let parameters = [("tone_map", "\"none\"")];
    let with = With { parameters: &parameters, features, size: Some([SIDE; 2]), ..With::default() };
    let picture = render(gpu, &check_file(pipeline, &with), scene);
    let pixels: Vec<[u8; 4]> = picture.rgba_pixels().collect();
    let at = |x: u32| {
        let [red, green, blue, _] = pixels[(SIDE / 2 * SIDE + x) as usize];
        [red, green, blue]
    };
    [at(SIDE * 3 / 8), at(SIDE * 5 / 8)]
}

#[test]
fn emission_follows_its_texture_on_every_path() {
    let Some(gpu) = gpu::device() else { return };
    let material = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 },
        "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0 },
    });
    let scene = square(&material, &[[[0, 0, 0, 255], [188, 64, 0, 255]]]);
    for path in PATHS {
        let [left, right] = halves(&gpu, path, &scene);
        assert!(left.iter().all(|part| *part < 60), "{path:?} shows {left:?} where nothing is emitted");
        for (part, (left, right, wanted)) in
            [188, 64, 0].iter().zip(left.iter().zip(right)).map(|(w, (l, r))| (l, r, w)).enumerate()
        {
            let more = |byte: u8| (f64::from(byte) / 255.0).powf(2.2);
            let emitted = (more(right) - more(*left)).max(0.0).powf(1.0 / 2.2) * 255.0;
            assert!(
                (emitted - f64::from(*wanted)).abs() < 8.0,
                "{path:?}: {emitted} of {wanted} in part {part}"
            );
        }
    }
}

/// Turns the light by an angle about an axis.
fn light_from(document: &mut Value, axis: [f64; 3], angle: f64) {
    let [x, y, z] = axis.map(|part| part * (angle / 2.0).sin());
    document["nodes"][2]["rotation"] = json!([x, y, z, (angle / 2.0).cos()]);
}

#[test]
fn normal_maps_bend_towards_their_colors() {
    let Some(gpu) = gpu::device() else { return };
    let material = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0 }, "normalTexture": { "index": 0 },
    });
    // Towards the first coordinate in light from the right, then green in light from above.
    let cases = [
        ([64, 128, 240, 255], [192, 128, 240, 255], [0.0, 1.0, 0.0], 0.8),
        ([128, 64, 240, 255], [128, 192, 240, 255], [1.0, 0.0, 0.0], -0.8),
    ];
    for (away, toward, axis, angle) in cases {
        for has_tangents in [false, true] {
            let scene = changed(&material, &[[away, toward]], |document| {
                light_from(document, axis, angle);
                if has_tangents {
                    document["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] = json!(2);
                }
            });
            for path in PATHS {
                let [left, right] = halves(&gpu, path, &scene);
                assert!(
                    right[1] > left[1] + 20,
                    "{path:?}, {has_tangents}: {left:?} and {right:?} about {axis:?}"
                );
            }
        }
    }
}

#[test]
fn paths_agree_on_a_material_with_every_map() {
    let Some(gpu) = gpu::device() else { return };
    let material = json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.9, 0.6, 0.3, 1], "roughnessFactor": 0.6, "metallicFactor": 0.9,
            "metallicRoughnessTexture": { "index": 0 }, "baseColorTexture": { "index": 1 },
        },
        "normalTexture": { "index": 2, "scale": 0.7 }, "occlusionTexture": { "index": 0, "strength": 0.8 },
        "emissiveFactor": [0.05, 0.1, 0.2], "emissiveTexture": { "index": 1 },
        "extensions": { "KHR_materials_ior": { "ior": 1.8 } },
    });
    let images = [
        [[40, 90, 20, 255], [250, 200, 240, 255]],
        [[200, 100, 250, 255], [240, 240, 20, 255]],
        [[140, 120, 240, 255], [100, 128, 230, 255]],
    ];
    let scene = changed(&material, &images, |document| light_from(document, [0.6, 0.8, 0.0], 0.7));
    let draw = |(pipeline, features): (&str, &[(&str, &str)])| {
        let with = With { features, size: Some([64; 2]), ..With::default() };
        render(&gpu, &check_file(pipeline, &with), &scene)
    };
    for (first, other) in [(0, 1), (3, 4), (3, 5)] {
        let differing = draw(PATHS[first]).differing(&draw(PATHS[other]), 2);
        assert!(
            differing <= 4,
            "{differing} of 4096 pixels differ from {:?} to {:?}",
            PATHS[first],
            PATHS[other]
        );
    }
}

#[test]
fn texture_transforms_move_maps_and_unlit_colors_stay() {
    let Some(gpu) = gpu::device() else { return };
    let moved = json!({ "KHR_texture_transform": { "offset": [0.5, 0] } });
    let material = json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 },
        "emissiveFactor": [1, 1, 1], "emissiveTexture": { "index": 0, "extensions": moved },
    });
    let [left, right] = halves(&gpu, PATHS[0], &square(&material, &[[[0, 0, 0, 255], [0, 255, 0, 255]]]));
    assert!(left[1] > 240 && right[1] > 240, "{left:?} {right:?}");
    let material = json!({
        "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "extensions": moved } },
        "extensions": { "KHR_materials_unlit": {} },
    });
    let scene = square(&material, &[[[0, 0, 0, 255], [200, 100, 50, 255]]]);
    for path in PATHS {
        for half in halves(&gpu, path, &scene) {
            assert!(
                half.iter().zip([200, 100, 50]).all(|(part, wanted)| part.abs_diff(wanted) <= 2),
                "{path:?} shows {half:?}"
            );
        }
    }
}

#[test]
fn rough_metal_is_bright_and_smooth_metal_has_a_highlight() {
    let Some(gpu) = gpu::device() else { return };
    let scene = |metallic: f64, roughness: f64| {
        let surface = json!({ "baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": metallic, "roughnessFactor": roughness });
        square(&json!({ "pbrMetallicRoughness": surface }), &[])
    };
    for path in PATHS {
        let green =
            |metallic: f64, roughness: f64| f64::from(halves(&gpu, path, &scene(metallic, roughness))[0][1]);
        let (chalk, rough, smooth) = (green(0.0, 1.0), green(1.0, 1.0), green(1.0, 0.3));
        assert!((rough / chalk - 1.0).abs() < 0.25, "{path:?}: {chalk} of chalk, {rough} of rough metal");
        assert!(smooth > rough + 20.0, "{path:?}: {rough} of rough metal, {smooth} of smooth metal");
    }
}

#[test]
fn emission_beyond_all_bounds_is_white() {
    let Some(gpu) = gpu::device() else { return };
    let material = json!({
        "pbrMetallicRoughness": { "metallicFactor": 0 }, "emissiveFactor": [1, 1, 1],
        "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 1e30 } },
    });
    let scene = square(&material, &[]);
    for path in PATHS {
        assert_eq!(halves(&gpu, path, &scene), [[255; 3]; 2], "{path:?}");
    }
}
