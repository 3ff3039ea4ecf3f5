//! A part of the host's texture stands for a resource: a mip level, a layer, another format.

use umbragraph::executor::{Import, read_bytes};
use umbragraph::frame::{Camera, FrameInput};
use umbragraph::{Error, Executor, Frame, Library, Options};
use umbragraph_test_support::gpu;

const COPIED: &str = r#"{
  "format": 1, "name": "parts",
  "resources": {
    "own": { "texture": { "format": "rgba8unorm", "size": "=viewport" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } },
    "drawn": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "draw": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&own" }] } },
    "draw_too": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&drawn" }] } },
    "hand_over": { "copy": { "from": { "name": "&own" }, "to": { "name": "&target" } } }
  }
}"#;

const FILL: &str = r#"{
  "format": 1, "name": "parts",
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "fill.wgsl.jinja", "color": [{ "to": "&target" }] } } }
}"#;

const SHADER: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(1.0, 0.5, 0.0, 1.0); }
";

const SRGB: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

#[test]
fn only_the_given_mip_layer_and_format_is_drawn_into() {
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
    let options = Options::new(8, 8).imports(&[("target", Import::mip(&texture, 1).layer(2).format(SRGB))]);
    let plan = library.load_text("parts.json", FILL).and_then(|pipeline| pipeline.plan(&options));
    let plan = plan.unwrap_or_else(|error| panic!("{error}"));
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
    let input = FrameInput::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], 0.8, 1.0));
    let record = |executor: &mut Executor, import: Import<'_>| -> Result<(), Error> {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let recorded = executor.record(&mut encoder, &Frame::new(&input).imports(&[("target", import)]));
        gpu.queue.submit([encoder.finish()]);
        recorded
    };
    // The texture is not what was planned, a part of it is.
    let error = record(&mut executor, Import::new(&texture)).unwrap_err();
    assert!(error.to_string().contains("16 by 16 with 3 layers"), "{error}");
    for layer in [2, 1] {
        let part = Import::mip(&texture, 1).layer(layer).format(SRGB);
        record(&mut executor, part).unwrap_or_else(|error| panic!("{error}"));
        let before = executor.statistics();
        record(&mut executor, part).unwrap_or_else(|error| panic!("{error}"));
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
    let beyond = Import::mip(&texture, 1).layer(3).format(SRGB);
    assert!(record(&mut executor, beyond).unwrap_err().to_string().contains("0 layers"));
    record(&mut executor, Import::mip(&texture, 1).layer(0).format(SRGB)).unwrap();
}

#[test]
fn what_is_copied_is_a_whole_texture() {
    let Some(gpu) = gpu::device() else { return };
    let plan = Library::new().load_text("parts.json", COPIED).and_then(|one| one.plan(&Options::new(8, 8)));
    let plan = plan.unwrap_or_else(|error| panic!("{error}"));
    let names: Vec<_> = plan.imports().map(|(name, _)| name.to_owned()).collect();
    assert_eq!(names, ["drawn", "target"]);
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
    let texture = mips(&gpu, 16);
    let target = executor.import::<wgpu::Texture>("target").unwrap();
    let error = executor.give(target, Import::mip(&texture, 1)).unwrap_err();
    assert!(error.to_string().contains("\"hand_over\" copies \"target\""), "{error}");
    let error = executor.import::<wgpu::Texture>("own").unwrap_err();
    assert!(error.to_string().contains("imports no texture \"own\""), "{error}");
    let error = executor.import::<wgpu::Texture>("tagret").unwrap_err();
    assert!(error.to_string().contains("did you mean \"target\"?"), "{error}");
    let error = executor.import::<wgpu::Buffer>("target").unwrap_err();
    assert!(error.to_string().contains("imports no buffer \"target\""), "{error}");
    let drawn = executor.import::<wgpu::Texture>("drawn").unwrap();
    executor.give(drawn, Import::mip(&texture, 1)).expect("a part of what no pass copies");
    assert!(executor.give(drawn, &texture).is_err(), "of 16 by 16 texels");
}

