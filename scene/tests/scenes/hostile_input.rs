//! Files made to hurt: no panic, no hang, no memory beyond the limits.

use proptest::prelude::*;
use serde_json::{Value, json};
use umbragraph_scene::load::limits;
use umbragraph_scene::{NoFiles, Scene, from_slice};
use umbragraph_test_support::property;

use crate::document::{Document, diagnostics};

/// A valid document that uses every feature the loader reads.
fn rich() -> Document {
    let mut document = Document::triangle();
    let normals = document.floats("VEC3", &[0., 0., 1., 0., 0., 1., 0., 0., 1.]);
    let texcoords = document.floats("VEC2", &[0., 0., 1., 0., 0., 1.]);
    let joints = document.shorts("VEC4", &[0; 12]);
    let weights = document.floats("VEC4", &[0.25; 12]);
    let indices = document.shorts("SCALAR", &[0, 1, 2]);
    for (name, accessor) in
        [("NORMAL", normals), ("TEXCOORD_0", texcoords), ("JOINTS_0", joints), ("WEIGHTS_0", weights)]
    {
        document.attribute(name, accessor);
    }
    let mut png = Vec::new();
    let texels = image::RgbaImage::from_pixel(2, 2, image::Rgba([1, 2, 3, 4]));
    texels.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let view = document.view(&png);
    document.push("images", json!({ "bufferView": view }));
    document.push("samplers", json!({ "wrapS": 33071 }));
    document.push("textures", json!({ "source": 0, "sampler": 0 }));
    document.push(
        "materials",
        json!({ "alphaMode": "MASK", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }),
    );
    document.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    document.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    let matrices = document.floats("MAT4", &[1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1.]);
    document.push("skins", json!({ "joints": [1], "inverseBindMatrices": matrices }));
    document.json["nodes"][0]["skin"] = json!(0);
    document.node(json!({ "rotation": [0, 0, 0, 1], "scale": [1, 1, 1] }));
    document.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([{ "type": "spot", "spot": {} }]);
    document.node(json!({ "camera": 0, "extensions": { "KHR_lights_punctual": { "light": 0 } } }));
    let times = document.floats("SCALAR", &[0.0, 1.0]);
    let turns = document.floats("VEC4", &[0., 0., 0., 1., 0., 1., 0., 0.]);
    document.push(
        "animations",
        json!({
            "samplers": [{ "input": times, "output": turns }],
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": "rotation" } }],
        }),
    );
    document
}

/// Calls the functions of a scene that a host would call, and checks the results.
fn exercise(scene: &Scene) {
    let frame = scene.frame_input(1.5, 0.3);
    assert_eq!(frame.camera.check(), None);
    assert!(frame.lights.iter().all(|light| light.check().is_none()));
    for draw in scene.draws() {
        let primitive = scene.primitive(draw);
        assert!(primitive.indices.iter().all(|index| (*index as usize) < primitive.positions.len()));
        assert_eq!(primitive.positions.len(), primitive.normals.len());
        assert_eq!(primitive.positions.len(), primitive.texcoords.len());
        assert!(primitive.normals.iter().flatten().all(|part| part.is_finite()));
        if let Some(texture) = scene.material(draw).base_color_map.map(|map| map.texture) {
            assert!(scene.textures[texture].image < scene.images.len());
        }
        let _ = scene.joint_transforms(draw.node, &scene.rest_pose()).count();
    }
}

#[test]
fn the_rich_document_itself_loads() {
    let scene = rich().load().unwrap();
    assert!(scene.warnings.is_empty());
    exercise(&scene);
}

proptest! {
    #![proptest_config(property::config(256))]

    #[test]
    fn changed_bytes_give_diagnostics_or_a_usable_scene(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..12)) {
        let mut bytes = rich().glb();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Ok(scene) = from_slice("test.glb", &bytes, &NoFiles) {
            exercise(&scene);
        }
    }

    #[test]
    fn changed_values_give_diagnostics_or_a_usable_scene(
        place in any::<prop::sample::Index>(),
        value in prop::sample::select(vec![
            json!(null), json!(-1), json!(0), json!(1), json!(2), json!(1e39), json!(u64::MAX), json!(1_u64 << 32),
            json!(0.5), json!(""), json!("POINTS"), json!([]), json!({}), json!(false), json!([0]), json!([1e39, 0, 0]),
        ]),
    ) {
        let mut document = rich();
        let count = values(&mut document.json).len();
        if let Some(changed) = values(&mut document.json).into_iter().nth(place.index(count)) {
            document.json.pointer_mut(&changed).map(|old| *old = value).unwrap_or_default();
        }
        if let Ok(scene) = document.load() {
            exercise(&scene);
        }
    }
}

