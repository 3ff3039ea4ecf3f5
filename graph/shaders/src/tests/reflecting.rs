//! Reflection of modules.

use wgpu_types::{
    BindingType, BufferBindingType, SamplerBindingType, ShaderStages, StorageTextureAccess, TextureFormat,
    TextureSampleType, TextureViewDimension, VertexFormat,
};

use super::Fixture;
use crate::{ScalarKind, Stage, TypeLayout};

const TEXT: &str = "
struct Cascade { matrix: mat4x4<f32>, far: f32, bias: vec2<f32> }
struct Frame { view: mat4x4<f32>, sun: vec3<f32>, count: u32, cascades: array<Cascade, 4> }
struct Item { position: vec3<f32>, id: u32 }
struct List { head: vec4<f32>, items: array<Item> }
@group(0) @binding(0) var<uniform> frame: Frame;
@group(1) @binding(7) var shadow_map: texture_depth_2d_array;
@group(1) @binding(3) var shadow_sampler: sampler_comparison;
@group(1) @binding(0) var albedo: texture_2d<f32>;
@group(1) @binding(1) var albedo_sampler: sampler;
@group(1) @binding(2) var noise: texture_2d<f32>;
@group(1) @binding(4) var samples: texture_multisampled_2d<f32>;
@group(1) @binding(5) var never: texture_3d<u32>;
@group(2) @binding(0) var<storage, read> list: List;
@group(2) @binding(1) var<storage, read_write> counters: array<atomic<u32>>;
@group(2) @binding(2) var output: texture_storage_2d<rgba16float, write>;
struct Vertex { @location(2) normal: vec3<f32>, @location(0) position: vec3<f32>, @builtin(vertex_index) index: u32 }
struct Varying { @builtin(position) position: vec4<f32>, @location(0) uv: vec2<f32> }
var<workgroup> shared_values: array<u32, 5>;
@vertex fn vertex(vertex: Vertex, @location(4) joints: vec4<u32>) -> Varying {
    return Varying(frame.view * vec4<f32>(vertex.position + vertex.normal, f32(joints.x)), vec2<f32>());
}
fn helper(t: texture_2d<f32>, s: sampler, uv: vec2<f32>) -> vec4<f32> { return textureSampleLevel(t, s, uv, 0.0); }
@fragment fn fragment(in: Varying) -> @location(0) vec4<f32> {
    let lit = textureSampleCompareLevel(shadow_map, shadow_sampler, in.uv, 0, 0.5);
    return helper(albedo, albedo_sampler, in.uv) * lit + textureLoad(noise, vec2<i32>(), 0)
        + textureLoad(samples, vec2<i32>(), 0) + frame.sun.xyzz;
}
@compute @workgroup_size(8, 4) fn compute() {
    shared_values[0] = list.items[0].id;
    atomicAdd(&counters[0], shared_values[0]);
    textureStore(output, vec2<i32>(), vec4<f32>());
}
";

