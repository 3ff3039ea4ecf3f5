//! A part of the host's texture stands for a resource: a mip level, a layer, another format.

use umbragraph::compiler::{Import, TextureSize};
use umbragraph::executor::{ImportPart, read_bytes};
use umbragraph::frame::{Camera, FrameInput};
use umbragraph::{Error, Executor, Frame, Library, Options};
use umbragraph_test_support::gpu;

const COPIED: &str = r#"{
  "format": 1, "name": "parts",
  "resources": {
    "own": { "texture": { "format": "rgba8unorm", "size": "viewport" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "viewport", "lifetime": "imported" } },
    "drawn": { "texture": { "format": "rgba8unorm", "size": "viewport", "lifetime": "imported" } }
  },
  "passes": {
    "draw": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "own" }] } },
    "draw_too": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "drawn" }] } },
    "hand_over": { "copy": { "from": { "name": "own" }, "to": { "name": "target" } } }
  }
}"#;

const FILL: &str = r#"{
  "format": 1, "name": "parts",
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "fill.wgsl.jinja", "color": [{ "to": "target" }] } } }
}"#;

const SHADER: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(1.0, 0.5, 0.0, 1.0); }
";

const SRGB: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

#[test]
fn a_mip_of_a_layer_in_another_format_is_drawn_into_and_nothing_else() {
    let Some(gpu) = gpu::device() else { return };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("array"),
        size: wgpu::Extent3d { width: 16, height: 16, depth_or_array_layers: 3 },
        mip_level_count: 2,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[SRGB],
    });
    let library = Library::new().template("fill.wgsl.jinja", SHADER);
    let size = TextureSize { width: 8, height: 8, layers: 1, mips: 1, samples: 1 };
    let options = Options::new(8, 8).import("target", Import::new(SRGB, size));
    let plan = library.load_text("parts.json", FILL).and_then(|pipeline| pipeline.plan(&options));
    let plan = plan.unwrap_or_else(|error| panic!("{error}"));
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
    let input = FrameInput::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], 0.8, 1.0));
    let record = |executor: &mut Executor| -> Result<(), Error> {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let recorded = executor.record(&mut encoder, &Frame::new(&input).imports(&[("target", &texture)]));
        gpu.queue.submit([encoder.finish()]);
        recorded
    };
    // The texture is not what was planned, a part of it is.
    let error = record(&mut executor).unwrap_err();
    assert!(error.to_string().contains("16 by 16 with 3 layers"), "{error}");
    for layer in [2, 1] {
        executor.import_part("target", Some(ImportPart::new(1, layer).format(SRGB))).unwrap();
        record(&mut executor).unwrap_or_else(|error| panic!("{error}"));
        let before = executor.statistics();
        record(&mut executor).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(executor.statistics(), before);
        for (mip, at, wanted) in [(1, layer, [255, 187, 0, 255]), (1, 0, [0; 4]), (0, layer, [0; 4])] {
            let texel = texel(&gpu, &texture, mip, at);
            // Half a level of sRGB may be rounded either way.
            assert!(
                texel.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) < 2),
                "mip {mip} of layer {at}: {texel:?}"
            );
        }
    }
    // Past the end of the texture there is no part.
    executor.import_part("target", Some(ImportPart::new(1, 3).format(SRGB))).unwrap();
    assert!(record(&mut executor).unwrap_err().to_string().contains("0 layers"));
    executor.import_part("target", Some(ImportPart::new(1, 0).format(SRGB))).unwrap();
    record(&mut executor).unwrap_or_else(|error| panic!("{error}"));
    let error = executor.import_part("tagret", None).unwrap_err();
    assert!(error.to_string().contains("imports no texture \"tagret\""), "{error}");
}

#[test]
fn what_is_copied_is_a_whole_texture() {
    let Some(gpu) = gpu::device() else { return };
    let plan = Library::new().load_text("parts.json", COPIED).and_then(|one| one.plan(&Options::new(8, 8)));
    let plan = plan.unwrap_or_else(|error| panic!("{error}"));
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
    let error = executor.import_part("target", Some(ImportPart::new(1, 0))).unwrap_err();
    assert!(error.to_string().contains("\"hand_over\" copies \"target\""), "{error}");
    let error = executor.import_part("own", None).unwrap_err();
    assert!(error.to_string().contains("imports no texture \"own\""), "{error}");
    executor.import_part("drawn", Some(ImportPart::new(1, 0))).expect("a part of what no pass copies");
}

/// The first texel of a layer of a mip.
fn texel(gpu: &gpu::Gpu, texture: &wgpu::Texture, mip: u32, layer: u32) -> [u8; 4] {
    let side = 16 >> mip;
    let size = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 };
    let copy = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("copy"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: texture.format(),
        usage: wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let from = wgpu::TexelCopyTextureInfo {
        mip_level: mip,
        origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
        ..texture.as_image_copy()
    };
    encoder.copy_texture_to_texture(from, copy.as_image_copy(), size);
    gpu.queue.submit([encoder.finish()]);
    let bytes = pollster::block_on(read_bytes(&gpu.device, &gpu.queue, &copy)).unwrap();
    [bytes[0], bytes[1], bytes[2], bytes[3]]
}
