//! The application of `examples/own_meshes`: a host with a geometry, a shader and blocks of its own.
//!
//! The oracle projects points of the floor on the CPU: those behind a standing domino are in its shadow, those on its
//! sunny side are lit.

mod common;
#[path = "../examples/own_meshes/dominoes.rs"]
mod dominoes;

use std::path::Path;
use std::sync::Arc;

use dominoes::{Dominoes, GEOMETRY, interface};
use glam::{DMat3, DQuat, DVec3};
use umbragraph::draw::{HostInterface, HostSlotKind};
use umbragraph::frame::{Camera, FrameInput, Light, LightKind, Projection};
use umbragraph::{Error, Executor, Frame, Library, Options, Plan};
use umbragraph_test_support::gpu;
use umbragraph_test_support::image::Picture;

const SIZE: [u32; 2] = [480, 270];

fn checked(host: HostInterface) -> Result<Arc<Plan>, Error> {
    let folder = Path::new("examples/own_meshes");
    let library = Library::new().templates(folder).host(GEOMETRY, host);
    library.load(folder.join("dominoes.json"))?.plan(&Options::new(SIZE[0], SIZE[1]))
}

fn frame() -> FrameInput {
    let (eye, middle) = (DVec3::new(1.2, 4.6, 6.2), DVec3::new(0.3, 0.0, 0.3));
    let back = (eye - middle).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let sun = Light::new("sun", LightKind::Directional)
        .direction(DVec3::new(-0.8, -0.7, -0.35).normalize())
        .intensity(4.0)
        .property("cast_shadow");
    FrameInput::new(Camera::new(
        eye,
        DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)),
        Projection::Perspective { vertical_fov: 0.8, near: 0.1, far: 40.0 },
        f64::from(SIZE[0]) / f64::from(SIZE[1]),
    ))
    .lights(vec![sun])
    .filter_bounds("casters", Dominoes::bounds())
    .scene_bounds(Dominoes::bounds())
}

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
fn an_application_of_its_own_draws_its_meshes_with_the_shadows_of_a_pipeline_it_extends() {
    let Some(gpu) = gpu::device() else { return };
    let plan = checked(interface()).unwrap_or_else(|error| panic!("{error}"));
    let meshes = Dominoes::new(&gpu.device, &gpu.queue);
    let target = common::gpu::import(&gpu, &plan, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, Some(&meshes))
        .unwrap_or_else(|diagnostics| panic!("{diagnostics:?}"));
    let input = frame();
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    executor
        .record(&mut encoder, &Frame::new(&input).draws(&meshes).imports(&[("target", &target)]))
        .unwrap_or_else(|diagnostics| panic!("{diagnostics:?}"));
    gpu.queue.submit([encoder.finish()]);
    let picture = common::gpu::read(&gpu, &target);

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
    let mut host = interface();
    if let HostSlotKind::Block { members, .. } = &mut host.object[0].kind {
        members[2].offset = 76;
    }
    let error = checked(host).expect_err("a host that stores otherwise");
    assert_eq!(error.findings().len(), 1, "{error}");
    assert!(
        error.to_string().contains("\"domino.color\" lies at byte 76 on the host and at byte 80"),
        "{error}"
    );
}
