//! Textures from the device to the host.
//!
//! One mip level with all of its layers is copied to a buffer and taken apart into four numbers for each texel. Depth in
//! a format that cannot be copied (`depth24plus`) is first read by a compute shader.
//!
//! Limits: compressed formats, `rgb9e5ufloat` and textures of several samples are rejected.

use wgpu::TextureFormat as Format;

use crate::diagnostic::{Diagnostic, Place, codes};

/// What a texture holds: row by row from the top, layer by layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    /// The width, in texels.
    pub width: u32,
    /// The height of a layer, in texels.
    pub height: u32,
    /// The number of layers.
    pub layers: u32,
    /// How many of the four numbers the format has: 1 to 4.
    pub channels: usize,
    /// Red, green, blue and alpha as a shader reads them, depth and stencil as red; 0, 0 and 1 where there is none.
    pub values: Vec<[f32; 4]>,
}

/// Reads the first mip level of a texture with the usages `COPY_SRC` and `TEXTURE_BINDING`, once everything that was
/// submitted before has run.
///
/// The future is ready at once except in a browser, which must not block.
///
/// # Errors
/// Formats without numbers of their own, several samples, errors of the device.
pub async fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Texels, Diagnostic> {
    let format = texture.format();
    let Some(layout) = Layout::of(format).filter(|_| texture.sample_count() == 1) else {
        let message = format!(
            "a texture of the format {format:?} with {} samples cannot be read back",
            texture.sample_count()
        );
        return Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message)
            .help("draw it into a texture of a format with plain channels, and of one sample"));
    };
    let (width, height, layers) = (texture.width(), texture.height(), texture.depth_or_array_layers());
    let row = (width * layout.bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(row) * u64::from(height) * u64::from(layers),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder =
        device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read back") });
    if layout.copied {
        let source = wgpu::TexelCopyTextureInfo { aspect: layout.aspect, ..texture.as_image_copy() };
        let rows =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: Some(height) };
        let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout: rows };
        let extent = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
        encoder.copy_texture_to_buffer(source, destination, extent);
    } else {
        read_depth(device, &mut encoder, texture, &buffer, row / 4);
    }
    queue.submit([encoder.finish()]);
    let bytes = mapped(device, &buffer).await.map_err(|reason| {
        let message = format!("a texture cannot be read back: {reason}");
        Diagnostic::error(codes::DEVICE, Place::Nowhere, message)
            .help("the device was lost; try a smaller picture, or another driver")
    })?;
    let texel = layout.bytes as usize;
    let rows = bytes.chunks_exact(row as usize).map(|line| &line[..width as usize * texel]);
    let values = rows.flat_map(|line| line.chunks_exact(texel).map(|one| layout.decode(one))).collect();
    Ok(Texels { width, height, layers, channels: layout.channels, values })
}

async fn mapped(device: &wgpu::Device, buffer: &wgpu::Buffer) -> Result<Vec<u8>, String> {
    let (sender, receiver) = futures_channel::oneshot::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        let _ = sender.send(result);
    });
    // Browsers call back by themselves.
    #[cfg(not(target_family = "wasm"))]
    device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| error.to_string())?;
    #[cfg(target_family = "wasm")]
    let _ = device;
    receiver.await.map_err(|error| error.to_string())?.map_err(|error| error.to_string())?;
    let bytes = buffer.slice(..).get_mapped_range().map_err(|error| error.to_string())?;
    Ok(bytes.to_vec())
}

/// Depth, texel by texel, as words of a buffer whose rows have so many words.
const READ_DEPTH: &str = "
@group(0) @binding(0) var depth: texture_depth_2d_array;
@group(0) @binding(1) var<storage, read_write> words: array<f32>;
override row: u32;
@compute @workgroup_size(8, 8) fn read(@builtin(global_invocation_id) at: vec3<u32>) {
    let size = textureDimensions(depth);
    if all(at.xy < size) {
        words[(at.z * size.y + at.y) * row + at.x] = textureLoad(depth, at.xy, at.z, 0);
    }
}";

