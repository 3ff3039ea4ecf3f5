//! The contract of materials as templates and pipelines state it, made of [`interface`](crate::interface).
//!
//! Shaders declare the blocks and textures of materials, and pipelines the geometry that draws bring. Both follow from
//! one list of Rust, whose structs are uploaded. The test below compares the files with that list, and writes them with
//! `UMBRAGRAPH_BLESS=1`: a factor, a texture or an attribute is one line in `interface.rs`.

use std::fmt::Write as _;
use std::path::Path;

use umbragraph_pipeline::data::ValueType;
use umbragraph_pipeline::wgpu_types::VertexFormat;
use umbragraph_test_support::environment::{BLESS, is_set, process};

use crate::interface::{
    ALPHA_MASKED, DETAILS, MAPS, MaterialBlock, MaterialDetailBlock, MotionBlock, ObjectBlock, PREVIOUS,
    STREAMS,
};

type Members = [(&'static str, ValueType, &'static str)];

const NOTE: &str =
    "Written by the tests of the crate umbragraph-scene (UMBRAGRAPH_BLESS=1) from scene/src/interface.rs.";

/// The WGSL type of a vertex attribute with this format.
fn attribute_type(format: VertexFormat) -> &'static str {
    match format {
        VertexFormat::Float32x2 => "vec2<f32>",
        VertexFormat::Float32x3 => "vec3<f32>",
        VertexFormat::Float32x4 => "vec4<f32>",
        other => panic!("an attribute in the format {other:?}"),
    }
}

/// The name that pipeline files use for a vertex format, such as `float32x3`.
fn attribute_format(format: VertexFormat) -> String {
    format!("{format:?}").to_lowercase()
}

fn structure(name: &str, members: &Members) -> String {
    let mut text = format!("struct {name} {{\n");
    for (member, value, doc) in members {
        writeln!(text, "    // {}\n    {member}: {value},", doc.trim()).expect("a text");
    }
    text + "}\n"
}

/// The WGSL declarations of a texture and a sampler for each map, with consecutive binding numbers that start at
/// `first`.
fn textures(maps: &[&str], first: usize) -> String {
    let of = |(at, map): (usize, &&str)| {
        let number = first + 2 * at;
        format!(
            "@group(2) @binding({number}) var {map}_texture: texture_2d<f32>;\n\
             @group(2) @binding({}) var {map}_sampler: sampler;\n",
            number + 1
        )
    };
    maps.iter().enumerate().map(of).collect()
}

/// The source of the shader template with the material block, the object block and the vertex attributes that materials
/// read.
fn blocks() -> String {
    let list = |attributes: &[(&str, VertexFormat)]| {
        let pairs: Vec<String> = (attributes.iter())
            .map(|(name, format)| format!("[\"{name}\", \"{}\"]", attribute_type(*format)))
            .collect();
        pairs.join(", ")
    };
    let plain: Vec<_> = STREAMS[2..].iter().map(|(name, format, _)| (*name, *format)).collect();
    let details: Vec<_> = DETAILS.iter().map(|(name, format, _)| (*name, *format)).collect();
    format!(
        "{{# Material and object of scenes, and the vertex attributes that materials read; more of them with `pbr`.\n   \
         {NOTE} #}}\n\
         {{% set attributes = [{}] %}}\n{{% if pbr %}}\n{{% set attributes = attributes + [{}] %}}\n{{% endif %}}\n\
         {}\n@group(2) @binding(0) var<uniform> material: Material;\n{}\n{}\n\
         {{% if instanced %}}\n@group(3) @binding(0) var<storage, read> objects: array<Object>;\n\
         {{% else %}}\n@group(3) @binding(0) var<uniform> object: Object;\n{{% endif %}}\n",
        list(&plain),
        list(&details),
        structure("Material", MaterialBlock::MEMBERS),
        textures(&MAPS[..1], 1),
        structure("Object", ObjectBlock::MEMBERS),
    )
}

