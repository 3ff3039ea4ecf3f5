//! One set of boxes and pyramids, stored in two ways: a block for each object and one vertex layout, or as engines do
//! it, an array of objects by instance, a vertex layout for each kind of mesh, materials in bind groups of the engine's
//! own.

use std::sync::{Arc, OnceLock};

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Quat, Vec3};
use umbragraph::data::ValueType;
use umbragraph::draw::{DrawPass, DrawSource, HostInterface, HostResource, HostVertexBuffer, PropertySet};
use umbragraph::frame::{Bounds, Camera, FrameInput, Light};
use umbragraph::{Library, Options, Plan};
use umbragraph_test_support::gpu::Gpu;
use wgpu::VertexFormat::{Float32x2, Float32x3};
use wgpu::util::DeviceExt;

/// The property of meshes whose positions are in a buffer of their own.
const SPLIT: PropertySet = PropertySet(1);

/// The boxes, the first of which is the floor, and the pyramids.
const COUNTS: [u32; 2] = [13, 12];

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    texcoord: [f32; 2],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Object {
    world: Mat4,
    normal: Mat4,
    receive_shadow: u32,
    pad: [u32; 3],
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Material {
    color: [f32; 4],
    emissive: [f32; 3],
    cutoff: f32,
    receive_shadow: u32,
    pad: [u32; 3],
}

const OBJECT: [(&str, ValueType, u32); 3] = [
    ("world_from_object", ValueType::MAT4, 0),
    ("normal_from_object", ValueType::MAT4, 64),
    ("receive_shadow", ValueType::U32, 128),
];

const MATERIAL: [(&str, ValueType, u32); 4] = [
    ("base_color", ValueType::VEC4, 0),
    ("emissive", ValueType::VEC3, 16),
    ("alpha_cutoff", ValueType::F32, 28),
    ("receive_shadow", ValueType::U32, 32),
];

/// The pipeline of the meshes: `awsm`, with a geometry of another name.
pub(crate) fn plan(instanced: bool, options: &Options) -> Arc<Plan> {
    let object = if instanced {
        r#""objects": [{ "world_from_object": "mat4x4<f32>", "normal_from_object": "mat4x4<f32>", "receive_shadow": "u32" }]"#
    } else {
        r#""object": { "world_from_object": "mat4x4<f32>", "normal_from_object": "mat4x4<f32>", "receive_shadow": "u32" }"#
    };
    let text = format!(
        r#"{{
          "format": 1, "name": "engine", "extends": "umbragraph:awsm.json",
          "derived": {{ "geometry": "='engine'", "instanced": "={instanced}" }},
          "geometry": {{ "engine": {{
            "vertex": {{ "position": "float32x3", "normal": "float32x3", "texcoord": "float32x2" }},
            "material": {{
              "material": {{ "base_color": "vec4<f32>", "emissive": "vec3<f32>", "alpha_cutoff": "f32", "receive_shadow": "u32" }},
              "base_color_texture": "texture_2d<f32>", "base_color_sampler": "sampler"
            }},
            "object": {{ {object} }}
          }} }}
        }}"#
    );
    // What one test of the program has proven serves the others.
    static LIBRARIES: [OnceLock<Library>; 2] = [OnceLock::new(), OnceLock::new()];
    let library =
        LIBRARIES[usize::from(instanced)].get_or_init(|| Library::new().host("engine", interface(instanced)));
    let pipeline = library.load_text("engine.json", &text).unwrap_or_else(|error| panic!("{error}"));
    pipeline.plan(options).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn interface(instanced: bool) -> HostInterface {
    let whole = [("position", Float32x3, 0), ("normal", Float32x3, 12), ("texcoord", Float32x2, 24)];
    let filters = ["opaque", "transparent", "casters", "static_casters", "dynamic_casters"];
    let interface = HostInterface::new().vertices(HostVertexBuffer::new(32, whole)).filters(&filters);
    if instanced {
        let split = [
            HostVertexBuffer::new(12, [("position", Float32x3, 0)]),
            HostVertexBuffer::new(20, [("normal", Float32x3, 0), ("texcoord", Float32x2, 12)]),
        ];
        interface
            .object(HostResource::array("objects", 144, OBJECT))
            .properties(["split"], [PropertySet::default(), SPLIT])
            .vertices_of(SPLIT, split)
            .material_layout(material_entries())
    } else {
        interface
            .material(HostResource::block("material", 0, MATERIAL))
            .material(HostResource::opaque("base_color_texture", "texture_2d<f32>"))
            .material(HostResource::opaque("base_color_sampler", "sampler"))
            .object(HostResource::block("object", 256, OBJECT))
    }
}

