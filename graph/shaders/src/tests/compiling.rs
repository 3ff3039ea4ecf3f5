//! Variants that compile: what they contain, what they are known by, how their text maps back.

use std::sync::Arc;

use super::{FRAGMENT, Fixture, values};
use crate::{AxisValue, ShaderCache, TargetLanguage, TargetProfile};

const AXES: &str = r#"{ "axes": {
  "tint":   { "type": "bool", "default": false },
  "unused": { "type": "bool", "default": false },
  "taps":   { "type": "integer", "min": 1, "max": 16, "default": 4 },
  "filter": { "type": "enum", "values": ["hard", "pcf"], "default": "pcf" },
  "format": { "type": "texture_format", "values": ["rgba16float", "rgba32float"], "default": "rgba16float" }
} }"#;

const MAIN: &str = "const TAPS = {{ taps }};
{% if tint %}
const TINT = {{ tint }}; // ä
{% endif %}
const FILTER = {% if filter == 'hard' %}0{% else %}1{% endif %};
@group(0) @binding(0) var output: texture_storage_2d<{{ format }}, write>;
@compute @workgroup_size(8) fn main() { textureStore(output, vec2<i32>(), vec4<f32>(f32(TAPS + FILTER))); }
";

#[test]
fn axes_that_the_text_does_not_read_are_no_part_of_a_module() {
    let fixture = Fixture::sound(&[("main.wgsl.jinja", MAIN), ("main.axes.json", AXES)]);
    let plain = fixture.compile("main.wgsl.jinja", &[]);
    assert_eq!(plain.axes.keys().collect::<Vec<_>>(), ["filter", "format", "taps", "tint"]);
    let same = fixture.compile("main.wgsl.jinja", &[("unused", true.into())]);
    assert_eq!(plain.hash, same.hash);
    let other =
        fixture.compile("main.wgsl.jinja", &[("format", "rgba32float".into()), ("tint", true.into())]);
    assert_ne!(plain.hash, other.hash);
    assert!(other.wgsl.contains("texture_storage_2d<rgba32float, write>"));
    assert!(other.wgsl.contains("const TINT = true;"), "{}", other.wgsl);
}

#[test]
fn block_tags_alone_on_a_line_leave_no_line_behind() {
    let fixture = Fixture::sound(&[("main.wgsl.jinja", MAIN), ("main.axes.json", AXES)]);
    let module = fixture.compile("main.wgsl.jinja", &[]);
    assert_eq!(module.wgsl.lines().next(), Some("const TAPS = 4;"));
    assert_eq!(module.wgsl.lines().nth(1), Some("const FILTER = 1;"));
}

#[test]
fn every_literal_byte_maps_to_itself() {
    let include = "// included ä {{ taps }}\nfn helper() -> f32 { return 1.0; }\n";
    let main = format!(
        "{MAIN}{{% include 'lib/a.wgsl.jinja' %}}\n{{% for i in range(2) %}}\nconst C{{{{ i }}}} = {{{{ i }}}};\n{{% endfor %}}\n"
    );
    let fixture = Fixture::sound(&[
        ("main.wgsl.jinja", &main),
        ("main.axes.json", AXES),
        ("lib/a.wgsl.jinja", include),
    ]);
    let module = fixture.compile("main.wgsl.jinja", &[("tint", true.into())]);
    let mut literal = 0;
    for (range, span) in module.map.pieces() {
        let span = span.expect("every piece has an origin");
        let origin = fixture.sources.text(span);
        if origin.starts_with("{{") {
            continue;
        }
        assert_eq!(origin, &module.wgsl[range.clone()]);
        literal += range.len();
    }
    assert!(literal * 10 > module.wgsl.len() * 9, "{literal} of {}", module.wgsl.len());
    let at = module.wgsl.find("const C1 = 1").unwrap();
    let tag = module.map.place(at + "const C1 = ".len()).unwrap();
    assert_eq!(fixture.sources.text(tag), "{{ i }}");
    assert_eq!(fixture.place(&tag.into()), "main.wgsl.jinja:10:18");
}

