//! A host whose meshes are coloured squares, and which can be made to misbehave.

use umbragraph::data::ValueType;
use umbragraph::draw::{DrawPass, DrawSource, HostInterface, HostResource, HostVertexBuffer, PropertySet};

/// The template that draws squares: four corners from 0 to 1, put into a rectangle of clip space.
pub(crate) const TEMPLATE: &str = "struct View { clip_from_world: mat4x4<f32> }
@group(0) @binding(0) var<uniform> view: View;
struct Material { tint: vec4<f32> }
@group(2) @binding(0) var<uniform> material: Material;
struct Object { rectangle: vec4<f32>, color: vec4<f32>, depth: f32 }
@group(3) @binding(0) var<uniform> object: Object;
@vertex fn place(@location(0) corner: vec2<f32>) -> @builtin(position) vec4<f32> {
    return view.clip_from_world * vec4<f32>(mix(object.rectangle.xy, object.rectangle.zw, corner), object.depth, 1.0);
}
@fragment fn paint() -> @location(0) vec4<f32> { return object.color * material.tint; }
";

/// The same without a fragment stage.
pub(crate) const DEPTH_TEMPLATE: &str = "struct View { clip_from_world: mat4x4<f32> }
@group(0) @binding(0) var<uniform> view: View;
struct Object { rectangle: vec4<f32>, color: vec4<f32>, depth: f32 }
@group(3) @binding(0) var<uniform> object: Object;
@vertex fn place(@location(0) corner: vec2<f32>) -> @builtin(position) vec4<f32> {
    return view.clip_from_world * vec4<f32>(mix(object.rectangle.xy, object.rectangle.zw, corner), object.depth, 1.0);
}
";

/// The contract in a pipeline.
pub(crate) const GEOMETRY: &str = r#""geometry": { "squares": {
    "vertex": { "corner": "float32x2" },
    "material": { "material": { "tint": "vec4<f32>" } },
    "object": { "object": { "rectangle": "vec4<f32>", "color": "vec4<f32>", "depth": "f32" } },
    "variants": ["double_sided"]
} }"#;

pub(crate) const WHOLE: [f32; 4] = [-1.0, -1.0, 1.0, 1.0];
pub(crate) const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
pub(crate) const GREEN: [f32; 4] = [0.0, 1.0, 0.0, 1.0];
pub(crate) const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 1.0];

/// The properties of a square that is seen from both sides.
pub(crate) const BOTH_SIDES: PropertySet = PropertySet(1);

const STRIDE: u64 = 256;

/// A square in clip space. One whose right edge lies left of its left edge is seen from behind.
#[derive(Clone, Copy)]
pub(crate) struct Square {
    pub(crate) rectangle: [f32; 4],
    pub(crate) color: [f32; 4],
    pub(crate) depth: f32,
}

/// A square that covers everything.
pub(crate) fn square(color: [f32; 4]) -> Square {
    Square { rectangle: WHOLE, color, depth: 0.5 }
}

type Script = Box<dyn Fn(&mut dyn DrawPass, &wgpu::Buffer) + Send + Sync>;

/// The host.
pub(crate) struct Squares {
    pub(crate) interface: HostInterface,
    pub(crate) generation: u64,
    pub(crate) revision: Option<u64>,
    pub(crate) material_count: u32,
    /// Whether a material has no buffer.
    pub(crate) lacks_material: bool,
    /// Whether a texture is given where a buffer is wanted.
    pub(crate) confuses_material: bool,
    /// The calls of the host in a draw pass; without it all squares are drawn with material 0.
    pub(crate) script: Option<Script>,
    objects: u32,
    corners: wgpu::Buffer,
    object_blocks: wgpu::Buffer,
    pub(crate) material_blocks: wgpu::Buffer,
    confusion: wgpu::TextureView,
}

impl Squares {
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        squares: &[Square],
        tints: &[[f32; 4]],
    ) -> Self {
        let buffer = |bytes: &[f32], usage| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("squares"),
                size: bytes.len() as u64 * 4,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            let bytes: Vec<u8> = bytes.iter().flat_map(|number| number.to_ne_bytes()).collect();
            queue.write_buffer(&buffer, 0, &bytes);
            buffer
        };
        let padded = |numbers: &[f32]| {
            let mut numbers = numbers.to_vec();
            numbers.resize(STRIDE as usize / 4, 0.0);
            numbers
        };
        let corners = [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0];
        let objects: Vec<f32> = squares
            .iter()
            .flat_map(|square| padded(&[&square.rectangle[..], &square.color[..], &[square.depth]].concat()))
            .collect();
        let materials: Vec<f32> = tints.iter().flat_map(|tint| padded(tint)).collect();
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("confusion"),
            size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        Self {
            interface: interface(),
            generation: 0,
            revision: None,
            material_count: tints.len() as u32,
            lacks_material: false,
            confuses_material: false,
            script: None,
            objects: squares.len() as u32,
            corners: buffer(&corners, wgpu::BufferUsages::VERTEX),
            object_blocks: buffer(&objects, wgpu::BufferUsages::UNIFORM),
            material_blocks: buffer(&materials, wgpu::BufferUsages::UNIFORM),
            confusion: texture.create_view(&wgpu::TextureViewDescriptor::default()),
        }
    }

    /// With another way to draw; it is given the vertex buffer.
    #[must_use]
    pub(crate) fn drawing(
        mut self,
        script: impl Fn(&mut dyn DrawPass, &wgpu::Buffer) + Send + Sync + 'static,
    ) -> Self {
        self.script = Some(Box::new(script));
        self
    }
}

/// The layout of the squares in buffers.
pub(crate) fn interface() -> HostInterface {
    let object =
        [("rectangle", ValueType::VEC4, 0), ("color", ValueType::VEC4, 16), ("depth", ValueType::F32, 32)];
    HostInterface::new()
        .vertices(HostVertexBuffer::new(8, [("corner", wgpu::VertexFormat::Float32x2, 0)]))
        .material(HostResource::block("material", 0, [("tint", ValueType::VEC4, 0)]))
        .object(HostResource::block("object", STRIDE as u32, object))
        .properties(["double_sided"], [PropertySet(0), BOTH_SIDES])
        .filters(&["all"])
}

impl DrawSource for Squares {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        (geometry == "squares").then_some(&self.interface)
    }

    fn generation(&self) -> u64 {
        self.generation
    }

    fn revision(&self, _: &str) -> Option<u64> {
        self.revision
    }

    fn material_count(&self) -> u32 {
        self.material_count
    }

    fn material(&self, material: u32, _: &str) -> Option<wgpu::BindingResource<'_>> {
        if self.lacks_material {
            return None;
        }
        if self.confuses_material {
            return Some(wgpu::BindingResource::TextureView(&self.confusion));
        }
        Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.material_blocks,
            offset: u64::from(material) * STRIDE,
            size: wgpu::BufferSize::new(16),
        }))
    }

    fn object(&self, _: &str) -> Option<wgpu::BindingResource<'_>> {
        Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: &self.object_blocks,
            offset: 0,
            size: None,
        }))
    }

    fn draw(&self, pass: &mut dyn DrawPass) {
        if let Some(script) = &self.script {
            return script(pass, &self.corners);
        }
        pass.render_pass().set_vertex_buffer(0, self.corners.slice(..));
        if pass.set_properties(PropertySet(0)) {
            pass.set_material(0);
            for object in 0..self.objects {
                pass.set_object(object);
                pass.render_pass().draw(0..6, 0..1);
            }
        }
    }
}