/// The layout of the engine's own materials, with a binding that no shader of the pipeline asks for.
fn material_entries() -> Vec<wgpu::BindGroupLayoutEntry> {
    let texture = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let block = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let kinds = [block, texture, sampler, texture];
    let entry = |(binding, ty)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty,
        count: None,
    };
    (0..).zip(kinds).map(entry).collect()
}

pub(crate) struct Meshes {
    interface: HostInterface,
    instanced: bool,
    /// Whole vertices; those of pyramids again as positions, and as the rest.
    vertices: [wgpu::Buffer; 3],
    indices: wgpu::Buffer,
    /// The indices of boxes and pyramids.
    ranges: [std::ops::Range<u32>; 2],
    /// The number of vertices before those of the pyramids, in the buffer of whole vertices.
    boxes: i32,
    objects: wgpu::Buffer,
    materials: Vec<wgpu::Buffer>,
    own_materials: Vec<wgpu::BindGroup>,
    white: wgpu::TextureView,
    sampler: wgpu::Sampler,
    indirect: wgpu::Buffer,
}

impl Meshes {
    pub(crate) fn new(gpu: &Gpu, instanced: bool) -> Self {
        let device = &gpu.device;
        let buffer = |contents: &[u8], usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let (mut vertices, mut indices) = (Vec::new(), Vec::new());
        cube(&mut vertices, &mut indices);
        let (boxes, first) = (vertices.len(), indices.len() as u32);
        pyramid(&mut vertices, &mut indices);
        let ranges = [0..first, first..indices.len() as u32];
        let positions: Vec<[f32; 3]> = vertices[boxes..].iter().map(|vertex| vertex.position).collect();
        let others: Vec<_> = vertices[boxes..]
            .iter()
            .map(|one| [one.normal[0], one.normal[1], one.normal[2], one.texcoord[0], one.texcoord[1]])
            .collect();
        let all = objects();
        let objects: Vec<u8> = if instanced {
            bytemuck::cast_slice(&all).to_vec()
        } else {
            all.iter()
                .flat_map(|object| {
                    let mut bytes = bytemuck::bytes_of(object).to_vec();
                    bytes.resize(256, 0);
                    bytes
                })
                .collect()
        };
        let material = |color| {
            let material =
                Material { color, emissive: [0.0; 3], cutoff: 0.0, receive_shadow: 1, pad: [0; 3] };
            buffer(bytemuck::bytes_of(&material), wgpu::BufferUsages::UNIFORM)
        };
        let materials = vec![material([0.5, 0.55, 0.5, 1.0]), material([0.8, 0.35, 0.2, 1.0])];
        let descriptor = wgpu::TextureDescriptor {
            label: Some("white"),
            size: wgpu::Extent3d::default(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let white = device.create_texture_with_data(
            &gpu.queue,
            &descriptor,
            wgpu::util::TextureDataOrder::LayerMajor,
            &[255; 4],
        );
        let white = white.create_view(&wgpu::TextureViewDescriptor::default());
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor::default());
        let entries = material_entries();
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("engine"),
            entries: &entries,
        });
        let own = |material: &wgpu::Buffer| {
            let resources = [
                material.as_entire_binding(),
                wgpu::BindingResource::TextureView(&white),
                wgpu::BindingResource::Sampler(&sampler),
                wgpu::BindingResource::TextureView(&white),
            ];
            let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
            let entries: Vec<_> = (0..).zip(resources).map(entry).collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &layout,
                entries: &entries,
            })
        };
        let args = wgpu::util::DrawIndexedIndirectArgs {
            index_count: ranges[0].len() as u32,
            instance_count: COUNTS[0],
            first_index: 0,
            base_vertex: 0,
            first_instance: 0,
        };
        Self {
            interface: interface(instanced),
            instanced,
            vertices: [
                buffer(bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
                buffer(bytemuck::cast_slice(&positions), wgpu::BufferUsages::VERTEX),
                buffer(bytemuck::cast_slice(&others), wgpu::BufferUsages::VERTEX),
            ],
            indices: buffer(bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            ranges,
            boxes: boxes as i32,
            objects: buffer(&objects, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE),
            own_materials: materials.iter().map(own).collect(),
            materials,
            white,
            sampler,
            indirect: buffer(args.as_bytes(), wgpu::BufferUsages::INDIRECT),
        }
    }
}

