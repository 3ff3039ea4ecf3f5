//! The application of `examples/own_meshes`: a host with a geometry, a shader and blocks of its own.
//!
//! The oracle projects points of the floor on the CPU: those behind a standing domino are in its shadow, those on its
//! sunny side are lit.

#[path = "../../examples/own_meshes/dominoes.rs"]
mod dominoes;
#[path = "../../examples/own_meshes/shadows.rs"]
mod shadows;

use dominoes::Dominoes;
use glam::DVec3;
use umbragraph::draw::HostResourceKind;
use umbragraph::frame::FrameInput;
use umbragraph::{Executor, Frame};
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;

const SIZE: [u32; 2] = [480, 270];

/// The brightness of the pixel that shows a point of the world.
fn brightness(picture: &Picture, input: &FrameInput, point: DVec3) -> u32 {
    let clip = input.camera.clip(false) * input.camera.view() * point.extend(1.0);
    let [x, y] = [clip.x / clip.w * 0.5 + 0.5, 0.5 - clip.y / clip.w * 0.5];
    let at = [(x * f64::from(SIZE[0])) as u32, (y * f64::from(SIZE[1])) as u32];
    let pixel =
        picture.rgba_pixels().nth((at[1] * SIZE[0] + at[0]) as usize).expect("a point in the picture");
    pixel[..3].iter().map(|value| u32::from(*value)).sum()
}

#[test]
fn an_application_draws_its_meshes_with_extended_shadows() {
    let Some(gpu) = gpu::device() else { return };
    let plan = shadows::plan(shadows::interface(), SIZE).unwrap_or_else(|error| panic!("{error}"));
    let meshes = Dominoes::new(&gpu.device, &gpu.queue);
    let target = crate::common::gpu::import(&gpu, &plan, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, Some(&meshes))
        .unwrap_or_else(|diagnostics| panic!("{diagnostics:?}"));
    let input = shadows::input(f64::from(SIZE[0]) / f64::from(SIZE[1]), 0.0, 0);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    executor
        .record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&[("target", &target)]))
        .unwrap_or_else(|diagnostics| panic!("{diagnostics:?}"));
    gpu.queue.submit([encoder.finish()]);
    let picture = crate::common::gpu::read(&gpu, &target);

    let from_sun = DVec3::new(-0.8, 0.0, -0.35);
    for number in [50, 53, 56] {
        let foot = dominoes::domino(number, 0.0).transform_point3(-DVec3::Y * 0.3);
        let behind = brightness(&picture, &input, foot + from_sun * 0.5);
        let before = brightness(&picture, &input, foot - from_sun * 0.5);
        assert!(behind * 3 < before * 2, "domino {number}: {behind} behind it, {before} before it");
    }
}

#[test]
fn a_host_whose_blocks_lie_elsewhere_is_found_without_a_device() {
    let mut host = shadows::interface();
    if let HostResourceKind::Block { members, .. } = &mut host.object[0].kind {
        members[2].offset = 76;
    }
    let error = shadows::plan(host, SIZE).expect_err("a host that stores otherwise");
    assert_eq!(error.diagnostics().len(), 1, "{error}");
    assert!(
        error.to_string().contains("\"domino.color\" lies at byte 76 on the host and at byte 80"),
        "{error}"
    );
}

/// Counts the lines that an application has to write: `shadows.rs`, and each line beside it that is about the module.
/// Imports of other crates do not count.
#[test]
fn fewer_than_fifty_lines_concern_the_module() {
    let lines = |file: &str| -> Vec<String> {
        let path = format!("examples/own_meshes/{file}");
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
        let lines = lines.filter(|line| !line.starts_with("use ") || line.contains("umbragraph"));
        lines.map(str::to_owned).collect()
    };
    let words = ["umbragraph", "shadows::", "xecutor", "imported_texture", "read_bytes"];
    let is_about = |line: &String| words.iter().any(|word| line.contains(word));
    let beside = [lines("main.rs"), lines("dominoes.rs")].concat();
    let count = lines("shadows.rs").len() + beside.iter().filter(|line| is_about(line)).count();
    println!("{count} lines concern the module");
    assert!((30..50).contains(&count), "{count}");
}
