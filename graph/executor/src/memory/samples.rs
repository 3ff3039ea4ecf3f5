//! Single samples of a texture with several samples per texel, read back by a compute shader.
//!
//! Such a texture cannot be copied to a buffer. The shader loads one sample of each texel and stores its channels as
//! numbers, which is what [`Texels`] holds.

use umbragraph_pipeline::diagnostic::{Diagnostic, Place, codes};
use umbragraph_pipeline::language::format_name;

use super::read_back::{Texels, caught, read_buffer};

/// The WGSL source of the shader. `TEXTURE` and `LOAD` are replaced by the texture type and by the loaded vector.
const READ: &str = "
@group(0) @binding(0) var source: TEXTURE;
@group(0) @binding(1) var<storage, read_write> values: array<vec4<f32>>;
override chosen: u32;
@compute @workgroup_size(8, 8) fn read(@builtin(global_invocation_id) at: vec3<u32>) {
    let size = textureDimensions(source);
    if all(at.xy < size) {
        values[at.y * size.x + at.x] = LOAD;
    }
}";

/// Reads one sample of each texel of a texture of several samples, after all work that was submitted before. A sample
/// that the texture does not have is its last one. The texture needs the usage `TEXTURE_BINDING`.
///
/// The future is ready at once, except in a browser, where the call must not block.
///
/// # Errors
/// A device without compute shaders or without room for the numbers; errors of the device.
pub async fn read_sample(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    sample: u32,
) -> Result<Texels, Diagnostic> {
    let format = texture.format();
    let failed = |reason: String| {
        let message =
            format!("single samples of a texture in {} cannot be read: {reason}", format_name(format));
        Diagnostic::error(codes::CAPTURE, Place::Nowhere, message)
            .help("read the texture that it is resolved to, or try another driver")
    };
    let is_depth = format.has_depth_aspect();
    let sample_type = match format
        .sample_type(Some(wgpu::TextureAspect::DepthOnly).filter(|_| is_depth), None)
    {
        Some(wgpu::TextureSampleType::Float { .. }) => wgpu::TextureSampleType::Float { filterable: false },
        Some(other) => other,
        None => return Err(failed("a shader sees no single numbers of it".to_owned())),
    };
    let vector = "vec4<f32>(textureLoad(source, at.xy, chosen))";
    let (kind, load) = match sample_type {
        wgpu::TextureSampleType::Depth => {
            ("texture_depth_multisampled_2d", "vec4<f32>(textureLoad(source, at.xy, chosen), 0.0, 0.0, 1.0)")
        }
        wgpu::TextureSampleType::Uint => ("texture_multisampled_2d<u32>", vector),
        wgpu::TextureSampleType::Sint => ("texture_multisampled_2d<i32>", vector),
        wgpu::TextureSampleType::Float { .. } => ("texture_multisampled_2d<f32>", vector),
    };
    let label = Some("read a sample");
    let scopes = [wgpu::ErrorFilter::Validation, wgpu::ErrorFilter::Internal, wgpu::ErrorFilter::OutOfMemory]
        .map(|filter| device.push_error_scope(filter));
    let text = READ.replace("TEXTURE", kind).replace("LOAD", load);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label,
        layout: None,
        module: &module,
        entry_point: Some("read"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[("chosen", f64::from(sample.min(texture.sample_count() - 1)))],
            ..Default::default()
        },
        cache: None,
    });
    let (width, height) = (texture.width(), texture.height());
    let values = device.create_buffer(&wgpu::BufferDescriptor {
        label,
        size: 16 * u64::from(width) * u64::from(height),
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let aspect = if is_depth { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All };
    let view = texture.create_view(&wgpu::TextureViewDescriptor {
        aspect,
        usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
        ..Default::default()
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
            wgpu::BindGroupEntry { binding: 1, resource: values.as_entire_binding() },
        ],
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label, timestamp_writes: None });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(width.div_ceil(8), height.div_ceil(8), 1);
    drop(pass);
    queue.submit([encoder.finish()]);
    caught(scopes).await.map_err(failed)?;
    let bytes = read_buffer(device, queue, &values).await?;
    let number = |bytes: &[u8]| bytes.try_into().map(f32::from_le_bytes).unwrap_or_default();
    let texel = |bytes: &[u8]| std::array::from_fn(|at| number(&bytes[4 * at..4 * at + 4]));
    let values = bytes.chunks_exact(16).map(texel).collect();
    let channels = if is_depth { 1 } else { usize::from(format.components()) };
    Ok(Texels { width, height, layers: 1, channels, values })
}