impl DrawSource for Meshes {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        (geometry == "engine").then_some(&self.interface)
    }

    fn material_count(&self) -> u32 {
        2
    }

    fn material(&self, material: u32, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        Some(match binding {
            "material" => self.materials[material as usize].as_entire_binding(),
            "base_color_texture" => wgpu::BindingResource::TextureView(&self.white),
            "base_color_sampler" => wgpu::BindingResource::Sampler(&self.sampler),
            _ => return None,
        })
    }

    fn object(&self, _: &str) -> Option<wgpu::BindingResource<'_>> {
        let size = if self.instanced { None } else { wgpu::BufferSize::new(144) };
        Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer: &self.objects, offset: 0, size }))
    }

    fn draw(&self, pass: &mut dyn DrawPass) {
        let is_empty = ["transparent", "dynamic_casters"].contains(&pass.filter());
        if is_empty || !pass.set_properties(PropertySet::default()) {
            return;
        }
        let [boxes, pyramids] = self.ranges.clone();
        pass.render_pass().set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint16);
        pass.render_pass().set_vertex_buffer(0, self.vertices[0].slice(..));
        if !self.instanced {
            for object in 0..COUNTS[0] + COUNTS[1] {
                let is_pyramid = object >= COUNTS[0];
                pass.set_material(u32::from(is_pyramid));
                pass.set_object(object);
                let (indices, first) =
                    if is_pyramid { (pyramids.clone(), self.boxes) } else { (boxes.clone(), 0) };
                pass.render_pass().draw_indexed(indices, first, 0..1);
            }
            return;
        }
        pass.set_bind_group(2, &self.own_materials[0], &[]);
        pass.render_pass().draw_indexed_indirect(&self.indirect, 0);
        assert!(pass.set_properties(SPLIT));
        pass.set_bind_group(2, &self.own_materials[1], &[]);
        pass.render_pass().set_vertex_buffer(0, self.vertices[1].slice(..));
        pass.render_pass().set_vertex_buffer(1, self.vertices[2].slice(..));
        pass.render_pass().draw_indexed(pyramids, 0, COUNTS[0]..COUNTS[0] + COUNTS[1]);
    }
}

/// A camera above the floor, and a low sun.
pub(crate) fn frame(size: [u32; 2]) -> FrameInput {
    let camera =
        Camera::look_at([9.0, 7.0, 11.0], [0.0, 0.5, 0.0], 0.8, f64::from(size[0]) / f64::from(size[1]));
    let sun = Light::directional("sun", [-0.6, -0.7, -0.35], [1.0, 0.95, 0.9], 4.0).property("cast_shadow");
    let bounds = Bounds::between([-12.0, -0.2, -12.0], [12.0, 4.0, 12.0]);
    FrameInput::new(camera).lights(vec![sun]).scene_bounds(bounds).filter_bounds("casters", bounds)
}