/// The JSON pointers to all values of a document except its buffers, which are filled in on writing.
fn values(json: &mut Value) -> Vec<String> {
    let (mut found, mut open) = (Vec::new(), vec![(String::new(), &*json)]);
    while let Some((at, value)) = open.pop() {
        match value {
            Value::Object(members) => {
                open.extend(members.iter().map(|(key, value)| (format!("{at}/{key}"), value)));
            }
            Value::Array(elements) => {
                open.extend(elements.iter().enumerate().map(|(key, value)| (format!("{at}/{key}"), value)));
            }
            _ => {}
        }
        if !at.is_empty() && !at.starts_with("/buffers") {
            found.push(at);
        }
    }
    found
}

#[test]
fn a_huge_count_without_bytes_is_rejected_unallocated() {
    let mut document = Document::triangle();
    document.json["accessors"][0] = json!({
        "componentType": 5126, "count": 1_u64 << 60, "type": "VEC3",
        "sparse": { "count": 1, "indices": { "bufferView": 0, "componentType": 5125 }, "values": { "bufferView": 0 } },
    });
    assert_eq!(
        diagnostics(document.load()),
        [
            "UG0715 /meshes/0/primitives/0/attributes/POSITION: decoding this would take the scene beyond 64 MiB, the most for files of their size \
          (simplify the scene, or share accessors and images instead of repeating them)"
        ]
    );
}

#[test]
fn immense_key_frames_never_become_non_finite() {
    let mut document = Document::triangle();
    let times = document.floats("SCALAR", &[0.0, 1.0e30]);
    let moves = document.floats("VEC3", &[3e38; 18]);
    let grows = document.floats("VEC3", &[0.0, 0.0, 0.0, 3e38, 3e38, 3e38]);
    let animated = |node: usize, sampler: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    // Every node of a chain grows: the products leave 64 bits as well.
    let (mut channels, mut child) = (vec![animated(0, 0, "translation")], 0);
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([{ "type": "spot", "spot": {} }]);
    document.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = json!(0);
    document.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }));
    document.json["nodes"][0]["camera"] = json!(0);
    for _ in 0..12 {
        child = document.push("nodes", json!({ "children": [child] }));
        channels.push(animated(child, 1, "scale"));
    }
    document.json["scenes"][0]["nodes"] = json!([child]);
    document.push("animations", json!({
        "samplers": [{ "input": times, "output": moves, "interpolation": "CUBICSPLINE" }, { "input": times, "output": grows }],
        "channels": channels,
    }));
    let scene = document.load().unwrap();
    for time in [0.0, 1.0, 1e15, 0.5e30, 0.999e30] {
        let frame = scene.frame_input(1.0, time);
        assert_eq!(frame.lights[0].check(), None, "at {time}");
        assert_eq!(frame.camera.check(), None, "at {time}");
        let pose = scene.pose(time);
        for draw in scene.draws() {
            assert!(pose.world(draw.node).as_mat4().is_finite(), "at {time}");
            assert!(!scene.draw_bounds(draw, &pose).is_empty(), "at {time}");
        }
    }
}

#[test]
fn too_many_objects_and_too_many_draws_are_rejected() {
    let mut json = String::from("{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{}");
    json.extend(std::iter::repeat_n(",{}", limits::MAX_OBJECTS));
    json.push_str("]}");
    let found = diagnostics(from_slice("test.glb", json.as_bytes(), &NoFiles));
    assert!(found[0].starts_with("UG0715 : the document has "), "{found:?}");

    let mut document = Document::triangle();
    let primitive = document.json["meshes"][0]["primitives"][0].clone();
    document.json["meshes"][0]["primitives"] = Value::Array(vec![primitive; 2000]);
    document.json["nodes"] = Value::Array(vec![json!({ "mesh": 0 }); 2000]);
    document.json["scenes"] = json!([]);
    assert_eq!(
        diagnostics(document.load()),
        ["UG0715 /nodes/524: the scene has more than 1048576 draws (join primitives that share a material)"]
    );
}

