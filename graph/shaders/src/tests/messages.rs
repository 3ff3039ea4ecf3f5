//! Mistakes of authors in templates and WGSL, each with the marked text and the words of its diagnostic.

use super::Fixture;
use umbragraph_text::diagnostic::{Diagnostic, Place};

/// The only errors of a template set whose template `main.wgsl.jinja` is compiled.
fn errors(fixture: &Fixture) -> Vec<Diagnostic> {
    if !fixture.diagnostics.is_empty() {
        return fixture.diagnostics.iter().cloned().collect();
    }
    let profile = crate::TargetProfile::webgpu();
    let compiled = crate::compile(&fixture.set, "main.wgsl.jinja", &super::values(&[]), &profile);
    match compiled {
        Ok(module) => panic!("compiles:\n{}", module.wgsl),
        Err(diagnostics) => diagnostics,
    }
}

/// Asserts that a template set has one error, with this code, marked text, and parts of its message and help.
fn assert_said(files: &[(&str, &str)], code: &str, marked: &str, message: &str, help: &str) {
    let fixture = Fixture::new(files);
    let errors = errors(&fixture);
    let said = format!("{errors:#?}");
    assert_eq!(errors.len(), 1, "{files:?}\n{said}");
    let Place::Span(span) = &errors[0].place else { panic!("{said}") };
    assert_eq!(errors[0].code.id, code, "{files:?}\n{said}");
    assert_eq!(fixture.sources.text(*span), marked, "{files:?}\n{said}");
    assert!(errors[0].message.contains(message), "{message}\n{said}");
    let found = errors[0].help.as_deref().unwrap_or_default();
    assert!(found.contains(help), "{help}\n{said}");
}

/// Declarations that the texts below share.
const DECLARED: &str = "
struct Covered { @builtin(position) position: vec4<f32>, @location(0) uv: vec2<f32> }
@group(1) @binding(0) var image: texture_2d<f32>;
@group(1) @binding(1) var image_sampler: sampler;
@group(1) @binding(2) var<storage, read> bins: array<u32, 64>;
@group(1) @binding(3) var<storage, read_write> counts: array<atomic<u32>, 64>;
@group(1) @binding(4) var result: texture_storage_2d<rgba16float, write>;
@group(1) @binding(5) var<uniform> view: mat4x4<f32>;
fn helper(color: vec3<f32>, scale: f32) -> vec3<f32> { return color * scale; }
";