fn objects() -> Vec<Object> {
    let object =
        |world: Mat4| Object { world, normal: world.inverse().transpose(), receive_shadow: 1, pad: [0; 3] };
    let floor = Mat4::from_scale_rotation_translation(
        Vec3::new(24.0, 0.2, 24.0),
        Quat::IDENTITY,
        Vec3::new(0.0, -0.1, 0.0),
    );
    let standing = (0..COUNTS[0] + COUNTS[1] - 1).map(|at| {
        let (x, z) = ((at * 7 % 24) as f32 % 5.0 * 2.2 - 4.4, (at * 7 % 24 / 5) as f32 * 2.2 - 4.4);
        let height = 0.8 + (at % 5) as f32 * 0.4;
        Mat4::from_scale_rotation_translation(
            Vec3::new(0.8, height, 0.8),
            Quat::from_rotation_y(at as f32 * 0.4),
            Vec3::new(x, height * 0.5, z),
        )
    });
    std::iter::once(floor).chain(standing).map(object).collect()
}

fn cube(vertices: &mut Vec<Vertex>, indices: &mut Vec<u16>) {
    for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
        let right = normal.any_orthonormal_vector();
        let up = normal.cross(right);
        face(
            vertices,
            indices,
            [normal - right - up, normal + right - up, normal + right + up, normal - right + up]
                .map(|corner| corner * 0.5),
            4,
        );
    }
}

fn pyramid(vertices: &mut Vec<Vertex>, indices: &mut Vec<u16>) {
    let corners = [
        Vec3::new(-0.5, -0.5, 0.5),
        Vec3::new(0.5, -0.5, 0.5),
        Vec3::new(0.5, -0.5, -0.5),
        Vec3::new(-0.5, -0.5, -0.5),
    ];
    let top = Vec3::new(0.0, 0.5, 0.0);
    let start = indices.len();
    for at in 0..4 {
        face(vertices, indices, [corners[at], corners[(at + 1) % 4], top, top], 3);
    }
    face(vertices, indices, [corners[3], corners[2], corners[1], corners[0]], 4);
    // From the first vertex of the pyramid on.
    let first = indices[start..].iter().copied().min().unwrap_or_default();
    indices[start..].iter_mut().for_each(|index| *index -= first);
}

/// A flat face of three or four corners, counter-clockwise.
fn face(vertices: &mut Vec<Vertex>, indices: &mut Vec<u16>, corners: [Vec3; 4], count: usize) {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    let first = vertices.len() as u16;
    vertices.extend(corners[..count].iter().map(|corner| Vertex {
        position: corner.to_array(),
        normal: normal.to_array(),
        texcoord: [0.5; 2],
    }));
    let fan: &[u16] = if count == 4 { &[0, 1, 2, 0, 2, 3] } else { &[0, 1, 2] };
    indices.extend(fan.iter().map(|index| first + index));
}

/// Meshes that a function draws.
pub(crate) struct DrawnBy<'a, F> {
    pub(crate) meshes: &'a Meshes,
    pub(crate) draw: F,
}

impl<F: Fn(&Meshes, &mut dyn DrawPass) + Send + Sync> DrawSource for DrawnBy<'_, F> {
    fn interface(&self, geometry: &str) -> Option<&HostInterface> {
        self.meshes.interface(geometry)
    }
    fn material_count(&self) -> u32 {
        self.meshes.material_count()
    }
    fn material(&self, material: u32, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        self.meshes.material(material, binding)
    }
    fn object(&self, binding: &str) -> Option<wgpu::BindingResource<'_>> {
        self.meshes.object(binding)
    }
    fn revision(&self, _: &str) -> Option<u64> {
        Some(0)
    }
    fn draw(&self, pass: &mut dyn DrawPass) {
        (self.draw)(self.meshes, pass);
    }
}