#[test]
fn an_override_axis_is_a_constant_of_the_module() {
    let axes = r#"{ "axes": {
        "size": { "type": "integer", "min": 1, "max": 64, "default": 8, "as": "override" },
        "fast": { "type": "bool", "default": true, "as": "override" } } }"#;
    let text = "override size: u32 = 1;\noverride fast: bool = false;\n@compute @workgroup_size(size) fn main() { if fast { return; } }\n";
    let fixture = Fixture::sound(&[("main.wgsl.jinja", text), ("main.axes.json", axes)]);
    let module = fixture.compile("main.wgsl.jinja", &[("size", AxisValue::Integer(32))]);
    assert_eq!(module.constants["size"], 32.0);
    assert_eq!(module.constants["fast"], 1.0);
    assert_eq!(module.reflection.entry_points[0].workgroup_size, [32, 1, 1]);
    assert_eq!(module.axes.len(), 0);
    assert_eq!(module.hash, fixture.compile("main.wgsl.jinja", &[]).hash);
}

#[test]
fn inherited_axes_and_constraints_hold() {
    let lib = r#"{ "axes": { "evsm": { "type": "bool", "default": false, "excludes": ["msaa"] },
                             "msaa": { "type": "bool", "default": false } } }"#;
    let main = r#"{ "inherits": ["lib.wgsl.jinja"], "axes": { "fog": { "type": "bool", "default": false, "requires": ["evsm"] } } }"#;
    let fixture = Fixture::sound(&[
        ("main.wgsl.jinja", "{% include 'lib.wgsl.jinja' %}{% if fog %}// fog\n{% endif %}"),
        ("lib.wgsl.jinja", FRAGMENT),
        ("main.axes.json", main),
        ("lib.axes.json", lib),
    ]);
    let axes = fixture.set.axes("main.wgsl.jinja").unwrap();
    assert_eq!(axes.names().collect::<Vec<_>>(), ["evsm", "fog", "msaa"]);
    fixture.compile("main.wgsl.jinja", &[("fog", true.into()), ("evsm", true.into())]);
    let rejected = fixture.rejection("main.wgsl.jinja", &[("fog", true.into())]);
    assert_eq!(
        rejected,
        [
            "UG0513 main.axes.json:1:100 evsm=false, fog=true breaks a constraint of \"main.wgsl.jinja\": fog requires evsm"
        ]
    );
}

#[test]
fn a_variant_is_written_in_every_language_and_line_by_line() {
    let lib = "fn half(x: f32) -> f32 {\n    return x * 0.5;\n}\n";
    let main = format!(
        "{{% include 'lib/half.wgsl.jinja' %}}\n{{% if tint %}}\nconst T = 1;\n{{% endif %}}\n{FRAGMENT}"
    );
    let axes = r#"{ "axes": { "tint": { "type": "bool", "default": false } } }"#;
    let files = [("main.wgsl.jinja", main.as_str()), ("main.axes.json", axes), ("lib/half.wgsl.jinja", lib)];
    let fixture = Fixture::sound(&files);
    let module = fixture.compile("main.wgsl.jinja", &[]);
    assert_eq!(
        module.annotated(&fixture.sources).lines().collect::<Vec<_>>(),
        [
            "lib/half.wgsl.jinja:1 | fn half(x: f32) -> f32 {",
            "lib/half.wgsl.jinja:2 |     return x * 0.5;",
            "lib/half.wgsl.jinja:3 | }",
            "main.wgsl.jinja:5     | @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(1.0); }",
        ]
    );
    for (language, sign) in [
        (TargetLanguage::Wgsl, "fn half"),
        (TargetLanguage::Msl, "metal_stdlib"),
        (TargetLanguage::Hlsl, "float half"),
        (TargetLanguage::Glsl, "#version 310 es"),
        (TargetLanguage::GlslWebgl2, "#version 300 es"),
    ] {
        let written = module.emit(&TargetProfile::webgpu(), language).unwrap();
        let text = String::from_utf8(written.to_bytes()).unwrap();
        assert!(text.contains(sign), "{text}");
    }
    let words = module.emit(&TargetProfile::webgpu(), TargetLanguage::Spirv).unwrap().to_bytes();
    assert_eq!(words[..4], 0x0723_0203_u32.to_le_bytes());
}