/// A statement of a fragment shader, the marked text, and parts of message and help.
#[rustfmt::skip]
const STATEMENTS: &[(&str, &str, &str, &str, &str)] = &[
    // Types
    ("let q = view * at.xyz;", "UG0521", "view * at.xyz", "WGSL has no `mat4x4<f32> * vec3<f32>`", "vec4<f32>(v, 1.0) for a point"),
    ("let q = at.xyz * view;", "UG0521", "at.xyz * view", "`vec3<f32> * mat4x4<f32>`", "vec4<f32>(v, 1.0) for a point"),
    ("let q = at.xyz * bins[0];", "UG0521", "at.xyz * bins[0]", "`vec3<f32> * u32`", "write `f32(…)` around the u32"),
    ("let q = bins[0] + at.x;", "UG0521", "bins[0] + at.x", "`u32 + f32`", "write `f32(…)` around the u32"),
    ("let q = vec2<u32>(at.xy) * at.xy;", "UG0521", "vec2<u32>(at.xy) * at.xy", "`vec2<u32> * vec2<f32>`", "`vec2<f32>(…)` around the vec2<u32>"),
    ("let q = bins[0] < i32(at.x);", "UG0521", "bins[0] < i32(at.x)", "`u32 < i32`", "write `u32(…)` around the i32"),
    ("let q = bins[at.x];", "UG0521", "at.x", "an index is i32 or u32, and this is f32", "`u32(…)`"),
    ("if bins[0] { return vec4<f32>(); }", "UG0521", "bins[0]", "is a bool, and this is u32", "`!= 0u`"),
    ("bins[0] = 1u;", "UG0521", "bins[0]", "\"bins\" is written here, but it is var<storage, read>", "read_write"),
    ("view[0] = at;", "UG0521", "view[0]", "var<uniform>, which shaders only read", "change the copy"),
    ("let q = textureLoad(result, vec2<u32>(at.xy));", "UG0521", "textureLoad", "the storage texture \"result\", which is declared for `write`", "r32float"),
    // Names of other languages
    ("let q = texture(image, at.xy);", "UG0520", "texture", "`texture`", "textureSample(texture, sampler, coordinates)"),
    ("let q: float3 = at.xyz;", "UG0520", "float3", "`float3`", "use vec3<f32>"),
    ("let q = lerp(at.x, at.y, 0.5);", "UG0520", "lerp", "`lerp`", "use mix"),
    ("let q = smothstep(0.0, 1.0, at.x);", "UG0520", "smothstep", "`smothstep`", "did you mean \"smoothstep\"?"),
    ("let q = helpr(at.xyz, 1.0);", "UG0520", "helpr", "`helpr`", "did you mean \"helper\"?"),
    ("let q = at.x > 0.5 ? 1.0 : 0.0;", "UG0520", ";", "found \"?\"", "select(if_false, if_true, condition)"),
    ("int i = 0;", "UG0520", "int i", "the type stands behind the name", "`var i: i32 = …`"),
    ("for (int i = 0; i < 4; i++) {}", "UG0520", "int i", "the type stands behind the name", "`var i: i32 = …`"),
    // Calls
    ("let q = mix(at.x, at.y);", "UG0520", "mix", "`mix` takes 3 arguments here, not 2", "mix(a, b, t)"),
    ("let q = textureLoad(image, vec2<u32>(at.xy));", "UG0520", "textureLoad", "takes 3 arguments here, not 2", "textureLoad(texture, coordinates, level)"),
    ("let q = counts[0] + 1u;", "UG0520", "counts[0]", "by the atomic functions alone", "atomicLoad(&counts[0])"),
    ("counts[2] += 1u;", "UG0520", "counts[2]", "by the atomic functions alone", "write atomicAdd(&counts[2], 1u)"),
    // Members
    ("let q = covered.uvs;", "UG0520", "uvs", "\"Covered\" has no member \"uvs\"", "did you mean \"uv\"?"),
    ("let q = covered.normal;", "UG0520", "normal", "\"Covered\" has no member \"normal\"", "its members are position, uv"),
    ("let q = at.x * (1 / 0);", "UG0520", "1 / 0", "Division by zero", ""),
];

#[test]
fn a_wrong_statement_is_explained() {
    for (statement, code, marked, message, help) in STATEMENTS {
        let text = format!(
            "{DECLARED}@fragment fn show(covered: Covered) -> @location(0) vec4<f32> {{
    let at = covered.position;
    {statement}
    return helper(at.xyz, 1.0).xyzz;
}}
"
        );
        // The missing sign is noticed behind the code.
        let marked = if *marked == ";" { "?" } else { marked };
        assert_said(&[("main.wgsl.jinja", &text)], code, marked, message, help);
    }
}

