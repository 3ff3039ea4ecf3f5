//! Conversion of a picture of any format of colors to one of a screen, on the device.
//!
//! It is the conversion with which `umbragraph render` writes a PNG: linear colors get the transfer function of sRGB,
//! and colors of floats are tone mapped from [`BRIGHT`] on. `tests/window/formats.rs` compares both.

use umbragraph::low_level::picture::{BRIGHT, is_of_floats};
use umbragraph::wgpu;

/// The format of the converted picture.
pub(crate) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

const SHADER: &str = "
@group(0) @binding(0) var source: texture_2d<f32>;
override is_gray: bool;
override is_float: bool;
override is_linear: bool;
override bright: f32;

@vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

fn tone_mapped(color: vec3<f32>) -> vec3<f32> {
    // No number is black, since it is not greater than 0.
    let finite = select(vec3<f32>(0.0), min(color, vec3<f32>(3.0e38)), color > vec3<f32>(0.0));
    let peak = max(finite.r, max(finite.g, finite.b));
    if peak <= bright {
        return finite;
    }
    let room = 1.0 - bright;
    return finite / peak * (1.0 - room * room / (peak - bright + room));
}

fn encoded(linear: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(max(linear, vec3<f32>(0.0)), vec3<f32>(1.0 / 2.4)) - 0.055;
    return select(curve, linear * 12.92, linear <= vec3<f32>(0.0031308));
}

@fragment fn shown(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let texel = textureLoad(source, vec2<i32>(at.xy), 0);
    var color = select(texel.rgb, texel.rrr, is_gray);
    if is_float {
        color = tone_mapped(color);
    }
    if is_linear {
        color = encoded(color);
    }
    return vec4<f32>(color, texel.a);
}";

/// The conversion of one texture to another of the same size.
pub(crate) struct Conversion {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    view: wgpu::TextureView,
}

impl Conversion {
    /// Prepares the conversion of a picture, and returns the texture that it is converted to.
    pub(crate) fn of(device: &wgpu::Device, picture: &wgpu::Texture) -> (Self, wgpu::Texture) {
        let label = Some("picture for the screen");
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label,
            size: picture.size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label,
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let entry = wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty: wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable: false },
                view_dimension: wgpu::TextureViewDimension::D2,
                multisampled: false,
            },
            count: None,
        };
        let entries = [entry];
        let layout =
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
        let groups = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layout)],
            ..Default::default()
        });
        let format = picture.format();
        let number = |is_on: bool| f64::from(u8::from(is_on));
        let constants = [
            ("is_gray", number(format.components() == 1)),
            ("is_float", number(is_of_floats(format))),
            ("is_linear", number(is_of_floats(format) || format.is_srgb())),
            ("bright", f64::from(BRIGHT)),
        ];
        let compilation_options =
            wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label,
            layout: Some(&groups),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("shown"),
                compilation_options,
                targets: &[Some(FORMAT.into())],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        let source = picture.create_view(&wgpu::TextureViewDescriptor {
            usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
            ..Default::default()
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&source),
            }],
        });
        (Self { pipeline, group, view: texture.create_view(&Default::default()) }, texture)
    }

    /// Records the conversion.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let attachment = wgpu::RenderPassColorAttachment {
            view: &self.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations::default(),
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture for the screen"),
            color_attachments: &[Some(attachment)],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..3, 0..1);
    }
}
