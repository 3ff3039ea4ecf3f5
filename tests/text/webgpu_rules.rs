//! The rules of WebGPU that a plan can break: each with a document that just keeps it and, one text replaced, one that
//! does not.
//!
//! wgpu is the judge: what keeps a rule runs dry on its backend without a driver, and what breaks one is rejected by
//! `check` with a code of its own before wgpu is asked. Rules that no document reaches: labels and debug groups are
//! balanced by the executor; queries belong to measuring; bundles, external textures and mapped buffers are not used;
//! textures are not used after they are destroyed, but for imports, which `record` rejects. Limits of one shader
//! (workgroups, bindings of a stage, variables between stages) are tested with shaders.

use std::sync::Arc;

use crate::common::{Outcome, With, check_with};
use umbragraph::executor::DryRun;
use umbragraph::low_level::shader::TargetProfile;

const FILL: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@fragment fn fill(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(covered.uv, 0.0, 1.0); }
"#;

const SHOW: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var reader: sampler;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> { return textureSample(picture, reader, covered.uv); }
"#;

const CUBE: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(0) @binding(0) var picture: texture_cube<f32>;
@group(0) @binding(1) var reader: sampler;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    return textureSample(picture, reader, vec3<f32>(covered.uv, 1.0));
}
"#;

const DEPTH: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(0) @binding(0) var picture: texture_depth_2d;
@group(0) @binding(1) var reader: sampler;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(textureSample(picture, reader, covered.uv));
}
"#;

/// Four outputs.
const FOUR: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Out {
    @location(0) a: vec4<f32>, @location(1) b: vec4<f32>, @location(2) c: vec4<f32>, @location(3) d: vec4<f32>
}
@fragment fn fill(covered: Covered) -> Out {
    let one = vec4<f32>(covered.uv, 0.0, 1.0);
    return Out(one, one, one, one);
}
"#;

const WORDS: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(0) @binding(0) var<storage, read> words: array<u32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> { return vec4<f32>(f32(words[0])); }
"#;

const BLOCK: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Block { values: array<vec4<f32>, 16> }
@group(0) @binding(0) var<uniform> block: Block;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> { return block.values[3]; }
"#;

const VALUE: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Block { color: vec4<f32> }
@group(0) @binding(0) var<storage, read> block: Block;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> { return block.color; }
"#;

const COUNT: &str = r#"@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<storage, read_write> counts: array<u32>;
@compute @workgroup_size(64) fn count(@builtin(global_invocation_id) at: vec3<u32>) { counts[at.x] = words[at.x]; }
"#;

const IMAGE: &str = r#"@group(0) @binding(0) var image: texture_storage_2d<rgba8unorm, write>;
@compute @workgroup_size(8, 8) fn paint(@builtin(global_invocation_id) at: vec3<u32>) {
    textureStore(image, at.xy, vec4<f32>(1.0));
}
"#;

const POINTS: &str = r#"struct Vertex { @location(0) position: vec2<f32> }
@vertex fn place(vertex: Vertex) -> @builtin(position) vec4<f32> { return vec4<f32>(vertex.position, 0.0, 1.0); }
@fragment fn paint() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }
"#;

/// Words that the vertex stage reads.
const PULLED: &str = r#"@group(0) @binding(0) var<storage, read> words: array<u32>;
@vertex fn place(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(words[at]), 0.0, 0.0, 1.0);
}
@fragment fn paint() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }
"#;

const STENCIL: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(0) @binding(0) var marks: texture_2d<u32>;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    return vec4<f32>(textureLoad(marks, vec2<i32>(covered.position.xy), 0));
}
"#;

const CUBES: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@group(0) @binding(0) var picture: texture_cube_array<f32>;
@group(0) @binding(1) var reader: sampler;
@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {
    return textureSample(picture, reader, vec3<f32>(covered.uv, 1.0), 1);
}
"#;

/// One output of each kind of whole numbers.
const INTEGERS: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
struct Out { @location(0) a: vec4<u32>, @location(1) b: vec4<i32> }
@fragment fn fill(covered: Covered) -> Out { return Out(vec4(u32(covered.uv.x)), vec4(i32(covered.uv.y))); }
"#;

/// Two channels.
const PAIR: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
@fragment fn fill(covered: Covered) -> @location(0) vec2<f32> { return covered.uv; }
"#;