/// Whole declarations, the marked text, and parts of message and help.
#[rustfmt::skip]
const DECLARATIONS: &[(&str, &str, &str, &str, &str)] = &[
    ("fn grade(color: vec3<f32>) -> vec3<f32> {\n    if color.r > 1.0 { return color; }\n}", "UG0521",
        "fn grade(color: vec3<f32>) -> vec3<f32> {\n    if color.r > 1.0 { return color; }\n}",
        "\"grade\" returns vec3<f32>, but a way through it ends without", "write a `return` of vec3<f32> at the end"),
    ("fn grade(color: vec3<f32>) -> f32 { return color; }", "UG0521", "color",
        "this is vec3<f32>, but \"grade\" is declared to return f32", "change one"),
    ("fn show() -> @location(0) vec4<f32> { return vec4<f32>(); }", "UG0521",
        "fn show() -> @location(0) vec4<f32> { return vec4<f32>(); }",
        "\"show\" has @location or @builtin", "write @fragment (or @vertex) before `fn show`"),
    ("struct Bins { items: array<u32>, count: u32 }\n@group(0) @binding(0) var<storage, read> bins: Bins;", "UG0521",
        "struct Bins { items: array<u32>, count: u32 }",
        "\"items\" is an array without a length, and not the last member", "array<u32, N>"),
    ("struct Settings { tint: array<f32, 4> }\n@group(0) @binding(0) var<uniform> settings: Settings;", "UG0521",
        "var<uniform> settings: Settings;",
        "the elements of array<f32, 4> are 4 bytes apart in \"tint\" of the uniform \"settings\"", "vec4<f32>"),
    ("let SCALE = 2.0;", "UG0520", "let", "found \"let\"", "`const NAME = VALUE;`"),
    ("#define SCALE 2.0", "UG0520", "#", "found \"#\"", "no preprocessor"),
    ("float grade(float x) { return x; }", "UG0520", "float", "found \"float\"", "`fn name(x: f32) -> f32 { … }`"),
    ("fn grade(x: f32) -> f32 { return grade(x); }", "UG0520", "grade", "is recursive", "use a loop"),
    ("@group(2) @binding(1) var one: sampler;\n@binding(0) var image: texture_2d<f32>;", "UG0520", "@binding(0)",
        "has @binding(0), and no @group", "@group(2) @binding(0)"),
    ("var<workgroup> sums: array<atomic<f32>, 4>;\nfn add() { atomicAdd(&sums[0], 1u); }", "UG0520",
        "atomic<f32>", "an atomic is u32 or i32, not f32", "atomic<u32>"),
    ("@group(0) @binding(0) var image: texture_2d<f32>;\n@group(0) @binding(1) var near: sampler;
@compute @workgroup_size(1) fn measure() { let a = textureSample(image, near, vec2<f32>()); }", "UG0521",
        "textureSample",
        "textureSample exists in fragment stages only, and \"measure\" is a compute stage", "textureSampleLevel"),
    ("fn slope(x: f32) -> f32 { return dpdx(x); }\n@compute @workgroup_size(1) fn measure() { let a = slope(1.0); }",
        "UG0521", "dpdx", "dpdx exists in fragment stages only", "compute the difference"),
    ("@fragment fn show() -> @location(0) vec4<f32> { workgroupBarrier(); return vec4<f32>(); }", "UG0521",
        "workgroupBarrier", "exists in compute stages only, and \"show\" is a fragment stage", "remove it"),
    ("@compute @workgroup_size(1) fn measure() { discard; }", "UG0521", "discard;",
        "`discard` exists in fragment stages only", "`return`"),
];

#[test]
fn a_wrong_declaration_is_explained() {
    for (text, code, marked, message, help) in DECLARATIONS {
        assert_said(&[("main.wgsl.jinja", text)], code, marked, message, help);
    }
}

const BASE: (&str, &str) = (
    "base.wgsl.jinja",
    "{% include 'part.wgsl.jinja' %}{% block declarations %}{% endblock %}
@fragment fn main() -> @location(0) vec4<f32> { {% block lighting %}return vec4<f32>(1.0);{% endblock %} }
",
);
const PART: (&str, &str) = ("part.wgsl.jinja", "{% block constants %}const ONE = 1.0;{% endblock %}\n");
const MACROS: (&str, &str) = ("macros.wgsl.jinja", "{% macro luma(c) %}dot({{ c }}, c){% endmacro %}");

/// Templates beside [`BASE`], [`PART`] and [`MACROS`], the marked text, and parts of message and help.
#[rustfmt::skip]
const TEMPLATES: &[(&str, &str, &str, &str, &str)] = &[
    ("{% extends 'base.wgsl.jinja' %}{% block lightning %}{% endblock %}", "UG0519", "lightning",
        "\"base.wgsl.jinja\", which this template extends, has no block \"lightning\"", "did you mean \"lighting\"?"),
    ("{% extends 'base.wgsl.jinja' %}{% block other %}{% endblock %}", "UG0519", "other",
        "has no block \"other\"", "its blocks are constants, declarations, lighting"),
    ("{% extends 'base.wgsl.jinja' %}\n// A note.\nfn help() -> f32 { return {{ 1 }}; }\n", "UG0519",
        "fn help() -> f32 { return {{ 1 }}; }", "text outside of blocks appears nowhere", "put it into one of the blocks"),
    ("{% from 'macros.wgsl.jinja' import luminance %}{{ luminance('a') }}", "UG0519", "luminance",
        "\"macros.wgsl.jinja\" has no macro \"luminance\"", "its macros are luma"),
    ("{% from 'macros.wgsl.jinja' import luma %}{{ luma() }}", "UG0506", "luma",
        "the macro luma(c) is called without \"c\"", "give it a value"),
    ("{{ luma('a') }}", "UG0506", "luma('a')", "luma is unknown", "{% from \"macros.wgsl.jinja\" import luma %}"),
    ("{% extends 'base.wgsl.jinja' %}{% block lighting %}{{ base() }}{% endblock %}", "UG0502", "base",
        "\"base\" is no axis", "{{ super() }} is the text of this block in \"base.wgsl.jinja\""),
    ("{% if true %}a{% else if false %}b{% endif %}", "UG0501", "else if", "{% else if %} does not exist", "{% elif false %}"),
    ("{{ 1 }; b {{ 2 }};", "UG0501", "}", "expected end of variable block", "close it with }}"),
    ("{% block a %}{% endblock %}{% block a %}{% endblock %}", "UG0501", "a", "defined twice", "another name"),
    ("{% set taps = 3 %}{% for i in taps %}{% endfor %}", "UG0506", "taps", "not iterable", "{% for i in range(taps) %}"),
    ("{% set look = 'a' %}{% if look == warm %}{% endif %}", "UG0502", "warm", "\"warm\" is no axis", "in quotes: \"warm\""),
];