/// A target in an sRGB format encodes by itself, so the template for the display does not; a pass that says otherwise
/// is right.
#[test]
fn a_target_is_encoded_once_whatever_its_format() {
    let Some(gpu) = gpu::device() else { return };
    let text = |axes: &str| {
        format!(
            r#"{{ "format": 1, "name": "encoded",
              "resources": {{
                "color": {{ "texture": {{ "format": "rgba16float", "size": "=viewport" }} }},
                "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }}
              }},
              "passes": {{
                "fill": {{ "fullscreen": {{ "shader": "fill.wgsl.jinja", "color": [{{ "to": "&color" }}] }} }},
                "present": {{ "fullscreen": {{
                  "shader": "tonemap.wgsl.jinja", "axes": {{ "tone_map": "none"{axes} }},
                  "bind": {{ "source": "&color", "settings": {{ "values": {{ "exposure": 0.5 }} }} }}, "color": [{{ "to": "&target" }}]
                }} }}
              }} }}"#
        )
    };
    let library = Library::new().template("fill.wgsl.jinja", SHADER);
    let bytes = |axes: &str, format: wgpu::TextureFormat| {
        let texture = gpu.target([16; 2], format);
        let imports = [("target", &texture)];
        let pipeline = library.load_text("encoded.json", &text(axes)).unwrap();
        let plan = pipeline.plan(&Options::new(16, 16).imports(&imports));
        let plan = plan.unwrap_or_else(|error| panic!("{error}"));
        let said = plan.passes[1].variants[0].clone();
        let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, None).unwrap();
        let input = FrameInput::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], 0.8, 1.0));
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor.record(&mut encoder, &Frame::new(&input).imports(&imports)).unwrap();
        gpu.queue.submit([encoder.finish()]);
        let bytes = pollster::block_on(read_bytes(&gpu.device, &gpu.queue, &texture)).unwrap();
        ([bytes[0], bytes[1]], said)
    };
    let near = |found: [u8; 2], wanted: [u8; 2]| found.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) < 2);
    let linear = wgpu::TextureFormat::Rgba8Unorm;
    for (axes, format, wanted, constant) in [
        ("", linear, [188, 137], "encode_srgb=1"),
        ("", SRGB, [188, 137], "encode_srgb=0"),
        (r#", "encode_srgb": true"#, SRGB, [223, 193], "encode_srgb=1"),
        (r#", "encode_srgb": false"#, linear, [128, 64], "encode_srgb=0"),
    ] {
        let (found, said) = bytes(axes, format);
        assert!(near(found, wanted) && said.contains(constant), "{axes} {format:?}: {found:?}, {said}");
    }
}

/// A texture or value set by handle stays, with its part, over a plan that does not have the import.
#[test]
fn given_imports_and_live_values_outlive_a_plan_without_them() {
    let Some(gpu) = gpu::device() else { return };
    let shader = "{% include 'lib/fullscreen.wgsl.jinja' %}
struct Settings { red: f32 }
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(settings.red, 0.0, 0.0, 1.0); }
";
    let with = FILL.replace(
        r#""name": "parts","#,
        r#""name": "live",
        "parameters": { "red": { "type": "f32", "default": 0, "min": 0, "max": 1 } },"#,
    );
    let with = with.replace(
        r#""shader": "fill.wgsl.jinja","#,
        r#""shader": "fill.wgsl.jinja", "bind": { "settings": { "values": { "red": "=red" } } },"#,
    );
    let without = FILL.replace("target", "other").replace("fill.wgsl.jinja", "gradient.wgsl.jinja");
    let library = Library::new().template("fill.wgsl.jinja", shader);
    let plan = |text: &str| {
        let plan = library.load_text("parts.json", text).and_then(|one| one.plan(&Options::new(8, 8)));
        plan.unwrap_or_else(|error| panic!("{error}"))
    };
    let (with, without) = (plan(&with), plan(&without));
    let (texture, other) = (mips(&gpu, 16), mips(&gpu, 8));
    let mut executor = Executor::new(&gpu.device, &gpu.queue, with.clone(), None).unwrap();
    executor.give::<wgpu::Texture>(executor.import("target").unwrap(), Import::mip(&texture, 1)).unwrap();
    executor.set(executor.parameter::<f32>("red").unwrap(), 1.0).unwrap();
    executor.set_plan(without).unwrap();
    let input = FrameInput::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], 0.8, 1.0));
    let record = |executor: &mut Executor, frame: Frame<'_>| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        executor.record(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
        gpu.queue.submit([encoder.finish()]);
    };
    record(&mut executor, Frame::new(&input).imports(&[("other", &other)]));
    executor.set_plan(with).unwrap();
    record(&mut executor, Frame::new(&input));
    assert_eq!(texel(&gpu, &texture, 1, 0), [255, 0, 0, 255]);
    // What a frame names counts over it.
    record(&mut executor, Frame::new(&input).imports(&[("target", &other)]));
    assert_eq!(texel(&gpu, &other, 0, 0), [255, 0, 0, 255]);
}

#[test]
fn a_parameter_is_asked_for_with_its_declared_type() {
    let Some(gpu) = gpu::device() else { return };
    let text = FILL.replace(
        r#""name": "parts","#,
        r#""name": "types", "parameters": {
        "number": { "type": "f32", "default": 1, "min": 0, "max": 9 },
        "count": { "type": "u32", "default": 1, "min": 0, "max": 9 },
        "list": { "type": "f32[]", "default": [1, 2] }
    },"#,
    );
    let library = Library::new().template("fill.wgsl.jinja", SHADER);
    let plan = library.load_text("types.json", &text).and_then(|one| one.plan(&Options::new(8, 8)));
    let executor = Executor::new(&gpu.device, &gpu.queue, plan.unwrap(), None).unwrap();
    executor.parameter::<f32>("number").unwrap();
    executor.parameter::<u32>("count").unwrap();
    executor.parameter::<[f32; 2]>("list").unwrap();
    let error = executor.parameter::<u32>("number").unwrap_err().to_string();
    assert!(
        error.contains("\"number\" is declared as f32, not u32") && error.contains("types.json:"),
        "{error}"
    );
    assert!(executor.parameter::<f32>("count").is_err());
    assert!(executor.parameter::<[u32; 2]>("list").is_err());
    let error = executor.parameter::<[f32; 3]>("list").unwrap_err().to_string();
    assert!(error.contains("declared as f32[] of 2, not [f32; 3]"), "{error}");
}

/// A texture with two mip levels.
fn mips(gpu: &gpu::Gpu, side: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("mips"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        mip_level_count: 2,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// The first texel of a layer of a mip.
fn texel(gpu: &gpu::Gpu, texture: &wgpu::Texture, mip: u32, layer: u32) -> [u8; 4] {
    let side = texture.width() >> mip;
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
