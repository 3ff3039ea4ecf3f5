//! Cameras as engines have them: matrices of any projection, without a far plane, off-centre, moved within a pixel.

use umbragraph::frame::{Camera, Projection};
use umbragraph::{Executor, Frame, Options};
use umbragraph_test_support::gpu::{self, Gpu};
use umbragraph_test_support::image::Picture;

use super::meshes::{Meshes, frame, plan};

const SIZE: [u32; 2] = [160, 90];

struct Studio<'a> {
    gpu: &'a Gpu,
    meshes: Meshes,
    target: wgpu::Texture,
    executor: Executor,
}

impl<'a> Studio<'a> {
    fn new(gpu: &'a Gpu, size: [u32; 2]) -> Self {
        let plan = plan(false, &Options::new(size[0], size[1]).set("cascade_side", 1024));
        let meshes = Meshes::new(gpu, false);
        let target = crate::common::gpu::import(gpu, &plan, "target");
        let executor = Executor::new(&gpu.device, &gpu.queue, plan, Some(&meshes)).unwrap();
        Self { gpu, meshes, target, executor }
    }

    fn picture(&mut self, camera: Camera) -> Picture {
        let input = frame(SIZE).camera(camera);
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.executor
            .record(
                &mut encoder,
                &Frame::new(&input).draws(&self.meshes).imports(&[("target", &self.target)]),
            )
            .unwrap_or_else(|error| panic!("{error}"));
        let unusable = self.executor.notices().filter(|notice| notice.code.id == "UG0806");
        assert_eq!(unusable.count(), 0, "the camera can be used");
        self.gpu.queue.submit([encoder.finish()]);
        crate::common::gpu::read(self.gpu, &self.target)
    }
}

/// The matrices of a camera, as an engine of `f32` has them.
fn matrices(camera: &Camera, reverse: bool) -> [[[f32; 4]; 4]; 2] {
    let world_from_view = camera.view().inverse();
    [world_from_view, camera.clip(reverse)].map(|matrix| matrix.as_mat4().to_cols_array_2d())
}

fn from(matrices: [[[f32; 4]; 4]; 2]) -> Camera {
    Camera::from_matrices(matrices[0], matrices[1])
}

/// The pixels of a picture in which another differs by more than a few levels.
fn differing(a: &Picture, b: &Picture) -> usize {
    let far = |(a, b): ([u8; 4], [u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 12);
    a.rgba_pixels().zip(b.rgba_pixels()).filter(|pair| far(*pair)).count()
}

#[test]
fn matrices_of_an_engine_show_what_angles_and_planes_show() {
    let Some(gpu) = gpu::device() else { return };
    let mut studio = Studio::new(&gpu, SIZE);
    let camera = frame(SIZE).camera;
    let wanted = studio.picture(camera);
    let endless = Projection::Perspective { vertical_fov: 0.8, near: 0.1, far: f64::INFINITY };
    let endless = camera.projection(endless);
    for (what, other) in [
        ("a matrix", from(matrices(&camera, false))),
        ("reversed depth", from(matrices(&camera, true))),
        ("no far plane", endless),
        ("no far plane, as a matrix", from(matrices(&endless, false))),
        ("no far plane, reversed depth", from(matrices(&endless, true))),
    ] {
        assert_eq!(other.check(), None, "{what}");
        let found = studio.picture(other);
        let count = differing(&wanted, &found);
        assert!(count <= 40, "{what}: {count} pixels");
    }
}

/// Each half of a picture through a projection of its own.
#[test]
fn two_off_centre_halves_are_the_whole_picture() {
    let Some(gpu) = gpu::device() else { return };
    let whole = frame(SIZE).camera;
    let wanted = Studio::new(&gpu, SIZE).picture(whole);
    let mut studio = Studio::new(&gpu, [SIZE[0] / 2, SIZE[1]]);
    for (side, first) in [(1.0_f32, 0), (-1.0, SIZE[0] / 2)] {
        let [world, mut clip] = matrices(&whole, true);
        // Twice as wide, and moved by half of the picture: x' = 2x ± w.
        clip.iter_mut().for_each(|column| column[0] = 2.0 * column[0] + side * column[3]);
        let found = studio.picture(from([world, clip]));
        let pixels: Vec<_> = wanted.rgba_pixels().collect();
        let part =
            pixels.chunks(SIZE[0] as usize).flat_map(|row| &row[first as usize..][..SIZE[0] as usize / 2]);
        let far = |(a, b): (&[u8; 4], [u8; 4])| a.iter().zip(b).any(|(a, b)| a.abs_diff(b) > 24);
        let count = part.zip(found.rgba_pixels()).filter(|pair| far(*pair)).count();
        assert!(count <= 200, "{count} pixels of 7200");
    }
}

#[test]
fn a_picture_is_moved_by_what_the_engine_says() {
    let Some(gpu) = gpu::device() else { return };
    let mut studio = Studio::new(&gpu, SIZE);
    let camera = frame(SIZE).camera;
    let wanted: Vec<_> = studio.picture(camera).rgba_pixels().collect();
    // Two pixels to the right.
    let moved: Vec<_> =
        studio.picture(camera.jittered([4.0 / f64::from(SIZE[0]), 0.0])).rgba_pixels().collect();
    let width = SIZE[0] as usize;
    let rows = wanted.chunks(width).zip(moved.chunks(width));
    let pairs = rows.flat_map(|(wanted, moved)| wanted[..width - 2].iter().zip(&moved[2..]));
    let count = pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 12)).count();
    assert!(count <= 150, "{count} pixels");
    assert_ne!(wanted, moved);
}
