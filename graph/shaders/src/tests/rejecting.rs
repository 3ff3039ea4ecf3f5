//! Variants that must not compile, and limits that must hold.

use std::time::Instant;

use super::{FRAGMENT, Fixture, values};
use crate::TargetProfile;
use crate::jinja::guard;

fn rejection(text: &str) -> Vec<String> {
    let fixture = Fixture::new(&[("main.wgsl.jinja", text)]);
    let mut lines = fixture.lines(&fixture.diagnostics);
    if lines.is_empty() {
        lines = fixture.rejection("main.wgsl.jinja", &[]);
    }
    lines
}

#[test]
fn an_undeclared_name_is_found_even_where_a_test_hides_it() {
    assert_eq!(
        rejection("a\n{% if sccs is defined %}{% endif %}"),
        ["UG0502 main.wgsl.jinja:2:7 \"sccs\" is no axis of \"main.wgsl.jinja\" and is bound by nothing"]
    );
    assert_eq!(rejection("\n  {{ taps }}").len(), 1);
    assert_eq!(rejection("{{ taps|default(3) }}").len(), 1);
}

#[test]
fn names_bound_by_tags_are_no_axes() {
    let text = "{% set a = 1 %}{% macro m(b, c=2) %}{{ a + b + c }}{{ later() }}{% endmacro %}
{% macro later() %}0{% endmacro %}
{% for k, v in [[1, 2]] %}const C{{ k }} = {{ v }}; // {{ loop.index }} {{ m(1) }}
{% endfor %}{% with d = 3 %}{{ '' if d else '' }}{% endwith %}";
    let text = format!("{text}\n{FRAGMENT}");
    let fixture = Fixture::sound(&[("main.wgsl.jinja", &text)]);
    let module = fixture.compile("main.wgsl.jinja", &[]);
    assert!(module.wgsl.contains("const C1 = 2; // 1 40"), "{}", module.wgsl);
}

#[test]
fn no_template_runs_for_ever_or_explodes() {
    guard::without_clock();
    let expression = "an expression makes a value larger than 1 MiB";
    let filter = "a filter makes a value larger than 1 MiB";
    let work = "its values and filters go through more than 4,194,304 elements";
    let cases = [
        (
            "{% for i in range(100000) %}{% for j in range(100000) %}{% endfor %}{% endfor %}",
            "it takes more steps than allowed",
        ),
        (
            "{% for i in range(100000) %}aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\n{% endfor %}",
            "the template writes more than 4 MiB of WGSL",
        ),
        (
            "{% set ns = namespace(s='x') %}{% for i in range(64) %}{% set ns.s = ns.s ~ ns.s %}{% endfor %}",
            expression,
        ),
        (
            "{% set ns = namespace(s='x') %}{% for i in range(64) %}{% set ns.s = ns.s + ns.s %}{% endfor %}",
            expression,
        ),
        ("{% macro f(s) %}{{ f(s ~ s) }}{% endmacro %}{{ f('x') }}", expression),
        ("{% set a = 'x' * 99999999 %}", expression),
        ("{{ 'x' * 99999999 }}", expression),
        ("{{ ((1, 2) * 40000000)|length }}", expression),
        ("{% set a = 'x' * 1000000 %}{% set b = a ~ a ~ a ~ a %}", expression),
        (
            "{% for i in range(20) %}{{ 'x' * 1000000 }}{% endfor %}",
            "the template writes more than 4 MiB of WGSL",
        ),
        ("{% set a %}{{ 'x' * 1000000 }}{{ 'x' * 1000000 }}{% endset %}", expression),
        (
            "{% set ns = namespace(s=[1]) %}{% for i in range(64) %}{% set ns.s = [ns.s, ns.s] %}{% endfor %}",
            work,
        ),
        (
            "{% set ns = namespace(s=[1]) %}{% for i in range(64) %}{% set ns.s = ns.s + ns.s %}{% endfor %}",
            expression,
        ),
        ("{{ ('x' * 100000)|replace('x', 'y' * 100000) }}", filter),
        ("{{ ([1] * 50000000)|join('xxxxxxxxxxxxxx') }}", expression),
        ("{{ ([1] * 500000)|join('xxxxxxxxxxxxxx') }}", filter),
        // Few steps, each of which takes long.
        ("{% set a = [1] * 500000 %}{% for i in range(100000) %}{% set b = [a] %}{% endfor %}", work),
        (
            "{% set a = 'X' * 1000000 %}{% for i in range(100000) %}{% if a|lower == 'y' %}{% endif %}{% endfor %}",
            work,
        ),
        (
            "{% set a = 'X' * 1000000 %}{% for i in range(100000) %}{% if a|replace('y', 'z') == 'y' %}{% endif %}{% endfor %}",
            work,
        ),
        (
            "{% set a = [1] * 500000 %}{% for i in range(100000) %}{% if a|max == 2 %}{% endif %}{% endfor %}",
            work,
        ),
        ("{% if ('x' * 99999999)|upper == 'y' %}{% endif %}", expression),
        (
            "{% set a = 'x' * 1000000 %}{% for i in range(100000) %}{% if 'zz' in a %}{% endif %}{% endfor %}",
            work,
        ),
        (
            "{% set a = 'x' * 1000000 %}{% for i in range(100000) %}{% if a[1:] == a[i] %}{% endif %}{% endfor %}",
            work,
        ),
        (
            "{% set a = [1] * 500000 %}{% for i in range(100000) %}{% if 2 in a %}{% endif %}{% endfor %}",
            work,
        ),
    ];
    for (case, limit) in cases {
        let lines = rejection(&format!("{case}\n{FRAGMENT}"));
        assert!(lines.len() == 1 && lines[0].starts_with("UG0505 main.wgsl.jinja:"), "{case}: {lines:?}");
        assert!(lines[0].ends_with(limit), "{case}: {lines:?}");
    }
}