/// Texels that the vertex stage reads.
const FETCHED: &str = r#"@group(0) @binding(0) var words: texture_storage_2d<r32float, read>;
@vertex fn place(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32(textureDimensions(words).x + at), 0.0, 0.0, 1.0);
}
@fragment fn paint() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }
"#;

/// The common beginning of a rule's own template and document.
struct Ground {
    template: &'static str,
    resources: &'static str,
    passes: &'static str,
}

const TARGET: &str =
    r#""target": { "texture": { "format": "rgba8unorm", "size": [64, 64], "lifetime": "imported" } }"#;

/// A picture of the own template.
const PAINT: Ground = Ground {
    template: FILL,
    resources: r#""kept": { "texture": { "format": "rgba8unorm", "size": [64, 64], "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&target" }] } }"#,
};

/// A picture, painted and shown.
const SHOWN: Ground = Ground {
    template: SHOW,
    resources: r#""picture": { "texture": { "format": "rgba8unorm", "size": [64, 64] } }"#,
    passes: r#""paint": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&picture" }] } },
        "own": { "fullscreen": { "shader": "own.wgsl.jinja",
            "bind": { "picture": "&picture", "reader": { "sampler": { "filter": "linear" } } }, "color": [{ "to": "&target" }] } }"#,
};

/// A picture that is blended onto another.
const BLENDED: Ground = Ground {
    template: FILL,
    resources: r#""sum": { "texture": { "format": "rgba16float", "size": [64, 64], "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&sum", "blend": "add" }] } },
        "show": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }"#,
};

/// Four samples, painted and resolved.
const RESOLVED: Ground = Ground {
    template: FILL,
    resources: r#""samples": { "texture": { "format": "rgba8unorm", "size": [64, 64], "samples": 4 } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja",
        "color": [{ "to": "&samples", "clear": [0, 0, 0, 1], "resolve": { "to": "&target" } }] } }"#,
};

/// The same, resolved to a mip of a layer.
const RESOLVED_TO_PART: Ground = Ground {
    template: FILL,
    resources: r#""samples": { "texture": { "format": "rgba8unorm", "size": [64, 64], "samples": 4 } },
        "kept": { "texture": { "format": "rgba8unorm", "size": [128, 128], "mips": 2, "layers": 2, "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja",
            "color": [{ "to": "&samples", "clear": [0, 0, 0, 1], "resolve": { "to": "&kept", "mip": 1, "layer": 1 } }] } },
        "show": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }"#,
};

/// Words of a buffer that is counted into another.
const COUNTED: Ground = Ground {
    template: COUNT,
    resources: r#""words": { "buffer": { "size": 1024 } }, "counts": { "buffer": { "size": 1024 } }"#,
    passes: r#""no_words": { "clear": { "buffer": "&words" } }, "no_counts": { "clear": { "buffer": "&counts" } },
        "own": { "compute": { "shader": "own.wgsl.jinja", "bind": { "words": "&words", "counts": "&counts" }, "workgroups": [4, 1, 1] } },
        "show": { "fullscreen": { "shader": "words.wgsl.jinja", "bind": { "words": "&counts" }, "color": [{ "to": "&target" }] } }"#,
};

/// An image that a compute pass paints.
const IMAGED: Ground = Ground {
    template: IMAGE,
    resources: r#""image": { "texture": { "format": "rgba8unorm", "size": [64, 64] } }"#,
    passes: r#""own": { "compute": { "shader": "own.wgsl.jinja", "bind": { "image": "&image" }, "dispatch_over": "&image" } },
        "copy": { "copy": { "from": { "name": "&image" }, "to": { "name": "&target" } } }"#,
};

/// A buffer bound in part as a block.
const BLOCKS: Ground = Ground {
    template: BLOCK,
    resources: r#""bytes": { "buffer": { "size": 1024 } }"#,
    passes: r#""none": { "clear": { "buffer": "&bytes" } },
        "own": { "fullscreen": { "shader": "own.wgsl.jinja",
            "bind": { "block": { "buffer": { "name": "&bytes", "offset": 256, "size": 256 } } }, "color": [{ "to": "&target" }] } }"#,
};