#[test]
fn a_template_included_by_two_others_says_both_ways() {
    // The templates "b" and "c" write nothing of their own, and "d" is what stands in the text twice.
    let fixture = Fixture::sound(&[
        (
            "main.wgsl.jinja",
            &format!("{{% include 'b.wgsl.jinja' %}}\n{{% include 'c.wgsl.jinja' %}}\n{FRAGMENT}"),
        ),
        ("b.wgsl.jinja", "{% include 'd.wgsl.jinja' %}"),
        ("c.wgsl.jinja", "\n{% include \"d.wgsl.jinja\" %}"),
        ("d.wgsl.jinja", "{% include 'e.wgsl.jinja' %}"),
        ("e.wgsl.jinja", "fn one() -> f32 { return 1.0; }\n"),
    ]);
    let profile = TargetProfile::webgpu();
    let said = crate::compile(&fixture.set, "main.wgsl.jinja", &values(&[]), &profile).unwrap_err();
    let [only] = &said[..] else { panic!("{said:?}") };
    assert_eq!(fixture.lines([only]), ["UG0520 e.wgsl.jinja:1:4 redefinition of `one`"]);
    let related = only.related.iter().map(|one| format!("{} {}", fixture.place(&one.place), one.message));
    assert_eq!(
        related.filter(|line| !line.contains("generated line")).collect::<Vec<_>>(),
        [
            "b.wgsl.jinja:1:1 \"d.wgsl.jinja\" is included here",
            "c.wgsl.jinja:2:1 \"d.wgsl.jinja\" is included here",
        ]
    );
    let help = "\"d.wgsl.jinja\" is included 2 times: include it once, before its first use";
    assert_eq!(only.help.as_deref(), Some(help));
}

#[test]
fn ten_megabytes_of_text_are_a_diagnostic() {
    let fixture = Fixture::sound(&[("main.wgsl.jinja", &"// 0123456789\n".repeat(800_000))]);
    let lines = fixture.rejection("main.wgsl.jinja", &[]);
    assert_eq!(lines, ["UG0505 main.wgsl.jinja:1:1 the template writes more than 4 MiB of WGSL"]);
}

#[test]
fn a_binding_number_of_several_pieces_moves_as_one() {
    let mut fixture = Fixture::new(&[(
        "own.wgsl.jinja",
        "{% set last = 2 %}{% include \"part.wgsl.jinja\" %}@group(0) @binding(12) var<uniform> b: f32;\n",
    )]);
    let text = "@group(0) @binding(1{{ last }}) var<uniform> a: f32;\n";
    let file = fixture.sources.add("part.wgsl.jinja", text);
    let Fixture { sources, set, diagnostics } = &mut fixture;
    set.add_library_file(sources, file, "part.wgsl.jinja", diagnostics);
    let module = fixture.compile("own.wgsl.jinja", &[]);
    assert!(module.wgsl.starts_with("@group(0) @binding(512) var<uniform> a: f32;\n"), "{}", module.wgsl);
    let offset = module.wgsl.find("512").unwrap();
    assert_eq!(fixture.sources.text(module.map.place(offset).unwrap()), "1");
    let own = module.map.place(module.wgsl.find("b: f32").unwrap()).unwrap();
    assert_eq!(fixture.sources.text(own), "b");
}

#[test]
fn a_survey_finds_the_modules_that_compiling_makes() {
    let main = "override taps: u32 = 4u;\n{% if wide %}const WIDE = {{ wide }};{% endif %}\n{% if double %}{% endif %}\
                @fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(f32(taps)); }\n";
    let wave = "override taps: u32 = 4u;\n@compute @workgroup_size(taps) fn main() {}\n";
    let axes = r#"{ "axes": {
        "taps": { "type": "integer", "min": 1, "max": 16, "default": 4, "as": "override" },
        "wide": { "type": "bool", "default": false }, "double": { "type": "bool", "default": false } } }"#;
    let fixture = Fixture::sound(&[
        ("main.wgsl.jinja", main),
        ("main.axes.json", axes),
        ("wave.wgsl.jinja", wave),
        ("wave.axes.json", axes),
    ]);
    let set = Arc::new(fixture.set);
    let first = ShaderCache::of_survey(&set, &TargetProfile::webgpu());
    let second = ShaderCache::beside(&first, &TargetProfile::webgpu_compat());
    for template in ["main.wgsl.jinja", "wave.wgsl.jinja"] {
        for (taps, wide, double) in [(4, false, false), (9, false, false), (9, true, false), (2, false, true)]
        {
            let given = values(&[
                ("taps", AxisValue::Integer(taps)),
                ("wide", wide.into()),
                ("double", double.into()),
            ]);
            let wanted = crate::compile(&set, template, &given, &TargetProfile::webgpu()).unwrap();
            for survey in [&first, &second] {
                assert_eq!(*survey.module(template, given.clone()).unwrap(), wanted, "{template} {given:?}");
            }
        }
    }
}
