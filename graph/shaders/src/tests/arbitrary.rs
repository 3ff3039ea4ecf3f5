//! Any input ends in modules or diagnostics, never in a panic.

use proptest::prelude::*;
use umbragraph_test_support::property;

use super::Fixture;
use crate::TargetProfile;
use crate::permutations::{Options, Request, check};
use crate::rendering::markers;

/// Pieces of templates, including pieces that make them invalid.
const PIECES: &[&str] = &[
    "{% if a %}",
    "{% elif b == 'x' %}",
    "{% else %}",
    "{% endif %}",
    "{{ a }}",
    "{{ n + 1 }}",
    "{{- b -}}",
    "{%- set c = n -%}",
    "{% for i in range(n) %}",
    "{% endfor %}",
    "{% macro m(x, y=2) %}",
    "{% endmacro %}",
    "{{ m(a) }}",
    "{% set s %}",
    "{% endset %}",
    "{% include 'lib.wgsl.jinja' %}",
    "{% include b %}",
    "{% raw %}",
    "{% endraw %}",
    "{# c #}",
    "{{",
    "}}",
    "{%",
    "%}",
    "{#",
    "'",
    "\\",
    "fn f() -> f32 { return 1.0; }\n",
    "const A = 1;\n",
    "override n: u32;\n",
    "@group(9) @binding(0) var t: texture_2d<f32>;\n",
    "struct S { a: f32, }\n",
    "(",
    ")",
    "{",
    "}",
    ";",
    "ä漢😀",
    "\u{E000}",
    "\r\n",
    "\0",
    "@compute @workgroup_size(n) fn main() {}\n",
    "{% with d = a %}",
    "{% endwith %}",
    "{% call(q) m(1) %}",
    "{% endcall %}",
    "{% filter upper %}",
    "{% endfilter %}",
    "{{ s }}",
    "{{ loop.index }}",
];

const AXES: &str = r#"{ "axes": {
    "a": { "type": "bool", "default": false, "requires": ["n!=2"] },
    "b": { "type": "enum", "values": ["x", "y"], "default": "x" },
    "n": { "type": "integer", "min": 0, "max": 3, "default": 1 } } }"#;

proptest! {
    #![proptest_config(property::config(400))]

    #[test]
    fn any_template_ends_in_variants_or_diagnostics(pieces in prop::collection::vec(prop::sample::select(PIECES), 0..24)) {
        let text = pieces.concat();
        let fixture = Fixture::new(&[
            ("main.wgsl.jinja", &text),
            ("main.axes.json", AXES),
            ("lib.wgsl.jinja", "// lib {{ a }}\n"),
        ]);
        let options = Options { threads: 1, report_dead: true, ..Options::default() };
        let outcome = check(&fixture.set, &[Request::all("main.wgsl.jinja", &[TargetProfile::webgpu()])], &options);
        let covered = outcome.templates.first().is_some_and(|report| report.covered == report.configurations);
        prop_assert!(outcome.diagnostics.has_errors() || covered, "{text}");
        fixture.lines(&outcome.diagnostics);
    }

    #[test]
    fn any_text_is_scanned_and_guarded_without_loss(text in "[ -~\\n{}%#'\"äö]{0,80}") {
        let prepared = crate::jinja::tree::prepare(&text);
        for at in 0..=prepared.text.len() {
            prop_assert!(prepared.original(at) <= text.len());
        }
        prop_assert_eq!(prepared.original(prepared.text.len()), text.len());
    }

    #[test]
    fn any_declaration_of_axes_is_read_or_rejected(text in "[ -~\\n]{0,120}") {
        Fixture::new(&[("main.wgsl.jinja", ""), ("main.axes.json", &text)]);
    }
}

#[test]
fn markers_leave_the_text_as_it_is() {
    let text = "{% macro m(x) %}\n  // {{ x }} in a macro\n{% endmacro %}\n{% for i in range(n) %}\n// {{ i -}}   \n  {{- a }}z\n{{ m(i)|trim|indent(2) }}\n{% endfor %}\n{% set s %}\n  // set {{ b }}\n{% endset %}\n{{ s }}{% if a %}// a\n{% endif %}";
    let fixture = Fixture::new(&[("main.wgsl.jinja", text), ("main.axes.json", AXES)]);
    let marked = markers::MarkedTemplates::new(&fixture.set.templates, None);
    let outcome = check(&fixture.set, &[Request::all("main.wgsl.jinja", &[])], &Options::default());
    assert!(outcome.templates[0].variants.len() > 8);
    for variant in &outcome.templates[0].variants {
        let wgsl = outcome.templates[0].text(&fixture.set, variant).unwrap();
        let exact = marked
            .map("main.wgsl.jinja", &variant.axes.values(), &wgsl)
            .expect("the stripped text is the plain one");
        for (needle, place) in [("in a macro", "main.wgsl.jinja:2:"), ("set ", "main.wgsl.jinja:10:")] {
            if let Some(at) = wgsl.find(needle) {
                let span = exact.map.place(at).unwrap();
                assert!(fixture.place(&span.into()).starts_with(place), "{needle}");
                assert!(exact.trail(at).next().is_some(), "{needle} was captured");
            }
        }
    }
}