#[test]
fn a_wrong_template_is_explained() {
    for (text, code, marked, message, help) in TEMPLATES {
        assert_said(&[("main.wgsl.jinja", text), BASE, PART, MACROS], code, marked, message, help);
    }
}

#[test]
fn templates_that_fit_have_no_diagnostics() {
    for text in [
        // A new block within one of the base, text of comments, and a block of an included template.
        "{% extends 'base.wgsl.jinja' %}\n// fn note\n/* fn a() {}\nfn b() {} */\n
         {% block declarations %}{% block more %}{% endblock %}{% endblock %}{% block constants %}{% endblock %}",
        "{% extends 'middle.wgsl.jinja' %}{% block more %}{% endblock %}{% block lighting %}{% endblock %}",
        "{% extends 'ba' ~ 'se.wgsl.jinja' %}{% block other %}{% endblock %}",
        "{% from 'macros.wgsl.jinja' import luma %}",
    ] {
        let middle = "{% extends 'base.wgsl.jinja' %}{% block declarations %}{% block more %}{% endblock %}{% endblock %}";
        Fixture::sound(&[("main.wgsl.jinja", text), ("middle.wgsl.jinja", middle), BASE, PART, MACROS]);
    }
}

#[test]
fn an_axis_of_an_included_template_is_inherited() {
    let files = [
        ("main.wgsl.jinja", "{% include 'blur.wgsl.jinja' %}"),
        ("blur.wgsl.jinja", "{{ taps }}"),
        ("blur.axes.json", r#"{"axes": {"taps": {"type": "integer", "min": 1, "max": 8, "default": 1}}}"#),
    ];
    let help = "write \"inherits\": [\"blur.wgsl.jinja\"], or declare it in main.axes.json";
    assert_said(&files, "UG0502", "taps", "\"taps\" is no axis", help);
}

/// Declarations of an axis, the marked text, and parts of message and help.
#[rustfmt::skip]
const AXES: &[(&str, &str, &str, &str, &str)] = &[
    (r#"{"axes": {"n": {"type": "int", "min": 1, "max": 8, "default": 1}}}"#, "UG0107", "\"int\"", "\"int\" is not known", "did you mean \"integer\"?"),
    (r#"{"axes": {"n": {"type": "integer", "min": 1, "max": 8, "default": 9}}}"#, "UG0510", "9", "(1 to 8)", "lower it, or raise \"max\""),
    (r#"{"axes": {"n": {"type": "integer", "min": 8, "max": 1, "default": 1}}}"#, "UG0510", "8", "\"min\" (8) is larger than \"max\" (1)", "\"min\": 1, \"max\": 8"),
    (r#"{"axes": {"n": {"type": "bool", "default": "true"}}}"#, "UG0510", "\"true\"", "none of its values", "without quotes: true"),
    (r#"{"axes": {"n": {"type": "integer", "min": 1, "max": 8, "default": "3"}}}"#, "UG0510", "\"3\"", "none of its values", "without quotes: 3"),
    (r#"{"axes": {"n": {"type": "enum", "default": "a"}}}"#, "UG0510", "\"n\"", "has no \"values\"", "\"values\": ["),
    (r#"{"axes": {"n": {"type": "enum", "values": ["soft", "hard"], "default": "sotf"}}}"#, "UG0510", "\"sotf\"", "none of its values", "did you mean \"soft\"?"),
    (r#"{"n": {"type": "bool", "default": true}}"#, "UG0102", "\"n\"", "unknown key \"n\"", "{ \"axes\": { \"n\": "),
];

#[test]
fn a_wrong_axis_is_explained() {
    for (axes, code, marked, message, help) in AXES {
        let template = "{% if n %}{% endif %}";
        assert_said(&[("main.wgsl.jinja", template), ("main.axes.json", axes)], code, marked, message, help);
    }
}