#[test]
fn what_a_few_bytes_announce_takes_memory_in_proportion_to_them() {
    let scene = |json: &Value| diagnostics(from_slice("test.glb", json.to_string().as_bytes(), &NoFiles));
    let elements = json!({
        "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }],
        "accessors": [{ "componentType": 5126, "count": 30_000_000, "type": "VEC3" }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
    });
    assert_eq!(scene(&elements).len(), 1);
    assert!(
        scene(&elements)[0].starts_with("UG0715 /meshes/0/primitives/0/attributes/POSITION: decoding this")
    );
    // Nodes that say nothing, and as many that say something.
    let nodes =
        |node: Value, count: usize| json!({ "asset": { "version": "2.0" }, "nodes": vec![node; count] });
    let empty = scene(&nodes(json!({}), 100_000));
    assert!(
        empty[0].starts_with("UG0715 : the document has 300037 bytes of JSON with 100002 objects"),
        "{empty:?}"
    );
    let moved = nodes(json!({ "translation": [1, 2, 3] }), 100_000).to_string();
    assert!(from_slice("test.glb", moved.as_bytes(), &NoFiles).is_ok());
}

/// A triangle document with `count` materials, each with its own texture of the same black image. `view` adds the
/// buffer view of an image.
fn pictures(side: u32, count: usize, view: impl Fn(&mut Document, &[u8], usize) -> usize) -> Document {
    let mut png = Vec::new();
    let texels = image::GrayImage::new(side, side);
    texels.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let mut document = Document::triangle();
    document.json["images"] = json!([]);
    for at in 0..count {
        let view = view(&mut document, &png, at);
        document.push("images", json!({ "bufferView": view }));
        document.push("textures", json!({ "source": at }));
        let material = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": at } } });
        document.push("materials", material);
    }
    document
}

#[test]
fn pictures_of_the_same_bytes_are_decoded_once() {
    let document = pictures(256, 100, |document, png, at| if at == 0 { document.view(png) } else { 1 });
    let scene = document.load().unwrap();
    assert_eq!((scene.images.len(), scene.textures.len()), (1, 100));
    assert!(scene.textures.iter().all(|texture| texture.image == 0));
}

#[test]
fn views_of_the_bytes_of_one_picture_share_what_it_may_take() {
    // What lies behind a picture in its view is no part of it, so each is a view of its own.
    let document = pictures(1024, 40, |document, png, at| {
        if at == 0 {
            document.view(&[png, &[0; 64][..]].concat())
        } else {
            let whole = document.json["bufferViews"][1].clone();
            let length = json!(whole["byteLength"].as_u64().unwrap() - at as u64);
            let offset = &whole["byteOffset"];
            document.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": length }))
        }
    });
    let found = diagnostics(document.load());
    assert!(found[0].starts_with("UG0715 /images/"), "{found:?}");
    assert!(found[0].contains("decoding this would take the scene beyond "), "{found:?}");
}

#[test]
fn accessors_that_share_a_view_share_what_it_may_take() {
    let mut document = Document::triangle();
    let positions = document.floats("VEC3", &vec![0.5; 3 << 14]);
    let (mut accessors, mut primitives) = (Vec::new(), Vec::new());
    for at in 0..2000 {
        accessors.push(document.json["accessors"][positions].clone());
        primitives.push(json!({ "attributes": { "POSITION": 2 + at } }));
    }
    document.json["accessors"].as_array_mut().unwrap().extend(accessors);
    document.json["meshes"][0]["primitives"] = Value::Array(primitives);
    let found = diagnostics(document.load());
    assert!(found[0].starts_with("UG0715 /meshes/0/primitives/"), "{:?}", found[0]);
}

#[test]
fn a_cycle_of_a_hundred_thousand_nodes_is_followed_once() {
    let count = 100_000;
    let nodes: Vec<Value> = (0..count).map(|index| json!({ "children": [(index + 1) % count] })).collect();
    let json = json!({ "asset": { "version": "2.0" }, "nodes": nodes });
    let found = diagnostics(from_slice("test.glb", json.to_string().as_bytes(), &NoFiles));
    assert_eq!(found.len(), 1);
    assert!(found[0].starts_with("UG0714 ") && found[0].contains("(100000 nodes)"), "{}", found[0]);
}

#[test]
fn a_chain_of_a_hundred_thousand_nodes_needs_no_stack() {
    let count = 100_000;
    let nodes: Vec<Value> = (0..count)
        .map(|index| if index + 1 < count { json!({ "children": [index + 1] }) } else { json!({}) })
        .collect();
    let json = json!({ "asset": { "version": "2.0" }, "nodes": nodes });
    assert!(from_slice("test.glb", json.to_string().as_bytes(), &NoFiles).is_ok());
}

#[test]
fn an_image_of_a_huge_claimed_size_is_rejected_undecoded() {
    let mut document = rich();
    let at = document.binary.windows(4).position(|bytes| bytes == b"IHDR").unwrap() + 4;
    document.binary[at..at + 4].copy_from_slice(&2_000_000_u32.to_be_bytes());
    // The checksum of the header, so that the size is believed.
    let checksum = crc32(&document.binary[at - 4..at + 13]);
    document.binary[at + 13..at + 17].copy_from_slice(&checksum.to_be_bytes());
    assert_eq!(
        diagnostics(document.load()),
        [
            "UG0715 /images/0: image 0 has 2000000 × 2 texels (at most 16384 texels a side and 134217728 in all are read)"
        ]
    );
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, byte| {
        (0..8).fold(
            sum ^ u32::from(*byte),
            |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 },
        )
    })
}

