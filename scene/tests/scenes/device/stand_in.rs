//! A small executor: one pipeline for each property set, one flat-colour shader, one 32 × 32 picture.

use std::collections::BTreeMap;
use umbragraph_executor::wgpu;
use umbragraph_executor::{DrawPass, DrawSource};
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::draw::{DOUBLE_SIDED, HostInterface, HostResourceKind, PropertySet};
use umbragraph_scene::gpu::SceneResources;
use umbragraph_test_support::gpu::Gpu;

/// The width and height of the picture, in pixels.
pub(crate) const SIDE: u32 = 32;

const SHADER: &str = "
struct Material { base_color: vec4<f32>, emissive: vec3<f32>, alpha_cutoff: f32, receive_shadow: u32 }
struct Object { world_from_object: mat4x4<f32>, normal_from_object: mat4x4<f32>, receive_shadow: u32 }
@group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;
@group(2) @binding(0) var<uniform> material: Material;
@group(2) @binding(1) var base_color_texture: texture_2d<f32>;
@group(2) @binding(2) var base_color_sampler: sampler;
@group(3) @binding(0) var<uniform> object: Object;

struct Vertex { @builtin(position) position: vec4<f32>, @location(0) normal: vec3<f32>, @location(1) texcoord: vec2<f32> }

@vertex fn project(@location(0) position: vec3<f32>, @location(1) normal: vec3<f32>, @location(2) texcoord: vec2<f32>) -> Vertex {
    let clip = clip_from_world * (object.world_from_object * vec4(position, 1.0));
    return Vertex(clip, (object.normal_from_object * vec4(normal, 0.0)).xyz, texcoord);
}

@fragment fn shade(vertex: Vertex, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    let color = material.base_color * textureSample(base_color_texture, base_color_sampler, vertex.texcoord);
    if color.a < material.alpha_cutoff { discard; }
    // Blue says that the normal points at the viewer as the face does.
    let towards = select(0.0, 1.0, front == (vertex.normal.z > 0.0));
    return vec4(color.rg, towards, 1.0);
}";

/// The drawn picture and the indices of the drawn objects.
pub(crate) struct Drawn {
    texels: Vec<u8>,
    /// The indices of the objects, in the order of their draw calls.
    pub(crate) objects: Vec<u32>,
}

impl Drawn {
    /// The red, green and blue bytes at a point of the picture; x and y run from −1 to 1, y upwards.
    pub(crate) fn at(&self, x: f64, y: f64) -> [u8; 3] {
        let pixel = |value: f64| ((value * 0.5 + 0.5) * f64::from(SIDE)) as usize;
        let at = (pixel(-y) * SIDE as usize + pixel(x)) * 4;
        [self.texels[at], self.texels[at + 1], self.texels[at + 2]]
    }
}

struct Pass<'a> {
    filter: &'a str,
    view: View,
    pipelines: &'a BTreeMap<PropertySet, wgpu::RenderPipeline>,
    materials: &'a [wgpu::BindGroup],
    object: &'a wgpu::BindGroup,
    objects: Vec<u32>,
    pass: wgpu::RenderPass<'static>,
}

impl DrawPass for Pass<'_> {
    fn geometry(&self) -> &str {
        "scene"
    }

    fn filter(&self) -> &str {
        self.filter
    }

    fn view(&self) -> &View {
        &self.view
    }

    fn set_properties(&mut self, properties: PropertySet) -> bool {
        let pipeline = self.pipelines.get(&properties);
        pipeline.is_some_and(|pipeline| {
            self.pass.set_pipeline(pipeline);
            true
        })
    }

    fn set_material(&mut self, material: u32) {
        self.pass.set_bind_group(2, &self.materials[material as usize], &[]);
    }

    fn set_object(&mut self, object: u32) {
        self.objects.push(object);
        self.pass.set_bind_group(3, self.object, &[object * 256]);
    }

    fn render_pass(&mut self) -> &mut wgpu::RenderPass<'static> {
        &mut self.pass
    }
}

