//! The pictures of lessons.

use super::{lesson, names};
use crate::common::gpu::{empty_frame, executor, import, picture, read, scene};
use crate::common::{With, check_file, root};
use umbragraph::Frame;
use umbragraph::scene::gpu::SceneResources;
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::{Channels, Picture};

#[test]
fn every_lesson_draws_a_picture_that_is_redder_on_the_right() {
    let Some(gpu) = gpu::device() else { return };
    for name in names() {
        let outcome = lesson(&name);
        // Meshes and buffers are of a host that shows a scene.
        let has_buffer = outcome.plan().imports().any(|(_, import)| import.format.is_none());
        if has_buffer || !outcome.plan().pipeline.geometry.is_empty() {
            continue;
        }
        let picture = picture(&gpu, &outcome);
        let pixels: Vec<_> = picture.rgba_pixels().collect();
        let middle = &pixels[pixels.len() / 2..];
        let (left, right) = (middle[40], middle[600]);
        assert!(right[0] > left[0].saturating_add(20), "{name}: {left:?} {right:?}");
    }
}

#[test]
fn a_persistent_texture_keeps_what_is_in_it() {
    grows_brighter("11-persistent");
}

#[test]
fn a_history_goes_on_from_what_the_frame_before_left() {
    grows_brighter("14-history");
}

/// Frames of a lesson on the courtyard, which the camera looks at from where it says for each.
fn frames(gpu: &gpu::Gpu, outcome: &crate::common::Outcome, cameras: &[f64]) -> Picture {
    let scene = scene(&root().join("examples/scenes/courtyard.glb"));
    let [width, height] = outcome.plan().viewport;
    let resources = SceneResources::new(&gpu.device, &gpu.queue, &scene, &scene.pose(0.0)).unwrap();
    let target = import(gpu, outcome.plan(), "target");
    let mut executor = executor(gpu, outcome.plan(), Some(&resources));
    for (index, aside) in cameras.iter().enumerate() {
        let mut input = scene.frame_input(f64::from(width) / f64::from(height), 0.0);
        input.camera.position += input.camera.rotation * glam::DVec3::X * *aside;
        let input = input.index(index as u64);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let imports = [("target", &target)];
        let frame = Frame::new(&input).draws(&resources).imports(&imports);
        executor.record(&mut encoder, &frame).expect("a record");
        gpu.queue.submit([encoder.finish()]);
    }
    read(gpu, &target)
}

fn on_courtyard(
    name: &str,
    [width, height]: [u32; 2],
    parameters: &[(&str, &str)],
) -> crate::common::Outcome {
    let with = With { size: Some([width, height]), parameters, ..With::default() };
    check_file(&format!("pipelines/learn/{name}.json"), &with)
}

/// The root of the mean square of the differences between two pictures, in steps of 255.
fn difference(one: &Picture, other: &Picture) -> f64 {
    let pairs = one
        .rgba_pixels()
        .zip(other.rgba_pixels())
        .flat_map(|(a, b)| [0, 1, 2].map(|at| (f64::from(a[at]) - f64::from(b[at])).powi(2)));
    let (sum, count) = pairs.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
    f64::sqrt(sum / count)
}

