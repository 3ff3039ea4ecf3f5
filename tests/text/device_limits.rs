//! Limits of WebGPU that no shader exceeds on its own: what variants bind together, what a pass writes at once.

use crate::common::{Outcome, With, check_with};

const TARGETS: &str = r#""size": [64, 64], "lifetime": "imported" } }"#;

fn check(text: &str, template: &str, axes: &str) -> Outcome {
    let templates = [("own.wgsl.jinja", template), ("own.axes.json", axes)];
    check_with("test.json", text, &With { templates: &templates, ..With::default() })
}

/// A full-screen pass over attachments of these formats.
fn attachments(formats: &[&str]) -> Outcome {
    let each = |one: &dyn Fn(usize) -> String| (0..formats.len()).map(one).collect::<Vec<_>>().join(", ");
    let resources =
        each(&|at| format!(r#""c{at}": {{ "texture": {{ "format": "{}", {TARGETS}"#, formats[at]));
    let color = each(&|at| format!(r#"{{ "to": "&c{at}", "clear": [0, 0, 0, 0] }}"#));
    let text = format!(
        r#"{{ "format": 1, "name": "test", "resources": {{ {resources} }},
             "passes": {{ "fill": {{ "fullscreen": {{ "shader": "own.wgsl.jinja", "color": [{color}] }} }} }} }}"#
    );
    let members: String =
        (0..formats.len()).map(|at| format!("@location({at}) c{at}: vec4<f32>,\n")).collect();
    let template = format!(
        "@vertex fn corner() -> @builtin(position) vec4<f32> {{ return vec4<f32>(); }}
         struct Colors {{ {members} }}
         @fragment fn paint() -> Colors {{ var colors: Colors; return colors; }}"
    );
    check(&text, &template, r#"{ "axes": {} }"#)
}

#[test]
fn color_attachments_stay_within_the_bytes_of_a_sample() {
    assert_eq!(attachments(&["rgba16float", "rgba16float", "rgba16float", "rgba16float"]).text(), "");
    // 8-bit formats of four components cost eight bytes each, and each format is aligned to its components.
    assert_eq!(attachments(&["r8unorm", "rgba16float", "rgba16float", "rgba8unorm"]).text(), "");
    let outcome = attachments(&["r8unorm", "rgba16float", "rgba16float", "rgba16float", "rgba16float"]);
    assert_eq!(outcome.codes(), ["UG0409"]);
    let text = outcome.text();
    assert!(text.contains("\"fill\" have 34 bytes for each sample, but only 32 are guaranteed"), "{text}");
}

/// A draw of meshes of two kinds, whose variants bind as many textures each, `shared` of them the same.
fn variants(each: usize, shared: usize) -> Outcome {
    let names: Vec<String> =
        (0..each).map(|at| format!("a{at}")).chain((shared..each).map(|at| format!("b{at}"))).collect();
    let bind: Vec<String> = names.iter().map(|name| format!(r#""{name}": "&image""#)).collect();
    let text = format!(
        r#"{{ "format": 1, "name": "test",
             "geometry": {{ "scene": {{ "vertex": {{ "position": "float32x3" }}, "material": {{}}, "object": {{}}, "variants": ["alpha_masked"] }} }},
             "resources": {{ "image": {{ "texture": {{ "format": "rgba8unorm", {TARGETS}, "out": {{ "texture": {{ "format": "rgba8unorm", {TARGETS} }},
             "passes": {{ "eye": {{ "camera": {{ "to": "&eye" }} }},
               "draw": {{ "draw": {{ "geometry": "scene", "mesh_filter": "opaque", "views": "&eye", "shader": "own.wgsl.jinja",
                 "bind": {{ {} }}, "color": [{{ "to": "&out", "clear": [0, 0, 0, 0] }}] }} }} }} }}"#,
        bind.join(", ")
    );
    let declared = |prefix: &str, range: std::ops::Range<usize>, first: usize| -> String {
        let one =
            |at: usize| format!("@group(1) @binding({}) var {prefix}{at}: texture_2d<f32>;\n", first + at);
        range.map(one).collect()
    };
    let sum = |prefix: &str, range: std::ops::Range<usize>| -> String {
        range.map(|at| format!(" + textureLoad({prefix}{at}, vec2<i32>(), 0)")).collect()
    };
    let template = format!(
        "@vertex fn place(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> {{ return vec4<f32>(position, 1.0); }}
         {common}{{% if alpha_masked %}}{masked}{{% else %}}{opaque}{{% endif %}}
         @fragment fn shade() -> @location(0) vec4<f32> {{
           return vec4<f32>(){common_sum}{{% if alpha_masked %}}{masked_sum}{{% else %}}{opaque_sum}{{% endif %}}; }}",
        common = declared("a", 0..shared, 0),
        opaque = declared("a", shared..each, 0),
        masked = declared("b", shared..each, each),
        common_sum = sum("a", 0..shared),
        opaque_sum = sum("a", shared..each),
        masked_sum = sum("b", shared..each),
    );
    let axes = r#"{ "axes": { "alpha_masked": { "type": "bool", "default": false } } }"#;
    check(&text, &template, axes)
}

#[test]
fn variants_of_one_layout_share_the_limits_of_a_stage() {
    assert_eq!(variants(16, 16).text(), "");
    assert_eq!(variants(10, 4).text(), "");
    let outcome = variants(10, 3);
    assert_eq!(outcome.codes(), ["UG0409"]);
    let text = outcome.text();
    assert!(
        text.contains("together bind 17 sampled textures, but only 16 are guaranteed in a stage"),
        "{text}"
    );
}