/// The source of the shader template with the material block and the texture maps that only draws with the property
/// `pbr` use.
fn details() -> String {
    format!(
        "{{# The rest of a material of scenes, for draws with `pbr`.\n   {NOTE} #}}\n\
         {}\n@group(2) @binding(3) var<uniform> material_detail: MaterialDetail;\n{}",
        structure("MaterialDetail", MaterialDetailBlock::MEMBERS),
        textures(&MAPS[1..], 4),
    )
}

/// The source of the shader template with the motion block of objects, for passes that write motion vectors.
fn motion() -> String {
    format!(
        "{{# The motion of a placed mesh of scenes. {NOTE} #}}\n\
         {}\n{{% if instanced %}}\n@group(3) @binding(1) var<storage, read> motions: array<Motion>;\n\
         {{% else %}}\n@group(3) @binding(1) var<uniform> motion: Motion;\n{{% endif %}}\n",
        structure("Motion", MotionBlock::MEMBERS),
    )
}

/// The contents of the pipeline file that declares the vertex streams and bindings of scenes.
fn geometry() -> String {
    let members = |members: &Members| {
        let pairs: Vec<String> =
            members.iter().map(|(name, value, _)| format!("\"{name}\": \"{value}\"")).collect();
        pairs.join(", ")
    };
    let maps = |maps: &[&str]| -> String {
        let pair = |map: &&str| {
            format!("        \"{map}_texture\": \"texture_2d<f32>\", \"{map}_sampler\": \"sampler\",\n")
        };
        maps.iter().map(pair).collect()
    };
    let vertex: Vec<String> = (STREAMS.iter())
        .map(|(name, format, _)| (*name, *format))
        .chain(DETAILS.iter().map(|(name, format, _)| (*name, *format)))
        .chain([(PREVIOUS.0, PREVIOUS.1)])
        .map(|(name, format)| format!("\"{name}\": \"{}\"", attribute_format(format)))
        .collect();
    let last = maps(&MAPS[1..]);
    format!(
        "// The meshes of glTF scenes as pipelines declare them. Those with \"pbr\" have the streams and maps after the first.\n\
         // {NOTE}\n\
         {{\n  \"$schema\": \"../../pipeline.schema.json\",\n  \"format\": 1,\n  \"name\": \"scene_geometry\",\n\n  \
         \"geometry\": {{\n    \"scene\": {{\n      \"vertex\": {{ {} }},\n      \"material\": {{\n        \
         \"material\": {{ {} }},\n{}        \"material_detail\": {{ {} }},\n{}\n      }},\n      \
         \"object\": {{ \"object\": {{ {} }}, \"motion\": {{ {} }} }},\n      \"variants\": [\"{ALPHA_MASKED}\", \"double_sided\", \"pbr\"]\n    \
         }}\n  }},\n\n  \"passes\": {{}}\n}}\n",
        vertex.join(", "),
        members(MaterialBlock::MEMBERS),
        maps(&MAPS[..1]),
        members(MaterialDetailBlock::MEMBERS),
        last.trim_end_matches(",\n"),
        members(ObjectBlock::MEMBERS),
        members(MotionBlock::MEMBERS),
    )
}

/// Returns the contents of a file without white space, so that a comparison ignores formatting.
fn words(text: &str) -> String {
    text.split_whitespace().collect()
}

#[test]
fn templates_and_pipelines_state_the_contract() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for (file, text) in [
        ("shaders-templates/lib/scene_blocks.wgsl.jinja", blocks()),
        ("shaders-templates/lib/scene_details.wgsl.jinja", details()),
        ("shaders-templates/lib/scene_motion.wgsl.jinja", motion()),
        ("pipelines/base/scene_geometry.json", geometry()),
    ] {
        let found = std::fs::read_to_string(root.join(file)).unwrap_or_default();
        if words(&found) == words(&text) {
            continue;
        }
        assert!(
            is_set(&process, BLESS),
            "{file} is not that of scene/src/interface.rs: UMBRAGRAPH_BLESS=1 writes it"
        );
        std::fs::write(root.join(file), &text).expect("a file of the workspace");
    }
}