/// The mean of four by four pixels for each.
fn shrunk(picture: &Picture, [width, height]: [u32; 2]) -> Picture {
    let pixels: Vec<[u8; 4]> = picture.rgba_pixels().collect();
    let wide = picture.width();
    let mean = |x: u32, y: u32, channel: usize| {
        let places = (0..16).map(|at| (y * 4 + at / 4) * wide + x * 4 + at % 4);
        (places.map(|at| u32::from(pixels[at as usize][channel])).sum::<u32>() / 16) as u8
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let bytes = places.flat_map(|(x, y)| [0, 1, 2, 3].map(|channel| mean(x, y, channel))).collect();
    Picture::new(width, height, Channels::Rgba, bytes).unwrap()
}

#[test]
fn gathered_frames_come_nearer_to_many_samples() {
    let Some(gpu) = gpu::device() else { return };
    let size = [160, 90];
    let settings: &[(&str, &str)] = &[("resolution", "512")];
    let temporal = on_courtyard("29-temporal", size, settings);
    let large = on_courtyard("26-depth-prepass", size.map(|side| side * 4), settings);
    let truth = shrunk(&frames(&gpu, &large, &[0.0]), size);
    let one = difference(&frames(&gpu, &temporal, &[0.0]), &truth);
    let many = difference(&frames(&gpu, &temporal, &[0.0; 10]), &truth);
    assert!(many < 0.75 * one, "{one} after one frame, {many} after ten");
    // A camera that comes to rest after a way aside: what it has gathered on its way is where it belongs.
    let way: Vec<f64> = (0..5).map(|at| 0.05 * f64::from(5 - at)).chain([0.0; 2]).collect();
    let moved = difference(&frames(&gpu, &temporal, &way), &truth);
    assert!(moved < 0.9 * one, "{one} after one frame, {moved} on the way");
}

#[test]
fn a_prepass_and_a_g_buffer_change_nothing_that_is_seen() {
    let Some(gpu) = gpu::device() else { return };
    let with = With { size: Some([240, 136]), ..With::default() };
    let forward = frames(&gpu, &check_file("pipelines/nebula.json", &with), &[0.0]);
    let prepass = frames(&gpu, &on_courtyard("26-depth-prepass", [240, 136], &[]), &[0.0]);
    assert_eq!(difference(&forward, &prepass), 0.0);
    let deferred = frames(&gpu, &on_courtyard("30-deferred", [240, 136], &[]), &[0.0]);
    let apart = difference(&forward, &deferred);
    assert!(apart > 0.0 && apart < 3.0, "{apart}");
}

#[test]
fn occlusion_only_darkens_and_bloom_only_brightens() {
    let Some(gpu) = gpu::device() else { return };
    let size = [240, 136];
    let plain = frames(&gpu, &on_courtyard("26-depth-prepass", size, &[]), &[0.0]);
    let mean = |picture: &Picture| {
        picture.rgba_pixels().map(|pixel| f64::from(pixel[1])).sum::<f64>() / f64::from(size[0] * size[1])
    };
    for (name, sign, by) in [("27-ssao", -1.0, 1.0), ("28-bloom", 1.0, 3.0)] {
        let picture = frames(&gpu, &on_courtyard(name, size, &[]), &[0.0]);
        let pairs = plain.rgba_pixels().zip(picture.rgba_pixels());
        let worst = pairs.map(|(a, b)| sign * (f64::from(b[1]) - f64::from(a[1]))).fold(0.0, f64::min);
        assert!(worst >= -1.0, "{name}: {worst}");
        let change = sign * (mean(&picture) - mean(&plain));
        assert!(change > by, "{name}: {change}");
    }
}

#[test]
fn an_overlay_is_drawn_over_the_picture_of_each_pipeline() {
    let Some(gpu) = gpu::device() else { return };
    for pipeline in ["nebula", "mantis", "caracal", "lore", "awsm", "umbra"] {
        let path = format!("pipelines/{pipeline}.json");
        let with = With { size: Some([96, 54]), ..With::default() };
        let plain = frames(&gpu, &check_file(&path, &with), &[0.0]);
        let extension = Some("pipelines/learn/parts/overlay.json");
        let lined = frames(&gpu, &check_file(&path, &With { extension, ..with }), &[0.0]);
        let differs: Vec<bool> = plain.rgba_pixels().zip(lined.rgba_pixels()).map(|(a, b)| a != b).collect();
        assert!(differs[18 * 96 + 10] && differs[10 * 96 + 32], "{pipeline} has no lines");
        assert!(!differs[10 * 96 + 16], "{pipeline} is changed between lines");
    }
}

fn grows_brighter(name: &str) {
    let Some(gpu) = gpu::device() else { return };
    let outcome = lesson(name);
    let plan = outcome.plan();
    let target = import(&gpu, plan, "target");
    let mut executor = executor(&gpu, plan, None);
    let mut reds = Vec::new();
    for _ in 0..2 {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor
            .record(&mut encoder, &Frame::new(&empty_frame()).imports(&[("target", &target)]))
            .expect("a record");
        gpu.queue.submit([encoder.finish()]);
        let pixels: Vec<_> = read(&gpu, &target).rgba_pixels().collect();
        reds.push(pixels[200][0]);
    }
    assert!(reds[0] > 40 && reds[1] > reds[0] + 40, "{reds:?}");
}
