//! Textures and buffers from the device to the host.
//!
//! One mip level with all of its layers is copied to a buffer and taken apart into four numbers for each texel. Depth
//! in a format that cannot be copied (`depth24plus`) is read by a compute shader, and so is `depth32float` on devices
//! that copy no depth to buffers (OpenGL).
//!
//! Limits: compressed formats, `rgb9e5ufloat` and textures of several samples are rejected, and depth on devices that
//! have neither such copies nor compute shaders (OpenGL ES 3.0).

use wgpu::TextureFormat as Format;

use umbragraph_pipeline::diagnostic::{Diagnostic, Place, codes};
use umbragraph_pipeline::language::format_name;

/// The texel values of a texture: row by row from the top, layer by layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Texels {
    /// The width, in texels.
    pub width: u32,
    /// The height of a layer, in texels.
    pub height: u32,
    /// The number of layers.
    pub layers: u32,
    /// The number of channels of the format: 1 to 4.
    pub channels: usize,
    /// Red, green, blue and alpha of each texel, as a shader reads them. Depth or stencil is in red; missing colour
    /// channels are 0, and missing alpha is 1.
    pub values: Vec<[f32; 4]>,
}

/// Reads mip level 0 of a texture as numbers, with the same requirements as [`read_bytes`].
///
/// # Errors
/// Compressed and other formats without plain channels; several samples; a missing usage; errors of the device.
pub async fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Texels, Diagnostic> {
    let layout = Layout::of_texture(texture)?;
    let bytes = read_bytes(device, queue, texture).await?;
    let values = bytes.chunks_exact(layout.bytes as usize).map(|texel| layout.numbers(texel)).collect();
    let (width, height, layers) = (texture.width(), texture.height(), texture.depth_or_array_layers());
    Ok(Texels { width, height, layers, channels: layout.channels, values })
}

