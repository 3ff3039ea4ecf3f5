//! Contents of vertex buffers can change from instance to instance: one draw of two squares, each at a place and of a
//! color of its own.

use umbragraph::draw::{DrawPass, DrawSource, HostInterface, HostVertexBuffer, PropertySet};
use umbragraph::executor::read_bytes;
use umbragraph::frame::{Camera, FrameInput};
use umbragraph::{Executor, Frame, Library, Options};
use umbragraph_test_support::gpu;
use wgpu::VertexFormat::{Float32x2, Float32x4};
use wgpu::util::DeviceExt;

const SIZE: u32 = 64;

const SHADER: &str = "struct View { clip_from_world: mat4x4<f32> }
@group(0) @binding(0) var<uniform> view: View;
struct Vertex { @builtin(position) position: vec4<f32>, @location(0) color: vec4<f32> }
@vertex fn place(
    @location(0) corner: vec2<f32>, @location(1) rectangle: vec4<f32>, @location(2) color: vec4<f32>,
) -> Vertex {
    return Vertex(vec4<f32>(mix(rectangle.xy, rectangle.zw, corner), 0.5, 1.0), color);
}
@fragment fn paint(vertex: Vertex) -> @location(0) vec4<f32> { return vertex.color; }
";

const TEXT: &str = r#"{
  "format": 1, "name": "steps",
  "geometry": { "squares": { "vertex": { "corner": "float32x2", "rectangle": "float32x4", "color": "float32x4" } } },
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": {
    "eye": { "camera": { "to": "&eye" } },
    "paint": { "draw": {
      "geometry": "squares", "mesh_filter": "all", "views": "&eye", "shader": "paint.wgsl.jinja", "cull": "none",
      "color": [{ "to": "&target", "clear": [0, 0, 0, 1] }]
    } }
  }
}"#;

struct Squares {
    interface: HostInterface,
    corners: wgpu::Buffer,
    places: wgpu::Buffer,
}

fn interface() -> HostInterface {
    let place = [("rectangle", Float32x4, 0), ("color", Float32x4, 16)];
    HostInterface::new()
        .vertices(HostVertexBuffer::new(8, [("corner", Float32x2, 0)]))
        .vertices(HostVertexBuffer::new(32, place).per_instance())
        .any_filter()
}

impl DrawSource for Squares {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        (geometry == "squares").then_some(&self.interface)
    }

    fn draw(&self, pass: &mut dyn DrawPass) {
        assert!(pass.set_properties(PropertySet::default()));
        let pass = pass.render_pass();
        pass.set_vertex_buffer(0, self.corners.slice(..));
        pass.set_vertex_buffer(1, self.places.slice(..));
        pass.draw(0..6, 0..2);
    }
}

#[test]
fn vertex_buffers_step_by_instance() {
    let Some(gpu) = gpu::device() else { return };
    let buffer = |numbers: &[f32]| {
        let contents = bytemuck::cast_slice(numbers);
        let usage = wgpu::BufferUsages::VERTEX;
        gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let left = [-1.0, -1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0];
    let right = [0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 0.0, 1.0];
    let squares = Squares {
        interface: interface(),
        corners: buffer(&[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0]),
        places: buffer(&[left, right].concat()),
    };
    let library = Library::new().host("squares", interface()).template("paint.wgsl.jinja", SHADER);
    let plan = library.load_text("steps.json", TEXT).and_then(|one| one.plan(&Options::new(SIZE, SIZE)));
    let plan = plan.unwrap_or_else(|error| panic!("{error}"));
    let target = crate::common::gpu::import(&gpu, &plan, "target");
    let mut executor = Executor::new(&gpu.device, &gpu.queue, plan, Some(&squares)).unwrap();
    let input = FrameInput::new(Camera::look_at([0.0, 0.0, 3.0], [0.0; 3], 0.8, 1.0));
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let imports = [("target", &target)];
    let frame = Frame::new(&input).draws(&squares).imports(&imports);
    executor.record(&mut encoder, &frame).unwrap_or_else(|error| panic!("{error}"));
    gpu.queue.submit([encoder.finish()]);
    let bytes = pollster::block_on(read_bytes(&gpu.device, &gpu.queue, &target)).unwrap();
    for (at, texel) in bytes.chunks(4).enumerate() {
        let (x, y) = (at as u32 % SIZE, at as u32 / SIZE);
        let expected = match (x < SIZE / 2, y < SIZE / 2) {
            (true, _) => [255, 0, 0, 255],
            (false, true) => [0, 255, 0, 255],
            (false, false) => [0, 0, 0, 255],
        };
        assert_eq!(texel, expected, "{x}, {y}");
    }
}
