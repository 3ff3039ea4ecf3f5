//! A renderer follows the pipeline, the options and the host's textures, and makes nothing while they stay.

use umbragraph::executor::read_bytes;
use umbragraph::frame::{Camera, FrameInput};
use umbragraph::{Error, Frame, Library, Options, Pipeline, Renderer};
use umbragraph_test_support::gpu::{self, Gpu};

const SHADER: &str = "{% include 'lib/fullscreen.wgsl.jinja' %}
struct Settings { color: vec3<f32> }
@group(1) @binding(0) var<uniform> settings: Settings;
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(settings.color, 1.0); }
";

fn pipeline(library: &Library, red: f32) -> Pipeline {
    let text = format!(
        r#"{{ "format": 1, "name": "fill",
          "parameters": {{ "green": {{ "type": "f32", "default": 0, "min": 0, "max": 1 }} }},
          "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
          "passes": {{ "fill": {{ "fullscreen": {{
            "shader": "fill.wgsl.jinja", "bind": {{ "settings": {{ "values": {{ "color": [{red}, "=green", 0] }} }} }},
            "color": [{{ "to": "&target" }}] }} }} }} }}"#
    );
    library.load_text("fill.json", &text).unwrap()
}

/// The bytes of the first texel after a frame.
fn drawn(
    gpu: &Gpu,
    renderer: &mut Renderer,
    (pipeline, options): (&Pipeline, &Options),
    target: &wgpu::Texture,
) -> Result<[u8; 4], Error> {
    let input = FrameInput::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], 0.8, 1.0));
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let recorded =
        renderer.record(pipeline, options, &mut encoder, &Frame::new(&input).imports(&[("target", target)]));
    gpu.queue.submit([encoder.finish()]);
    recorded?;
    let bytes = pollster::block_on(read_bytes(&gpu.device, &gpu.queue, target)).unwrap();
    Ok([bytes[0], bytes[1], bytes[2], bytes[3]])
}

#[test]
fn a_renderer_follows_what_changes_and_makes_nothing_otherwise() {
    let Some(gpu) = gpu::device() else { return };
    let library = Library::new().template("fill.wgsl.jinja", SHADER);
    let (red, dark) = (pipeline(&library, 1.0), pipeline(&library, 0.0));
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue);
    assert!(renderer.executor().is_none());
    let small = gpu.target([16; 2], wgpu::TextureFormat::Rgba8Unorm);
    let options = Options::new(16, 16);
    assert_eq!(drawn(&gpu, &mut renderer, (&red, &options), &small).unwrap(), [255, 0, 0, 255]);

    // Nothing is other than before.
    let before = renderer.executor().unwrap().statistics();
    for _ in 0..3 {
        drawn(&gpu, &mut renderer, (&red.clone(), &options), &small).unwrap();
    }
    assert_eq!(renderer.executor().unwrap().statistics(), before);

    // Another format and another size of the host's texture, another pipeline, other options.
    let other = gpu.target([16; 2], wgpu::TextureFormat::Bgra8Unorm);
    assert_eq!(drawn(&gpu, &mut renderer, (&red, &options), &other).unwrap(), [0, 0, 255, 255]);
    let (large, wide) = (gpu.target([32; 2], wgpu::TextureFormat::Rgba8Unorm), Options::new(32, 32));
    assert_eq!(drawn(&gpu, &mut renderer, (&red, &wide), &large).unwrap(), [255, 0, 0, 255]);
    assert_eq!(drawn(&gpu, &mut renderer, (&dark, &wide), &large).unwrap(), [0, 0, 0, 255]);
    let green = wide.clone().set("green", 1);
    assert_eq!(drawn(&gpu, &mut renderer, (&dark, &green), &large).unwrap(), [0, 255, 0, 255]);

    // What cannot be planned is said once, and the plan before goes on.
    let rejected = wide.set("green", 7);
    let error = drawn(&gpu, &mut renderer, (&dark, &rejected), &large).unwrap_err();
    assert!(error.to_string().contains("0 to 1"), "{error}");
    assert_eq!(drawn(&gpu, &mut renderer, (&dark, &rejected), &large).unwrap(), [0, 255, 0, 255]);
}
