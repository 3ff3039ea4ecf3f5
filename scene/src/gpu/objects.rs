//! Two uniform blocks for each draw: its place, and its place in the pose before.

use glam::{DMat4, Mat4};
use std::num::NonZeroU64;
use umbragraph_executor::wgpu;

use super::geometry::normal_matrix;
use crate::interface::{BLOCK_STRIDE, MotionBlock, ObjectBlock};
use crate::pose::Pose;
use crate::scene::{Draw, Scene};

/// The uniform buffers with the transforms of all draws, in the order of [`Scene::draws_of_all_details`].
pub(super) struct Objects {
    places: wgpu::Buffer,
    motions: wgpu::Buffer,
}

impl Objects {
    pub(super) fn new(device: &wgpu::Device, scene: &Scene) -> Self {
        let count = scene.draws_of_all_details().len().max(1) as u64;
        let buffer = |label| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: count * u64::from(BLOCK_STRIDE),
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self { places: buffer("scene objects"), motions: buffer("scene motions") }
    }

    /// The binding of the uniform buffer `object` or `motion`, with the size of one block. A dynamic offset selects the
    /// block of a draw. `None` for any other name.
    pub(super) fn binding(&self, name: &str) -> Option<wgpu::BindingResource<'_>> {
        let (buffer, size) = match name {
            "object" => (&self.places, ObjectBlock::SIZE),
            "motion" => (&self.motions, MotionBlock::SIZE),
            _ => return None,
        };
        let size = NonZeroU64::new(u64::from(size));
        Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size }))
    }

    /// Writes the current and the previous transforms of all draws, both for the same pose.
    pub(super) fn write_all(&self, queue: &wgpu::Queue, scene: &Scene, pose: &Pose) {
        write_whole(queue, &self.places, scene, |draw| block(draw, pose));
        write_whole(queue, &self.motions, scene, |draw| motion(draw, pose));
    }

    /// Writes the current transforms in `pose` of the draws that can move.
    pub(super) fn write_dynamic(&self, queue: &wgpu::Queue, scene: &Scene, pose: &Pose) {
        write_moving(queue, &self.places, scene, |draw| block(draw, pose));
    }

    /// Writes the transforms in the pose `previous` of the draws that can move, for motion vectors.
    pub(super) fn write_motion(&self, queue: &wgpu::Queue, scene: &Scene, previous: &Pose) {
        write_moving(queue, &self.motions, scene, |draw| motion(draw, previous));
    }
}

/// Writes the uniform blocks of all draws to a buffer; `block` returns the block of a draw.
fn write_whole<T: bytemuck::Pod>(
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    scene: &Scene,
    block: impl Fn(Draw) -> T,
) {
    let stride = BLOCK_STRIDE as usize;
    let mut bytes = vec![0; scene.draws_of_all_details().len() * stride];
    for (draw, bytes) in scene.draws_of_all_details().zip(bytes.chunks_exact_mut(stride)) {
        bytes[..size_of::<T>()].copy_from_slice(bytemuck::bytes_of(&block(draw)));
    }
    if !bytes.is_empty() {
        queue.write_buffer(buffer, 0, &bytes);
    }
}

/// Writes the uniform blocks of the draws that can move to a buffer; `block` returns the block of a draw.
fn write_moving<T: bytemuck::Pod>(
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
    scene: &Scene,
    block: impl Fn(Draw) -> T,
) {
    for (number, draw) in scene.draws_of_all_details().enumerate().filter(|(_, draw)| draw.dynamic) {
        let offset = number as u64 * u64::from(BLOCK_STRIDE);
        queue.write_buffer(buffer, offset, bytemuck::bytes_of(&block(draw)));
    }
}

/// The matrix from the space of a draw's vertices to world space. It is the identity for skinned draws, whose vertices
/// are in world space.
pub(super) fn world_from_object(draw: Draw, pose: &Pose) -> DMat4 {
    if draw.skin.is_some() { DMat4::IDENTITY } else { pose.world(draw.node) }
}

fn motion(draw: Draw, previous: &Pose) -> MotionBlock {
    let world = world_from_object(draw, previous).as_mat4();
    MotionBlock { previous_world_from_object: world.to_cols_array_2d() }
}

fn block(draw: Draw, pose: &Pose) -> ObjectBlock {
    let world = world_from_object(draw, pose);
    ObjectBlock {
        world_from_object: world.as_mat4().to_cols_array_2d(),
        normal_from_object: Mat4::from_mat3(normal_matrix(&world).as_mat3()).to_cols_array_2d(),
        receive_shadow: u32::from(draw.receive_shadow),
    }
}
