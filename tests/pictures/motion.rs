//! Motion vectors of meshes that move in each way, and what temporal antialiasing makes of them: small scenes are written here.

use crate::common::gpu::{Host, import, read};
use crate::common::{Outcome, SMALL_MAPS, With, check_file, check_with, root};
use serde_json::{Value, json};
use umbragraph::executor::read_back;
use umbragraph::scene::{NoFiles, Scene, from_slice};
use umbragraph_test_support::glb::container;
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

const SIZE: [u32; 2] = [160, 90];

/// Half the width and height of what the camera sees, in metres.
const SEEN: [f64; 2] = [16.0 / 9.0, 1.0];

/// Ways in which a mesh moves.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Way {
    Rigid,
    Skinned,
    Morphed,
}

const WAYS: [Way; 3] = [Way::Rigid, Way::Skinned, Way::Morphed];

/// A figure, a square of 0.4 m in a color, that moves by 1 m in a second to the right before a fence of thin dark bars.
fn walk(way: Way, color: [f64; 3]) -> Scene {
    let mut binary: Vec<u8> = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    let mut add = |bytes: &[u8], component: u32, count: usize, kind: &str, bounds: Option<[Vec<f32>; 2]>| {
        views.push(json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() }));
        binary.extend(bytes);
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut accessor = json!({
            "bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind,
        });
        if let Some([min, max]) = bounds {
            (accessor["min"], accessor["max"]) = (json!(min), json!(max));
        }
        accessors.push(accessor);
        accessors.len() - 1
    };
    let floats =
        |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    let square = |x: f32, y: f32| vec![-x, -y, 0.0, x, -y, 0.0, -x, y, 0.0, x, y, 0.0];
    let mut place = |x: f32, y: f32| {
        add(&floats(&square(x, y)), 5126, 4, "VEC3", Some([vec![-x, -y, 0.0], vec![x, y, 0.0]]))
    };
    let (bar, figure) = (place(0.01, 0.9), place(0.2, 0.4));
    let times = add(&floats(&[0.0, 1.0]), 5126, 2, "SCALAR", Some([vec![0.0], vec![1.0]]));
    let way_of = add(&floats(&[-0.5, 0.0, 0.0, 0.5, 0.0, 0.0]), 5126, 2, "VEC3", None);
    let weights = add(&floats(&[-0.5, 0.5]), 5126, 2, "SCALAR", None);
    let aside = add(
        &floats(&[1.0, 0.0, 0.0].repeat(4)),
        5126,
        4,
        "VEC3",
        Some([vec![1.0, 0.0, 0.0], vec![1.0, 0.0, 0.0]]),
    );
    let joints = add(&[0; 16], 5121, 4, "VEC4", None);
    let joint_weights = add(&floats(&[1.0, 0.0, 0.0, 0.0].repeat(4)), 5126, 4, "VEC4", None);
    let (path, output) = if way == Way::Morphed { ("weights", weights) } else { ("translation", way_of) };
    let target = if way == Way::Skinned { 3 } else { 2 };
    let mut moving = json!({ "attributes": { "POSITION": figure }, "mode": 5, "material": 1 });
    let mut node = json!({ "mesh": 1 });
    match way {
        Way::Rigid => {}
        Way::Morphed => moving["targets"] = json!([{ "POSITION": aside }]),
        Way::Skinned => {
            moving["attributes"]["JOINTS_0"] = json!(joints);
            moving["attributes"]["WEIGHTS_0"] = json!(joint_weights);
            node["skin"] = json!(0);
        }
    }
    let bars = (-26..=26).map(|at| json!({ "mesh": 0, "translation": [f64::from(at) * 0.06, 0, -1] }));
    let nodes = [
        json!({ "camera": 0, "translation": [0, 0, 5] }),
        json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } } }),
        node,
        json!({}),
    ];
    let nodes: Vec<Value> = nodes.into_iter().chain(bars).collect();
    let emissive = |color: [f64; 3]| json!({ "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 0, 1], "metallicFactor": 0 }, "emissiveFactor": color });
    let document = json!({
        "asset": { "version": "2.0" }, "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "directional", "intensity": 2 }] } },
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }], "nodes": nodes,
        "cameras": [{
            "type": "orthographic",
            "orthographic": { "xmag": SEEN[0], "ymag": SEEN[1], "znear": 0.1, "zfar": 20 },
        }],
        "meshes": [
            { "primitives": [{ "attributes": { "POSITION": bar }, "mode": 5, "material": 0 }] },
            { "primitives": [moving] },
        ],
        "skins": [{ "joints": [3] }],
        "materials": [emissive([0.0; 3]), emissive(color)],
        "animations": [{
            "samplers": [{ "input": times, "output": output }],
            "channels": [{ "sampler": 0, "target": { "node": target, "path": path } }],
        }],
        "accessors": accessors, "bufferViews": views, "buffers": [{ "byteLength": binary.len() }],
    });
    from_slice("walk.glb", &container(&document.to_string(), &binary), &NoFiles)
        .unwrap_or_else(|error| panic!("{error:?}"))
}