/// Draws the scene with a filter, in an orthographic view along −Z of x and y from −1 to 1.
pub(crate) fn draw(gpu: &Gpu, resources: &SceneResources, filter: &str) -> Drawn {
    let (device, queue) = (&gpu.device, &gpu.queue);
    let interface = resources.interface("scene").expect("the contract of scenes");
    let layouts = [uniform_layout(device, false), material_layout(device), uniform_layout(device, true)];
    let view = orthographic();
    let matrix = bytemuck::cast::<_, [u8; 64]>(view.clip_from_world.as_mat4().to_cols_array());
    let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
    let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 64,
        usage,
        mapped_at_creation: false,
    });
    queue.write_buffer(&uniforms, 0, &matrix);
    let group = |layout: &wgpu::BindGroupLayout, resources: Vec<wgpu::BindingResource<'_>>| {
        let entries: Vec<wgpu::BindGroupEntry<'_>> = resources
            .into_iter()
            .enumerate()
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    };
    let frame = group(&layouts[0], vec![uniforms.as_entire_binding()]);
    let materials: Vec<wgpu::BindGroup> = (0..resources.material_count())
        .map(|material| {
            let names = ["material", "base_color_texture", "base_color_sampler"];
            let slots = names.map(|name| resources.material(material, name).expect("a binding"));
            group(&layouts[1], slots.to_vec())
        })
        .collect();
    let object = group(&layouts[2], vec![resources.object("object").expect("the object")]);
    let pipelines = pipelines(device, interface, &layouts);
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIDE, height: SIDE, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let attachment = wgpu::RenderPassColorAttachment {
        view: &target.create_view(&wgpu::TextureViewDescriptor::default()),
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
    };
    let descriptor = wgpu::RenderPassDescriptor {
        color_attachments: &[Some(attachment)],
        ..wgpu::RenderPassDescriptor::default()
    };
    let mut render_pass = encoder.begin_render_pass(&descriptor).forget_lifetime();
    render_pass.set_bind_group(0, &frame, &[]);
    let mut pass = Pass {
        filter,
        view,
        pipelines: &pipelines,
        materials: &materials,
        object: &object,
        objects: Vec::new(),
        pass: render_pass,
    };
    resources.draw(&mut pass);
    let objects = std::mem::take(&mut pass.objects);
    drop(pass);
    Drawn { texels: read_back(gpu, encoder, &target), objects }
}

fn orthographic() -> View {
    let clip_from_world = glam::DMat4::from_cols_array(&[
        1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -0.01, 0.0, 0.0, 0.0, 0.5, 1.0,
    ]);
    View::new(clip_from_world, glam::DMat4::IDENTITY, glam::DVec3::new(0.0, 0.0, 50.0), glam::DVec3::NEG_Z)
}

fn uniform_layout(device: &wgpu::Device, moved: bool) -> wgpu::BindGroupLayout {
    let ty = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: moved,
        min_binding_size: None,
    };
    layout(device, &[ty])
}

fn material_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let block = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    layout(device, &[block, texture, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)])
}

fn layout(device: &wgpu::Device, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
    let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
    let entries: Vec<wgpu::BindGroupLayoutEntry> = types
        .iter()
        .enumerate()
        .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility,
            ty: *ty,
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

fn pipelines(
    device: &wgpu::Device,
    interface: &HostInterface,
    layouts: &[wgpu::BindGroupLayout; 3],
) -> BTreeMap<PropertySet, wgpu::RenderPipeline> {
    let [HostResourceKind::Block { stride, .. }] = [&interface.object[0].kind] else {
        panic!("the object is a block")
    };
    assert_eq!(*stride, 256);
    let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(SHADER.into()),
    });
    let empty = layout(device, &[]);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&layouts[0]), Some(&empty), Some(&layouts[1]), Some(&layouts[2])],
        immediate_size: 0,
    });
    let attributes: Vec<[wgpu::VertexAttribute; 1]> = ["position", "normal", "texcoord"]
        .into_iter()
        .zip(0..)
        .map(|(name, shader_location)| {
            let attribute = interface.attribute(PropertySet::default(), name).expect("a stream");
            [wgpu::VertexAttribute { format: attribute.format, offset: attribute.offset, shader_location }]
        })
        .collect();
    let buffers: Vec<Option<wgpu::VertexBufferLayout<'_>>> = interface
        .vertex_buffers
        .iter()
        .zip(&attributes)
        .map(|(buffer, attributes)| {
            Some(wgpu::VertexBufferLayout {
                array_stride: buffer.stride,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes,
            })
        })
        .collect();
    let pipeline = |set: PropertySet| {
        let double_sided = interface.property_names(set).contains(&DOUBLE_SIDED);
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &shader,
                entry_point: Some("project"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &buffers,
            },
            primitive: wgpu::PrimitiveState {
                cull_mode: (!double_sided).then_some(wgpu::Face::Back),
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &shader,
                entry_point: Some("shade"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    };
    interface.property_sets.iter().map(|set| (*set, pipeline(*set))).collect()
}

fn read_back(gpu: &Gpu, mut encoder: wgpu::CommandEncoder, target: &wgpu::Texture) -> Vec<u8> {
    const ROW: u32 = 256;
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(ROW * SIDE),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let rows = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(ROW), rows_per_image: None };
    let copy = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout: rows };
    encoder.copy_texture_to_buffer(target.as_image_copy(), copy, target.size());
    gpu.queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("a mapping"));
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).expect("a finished queue");
    let bytes = buffer.slice(..).get_mapped_range().expect("mapped").to_vec();
    bytes.chunks(ROW as usize).flat_map(|row| row[..SIDE as usize * 4].to_vec()).collect()
}