/// An encoded image of 40 × 24 texels in a file format.
fn colors(format: image::ImageFormat) -> Vec<u8> {
    let texels = image::RgbImage::from_fn(40, 24, |x, y| image::Rgb([x as u8 * 6, y as u8 * 9, 200]));
    let mut bytes = Vec::new();
    texels.write_to(&mut std::io::Cursor::new(&mut bytes), format).unwrap();
    bytes
}

#[test]
fn pictures_with_random_faults_are_decoded_whole_or_rejected() {
    for format in [image::ImageFormat::Png, image::ImageFormat::Jpeg] {
        let sound = colors(format);
        let mut random = umbragraph_test_support::random::Random(7);
        let (mut decoded, mut rejected) = (0, 0);
        for _ in 0..600 {
            let mut bytes = sound.clone();
            // Headers are at the front.
            let end = if random.below(2) == 0 { bytes.len().min(700) } else { bytes.len() };
            for _ in 0..=random.below(4) {
                bytes[random.below(end)] = random.below(256) as u8;
            }
            if random.below(8) == 0 {
                bytes.truncate(random.below(bytes.len()));
            }
            match Document::pictured(&bytes).load() {
                Ok(scene) => {
                    decoded += 1;
                    let image = &scene.images[0];
                    assert_eq!(image.rgba.len() as u64, u64::from(image.width) * u64::from(image.height) * 4);
                }
                Err(said) => {
                    rejected += 1;
                    assert_eq!(said.len(), 1, "{said:?}");
                }
            }
        }
        assert!(rejected > 50, "{format:?}: {decoded} decoded, {rejected} rejected");
    }
}

#[test]
fn a_jpeg_of_two_channels_is_rejected() {
    let mut bytes = colors(image::ImageFormat::Jpeg);
    let marker = |bytes: &[u8], marker| bytes.windows(2).position(|pair| pair == [0xff, marker]).unwrap();
    // The frame's header, then the scan's: a length, and three bytes, or two, for each channel.
    let frame = marker(&bytes, 0xc0);
    bytes[frame + 3] -= 3;
    bytes[frame + 9] = 2;
    bytes.drain(frame + 16..frame + 19);
    let scan = marker(&bytes, 0xda);
    bytes[scan + 3] -= 2;
    bytes[scan + 4] = 2;
    bytes.drain(scan + 9..scan + 11);
    let expected = "UG0718 /images/0: image 0 cannot be decoded: a JPEG of 2 channels is neither grey nor RGB, YCbCr or CMYK (use a PNG or JPEG image)";
    assert_eq!(diagnostics(Document::pictured(&bytes).load()), [expected]);
}

#[test]
fn a_jpeg_on_which_the_decoder_panics_is_rejected() {
    let segment = |marker: u8, body: &[u8]| {
        [&[0xff, marker], &(body.len() as u16 + 2).to_be_bytes()[..], body].concat()
    };
    // A progressive frame of four channels, the first of which has twice as many rows, that calls itself YCbCr.
    let frame = [8, 0, 16, 0, 16, 4, 1, 0x12, 0, 2, 0x11, 0, 3, 0x11, 0, 4, 0x11, 0];
    let mut one_code = [0; 18];
    one_code[1] = 1;
    let bytes = [
        vec![0xff, 0xd8],
        segment(0xdb, &[[0].as_slice(), &[1; 64]].concat()),
        segment(0xc2, &frame),
        segment(0xee, b"Adobe\0\x64\0\0\0\0\x01"),
        segment(0xc4, &one_code),
        segment(0xda, &[4, 1, 0, 2, 0, 3, 0, 4, 0, 0, 0, 0]),
        vec![0; 64],
        vec![0xff, 0xd9],
    ]
    .concat();
    let expected =
        "UG0718 /images/0: image 0 cannot be decoded: the JPEG decoder failed (use a PNG or JPEG image)";
    assert_eq!(diagnostics(Document::pictured(&bytes).load()), [expected]);
}
