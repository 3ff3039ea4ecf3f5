//! glTF files and the images in them, read and posed.

use serde_json::{Value, json};
use umbragraph::scene::{NoFiles, Scene, from_slice};
use umbragraph_test_support::glb;
use umbragraph_test_support::random::Random;

use crate::mutation::{self, Choices};
use crate::worker::note;

/// A binary file taken apart: the document and its buffer.
fn parts(file: &[u8]) -> (Value, Vec<u8>) {
    let word = |at: usize| file.get(at..at + 4).and_then(|word| word.first_chunk()).copied();
    let length = u32::from_le_bytes(word(12).expect("a binary glTF")) as usize;
    let document = serde_json::from_slice(&file[20..20 + length]).expect("JSON");
    (document, file[28 + length..].to_vec())
}

/// Asserts what a host relies on.
fn exercise(scene: &Scene, time: f64) {
    let frame = scene.frame_input(1.5, time);
    assert_eq!(frame.camera.check(), None);
    assert!(frame.lights.iter().all(|light| light.check().is_none()));
    for draw in scene.draws() {
        let primitive = scene.primitive(draw);
        let vertices = primitive.positions.len();
        assert!(primitive.indices.iter().all(|index| (*index as usize) < vertices), "an index beyond all");
        assert_eq!((vertices, vertices), (primitive.normals.len(), primitive.texcoords.len()));
        assert!(primitive.normals.iter().flatten().all(|part| part.is_finite()), "a normal of no number");
        if let Some(texture) = scene.material(draw).base_color_map.map(|map| map.texture) {
            assert!(scene.textures[texture].image < scene.images.len());
        }
        assert!(scene.joint_transforms(draw.node, &scene.rest_pose()).count() < 1 << 20);
    }
}

fn try_file(file: &[u8], choices: &mut Choices<'_>) {
    note(file);
    let time = f64::from(choices.number::<i16>()) / 100.0;
    match from_slice("input.glb", file, &NoFiles) {
        Ok(scene) => exercise(&scene, time),
        Err(diagnostics) => assert!(diagnostics.has_errors()),
    }
}

/// Pointers to all values of a document.
fn pointers(document: &Value) -> Vec<String> {
    let (mut found, mut open) = (Vec::new(), vec![(String::new(), document)]);
    while let Some((at, value)) = open.pop() {
        match value {
            Value::Object(members) => {
                open.extend(members.iter().map(|(key, value)| (format!("{at}/{key}"), value)));
            }
            Value::Array(all) => {
                open.extend(all.iter().enumerate().map(|(key, value)| (format!("{at}/{key}"), value)));
            }
            _ => {}
        }
        found.push(at);
    }
    found
}

/// Values that are odd in most places.
fn odd(choices: &mut Choices<'_>) -> Value {
    let all = [
        json!(null),
        json!(-1),
        json!(0),
        json!(1),
        json!(2),
        json!(1e39),
        json!(u64::MAX),
        json!(1_u64 << 32),
        json!(0.5),
        json!(-1e-40),
        json!(""),
        json!("POINTS"),
        json!("SCALAR"),
        json!("MASK"),
        json!([]),
        json!({}),
        json!(false),
        json!([0]),
        json!([1e39, 0, 0]),
        json!({ "KHR_texture_transform": { "scale": [0, 1e30] } }),
        json!(5120),
        json!(5126),
    ];
    choices.one_of(&all).clone()
}

/// Documents and buffers of the example scenes, with values changed.
pub(crate) fn scenes(choices: &mut Choices<'_>) {
    struct Known(Vec<(Value, Vec<u8>, Vec<String>)>);
    impl Default for Known {
        fn default() -> Self {
            let read = |name: &str| {
                let file = std::fs::read(format!("examples/scenes/{name}.glb")).expect("a scene");
                let (document, buffer) = parts(&file);
                let all = pointers(&document);
                (document, buffer, all)
            };
            Self(["figure", "foliage"].map(read).into())
        }
    }
    thread_local!(static SCENES: Known = Known::default());
    SCENES.with(|Known(all)| {
        let (document, buffer, places) = choices.one_of(all);
        let (mut document, mut buffer) = (document.clone(), buffer.clone());
        for _ in 0..=choices.below(4) {
            let place = choices.one_of(places);
            let other = document.pointer(choices.one_of::<String>(places)).cloned();
            let new = if choices.below(4) == 0 { other.unwrap_or_default() } else { odd(choices) };
            // What an earlier change took away is no place any more.
            let Some(value) = document.pointer_mut(place) else { continue };
            *value = new;
        }
        if choices.below(3) == 0 {
            mutation::changed_bytes(&mut buffer, choices);
        }
        let mut file = glb::container(&document.to_string(), &buffer);
        if choices.below(10) == 0 {
            mutation::changed_bytes(&mut file, choices);
        }
        try_file(&file, choices);
    });
}

/// Gives the chunks of a PNG file, as far as they are there, the checksums of what they hold now.
fn with_right_sums(file: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = file.get(at..at + 4).and_then(|word| word.first_chunk()) {
        let end = at + 8 + u32::from_be_bytes(*length) as usize;
        let Some(sum) = file.get(at + 4..end).map(crc32fast::hash) else { return };
        let Some(place) = file.get_mut(end..end + 4) else { return };
        place.copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
}

/// A triangle with a texture whose file has bytes changed.
pub(crate) fn images(choices: &mut Choices<'_>) {
    let (width, height) = (1 + choices.below(9) as u32, 1 + choices.below(9) as u32);
    let color = *choices.one_of(&[png::ColorType::Rgba, png::ColorType::Rgb, png::ColorType::Grayscale]);
    let depth = *choices.one_of(&[png::BitDepth::Eight, png::BitDepth::Sixteen]);
    let mut picture = Vec::new();
    let mut encoder = png::Encoder::new(&mut picture, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let bytes = color.samples() * (depth as usize / 8) * (width * height) as usize;
    let mut random = Random(choices.number());
    let texels: Vec<u8> = (0..bytes).map(|_| random.next() as u8).collect();
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&texels));
    written.expect("memory takes all bytes");
    mutation::changed_bytes(&mut picture, choices);
    if choices.below(4) > 0 {
        with_right_sums(&mut picture);
    }
    let positions = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut buffer: Vec<u8> = positions.iter().flat_map(|part| part.to_le_bytes()).collect();
    let at = buffer.len();
    buffer.extend(&picture);
    let document = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
        "textures": [{ "source": 0 }], "images": [{ "bufferView": 1, "mimeType": "image/png" }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
        "bufferViews": [{ "buffer": 0, "byteLength": at }, { "buffer": 0, "byteOffset": at, "byteLength": picture.len() }],
        "buffers": [{ "byteLength": buffer.len() }],
    });
    try_file(&glb::container(&document.to_string(), &buffer), choices);
}