/// Triangles of a buffer.
const DRAWN: Ground = Ground {
    template: POINTS,
    resources: r#""points": { "buffer": { "size": 48 } }, "indices": { "buffer": { "size": 16 } }"#,
    passes: r#""no_points": { "clear": { "buffer": "&points" } }, "no_indices": { "clear": { "buffer": "&indices" } },
        "own": { "mesh": { "shader": "own.wgsl.jinja", "count": 6,
            "vertices": [{ "buffer": "&points", "attributes": [{ "name": "position", "format": "float32x2" }] }],
            "color": [{ "to": "&target", "clear": [0, 0, 0, 1] }] } }"#,
};

/// The same in front of depth, with a bias.
const BIASED: Ground = Ground {
    template: POINTS,
    resources: r#""points": { "buffer": { "size": 48 } }, "depth": { "texture": { "format": "depth32float", "size": [64, 64] } }"#,
    passes: r#""no_points": { "clear": { "buffer": "&points" } },
        "own": { "mesh": { "shader": "own.wgsl.jinja", "count": 6, "topology": "triangle-strip",
            "vertices": [{ "buffer": "&points", "attributes": [{ "name": "position", "format": "float32x2" }] }],
            "color": [{ "to": "&target", "clear": [0, 0, 0, 1] }],
            "depth": { "to": "&depth", "clear": 1, "compare": "less", "write": true, "slope_bias": 1.5 } } }"#,
};

/// Vertices from storage.
const VERTEX_STORAGE: Ground = Ground {
    template: PULLED,
    resources: r#""words": { "buffer": { "size": 64 } }"#,
    passes: r#""no_words": { "clear": { "buffer": "&words" } },
        "own": { "mesh": { "shader": "own.wgsl.jinja", "count": 3, "bind": { "words": "&words" },
            "color": [{ "to": "&target", "clear": [0, 0, 0, 1] }] } }"#,
};

/// Depth, drawn with and without.
const DEPTHS: Ground = Ground {
    template: FILL,
    resources: r#""depth": { "texture": { "format": "depth32float", "size": [64, 64] } },
        "other": { "texture": { "format": "depth32float", "size": [64, 64], "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&target" }],
            "depth": { "to": "&depth", "clear": 1, "compare": "always", "write": true } } },
        "copy": { "copy": { "from": { "name": "&depth" }, "to": { "name": "&other" }, "extent": [64, 64] } }"#,
};

/// Stencil that a pass sees while it writes another depth.
const STENCILED: Ground = Ground {
    template: STENCIL,
    resources: r#""marks": { "texture": { "format": "depth24plus-stencil8", "size": [64, 64] } },
        "depth": { "texture": { "format": "depth32float", "size": [64, 64] } }"#,
    passes: r#""mark": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }],
            "depth": { "to": "&marks", "clear": 1, "compare": "always", "write": true },
            "stencil": { "to": "&marks", "clear": 0, "reference": 1, "front": { "pass": "replace" } } } },
        "own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&target" }],
            "bind": { "marks": { "texture": { "name": "&marks", "aspect": "stencil-only" } } },
            "depth": { "to": "&depth", "clear": 1, "compare": "always", "write": true } } }"#,
};

/// A copy of texels and one into rows of a buffer.
const COPIED: Ground = Ground {
    template: FILL,
    resources: r#""one": { "texture": { "format": "rgba8unorm", "size": [64, 64] } },
        "rows": { "buffer": { "size": "=64 * 256", "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&one" }] } },
        "across": { "copy": { "from": { "name": "&one" }, "to": { "name": "&target" } } },
        "down": { "copy": { "from": { "name": "&one" }, "to": { "name": "&rows" } } }"#,
};

/// A cube of the host's.
const CUBED: Ground = Ground {
    template: CUBE,
    resources: r#""sky": { "texture": { "format": "rgba8unorm", "size": [64, 64], "layers": 6, "view_dimension": "cube", "lifetime": "imported" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja",
        "bind": { "picture": "&sky", "reader": { "sampler": { "filter": "linear" } } }, "color": [{ "to": "&target" }] } }"#,
};

/// Two cubes, which are layers of one texture.
const CUBE_ARRAY: Ground = Ground {
    template: CUBES,
    resources: r#""sky": { "texture": { "format": "rgba8unorm", "size": [64, 64], "layers": 12, "lifetime": "imported" } }"#,
    passes: CUBED.passes,
};

/// Attachments of whole numbers.
const WHOLE_NUMBERS: Ground = Ground {
    template: INTEGERS,
    resources: r#""a": { "texture": { "format": "rgba8uint", "size": [64, 64], "lifetime": "persistent" } },
        "b": { "texture": { "format": "rgba8sint", "size": [64, 64], "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&a" }, { "to": "&b" }] } },
        "show": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }"#,
};