#[test]
fn the_clock_ends_what_nothing_counts() {
    let case =
        "{% set n = 99999999 %}{% for i in range(100000) %}{% if 'x' * n == 'y' %}{% endif %}{% endfor %}";
    let lines = rejection(&format!("{case}\n{FRAGMENT}"));
    assert!(lines.len() == 1 && lines[0].starts_with("UG0505 main.wgsl.jinja:"), "{lines:?}");
}

#[test]
fn an_expression_of_any_length_takes_a_second() {
    let sum = |count: usize, one: &str, sign: &str| vec![one; count].join(sign);
    let long = "{% set s = 'x' * 1000000 %}";
    let cases = [
        format!("{{% set s = {} %}}", sum(16, "('x' * 90000000)", " ~ ")),
        format!("{{% set s = {} %}}", sum(300_000, "'x'", "~")),
        format!("{{% set s = {} %}}", sum(300_000, "1", "+")),
        format!("{{% if {} %}}{{% endif %}}", sum(300_000, "true", " and ")),
        format!("{long}{{% if {} %}}{{% endif %}}", sum(500, "s", " ~ ")),
        format!("{long}{{% if {} %}}{{% endif %}}", sum(500, "s", " + ")),
        format!("{{% if {} %}}{{% endif %}}", sum(300, "('x' * 90000000)", " * 1 ~ ")),
        long.to_owned() + &"{% if s[1:] == s %}{% endif %}".repeat(20_000),
        "{% if 1 %}".to_owned() + &"{% elif 1 %}".repeat(100_000) + "{% endif %}",
        format!("{{{{ s{} }}}}", "|upper".repeat(100_000)),
        format!("{{{{ s{} }}}}", "|replace('a', 'b')".repeat(100_000)),
        format!("{{{{ {} }}}}", sum(100_000, "[1, 2][0]", "~")),
        format!("{{{{ {}1 }}}}", "not ".repeat(100_000)),
    ];
    for case in cases {
        let start = Instant::now();
        let lines = rejection(&format!("{case}\n{FRAGMENT}"));
        // Without optimization, on a busy machine, everything takes longer; without guards it is minutes.
        assert!(start.elapsed().as_secs() < 60, "{}: {:?}", &case[..60], start.elapsed());
        assert!(lines.len() == 1 && lines[0].starts_with("UG0505 "), "{}: {lines:?}", &case[..60]);
    }
}

#[test]
fn recursion_ends() {
    assert_eq!(
        rejection("\n {% include 'main.wgsl.jinja' %}"),
        [
            "UG0504 main.wgsl.jinja:2:5 the template includes itself: \"main.wgsl.jinja\" includes \"main.wgsl.jinja\""
        ]
    );
    let lines = rejection("{% macro f() %}{{ f() }}{% endmacro %}{{ f() }}");
    assert!(lines[0].starts_with("UG0504 main.wgsl.jinja:1:"), "{lines:?}");
}