fn read_depth(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    texture: &wgpu::Texture,
    buffer: &wgpu::Buffer,
    row: u32,
) {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("read depth"),
        source: wgpu::ShaderSource::Wgsl(READ_DEPTH.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("read depth"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[("row", f64::from(row))],
            ..Default::default()
        },
        cache: None,
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        aspect: wgpu::TextureAspect::DepthOnly,
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        base_mip_level: 0,
        mip_level_count: Some(1),
        ..Default::default()
    });
    let words = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("read depth"),
        size: buffer.size(),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("read depth"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
            wgpu::BindGroupEntry { binding: 1, resource: words.as_entire_binding() },
        ],
    });
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        let groups = |side: u32| side.div_ceil(8);
        pass.dispatch_workgroups(
            groups(texture.width()),
            groups(texture.height()),
            texture.depth_or_array_layers(),
        );
    }
    encoder.copy_buffer_to_buffer(&words, 0, buffer, 0, buffer.size());
}

/// How the bytes of a texel lie.
struct Layout {
    bytes: u32,
    channels: usize,
    aspect: wgpu::TextureAspect,
    /// Whether the format can be copied to a buffer.
    copied: bool,
    range: SubresourceRange,
}

/// What one channel is.
#[derive(Clone, Copy)]
enum SubresourceRange {
    Unorm8,
    /// Blue before red.
    Bgra8,
    /// Red, green and blue by the transfer function of sRGB.
    Srgb8,
    Bgra8Srgb,
    Snorm8,
    Uint8,
    Sint8,
    Unorm16,
    Snorm16,
    Uint16,
    Sint16,
    Float16,
    Uint32,
    Sint32,
    Float32,
    /// Ten bits each of red, green and blue, two of alpha.
    Unorm10,
}

impl Layout {
    fn of(format: Format) -> Option<Self> {
        use Format as F;
        let plain = |channels: u32, bytes: u32, range: SubresourceRange| Layout {
            bytes: channels * bytes,
            channels: channels as usize,
            aspect: wgpu::TextureAspect::All,
            copied: true,
            range,
        };
        Some(match format {
            F::R8Unorm => plain(1, 1, SubresourceRange::Unorm8),
            F::Rg8Unorm => plain(2, 1, SubresourceRange::Unorm8),
            F::Rgba8Unorm => plain(4, 1, SubresourceRange::Unorm8),
            F::Bgra8Unorm => plain(4, 1, SubresourceRange::Bgra8),
            F::Rgba8UnormSrgb => plain(4, 1, SubresourceRange::Srgb8),
            F::Bgra8UnormSrgb => plain(4, 1, SubresourceRange::Bgra8Srgb),
            F::R8Snorm => plain(1, 1, SubresourceRange::Snorm8),
            F::Rg8Snorm => plain(2, 1, SubresourceRange::Snorm8),
            F::Rgba8Snorm => plain(4, 1, SubresourceRange::Snorm8),
            F::R8Uint | F::Stencil8 => plain(1, 1, SubresourceRange::Uint8),
            F::Rg8Uint => plain(2, 1, SubresourceRange::Uint8),
            F::Rgba8Uint => plain(4, 1, SubresourceRange::Uint8),
            F::R8Sint => plain(1, 1, SubresourceRange::Sint8),
            F::Rg8Sint => plain(2, 1, SubresourceRange::Sint8),
            F::Rgba8Sint => plain(4, 1, SubresourceRange::Sint8),
            F::R16Unorm | F::Depth16Unorm => plain(1, 2, SubresourceRange::Unorm16),
            F::Rg16Unorm => plain(2, 2, SubresourceRange::Unorm16),
            F::Rgba16Unorm => plain(4, 2, SubresourceRange::Unorm16),
            F::R16Snorm => plain(1, 2, SubresourceRange::Snorm16),
            F::Rg16Snorm => plain(2, 2, SubresourceRange::Snorm16),
            F::Rgba16Snorm => plain(4, 2, SubresourceRange::Snorm16),
            F::R16Uint => plain(1, 2, SubresourceRange::Uint16),
            F::Rg16Uint => plain(2, 2, SubresourceRange::Uint16),
            F::Rgba16Uint => plain(4, 2, SubresourceRange::Uint16),
            F::R16Sint => plain(1, 2, SubresourceRange::Sint16),
            F::Rg16Sint => plain(2, 2, SubresourceRange::Sint16),
            F::Rgba16Sint => plain(4, 2, SubresourceRange::Sint16),
            F::R16Float => plain(1, 2, SubresourceRange::Float16),
            F::Rg16Float => plain(2, 2, SubresourceRange::Float16),
            F::Rgba16Float => plain(4, 2, SubresourceRange::Float16),
            F::R32Uint => plain(1, 4, SubresourceRange::Uint32),
            F::Rg32Uint => plain(2, 4, SubresourceRange::Uint32),
            F::Rgba32Uint => plain(4, 4, SubresourceRange::Uint32),
            F::R32Sint => plain(1, 4, SubresourceRange::Sint32),
            F::Rg32Sint => plain(2, 4, SubresourceRange::Sint32),
            F::Rgba32Sint => plain(4, 4, SubresourceRange::Sint32),
            F::R32Float => plain(1, 4, SubresourceRange::Float32),
            F::Rg32Float => plain(2, 4, SubresourceRange::Float32),
            F::Rgba32Float => plain(4, 4, SubresourceRange::Float32),
            F::Rgb10a2Unorm => Layout { channels: 4, ..plain(1, 4, SubresourceRange::Unorm10) },
            F::Depth32Float | F::Depth32FloatStencil8 => {
                Layout { aspect: wgpu::TextureAspect::DepthOnly, ..plain(1, 4, SubresourceRange::Float32) }
            }
            F::Depth24Plus | F::Depth24PlusStencil8 => {
                Layout { copied: false, ..plain(1, 4, SubresourceRange::Float32) }
            }
            _ => return None,
        })
    }