/// The lesson about motion, whose texture of it can be read.
fn lesson() -> Outcome {
    let text = json!({
        "format": 1, "name": "seen", "extends": "34-motion.json",
        "resources": { "motion": { "texture": { "lifetime": "imported" } } },
    });
    let with = With { parameters: &[("resolution", "512")], size: Some(SIZE), ..With::default() };
    check_with("pipelines/learn/seen.json", &text.to_string(), &with)
}

/// Draws a frame at each time, and sees what follows the last one.
fn play<T>(
    gpu: &Gpu,
    outcome: &Outcome,
    scene: &Scene,
    times: &[f64],
    mut then: impl FnMut(&mut Host<'_>, usize) -> T,
) -> Vec<T> {
    let mut host = Host::new(gpu, outcome, scene);
    if outcome.plan().resources.contains_key("motion") {
        host.imports.push(("motion", import(gpu, outcome.plan(), "motion")));
    }
    let aspect = f64::from(SIZE[0]) / f64::from(SIZE[1]);
    let mut found = Vec::new();
    for (index, time) in (0..).zip(times) {
        let pose = scene.pose(*time);
        host.scene.update(&gpu.queue, scene, &pose);
        let input = scene.frame_input_of(&pose, aspect, *time).index(index as u64);
        if index == 0 {
            host.settle(&input);
        }
        host.frame(&input);
        found.push(then(&mut host, index));
    }
    found
}

/// The motion of each pixel in pictures, of a frame at a time after one at another.
fn motion(gpu: &Gpu, outcome: &Outcome, scene: &Scene, times: &[f64]) -> Vec<[f32; 2]> {
    let read = |host: &mut Host<'_>, _| {
        let texels = pollster::block_on(read_back(&host.gpu.device, &host.gpu.queue, &host.imports[0].1));
        texels.expect("texels").values.iter().map(|texel| [texel[0], texel[1]]).collect()
    };
    play(gpu, outcome, scene, times, read).pop().expect("a frame")
}

#[test]
fn motion_vectors_follow_meshes_in_every_way() {
    let Some(gpu) = gpu::device() else { return };
    let outcome = lesson();
    for way in WAYS {
        let scene = walk(way, [1.0, 0.0, 0.0]);
        // Half a second is the middle of the way; the figure stands in the middle of the picture then.
        for (times, wanted) in [
            (&[0.0, 0.4, 0.5][..], -0.1 / (2.0 * SEEN[0])),
            (&[0.0, 0.55, 0.5], 0.05 / (2.0 * SEEN[0])),
            (&[0.0, 0.4, 0.5, 0.5], 0.0),
        ] {
            let moved = motion(&gpu, &outcome, &scene, times);
            let [width, height] = SIZE.map(|side| side as usize);
            let [x, y] = moved[height / 2 * width + width / 2];
            assert!(
                (f64::from(x) - wanted).abs() < 2e-4 && y.abs() < 2e-4,
                "{way:?} at {times:?}: {x} and {y}, not {wanted}"
            );
            let figure = moved.iter().filter(|[x, _]| *x < 3.0).count();
            let area = 0.4 * 0.8 / (4.0 * SEEN[0] * SEEN[1]) * (width * height) as f64;
            assert!((figure as f64 / area - 1.0).abs() < 0.1, "{way:?}: {figure} pixels of {area}");
        }
    }
}