/// Reads the bytes of mip level 0 of a texture, after all work that was submitted before: row by row from the top
/// without gaps, layer by layer. The texture needs the usage `COPY_SRC`, or `TEXTURE_BINDING` for `depth24plus`. Of a
/// combined depth and stencil format, only the depth is read.
///
/// The future is ready at once, except in a browser, where the call must not block.
///
/// # Errors
/// Compressed and other formats without plain channels; several samples; a missing usage; errors of the device.
pub async fn read_bytes(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, Diagnostic> {
    let layout = Layout::of_texture(texture)?;
    let mut read = rows(device, queue, texture, &layout, !layout.copied).await;
    // A device does not say whether it copies depth; its error does.
    let is_depth = texture.format().is_depth_stencil_format() && layout.bytes == 4;
    if read.is_err()
        && layout.copied
        && is_depth
        && texture.usage().contains(wgpu::TextureUsages::TEXTURE_BINDING)
    {
        read = rows(device, queue, texture, &layout, true).await;
    }
    read.map_err(|reason| {
        let format = format_name(texture.format());
        let message = format!("a texture in {format} cannot be read back: {reason}");
        Diagnostic::error(codes::DEVICE, Place::Nowhere, message)
            .help("the device was lost or copies no such texture to buffers: try another driver, or draw the texture into one of color")
    })
}

/// Reads the bytes of a buffer, after all work that was submitted before. The buffer needs the usage `COPY_SRC`.
///
/// The future is ready at once, except in a browser, where the call must not block.
///
/// # Errors
/// A missing usage; errors of the device.
pub async fn read_buffer(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<u8>, Diagnostic> {
    let failed = |reason: String| {
        let message = format!("a buffer of {} bytes cannot be read back: {reason}", buffer.size());
        Diagnostic::error(codes::DEVICE, Place::Nowhere, message)
            .help("create it with the usage COPY_SRC; a device that was lost has to be made again")
    };
    let label = Some("read back");
    let scopes = [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory]
        .map(|filter| device.push_error_scope(filter));
    let copy = device.create_buffer(&wgpu::BufferDescriptor {
        label,
        size: buffer.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    queue.submit([encoder.finish()]);
    caught(scopes).await.map_err(failed)?;
    mapped(device, &copy).await.map_err(failed)
}

/// Ends error scopes, the last first, and returns the causes of the error that the first of them caught.
pub(super) async fn caught<const N: usize>(scopes: [wgpu::ErrorScopeGuard; N]) -> Result<(), String> {
    let mut error = None;
    for scope in scopes.into_iter().rev() {
        error = scope.pop().await.or(error);
    }
    error.map_or(Ok(()), |error| Err(crate::objects::creation::causes(&error)))
}

/// Returns the bytes of a texture row by row, without gaps. With `by_shader`, a compute shader reads the depth;
/// otherwise the texture is copied.
async fn rows(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    layout: &Layout,
    by_shader: bool,
) -> Result<Vec<u8>, String> {
    let lines = u64::from(texture.height()) * u64::from(texture.depth_or_array_layers());
    let row = (texture.width() * layout.bytes).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let label = Some("read back");
    let scopes = [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory]
        .map(|filter| device.push_error_scope(filter));
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label,
        size: u64::from(row) * lines,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    if by_shader {
        read_depth(device, &mut encoder, texture, &buffer, row / 4);
    } else {
        let source = wgpu::TexelCopyTextureInfo { aspect: layout.aspect, ..texture.as_image_copy() };
        let rows_per_image = Some(texture.height());
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image };
        let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(source, destination, texture.size());
    }
    queue.submit([encoder.finish()]);
    caught(scopes).await?;
    let mut bytes = mapped(device, &buffer).await?;
    let (row, wanted, lines) = (row as usize, (texture.width() * layout.bytes) as usize, lines as usize);
    for line in 0..lines {
        bytes.copy_within(line * row..line * row + wanted, line * wanted);
    }
    bytes.truncate(wanted * lines);
    Ok(bytes)
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

/// The WGSL source that writes the depth of each texel to a buffer with `row` words per row. `TEXTURE` and `LAYER` are
/// replaced for one layer or several, which OpenGL distinguishes; depth is read as a texture of `f32`.
const READ_DEPTH: &str = "
@group(0) @binding(0) var depth: TEXTURE<f32>;
@group(0) @binding(1) var<storage, read_write> words: array<f32>;
override row: u32;
@compute @workgroup_size(8, 8) fn read(@builtin(global_invocation_id) at: vec3<u32>) {
    let size = textureDimensions(depth);
    if all(at.xy < size) {
        words[(at.z * size.y + at.y) * row + at.x] = textureLoad(depth, at.xy, LAYER 0).r;
    }
}";

fn read_depth(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    texture: &wgpu::Texture,
    buffer: &wgpu::Buffer,
    row: u32,
) {
    let (name, layer, view_dimension) = match texture.depth_or_array_layers() {
        1 => ("texture_2d", "", wgpu::TextureViewDimension::D2),
        _ => ("texture_2d_array", "at.z,", wgpu::TextureViewDimension::D2Array),
    };
    let label = Some("read depth");
    let text = READ_DEPTH.replace("TEXTURE", name).replace("LAYER", layer);
    let source = wgpu::ShaderSource::Wgsl(text.into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty,
        count: None,
    };
    let sample_type = wgpu::TextureSampleType::Float { filterable: false };
    let storage = wgpu::BufferBindingType::Storage { read_only: false };
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label,
        entries: &[
            entry(0, wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }),
            entry(
                1,
                wgpu::BindingType::Buffer { ty: storage, has_dynamic_offset: false, min_binding_size: None },
            ),
        ],
    });
    let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[Some(&layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: Some(&pipeline_layout),
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
        dimension: Some(view_dimension),
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
        layout: &layout,
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

/// The byte layout of a texel.
struct Layout {
    bytes: u32,
    channels: usize,
    aspect: wgpu::TextureAspect,
    /// Whether the format can be copied to a buffer; otherwise a compute shader reads the depth.
    copied: bool,
    /// Whether blue is the first channel and red the third.
    is_bgra: bool,
    /// The packing of channels that share a 32-bit word; `None` if each channel has bytes of its own.
    packed: Option<Packed>,
    /// The decoders of a colour channel, and of the alpha channel, which is never sRGB-encoded.
    decode: [Decode; 2],
}

/// A format whose channels share one 32-bit word.
#[derive(Clone, Copy)]
enum Packed {
    /// Unsigned normalised channels: ten bits each for red, green and blue, two for alpha.
    Unorm,
    /// Floating-point channels without sign: eleven bits each for red and green, ten for blue, with the exponent of
    /// half floats.
    Float,
}

/// A function from the little-endian bytes of one channel to its number.
type Decode = fn(&[u8]) -> f32;

impl Layout {
    fn of_texture(texture: &wgpu::Texture) -> Result<Self, Diagnostic> {
        let (format, samples) = (texture.format(), texture.sample_count());
        let layout = Self::of(format).filter(|_| samples == 1).ok_or_else(|| {
            let message =
                format!("a texture of the format {format:?} with {samples} samples cannot be read back");
            Diagnostic::error(codes::CAPTURE, Place::Nowhere, message)
                .help("draw it into a texture of a format with plain channels, and of one sample")
        })?;
        let needed =
            if layout.copied { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::TEXTURE_BINDING };
        if !texture.usage().contains(needed) {
            let message =
                format!("the texture was created without the usage {needed:?}, by which it is read back");
            return Err(Diagnostic::error(codes::CAPTURE, Place::Nowhere, message).help(
                "create it with the usage; a texture of a plan has it with \"exposed\": true or Options::expose",
            ));
        }
        Ok(layout)
    }

    /// Returns the layout of a format, from the channels, bits and number type in its WebGPU name. `None` if the format
    /// cannot be decoded.
    fn of(format: Format) -> Option<Self> {
        let packed = match format {
            Format::Rgb10a2Unorm => Some((Packed::Unorm, 4)),
            Format::Rg11b10Ufloat => Some((Packed::Float, 3)),
            _ => None,
        };
        if let Some((packed, channels)) = packed {
            return Some(Self { packed: Some(packed), channels, ..Self::of(Format::R32Uint)? });
        }
        let (all, depth) = (wgpu::TextureAspect::All, wgpu::TextureAspect::DepthOnly);
        let (name, aspect, copied) = match format {
            Format::Stencil8 => ("r8uint".to_owned(), all, true),
            Format::Depth16Unorm => ("r16unorm".to_owned(), all, true),
            Format::Depth32Float | Format::Depth32FloatStencil8 => ("r32float".to_owned(), depth, true),
            Format::Depth24Plus | Format::Depth24PlusStencil8 => ("r32float".to_owned(), all, false),
            _ => (format_name(format), all, true),
        };
        let (channels, rest) = name.split_at(name.find(|letter: char| letter.is_ascii_digit())?);
        let (bits, kind) = rest.split_at(rest.find(|letter: char| !letter.is_ascii_digit())?);
        let decode = [decode(bits, kind)?, decode(bits, kind.trim_end_matches("-srgb"))?];
        let bytes = channels.len() as u32 * bits.parse::<u32>().ok()? / 8;
        Some(Self {
            bytes,
            channels: channels.len(),
            aspect,
            copied,
            is_bgra: channels == "bgra",
            packed: None,
            decode,
        })
    }

    /// Decodes the bytes of a texel to red, green, blue and alpha.
    fn numbers(&self, bytes: &[u8]) -> [f32; 4] {
        match self.packed {
            Some(Packed::Unorm) => {
                let run = |shift: u32, max: u32| (word(bytes) >> shift & max) as f32 / max as f32;
                return [run(0, 1023), run(10, 1023), run(20, 1023), run(30, 3)];
            }
            Some(Packed::Float) => {
                let half = |bits: u32| half::f16::from_bits(bits as u16 & 0x7fff).to_f32();
                return [
                    half(word(bytes) << 4),
                    half(word(bytes) >> 11 << 4),
                    half(word(bytes) >> 22 << 5),
                    1.0,
                ];
            }
            None => {}
        }
        let mut values = [0.0, 0.0, 0.0, 1.0];
        let size = bytes.len() / self.channels;
        let [channel, alpha] = self.decode;
        for (at, (value, bytes)) in values.iter_mut().zip(bytes.chunks_exact(size)).enumerate() {
            *value = if at == 3 { alpha(bytes) } else { channel(bytes) };
        }
        if self.is_bgra {
            values.swap(0, 2);
        }
        values
    }
}

/// Joins up to four bytes in little-endian order to one word.
fn word(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte))
}

fn decode(bits: &str, kind: &str) -> Option<Decode> {
    Some(match (bits, kind) {
        ("8", "unorm") => |bytes| word(bytes) as f32 / 255.0,
        ("8", "unorm-srgb") => |bytes| {
            let encoded = word(bytes) as f32 / 255.0;
            if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
        },
        ("8", "snorm") => |bytes| (f32::from(word(bytes) as i8) / 127.0).max(-1.0),
        ("8", "sint") => |bytes| f32::from(word(bytes) as i8),
        ("16", "unorm") => |bytes| word(bytes) as f32 / 65535.0,
        ("16", "snorm") => |bytes| (f32::from(word(bytes) as i16) / 32767.0).max(-1.0),
        ("16", "sint") => |bytes| f32::from(word(bytes) as i16),
        ("16", "float") => |bytes| half::f16::from_bits(word(bytes) as u16).to_f32(),
        ("8" | "16" | "32", "uint") => |bytes| word(bytes) as f32,
        ("32", "sint") => |bytes| word(bytes) as i32 as f32,
        ("32", "float") => |bytes| f32::from_bits(word(bytes)),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packed_floats_are_three_numbers() {
        // 1.0, 0.5 and 2.0: exponents 15, 14 and 16.
        let word: u32 = 15 << 6 | 14 << 6 << 11 | 16 << 5 << 22;
        let layout = Layout::of(Format::Rg11b10Ufloat).expect("a layout");
        assert_eq!((layout.bytes, layout.channels), (4, 3));
        assert_eq!(layout.numbers(&word.to_le_bytes()), [1.0, 0.5, 2.0, 1.0]);
    }
}