/// One channel, to which another is added.
const WITHOUT_ALPHA: Ground = Ground {
    template: PAIR,
    resources: BY_ALPHA.resources,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&sum", "blend": "add" }] } },
        "show": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }"#,
};

/// A storage texture that vertices are made of.
const VERTEX_TEXTURE: Ground = Ground {
    template: FETCHED,
    resources: r#""words": { "texture": { "format": "r32float", "size": [64, 64], "lifetime": "persistent" } }"#,
    passes: r#""no_words": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&words" }] } },
        "own": { "mesh": { "shader": "own.wgsl.jinja", "count": 3, "bind": { "words": "&words" },
            "color": [{ "to": "&target", "clear": [0, 0, 0, 1] }] } }"#,
};

/// A block of values.
const VALUES: Ground = Ground {
    template: VALUE,
    resources: PAINT.resources,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "bind": { "block": { "values": { "color": [1, 0, 0, 1] } } },
        "color": [{ "to": "&target" }] } }"#,
};

/// Four attachments of 32 bytes a texel together.
const WIDE: Ground = Ground {
    template: FOUR,
    resources: r#""a": { "texture": { "format": "rgba16float", "size": [64, 64], "lifetime": "persistent" } },
        "b": { "texture": { "format": "rgba16float", "size": [64, 64], "lifetime": "persistent" } },
        "c": { "texture": { "format": "rgba16float", "size": [64, 64], "lifetime": "persistent" } },
        "d": { "texture": { "format": "rgba16float", "size": [64, 64], "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja",
            "color": [{ "to": "&a" }, { "to": "&b" }, { "to": "&c" }, { "to": "&d" }] } },
        "show": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }"#,
};

/// One channel, blended by an alpha that only the shader has.
const BY_ALPHA: Ground = Ground {
    template: FILL,
    resources: r#""sum": { "texture": { "format": "r16float", "size": [64, 64], "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&sum", "blend": "alpha" }] } },
        "show": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target" }] } }"#,
};

/// Depth that goes to rows of a buffer.
const DEPTH_ROWS: Ground = Ground {
    template: FILL,
    resources: r#""depth": { "texture": { "format": "depth32float", "size": [64, 64] } },
        "rows": { "buffer": { "size": "=64 * 256", "lifetime": "persistent" } }"#,
    passes: r#""own": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&target" }],
            "depth": { "to": "&depth", "clear": 1, "compare": "always", "write": true } } },
        "down": { "copy": { "from": { "name": "&depth" }, "to": { "name": "&rows" } } }"#,
};

