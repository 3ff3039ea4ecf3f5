//! One uniform block for each draw.

use glam::{DMat4, Mat4};
use std::num::NonZeroU64;
use umbragraph_executor::wgpu;

use super::geometry::normal_matrix;
use crate::interface::{BLOCK_STRIDE, ObjectBlock};
use crate::pose::Pose;
use crate::scene::{Draw, Scene};

/// The blocks of all draws, in the order of the scene.
pub(super) struct Objects {
    buffer: wgpu::Buffer,
}

impl Objects {
    pub(super) fn new(device: &wgpu::Device, scene: &Scene) -> Self {
        let count = scene.draws_of_all_details().len().max(1) as u64;
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("scene objects"),
            size: count * u64::from(BLOCK_STRIDE),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { buffer }
    }

    /// One block; a dynamic offset moves it to the others.
    pub(super) fn binding(&self) -> wgpu::BindingResource<'_> {
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.buffer,
            offset: 0,
            size: NonZeroU64::new(u64::from(ObjectBlock::SIZE)),
        })
    }

    pub(super) fn write_all(&self, queue: &wgpu::Queue, scene: &Scene, pose: &Pose) {
        let stride = BLOCK_STRIDE as usize;
        let mut bytes = vec![0; scene.draws_of_all_details().len() * stride];
        for (draw, bytes) in scene.draws_of_all_details().zip(bytes.chunks_exact_mut(stride)) {
            bytes[..size_of::<ObjectBlock>()].copy_from_slice(bytemuck::bytes_of(&block(draw, pose)));
        }
        if !bytes.is_empty() {
            queue.write_buffer(&self.buffer, 0, &bytes);
        }
    }

    pub(super) fn write_dynamic(&self, queue: &wgpu::Queue, scene: &Scene, pose: &Pose) {
        for (number, draw) in scene.draws_of_all_details().enumerate().filter(|(_, draw)| draw.dynamic) {
            let offset = number as u64 * u64::from(BLOCK_STRIDE);
            queue.write_buffer(&self.buffer, offset, bytemuck::bytes_of(&block(draw, pose)));
        }
    }
}

/// The matrix from the space of a draw's vertices to the world. Skinned vertices are in the world already.
pub(super) fn world_from_object(draw: Draw, pose: &Pose) -> DMat4 {
    if draw.skin.is_some() { DMat4::IDENTITY } else { pose.world(draw.node) }
}

fn block(draw: Draw, pose: &Pose) -> ObjectBlock {
    let world = world_from_object(draw, pose);
    ObjectBlock {
        world_from_object: world.as_mat4().to_cols_array_2d(),
        normal_from_object: Mat4::from_mat3(normal_matrix(&world).as_mat3()).to_cols_array_2d(),
        receive_shadow: u32::from(draw.receive_shadow),
    }
}
