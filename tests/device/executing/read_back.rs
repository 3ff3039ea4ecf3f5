//! Textures on the way back to the host: what the numbers of each format are.

use umbragraph::executor::{Texels, read_back};
use umbragraph_test_support::gpu::{self, Gpu};
use wgpu::TextureFormat as Format;

/// The texels read back from a texture with one row of these bytes.
#[track_caller]
fn read(gpu: &Gpu, format: Format, bytes: &[u8]) -> Texels {
    let size = format.block_copy_size(None).expect("a format of one aspect");
    let extent = wgpu::Extent3d { width: bytes.len() as u32 / size, height: 1, depth_or_array_layers: 1 };
    let texture = texture(gpu, format, extent, wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC);
    let layout =
        wgpu::TexelCopyBufferLayout { bytes_per_row: Some(bytes.len() as u32), ..Default::default() };
    gpu.queue.write_texture(texture.as_image_copy(), bytes, layout, extent);
    pollster::block_on(read_back(&gpu.device, &gpu.queue, &texture)).expect("numbers")
}

fn texture(gpu: &Gpu, format: Format, size: wgpu::Extent3d, usage: wgpu::TextureUsages) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("read back"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

#[test]
fn numbers_are_those_that_a_shader_reads() {
    let Some(gpu) = gpu::device() else { return };
    let has_norms = gpu.device.features().contains(wgpu::Features::TEXTURE_FORMAT_16BIT_NORM);
    let packed = (1023_u32 | 341 << 10 | 2 << 30).to_le_bytes();
    let words = |words: [i32; 2]| words.map(i32::to_le_bytes).concat();
    let halves = |halves: [i16; 2]| halves.map(i16::to_le_bytes).concat();
    let cases = [
        (Format::R8Unorm, vec![0, 51, 255], vec![0.0, 0.2, 1.0], 1),
        (Format::R8Snorm, vec![127, 0x81, 0x80, 0], vec![1.0, -1.0, -1.0, 0.0], 1),
        (Format::Rg8Snorm, vec![127, 0x81], vec![1.0, -1.0], 2),
        (Format::R8Uint, vec![0, 200], vec![0.0, 200.0], 1),
        (Format::Rg8Sint, vec![100, 0x80], vec![100.0, -128.0], 2),
        (Format::Rgba8Unorm, vec![255, 51, 0, 102], vec![1.0, 0.2, 0.0, 0.4], 4),
        (Format::Bgra8Unorm, vec![0, 51, 255, 102], vec![1.0, 0.2, 0.0, 0.4], 4),
        (Format::Rgba8UnormSrgb, vec![255, 10, 188, 51], vec![1.0, 0.003_035_27, 0.502_886, 0.2], 4),
        (Format::Rgb10a2Unorm, packed.to_vec(), vec![1.0, 1.0 / 3.0, 0.0, 2.0 / 3.0], 4),
        (Format::R16Uint, halves([-1, 7]), vec![65535.0, 7.0], 1),
        (Format::Rg16Sint, halves([-300, 300]), vec![-300.0, 300.0], 2),
        (Format::Rg16Float, halves([0x3c00, 0xb800_u16 as i16]), vec![1.0, -0.5], 2),
        (Format::R16Unorm, halves([-1, 0x3333]), vec![1.0, 0.2], 1),
        (Format::Rg16Snorm, halves([-32768, 32767]), vec![-1.0, 1.0], 2),
        (Format::R16Snorm, halves([-32767, 0]), vec![-1.0, 0.0], 1),
        (Format::R32Uint, words([-1, 3]), vec![4_294_967_295.0, 3.0], 1),
        (Format::Rg32Sint, words([-70000, 70000]), vec![-70000.0, 70000.0], 2),
        (Format::R32Float, (-1.5_f32).to_le_bytes().to_vec(), vec![-1.5], 1),
        (Format::Stencil8, vec![0, 200], vec![0.0, 200.0], 1),
        (Format::Depth16Unorm, halves([-1, 0x3333]), vec![1.0, 0.2], 1),
    ];
    for (format, bytes, wanted, channels) in cases {
        if matches!(format, Format::R16Unorm | Format::R16Snorm | Format::Rg16Snorm) && !has_norms {
            continue;
        }
        let texels = read(&gpu, format, &bytes);
        assert_eq!((texels.height, texels.layers, texels.channels), (1, 1, channels), "{format:?}");
        // What a format does not have is black and opaque.
        let filled = wanted.chunks(channels).map(|texel| {
            let mut all = [0.0, 0.0, 0.0, 1.0];
            all[..channels].copy_from_slice(texel);
            all
        });
        let filled: Vec<[f32; 4]> = filled.collect();
        let apart = filled.iter().flatten().zip(texels.values.iter().flatten());
        let is_equal = apart.map(|(one, other)| (one - other).abs()).all(|apart| apart < 1e-6);
        assert!(is_equal && filled.len() == texels.values.len(), "{format:?}: {:?}", texels.values);
    }
}

#[test]
fn depth_is_read_layer_by_layer_also_where_it_cannot_be_copied() {
    let Some(gpu) = gpu::device() else { return };
    for format in
        [Format::Depth32Float, Format::Depth32FloatStencil8, Format::Depth24Plus, Format::Depth24PlusStencil8]
    {
        if !gpu.device.features().contains(format.required_features()) {
            continue;
        }
        // More than a workgroup, and rows that are no multiple of what copies want.
        let size = wgpu::Extent3d { width: 11, height: 9, depth_or_array_layers: 2 };
        let seen = if matches!(format, Format::Depth32Float | Format::Depth32FloatStencil8) {
            wgpu::TextureUsages::COPY_SRC
        } else {
            wgpu::TextureUsages::TEXTURE_BINDING
        };
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | seen;
        let texture = texture(&gpu, format, size, usage);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for (layer, depth) in [(0, 0.25), (1, 0.75)] {
            let view = texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            let clear = wgpu::Operations { load: wgpu::LoadOp::Clear(depth), store: wgpu::StoreOp::Store };
            let clear_stencil =
                wgpu::Operations { load: wgpu::LoadOp::Clear(7), store: wgpu::StoreOp::Store };
            drop(encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &view,
                    depth_ops: Some(clear),
                    stencil_ops: format.has_stencil_aspect().then_some(clear_stencil),
                }),
                ..Default::default()
            }));
        }
        gpu.queue.submit([encoder.finish()]);
        let texels = pollster::block_on(read_back(&gpu.device, &gpu.queue, &texture)).expect("numbers");
        assert_eq!((texels.width, texels.height, texels.layers, texels.channels), (11, 9, 2, 1));
        let (near, far) = texels.values.split_at(99);
        let is_near =
            |texel: &[f32; 4], depth: f32| (texel[0] - depth).abs() < 1e-6 && texel[1..] == [0.0, 0.0, 1.0];
        assert!(near.iter().all(|texel| is_near(texel, 0.25)), "{format:?}: {near:?}");
        assert!(far.len() == 99 && far.iter().all(|texel| is_near(texel, 0.75)), "{format:?}: {far:?}");
    }
}