/// Pixels in which two pictures differ by more than two levels.
fn differing(one: &Picture, other: &Picture) -> Vec<bool> {
    let apart = |(a, b): ([u8; 4], [u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 2);
    one.rgba_pixels().zip(other.rgba_pixels()).map(apart).collect()
}

/// Whether red and blue figures look different, by frame and pixel.
fn apart(gpu: &Gpu, outcome: &Outcome, way: Way) -> Vec<Vec<bool>> {
    let times: Vec<f64> = (6..17).map(|at| f64::from(at) / 20.0).collect();
    let [red, blue] = [[1.0, 0.1, 0.0], [0.0, 0.3, 1.0]]
        .map(|color| play(gpu, outcome, &walk(way, color), &times, |host, _| read(gpu, &host.target)));
    red.iter().zip(&blue).map(|(red, blue)| differing(red, blue)).collect()
}

/// Pixels of the last frame that still know the color of a figure which is seen in frames without a memory, but was not
/// there in the last one, two, three and four of them.
fn traces(plain: &[Vec<bool>], gathered: &[Vec<bool>]) -> Vec<usize> {
    let (last, width) = (plain.len() - 1, SIZE[0] as usize);
    // The picture is moved by half a pixel at most, and each pixel is held to those around it.
    let around = |mask: &[bool], at: usize| {
        let near = |step: usize| {
            let (x, y) = ((at % width + step % 5).wrapping_sub(2), (at / width + step / 5).wrapping_sub(2));
            x < width && y < SIZE[1] as usize && mask[y * width + x]
        };
        (0..25).any(near)
    };
    let was_there = |at: usize, frames: usize| (0..=frames).any(|back| around(&plain[last - back], at));
    let pixels = 0..plain[last].len();
    (0..4)
        .map(|frames| pixels.clone().filter(|at| gathered[last][*at] && !was_there(*at, frames)).count())
        .collect()
}

#[test]
fn a_walk_before_a_fence_leaves_no_trace() {
    let Some(gpu) = gpu::device() else { return };
    let umbra = |features: &[(&str, &str)]| {
        let features: Vec<_> =
            features.iter().copied().chain([("bloom", "false"), ("light_filter", "\"hard\"")]).collect();
        let with = With { parameters: SMALL_MAPS, features: &features, size: Some(SIZE), ..With::default() };
        check_file("pipelines/umbra.json", &with)
    };
    let plain = apart(&gpu, &umbra(&[("fxaa", "false")]), Way::Rigid);
    let temporal = umbra(&[("temporal", "true")]);
    for (outcome, way) in [
        (&temporal, Way::Rigid),
        (&lesson(), Way::Rigid),
        (&lesson(), Way::Skinned),
        (&lesson(), Way::Morphed),
    ] {
        let found = traces(&plain, &apart(&gpu, outcome, way));
        println!("{way:?}: {found:?} pixels that were left one to four frames ago");
        assert_eq!(found[1..], [0; 3], "{way:?}");
    }
    let blind = umbra(&[("temporal", "true"), ("motion_vectors", "false")]);
    let found = traces(&plain, &apart(&gpu, &blind, Way::Rigid));
    println!("without motion vectors: {found:?}");
    assert!(found[1] > 20, "{found:?}");
}

/// The mean difference of two pictures by channel, in levels of 255.
fn mean_difference(one: &[[f64; 3]], other: &[[f64; 3]]) -> f64 {
    let sum: f64 = one.iter().zip(other).flat_map(|(a, b)| [0, 1, 2].map(|at| (a[at] - b[at]).abs())).sum();
    sum / (3 * one.len()) as f64
}

/// Levels of 255 of the mean light of squares of pixels.
fn shrunk(picture: &Picture, side: u32) -> Vec<[f64; 3]> {
    let pixels: Vec<[u8; 4]> = picture.rgba_pixels().collect();
    let light = |byte: u8| (f64::from(byte) / 255.0).powf(2.2);
    let (wide, [width, height]) =
        (picture.width(), [picture.width(), picture.height()].map(|size| size / side));
    let mean = |x: u32, y: u32, channel: usize| {
        let places = (0..side * side).map(|at| (y * side + at / side) * wide + x * side + at % side);
        let sum: f64 = places.map(|at| light(pixels[at as usize][channel])).sum();
        (sum / f64::from(side * side)).powf(1.0 / 2.2) * 255.0
    };
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| [0, 1, 2].map(|at| mean(x, y, at)))
        .collect()
}

/// Lavapipe's anisotropic filter knows no bias, so textures have none here; ambient occlusion is another at another size.
#[test]
fn still_frames_converge_to_many_samples() {
    let Some(gpu) = gpu::device() else { return };
    let mut scene = crate::common::gpu::scene(&root().join("examples/scenes/courtyard.glb"));
    for texture in &mut scene.textures {
        texture.sampler.mipmap = Some(wgpu::MipmapFilterMode::Nearest);
    }
    let outcome = |side: u32, features: &[(&str, &str)]| {
        let more = [("bloom", "false"), ("light_filter", "\"hard\""), ("ambient_occlusion", "false")];
        let features: Vec<_> = features.iter().copied().chain(more).collect();
        let size = Some(SIZE.map(|size| size * side));
        check_file(
            "pipelines/umbra.json",
            &With { parameters: SMALL_MAPS, features: &features, size, ..With::default() },
        )
    };
    let truth = {
        let outcome = outcome(8, &[("fxaa", "false")]);
        let picture = Host::new(&gpu, &outcome, &scene).picture(&scene.frame_input(16.0 / 9.0, 0.0));
        shrunk(&picture, 8)
    };
    let mean = |features: &[(&str, &str)], frames: usize| {
        let pictures =
            play(&gpu, &outcome(1, features), &scene, &vec![0.0; frames], |host, _| read(&gpu, &host.target));
        mean_difference(&shrunk(pictures.last().expect("a picture"), 1), &truth)
    };
    let (one, smoothed, many) =
        (mean(&[("fxaa", "false")], 1), mean(&[], 1), mean(&[("temporal", "true")], 24));
    println!("{one:.2} levels off with one sample, {smoothed:.2} with fxaa, {many:.2} after 24 frames");
    assert!(many < 0.5 * one, "{one} and {many} levels off");
}