/// Modules with `count` links of each kind of chain over which naga recurses.
fn chains(count: usize) -> Vec<String> {
    let around = |before: &str, open: &str, middle: &str, close: &str, after: &str| {
        format!("{before}{}{middle}{}{after}", open.repeat(count), close.repeat(count))
    };
    let numbered = |each: &dyn Fn(usize) -> String| (0..count).map(each).collect::<String>();
    vec![
        around("const A = ", "(", "1", ")", ";"),
        around("const A = ", "!", "true", "", ";"),
        around("const A = ", "-", "1", "", ";"),
        around("const A = ", "1 + ", "1", "", ";"),
        around("const A = ", "true && ", "true", "", ";"),
        around("fn f() { ", "{", "", "}", "}"),
        around("fn f() { if true {} ", "else if true {} ", "", "", "}"),
        around("fn f(x: vec4<f32>) { let b = x", ".xyzw", "", "", ";}"),
        around("fn f(x: f32) { var y = x; ", "y = y + 1.0; ", "", "", "}"),
        around("var<private> a: ", "array<", "i32", ", 2>", ";"),
        around("", "/*", "", "*/", ""),
        around("", "@must_use ", "", "", "fn f() {}"),
        format!("const A{count} = 1; {}", numbered(&|at| format!("const A{at} = A{}; ", at + 1))),
        format!("fn a{count}() {{}} {}", numbered(&|at| format!("fn a{at}() {{ a{}(); }} ", at + 1))),
        format!(
            "struct S{count} {{ a: f32 }} {}",
            numbered(&|at| format!("struct S{at} {{ a: S{} }} ", at + 1))
        ),
    ]
}

#[test]
fn chains_of_any_length_end_in_a_module_or_a_diagnostic() {
    for count in [100, 8_000, 40_000, 300_000] {
        for text in chains(count) {
            let text = format!("{{% raw %}}{text}{{% endraw %}}");
            let fixture = Fixture::new(&[("main.wgsl.jinja", &text)]);
            let start = Instant::now();
            let profile = crate::TargetProfile::webgpu();
            let compiled = crate::compile(&fixture.set, "main.wgsl.jinja", &Default::default(), &profile);
            assert!(start.elapsed().as_secs() < 60, "{}", &text[..80]);
            let may_be_long = text.contains("/*") || text.contains("{{{");
            assert!(count < 300_000 || may_be_long || compiled.is_err(), "{}", &text[..80]);
        }
    }
}

#[test]
fn errors_of_the_wgsl_stand_in_the_template() {
    let lib = "fn half(x: f32) -> f32 {\n    return x * 5i;\n}\n";
    let main = format!("// ä\n{{% include 'lib/half.wgsl.jinja' %}}\n{FRAGMENT}");
    let fixture = Fixture::sound(&[("main.wgsl.jinja", &main), ("lib/half.wgsl.jinja", lib)]);
    let lines = fixture.rejection("main.wgsl.jinja", &[]);
    assert_eq!(lines.len(), 1);
    assert!(lines[0].contains("lib/half.wgsl.jinja:2:12"), "{lines:?}");
}

#[test]
fn an_error_in_a_macro_stands_in_the_macro() {
    let lib = "{% macro tap(i) -%}\n    sum += weight({{ i }});\n{%- endmacro %}\n";
    let main = format!(
        "{{% from 'lib.wgsl.jinja' import tap %}}\nfn f() {{\n    var sum = 0.0;\n    {{{{ tap(1) }}}}\n}}\n{FRAGMENT}"
    );
    let fixture = Fixture::sound(&[("main.wgsl.jinja", &main), ("lib.wgsl.jinja", lib)]);
    let lines = fixture.rejection("main.wgsl.jinja", &[]);
    assert!(lines[0].starts_with("UG0520 lib.wgsl.jinja:2:12 no definition in scope"), "{lines:?}");
}

#[test]
fn too_large_a_text_is_blamed_on_its_largest_template() {
    let line = "// A line that says the same again, as the one before it did, and the next will.\n";
    let part = "fn helper() {}\n".repeat(100);
    let long =
        format!("{{% include \"part.wgsl.jinja\" %}}\n{{% if true %}}{}{{% endif %}}\n", line.repeat(60_000));
    let looped =
        format!("{{% for i in range(9000) %}}{{% include \"part.wgsl.jinja\" %}}{{% endfor %}}\n{FRAGMENT}");
    for (main, place, from) in [
        (long.as_str(), "main.wgsl.jinja:2:", "main.wgsl.jinja"),
        (&looped, "part.wgsl.jinja:1:", "part.wgsl.jinja"),
    ] {
        let fixture = Fixture::sound(&[("main.wgsl.jinja", main), ("part.wgsl.jinja", &part)]);
        let diagnostics =
            crate::compile(&fixture.set, "main.wgsl.jinja", &values(&[]), &TargetProfile::webgpu())
                .unwrap_err();
        let [diagnostic] = diagnostics.as_slice() else { panic!("{:?}", fixture.lines(&diagnostics)) };
        assert_eq!(diagnostic.code.id, "UG0505");
        assert!(fixture.place(&diagnostic.place).starts_with(place), "{:?}", fixture.lines(&diagnostics));
        let help = diagnostic.help.as_deref().unwrap_or_default();
        assert!(help.contains(&format!("bytes come from {from}")), "{help}");
    }
}