/// A rule of WebGPU, the code of what breaks it, and the texts to replace in the template or the document.
struct Rule(&'static str, &'static str, &'static Ground, &'static str, &'static str);

#[rustfmt::skip]
const RULES: &[Rule] = &[
    // Shader modules
    Rule("a module is valid", "UG0521", &PAINT, "vec4<f32>(covered.uv, 0.0, 1.0)", "vec4<f32>(covered.uv, 0, 1u)"),
    Rule("@group is below 4", "UG0409", &SHOWN, "@group(0) @binding(1)", "@group(4) @binding(1)"),
    Rule("@binding is below 1,000", "UG0409", &SHOWN, "@binding(1) var", "@binding(1000) var"),
    // Bind group layouts
    Rule("storage textures are read and written in few formats", "UG0409", &IMAGED, "rgba8unorm, write", "rgba8unorm, read_write"),
    Rule("bindings have one type", "UG0521", &SHOWN, "@binding(1) var", "@binding(0) var"),
    // Bind groups
    Rule("uniform offsets are aligned", "UG0409", &BLOCKS, "\"offset\": 256", "\"offset\": 128"),
    Rule("what is bound holds the block", "UG0409", &BLOCKS, "\"size\": 256", "\"size\": 128"),
    Rule("what is bound lies in its buffer", "UG0405", &BLOCKS, "\"offset\": 256", "\"offset\": 1024"),
    Rule("a uniform binding has at most 65,536 bytes", "UG0409", &BLOCKS, "vec4<f32>, 16>", "vec4<f32>, 4097>"),
    Rule("several samples are seen by multisampled bindings", "UG0409", &SHOWN, "\"size\": [64, 64] } }", "\"size\": [64, 64], \"samples\": 4 } }"),
    Rule("cubes have six layers", "UG0409", &SHOWN, SHOW, CUBE),
    Rule("integers are not sampled as floats", "UG0323", &SHOWN, "\"picture\": { \"texture\": { \"format\": \"rgba8unorm\"", "\"picture\": { \"texture\": { \"format\": \"rgba8uint\""),
    Rule("what is filtered can be filtered", "UG0323", &SHOWN, "\"picture\": { \"texture\": { \"format\": \"rgba8unorm\"", "\"picture\": { \"texture\": { \"format\": \"rgba32float\""),
    Rule("storage textures have their shader's format", "UG0323", &IMAGED, "\"image\": { \"texture\": { \"format\": \"rgba8unorm\"", "\"image\": { \"texture\": { \"format\": \"rgba16float\""),
    Rule("samplers that compare are bound to those that do", "UG0302", &SHOWN, "\"filter\": \"linear\"", "\"compare\": \"less\""),
    Rule("depth bindings see depth", "UG0323", &SHOWN, SHOW, DEPTH),
    Rule("storage offsets are aligned", "UG0409", &COUNTED, "\"counts\": \"&counts\" }", "\"counts\": { \"buffer\": { \"name\": \"&counts\", \"offset\": 128, \"size\": 256 } } }"),
    Rule("a storage binding has at most 128 MiB", "UG0409", &COUNTED, "\"counts\": { \"buffer\": { \"size\": 1024", "\"counts\": { \"buffer\": { \"size\": 134217732"),
    Rule("cubes are square", "UG0321", &CUBED, "\"size\": [64, 64], \"layers\": 6", "\"size\": [64, 32], \"layers\": 6"),
    Rule("several cubes have six layers each", "UG0409", &CUBE_ARRAY, "\"layers\": 12", "\"layers\": 13"),
    Rule("several cubes are square", "UG0409", &CUBE_ARRAY, "\"size\": [64, 64], \"layers\"", "\"size\": [64, 32], \"layers\""),
    Rule("shaders write no values of the host", "UG0409", &VALUES, "storage, read>", "storage, read_write>"),
    Rule("storage bindings have a multiple of 4 bytes", "UG0409", &COUNTED, "\"words\": \"&words\", \"counts\"", "\"words\": { \"buffer\": { \"name\": \"&words\", \"offset\": 0, \"size\": 254 } }, \"counts\""),
    Rule("buffers are bound where a shader has buffers", "UG0302", &COUNTED, "\"words\": \"&words\", \"counts\"", "\"words\": \"&target\", \"counts\""),
    // Samplers
    Rule("anisotropic samplers are linear", "UG0302", &SHOWN, "\"filter\": \"linear\"", "\"filter\": \"nearest\", \"max_anisotropy\": 4"),
    Rule("levels of detail are in order", "UG0108", &SHOWN, "\"filter\": \"linear\"", "\"filter\": \"linear\", \"lod_min_clamp\": 4, \"lod_max_clamp\": 1"),
    Rule("anisotropy is at most 16", "UG0108", &SHOWN, "\"filter\": \"linear\"", "\"filter\": \"linear\", \"max_anisotropy\": 17"),
    // Render pipelines
    Rule("a pipeline has a vertex stage", "UG0609", &PAINT, "{% include \"lib/fullscreen.wgsl.jinja\" %}", "struct Covered { @location(0) uv: vec2<f32> }"),
    Rule("a stage has one entry point", "UG0609", &PAINT, "@fragment fn fill", "@fragment fn another() -> @location(0) vec4<f32> { return vec4<f32>(); }\n@fragment fn fill"),
    Rule("every attachment is written", "UG0405", &PAINT, "\"color\": [{ \"to\": \"&target\" }]", "\"color\": [{ \"to\": \"&target\" }, { \"to\": \"&kept\" }]"),
    Rule("every output has an attachment", "UG0405", &PAINT, "@location(0) vec4", "@location(1) vec4"),
    Rule("outputs have the type of their attachment", "UG0405", &PAINT, "vec4<f32> { return vec4<f32>(covered.uv, 0.0, 1.0)", "vec4<u32> { return vec4<u32>(1u)"),
    Rule("outputs without a sign have their attachment's type", "UG0405", &WHOLE_NUMBERS, "\"rgba8uint\"", "\"rgba8sint\""),
    Rule("outputs with a sign have their attachment's type", "UG0405", &WHOLE_NUMBERS, "\"rgba8sint\"", "\"rgba8uint\""),
    Rule("outputs have the components of their attachment", "UG0405", &PAINT, "vec4<f32> { return vec4<f32>(covered.uv, 0.0, 1.0)", "vec3<f32> { return vec3<f32>(covered.uv, 0.0)"),
    Rule("frag_depth has a depth attachment", "UG0405", &PAINT, "@location(0) vec4<f32> { return vec4<f32>(covered.uv, 0.0, 1.0)", "Both { return Both(vec4<f32>(1.0), 0.5)"),
    Rule("the vertex stage writes no storage", "UG0521", &VERTEX_STORAGE, "storage, read>", "storage, read_write>"),
    Rule("the vertex stage writes no storage texture", "UG0521", &VERTEX_TEXTURE, "r32float, read>", "r32float, write>"),
    Rule("vertex attributes fit their stride", "UG0409", &DRAWN, "\"buffer\": \"&points\",", "\"buffer\": \"&points\", \"stride\": 4,"),
    Rule("vertex inputs have an attribute", "UG0603", &DRAWN, "\"name\": \"position\"", "\"name\": \"place\""),
    Rule("attributes have the type of their input", "UG0607", &DRAWN, "\"format\": \"float32x2\"", "\"format\": \"uint32x2\""),
    Rule("points and lines have no depth bias", "UG0409", &BIASED, "triangle-strip", "line-strip"),
    Rule("what is blended can be blended", "UG0323", &BLENDED, "\"format\": \"rgba16float\"", "\"format\": \"rgba32float\""),
    Rule("several samples have one mip level", "UG0409", &RESOLVED, "\"samples\": 4", "\"samples\": 4, \"mips\": 2"),
    Rule("the number of samples is 1 or 4", "UG0321", &RESOLVED, "\"samples\": 4", "\"samples\": 2"),
    Rule("textures are at most 8,192 texels wide", "UG0321", &SHOWN, "\"size\": [64, 64] } }", "\"size\": [8193, 64] } }"),
    Rule("textures have at most 256 layers", "UG0321", &SHOWN, "\"size\": [64, 64] } }", "\"size\": [64, 64], \"layers\": 257 } }"),
    Rule("mip levels end at one texel", "UG0321", &SHOWN, "\"size\": [64, 64] } }", "\"size\": [64, 64], \"mips\": 8 } }"),
    Rule("textures of several samples can be attached", "UG0323", &RESOLVED, "\"format\": \"rgba8unorm\", \"size\": [64, 64], \"samples\": 4", "\"format\": \"rg11b10ufloat\", \"size\": [64, 64], \"samples\": 4"),
    Rule("several samples have one layer", "UG0409", &RESOLVED, "\"samples\": 4", "\"samples\": 4, \"layers\": 2"),
    Rule("attachments can be rendered to", "UG0323", &SHOWN, "\"picture\": { \"texture\": { \"format\": \"rgba8unorm\"", "\"picture\": { \"texture\": { \"format\": \"rgb9e5ufloat\""),
    Rule("attachments have at most 32 bytes a texel", "UG0409", &WIDE, "\"d\": { \"texture\": { \"format\": \"rgba16float\"", "\"d\": { \"texture\": { \"format\": \"rgba32float\""),
    Rule("what is blended by alpha has an alpha", "UG0405", &BY_ALPHA, "vec4<f32> { return vec4<f32>(covered.uv, 0.0, 1.0)", "vec2<f32> { return covered.uv"),
    Rule("blending by alpha needs an output with alpha", "UG0405", &WITHOUT_ALPHA, "\"blend\": \"add\"", "\"blend\": \"alpha\""),
    Rule("the least and the greatest have factors of one", "UG0405", &BLENDED, "\"blend\": \"add\"", "\"blend\": { \"color\": { \"operation\": \"min\", \"src_factor\": \"src-alpha\", \"dst_factor\": \"one\" } }"),
    Rule("strides are multiples of 4", "UG0409", &DRAWN, "\"count\": 6,\n            \"vertices\": [{", "\"count\": 1, \"vertices\": [{ \"stride\": 10,"),
    Rule("strides are at most 2,048", "UG0409", &DRAWN, "\"count\": 6,\n            \"vertices\": [{", "\"count\": 1, \"vertices\": [{ \"stride\": 2052,"),
    Rule("depth is of a format with depth", "UG0323", &DEPTHS, "\"depth\": { \"texture\": { \"format\": \"depth32float\"", "\"depth\": { \"texture\": { \"format\": \"r32float\""),
    Rule("stencil is of a format with stencil", "UG0323", &DEPTHS, "\"write\": true }", "\"write\": true }, \"stencil\": { \"to\": \"&depth\", \"clear\": 0 }"),
    // Buffers
    Rule("buffers have at most 256 MiB", "UG0321", &COUNTED, "\"counts\": { \"buffer\": { \"size\": 1024", "\"counts\": { \"buffer\": { \"size\": 268435460"),
    // Passes
    Rule("attachments have one size", "UG0405", &DEPTHS, "\"depth\": { \"texture\": { \"format\": \"depth32float\", \"size\": [64, 64]", "\"depth\": { \"texture\": { \"format\": \"depth32float\", \"size\": [32, 64]"),
    Rule("attachments have one number of samples", "UG0405", &DEPTHS, "\"depth\": { \"texture\": { \"format\": \"depth32float\",", "\"depth\": { \"texture\": { \"format\": \"depth32float\", \"samples\": 4,"),
    Rule("an attachment is a layer", "UG0409", &SHOWN, "\"size\": [64, 64] } }", "\"size\": [64, 64], \"layers\": 2 } }"),
    Rule("volumes are not attached", "UG0409", &SHOWN, "\"size\": [64, 64] } }", "\"size\": [64, 64], \"view_dimension\": \"3d\" } }"),
    Rule("a pass does not sample what it draws to", "UG0404", &SHOWN, "\"picture\": \"&picture\"", "\"picture\": \"&target\""),
    Rule("a pass sees no stencil beside depth that it writes", "UG0404", &STENCILED, "\"to\": \"&depth\", \"clear\": 1,", "\"to\": \"&marks\","),
    Rule("a usage scope reads no buffer that it writes", "UG0404", &COUNTED, "\"words\": \"&words\", \"counts\": \"&counts\"", "\"words\": { \"buffer\": { \"name\": \"&words\", \"offset\": 0, \"size\": 256 } }, \"counts\": { \"buffer\": { \"name\": \"&words\", \"offset\": 256, \"size\": 256 } }"),
    Rule("resolving changes no format", "UG0409", &RESOLVED, "\"samples\": { \"texture\": { \"format\": \"rgba8unorm\"", "\"samples\": { \"texture\": { \"format\": \"bgra8unorm\""),
    Rule("resolving begins with several samples", "UG0409", &RESOLVED, ", \"samples\": 4", ""),
    Rule("resolving ends with one sample", "UG0409", &RESOLVED, "\"lifetime\": \"imported\"", "\"samples\": 4, \"lifetime\": \"imported\""),
    Rule("a layer is resolved to", "UG0409", &RESOLVED_TO_PART, ", \"layer\": 1", ""),
    Rule("resolving changes no size", "UG0409", &RESOLVED_TO_PART, "\"mip\": 1, ", ""),
    Rule("attachments are others", "UG0404", &WIDE, "{ \"to\": \"&d\" }", "{ \"to\": \"&c\" }"),
    Rule("depth is cleared to 0 to 1", "UG0108", &DEPTHS, "\"clear\": 1,", "\"clear\": 2,"),
    // Copies
    Rule("copies change no format", "UG0409", &COPIED, "\"one\": { \"texture\": { \"format\": \"rgba8unorm\"", "\"one\": { \"texture\": { \"format\": \"r32float\""),
    Rule("copies stay within", "UG0409", &COPIED, "\"from\": { \"name\": \"&one\" }, \"to\": { \"name\": \"&target\" }", "\"from\": { \"name\": \"&one\", \"origin\": [1, 0] }, \"to\": { \"name\": \"&target\" }, \"extent\": [64, 64]"),
    Rule("rows of a copy fit the buffer", "UG0409", &COPIED, "\"size\": \"=64 * 256\"", "\"size\": \"=63 * 256\""),
    Rule("depth is copied whole", "UG0409", &DEPTHS, "\"extent\": [64, 64]", "\"extent\": [32, 32]"),
    Rule("no texture is copied onto itself", "UG0404", &COPIED, "\"to\": { \"name\": \"&target\" }", "\"to\": { \"name\": \"&one\" }"),
    Rule("copies keep the number of samples", "UG0409", &COPIED, "\"one\": { \"texture\": { \"format\": \"rgba8unorm\",", "\"one\": { \"texture\": { \"format\": \"rgba8unorm\", \"samples\": 4,"),
    Rule("copied bytes begin with a texel", "UG0409", &COPIED, "\"to\": { \"name\": \"&rows\" }", "\"to\": { \"name\": \"&rows\", \"offset\": 2, \"size\": 8192 }, \"extent\": [64, 16]"),
    Rule("depth24plus is copied to no buffer", "UG0409", &DEPTH_ROWS, "depth32float", "depth24plus"),
    Rule("cleared bytes are multiples of 4", "UG0409", &COUNTED, "\"no_words\": { \"clear\": { \"buffer\": \"&words\"", "\"no_words\": { \"clear\": { \"buffer\": \"&words\", \"offset\": 2, \"size\": 4"),
    // Dispatches and draws
    Rule("at most 65,535 workgroups are dispatched each way", "UG0406", &COUNTED, "[4, 1, 1]", "[65536, 1, 1]"),
    Rule("vertex buffers hold what is drawn", "UG0409", &DRAWN, "\"count\": 6", "\"count\": 7"),
    Rule("index buffers hold what is drawn", "UG0409", &DRAWN, "\"count\": 6", "\"count\": 6, \"indices\": { \"buffer\": \"&indices\", \"format\": \"uint32\" }"),
    Rule("indirect offsets are multiples of 4", "UG0409", &COUNTED, "\"workgroups\": [4, 1, 1]", "\"indirect\": { \"buffer\": \"&words\", \"offset\": 2 }"),
    Rule("indirect words lie in their buffer", "UG0405", &COUNTED, "\"workgroups\": [4, 1, 1]", "\"indirect\": { \"buffer\": \"&words\", \"offset\": 1016 }"),
];

fn check(ground: &Ground, from: &str, to: &str) -> Outcome {
    let template = ground.template.replacen(from, to, 1)
        + "\nstruct Both { @location(0) color: vec4<f32>, @builtin(frag_depth) depth: f32 }";
    let body =
        format!(r#""resources": {{ {TARGET}, {} }}, "passes": {{ {} }}"#, ground.resources, ground.passes);
    let text = format!(r#"{{ "format": 1, "name": "rule", {} }}"#, body.replacen(from, to, 1));
    let templates = [("own.wgsl.jinja", template.as_str()), ("words.wgsl.jinja", WORDS)];
    check_with("rule.json", &text, &With { templates: &templates, ..With::default() })
}

#[test]
fn what_breaks_a_rule_of_webgpu_has_a_code() {
    let mut wrong = Vec::new();
    for Rule(rule, code, ground, from, to) in RULES {
        let outcome = check(ground, from, to);
        if !outcome.codes().iter().any(|found| found == code) {
            wrong.push(format!("{rule}: {code} expected\n{}", outcome.text()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn what_breaks_a_rule_is_named_with_a_way_out() {
    let samples = "\"one\": { \"texture\": { \"format\": \"rgba8unorm\",";
    let with_samples = format!("{samples} \"samples\": 4,");
    for (ground, from, to, said) in [
        (&SHOWN, SHOW, CUBE, "\"picture\" is 64 by 64 with 1 layer, \"picture\" is texture_cube<f32>"),
        (
            &IMAGED,
            "rgba8unorm, write",
            "rgba8unorm, read_write",
            "read and write r32float, r32sint or r32uint",
        ),
        (&COPIED, samples, &with_samples, "several samples have no bytes: resolve them first"),
    ] {
        let text = check(ground, from, to).text();
        assert!(text.contains(said), "{text}");
    }
}

#[test]
fn what_keeps_the_rules_of_webgpu_runs_dry() {
    let mut dry_run = pollster::block_on(DryRun::new(&TargetProfile::webgpu())).expect("a device");
    for Rule(rule, _, ground, ..) in RULES {
        let outcome = check(ground, "\u{0}", "");
        assert_eq!(outcome.text(), "", "{rule}");
        let said = pollster::block_on(dry_run.run(&Arc::new(outcome.plan().clone())));
        assert!(!said.has_errors(), "{rule}: {said:?}");
    }
}