    /// The numbers of a texel.
    fn decode(&self, bytes: &[u8]) -> [f32; 4] {
        let mut values = [0.0, 0.0, 0.0, 1.0];
        if let (SubresourceRange::Unorm10, [a, b, c, d]) = (self.range, bytes) {
            let word = u32::from_le_bytes([*a, *b, *c, *d]);
            let range = |shift: u32, max: u32| (word >> shift & max) as f32 / max as f32;
            return [range(0, 1023), range(10, 1023), range(20, 1023), range(30, 3)];
        }
        let ranges = bytes.chunks_exact(bytes.len() / self.channels);
        for (channel, (value, range)) in values.iter_mut().zip(ranges).enumerate() {
            *value = self.range.decode(range, channel == 3);
        }
        if matches!(self.range, SubresourceRange::Bgra8 | SubresourceRange::Bgra8Srgb) {
            values.swap(0, 2);
        }
        values
    }
}

impl SubresourceRange {
    fn decode(self, bytes: &[u8], alpha: bool) -> f32 {
        match (self, bytes) {
            (SubresourceRange::Unorm8 | SubresourceRange::Bgra8, [a]) => f32::from(*a) / 255.0,
            (SubresourceRange::Srgb8 | SubresourceRange::Bgra8Srgb, [a]) if alpha => f32::from(*a) / 255.0,
            (SubresourceRange::Srgb8 | SubresourceRange::Bgra8Srgb, [a]) => {
                let encoded = f32::from(*a) / 255.0;
                if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
            }
            (SubresourceRange::Snorm8, [a]) => (f32::from(*a as i8) / 127.0).max(-1.0),
            (SubresourceRange::Uint8, [a]) => f32::from(*a),
            (SubresourceRange::Sint8, [a]) => f32::from(*a as i8),
            (SubresourceRange::Unorm16, [a, b]) => f32::from(u16::from_le_bytes([*a, *b])) / 65535.0,
            (SubresourceRange::Snorm16, [a, b]) => {
                (f32::from(i16::from_le_bytes([*a, *b])) / 32767.0).max(-1.0)
            }
            (SubresourceRange::Uint16, [a, b]) => f32::from(u16::from_le_bytes([*a, *b])),
            (SubresourceRange::Sint16, [a, b]) => f32::from(i16::from_le_bytes([*a, *b])),
            (SubresourceRange::Float16, [a, b]) => half::f16::from_le_bytes([*a, *b]).to_f32(),
            (SubresourceRange::Uint32, [a, b, c, d]) => u32::from_le_bytes([*a, *b, *c, *d]) as f32,
            (SubresourceRange::Sint32, [a, b, c, d]) => i32::from_le_bytes([*a, *b, *c, *d]) as f32,
            (SubresourceRange::Float32, [a, b, c, d]) => f32::from_le_bytes([*a, *b, *c, *d]),
            _ => 0.0,
        }
    }
}