#[test]
fn layout_entries_say_what_the_stages_use() {
    let fixture = Fixture::sound(&[("main.wgsl.jinja", TEXT)]);
    let reflection = fixture.compile("main.wgsl.jinja", &[]).reflection;
    let entry = |name: &str| reflection.binding(name).unwrap().entry;
    let order: Vec<_> = reflection.bindings.iter().map(|binding| (binding.group, binding.binding)).collect();
    assert!(order.is_sorted(), "{order:?}");
    assert_eq!(entry("frame").visibility, ShaderStages::VERTEX_FRAGMENT);
    assert_eq!(entry("list").visibility, ShaderStages::COMPUTE);
    assert_eq!(reflection.unused.iter().map(|binding| binding.name.as_str()).collect::<Vec<_>>(), ["never"]);
    let float = |filterable| BindingType::Texture {
        sample_type: TextureSampleType::Float { filterable },
        view_dimension: TextureViewDimension::D2,
        multisampled: false,
    };
    assert_eq!(entry("albedo").ty, float(true));
    assert_eq!(entry("noise").ty, float(false), "only loaded from");
    assert_eq!(
        entry("samples").ty,
        BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: false },
            view_dimension: TextureViewDimension::D2,
            multisampled: true
        }
    );
    assert_eq!(
        entry("shadow_map").ty,
        BindingType::Texture {
            sample_type: TextureSampleType::Depth,
            view_dimension: TextureViewDimension::D2Array,
            multisampled: false
        }
    );
    assert_eq!(entry("shadow_sampler").ty, BindingType::Sampler(SamplerBindingType::Comparison));
    assert_eq!(entry("albedo_sampler").ty, BindingType::Sampler(SamplerBindingType::Filtering));
    assert_eq!(
        entry("output").ty,
        BindingType::StorageTexture {
            access: StorageTextureAccess::WriteOnly,
            format: TextureFormat::Rgba16Float,
            view_dimension: TextureViewDimension::D2
        }
    );
    let buffer = |name: &str| match entry(name).ty {
        BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size } => {
            (ty, min_binding_size.map_or(0, std::num::NonZero::get))
        }
        other => panic!("{other:?}"),
    };
    assert_eq!(buffer("frame"), (BufferBindingType::Uniform, 400));
    assert_eq!(buffer("list"), (BufferBindingType::Storage { read_only: true }, 32));
    assert_eq!(buffer("counters"), (BufferBindingType::Storage { read_only: false }, 4));
    assert_eq!(reflection.binding("shadow_map").unwrap().type_name, "texture_depth_2d_array");
}

#[test]
fn blocks_have_the_offsets_of_wgsl() {
    let fixture = Fixture::sound(&[("main.wgsl.jinja", TEXT)]);
    let reflection = fixture.compile("main.wgsl.jinja", &[]).reflection;
    let block = reflection.binding("frame").unwrap().block.clone().unwrap();
    assert_eq!((block.size(), block.align(), block.spelling()), (400, 16, "Frame".to_owned()));
    let TypeLayout::Struct { members, .. } = &block else { panic!("{block:?}") };
    let found: Vec<_> =
        members.iter().map(|each| (each.name.as_str(), each.offset, each.layout.spelling())).collect();
    assert_eq!(
        found,
        [
            ("view", 0, "mat4x4<f32>".to_owned()),
            ("sun", 64, "vec3<f32>".to_owned()),
            ("count", 76, "u32".to_owned()),
            ("cascades", 80, "array<Cascade, 4>".to_owned()),
        ]
    );
    let TypeLayout::Array { element, count: Some(4), stride: 80 } = &members[3].layout else { panic!() };
    let TypeLayout::Struct { members, .. } = &**element else { panic!() };
    assert_eq!(members[2].offset, 72);
}

#[test]
fn entry_points_list_inputs_outputs_and_bindings() {
    let fixture = Fixture::sound(&[("main.wgsl.jinja", TEXT)]);
    let reflection = fixture.compile("main.wgsl.jinja", &[]).reflection;
    let vertex =
        reflection.entry_points.iter().find(|entry_point| entry_point.stage == Stage::Vertex).unwrap();
    let inputs: Vec<_> =
        vertex.inputs.iter().map(|input| (input.name.as_str(), input.location, input.format)).collect();
    assert_eq!(
        inputs,
        [
            ("position", 0, VertexFormat::Float32x3),
            ("normal", 2, VertexFormat::Float32x3),
            ("joints", 4, VertexFormat::Uint32x4)
        ]
    );
    assert_eq!(
        (vertex.bindings.as_slice(), vertex.varyings.as_slice()),
        ([(0, 0)].as_slice(), [0].as_slice())
    );
    let fragment = reflection.entry_point("fragment").unwrap();
    assert_eq!(fragment.outputs[0].kind, ScalarKind::Float);
    assert_eq!((fragment.outputs[0].location, fragment.outputs[0].components), (0, 4));
    assert_eq!(fragment.sampling_pairs, [((1, 0), (1, 1)), ((1, 7), (1, 3))]);
    let compute = reflection.entry_point("compute").unwrap();
    assert_eq!((compute.workgroup_size, compute.workgroup_storage), ([8, 4, 1], 32));
    assert_eq!(compute.bindings, [(2, 0), (2, 1), (2, 2)]);
}
