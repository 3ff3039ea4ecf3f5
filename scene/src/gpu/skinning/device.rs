//! Skinning on the device: a dispatch for each skinned draw.

use glam::{DMat4, Mat4};
use std::collections::BTreeMap;
use std::num::NonZeroU64;
use umbragraph_executor::wgpu;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use super::Skinned;
use crate::gpu::geometry::Geometry;
use crate::interface::BLOCK_STRIDE;
use crate::mesh::Primitive;
use crate::scene::Scene;

const WORKGROUP: u32 = 64;

/// The number of storage buffers that the skinning shader binds.
const STORAGE_BUFFERS: u32 = 4;

/// The compute pipeline that skins vertices, with its bind group and buffers.
pub(super) struct DeviceSkinning {
    device: wgpu::Device,
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    joints: wgpu::Buffer,
    /// The number of workgroups in the dispatch of each skinned draw.
    workgroups: Vec<u32>,
    /// The joint matrices of the last upload, in `f32`; kept to reuse the allocation.
    matrices: Vec<Mat4>,
}

/// A vertex of the mesh before skinning, in the memory layout that the skinning shader reads.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Modelled {
    position: [f32; 3],
    first_joints: [u16; 2],
    normal: [f32; 3],
    last_joints: [u16; 2],
    weights: [f32; 4],
}

/// The uniform block of one skinning dispatch, in the memory layout that the skinning shader reads.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Task {
    vertex_count: u32,
    first_modelled: u32,
    first_vertex: u32,
    first_joint: u32,
    joint_count: u32,
    padding: [u32; 3],
}

impl DeviceSkinning {
    /// Returns `true` if a device with these limits can skin `draws`; `vertices` is the number of vertices of all
    /// skinned draws.
    pub(super) fn fits(limits: &wgpu::Limits, scene: &Scene, draws: &[Skinned], vertices: u32) -> bool {
        let joints: u64 = draws.iter().map(|skinned| u64::from(skinned.joint_count)).sum();
        let max = draws.iter().map(|skinned| scene.primitive(skinned.draw).positions.len()).max();
        let max_buffer = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        limits.max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
            && limits.max_compute_workgroup_size_x >= WORKGROUP
            && limits.max_compute_invocations_per_workgroup >= WORKGROUP
            && max.unwrap_or(0).div_ceil(WORKGROUP as usize)
                <= limits.max_compute_workgroups_per_dimension as usize
            && joints * size_of::<Mat4>() as u64 <= max_buffer
            // Modelled vertices are shared between draws, so there are no more of them.
            && u64::from(vertices) * size_of::<Modelled>() as u64 <= max_buffer
    }

    pub(super) fn new(device: &wgpu::Device, scene: &Scene, draws: &[Skinned], geometry: &Geometry) -> Self {
        let mut modelled: Vec<Modelled> = Vec::new();
        let mut first_modelled = BTreeMap::new();
        let mut tasks = vec![0; draws.len() * BLOCK_STRIDE as usize];
        let mut workgroups = Vec::with_capacity(draws.len());
        for (skinned, bytes) in draws.iter().zip(tasks.chunks_exact_mut(BLOCK_STRIDE as usize)) {
            let primitive = scene.primitive(skinned.draw);
            let first =
                first_modelled.entry((skinned.draw.mesh, skinned.draw.primitive)).or_insert_with(|| {
                    let first = modelled.len() as u32;
                    modelled.extend(modelled_vertices(primitive));
                    first
                });
            let task = Task {
                vertex_count: primitive.positions.len() as u32,
                first_modelled: *first,
                first_vertex: skinned.first_vertex,
                first_joint: skinned.first_joint,
                joint_count: skinned.joint_count,
                padding: [0; 3],
            };
            bytes[..size_of::<Task>()].copy_from_slice(bytemuck::bytes_of(&task));
            workgroups.push(task.vertex_count.div_ceil(WORKGROUP));
        }
        // Of all skinned draws, those with morph targets as well, which are moved by the processor.
        let skins = scene.draws_of_all_details().filter_map(|draw| scene.skins.get(draw.skin?));
        let joint_count = skins.map(|skin| skin.joints.len() as u32).sum::<u32>();
        let joints = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("scene joints"),
            size: u64::from(joint_count.max(1)) * size_of::<Mat4>() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let buffer = |label, contents: &[u8], usage| {
            device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let tasks = buffer("scene skinned draws", &tasks, wgpu::BufferUsages::UNIFORM);
        let modelled =
            buffer("scene modelled vertices", bytemuck::cast_slice(&modelled), wgpu::BufferUsages::STORAGE);
        let layout = layout(device);
        let streams = NonZeroU64::new(u64::from(geometry.skinned_vertices) * 12);
        let part =
            |buffer, size| wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size });
        let resources = [
            part(&tasks, NonZeroU64::new(size_of::<Task>() as u64)),
            part(&modelled, None),
            part(&joints, None),
            part(&geometry.positions, streams),
            part(&geometry.normals, streams),
        ];
        let entries = resources.into_iter().zip(0..);
        let entries: Vec<_> =
            entries.map(|(resource, binding)| wgpu::BindGroupEntry { binding, resource }).collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene skinning"),
            layout: &layout,
            entries: &entries,
        });
        let pipeline = pipeline(device, &layout);
        Self { device: device.clone(), pipeline, group, joints, workgroups, matrices: Vec::new() }
    }

    /// Uploads the joint matrices and submits the dispatches that compute the skinned vertices.
    pub(super) fn write(&mut self, queue: &wgpu::Queue, joints: &[DMat4]) {
        self.matrices.clear();
        self.matrices.extend(joints.iter().map(DMat4::as_mat4));
        queue.write_buffer(&self.joints, 0, bytemuck::cast_slice(&self.matrices));
        let descriptor = wgpu::CommandEncoderDescriptor { label: Some("scene skinning") };
        let mut encoder = self.device.create_command_encoder(&descriptor);
        let descriptor =
            wgpu::ComputePassDescriptor { label: Some("scene skinning"), timestamp_writes: None };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&self.pipeline);
        for (at, workgroups) in (0..).zip(&self.workgroups) {
            pass.set_bind_group(0, &self.group, &[at * BLOCK_STRIDE]);
            pass.dispatch_workgroups(*workgroups, 1, 1);
        }
        drop(pass);
        queue.submit([encoder.finish()]);
    }
}

fn modelled_vertices(primitive: &Primitive) -> impl Iterator<Item = Modelled> + '_ {
    let joints = primitive.joints.iter().flat_map(|joints| joints.joints.iter().zip(&joints.weights));
    let vertices = primitive.positions.iter().zip(&primitive.normals);
    vertices.zip(joints).map(|((position, normal), ([a, b, c, d], weights))| Modelled {
        position: *position,
        first_joints: [*a, *b],
        normal: *normal,
        last_joints: [*c, *d],
        weights: *weights,
    })
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let read = wgpu::BufferBindingType::Storage { read_only: true };
    let write = wgpu::BufferBindingType::Storage { read_only: false };
    let types = [wgpu::BufferBindingType::Uniform, read, read, write, write];
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: ty == wgpu::BufferBindingType::Uniform,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("scene skinning"),
        entries: &entries,
    })
}

fn pipeline(device: &wgpu::Device, layout: &wgpu::BindGroupLayout) -> wgpu::ComputePipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("scene skinning"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    let module = device.create_shader_module(wgpu::include_wgsl!("skin.wgsl"));
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("scene skinning"),
        layout: Some(&layout),
        module: &module,
        entry_point: Some("skin"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}
