//! Dead axes and text, and axes and text that only look dead.

use std::collections::BTreeSet;

use super::{FRAGMENT, Fixture};
use crate::TargetProfile;
use crate::permutations::{Options, Request, check, dead};
use umbragraph_text::source::FileId;

fn proven(fixture: &Fixture) -> Vec<String> {
    let options = Options { threads: 1, report_dead: true, ..Options::default() };
    let request = Request::all("main.wgsl.jinja", &[TargetProfile::webgpu()]);
    sorted(fixture.lines(&check(&fixture.set, &[request], &options).diagnostics))
}

fn looked_at(fixture: &Fixture, shared: &BTreeSet<FileId>) -> Vec<String> {
    sorted(fixture.lines(&dead(&fixture.set, &["main.wgsl.jinja".to_owned()].into(), shared)))
}

fn sorted(mut lines: Vec<String>) -> Vec<String> {
    lines.sort();
    lines
}

#[test]
fn axes_that_a_constraint_ties_together_are_not_dead() {
    let main =
        format!("{{% if a %}}const A = 1;\n{{% endif %}}{{% if c or true %}}{FRAGMENT}{{% endif %}}\n");
    let axes = r#"{
  "axes": {
    "a": { "type": "bool", "default": true },
    "b": { "type": "bool", "default": false },
    "c": { "type": "bool", "default": false } },
  "constraints": [{ "one_of": ["a", "b"] }]
}"#;
    let main_of_both = format!("{{% if b %}}const B = 1;\n{{% endif %}}{main}");
    let fixture = Fixture::sound(&[("main.wgsl.jinja", &main_of_both), ("main.axes.json", axes)]);
    assert_eq!(proven(&fixture), ["UG0550 main.axes.json:5:5 no text depends on the axis \"c\""]);
    assert_eq!(looked_at(&fixture, &BTreeSet::new()), proven(&fixture));
}

#[test]
fn nothing_in_a_file_that_others_use_is_dead() {
    let axes =
        |name: &str| format!(r#"{{ "axes": {{ "{name}": {{ "type": "bool", "default": false }} }} }}"#);
    let inherits = r#"{ "inherits": ["part.wgsl.jinja"], "axes": {
  "mine": { "type": "bool", "default": false } } }"#;
    let main = format!(
        "{{% include 'part.wgsl.jinja' %}}\n{{% if mine and not mine %}}\n// mine\n{{% endif %}}\n{FRAGMENT}"
    );
    let part = "// part\n{% if theirs and not theirs %}\n// theirs\n{% endif %}\n";
    let fixture = Fixture::sound(&[
        ("main.wgsl.jinja", &main),
        ("main.axes.json", inherits),
        ("part.wgsl.jinja", part),
        ("part.axes.json", &axes("theirs")),
    ]);
    let of = |name: &str| [fixture.set.file(name), fixture.set.axes_file(name)].into_iter().flatten();
    let all = looked_at(&fixture, &BTreeSet::new());
    assert_eq!(
        all,
        [
            "UG0550 main.axes.json:2:3 no text depends on the axis \"mine\"",
            "UG0550 part.axes.json:1:13 no text depends on the axis \"theirs\"",
            "UG0551 main.wgsl.jinja:3:1 no variant contains this text",
            "UG0551 part.wgsl.jinja:3:1 no variant contains this text",
        ]
    );
    assert_eq!(proven(&fixture), all);
    let shared = of("part.wgsl.jinja").collect();
    assert_eq!(looked_at(&fixture, &shared), [all[0].as_str(), &all[2]]);
}

#[test]
fn nothing_is_dead_in_failing_or_very_large_templates() {
    let axes = r#"{ "axes": { "a": { "type": "bool", "default": false },
  "n": { "type": "integer", "min": 0, "max": 1023, "default": 0 } } }"#;
    let never = "{% if a and not a %}\n// never\n{% endif %}\n";
    let diagnostics = |main: &str| {
        let fixture = Fixture::sound(&[("main.wgsl.jinja", main), ("main.axes.json", axes)]);
        looked_at(&fixture, &BTreeSet::new()).len()
    };
    assert_eq!(diagnostics(&format!("{never}// {{{{ n }}}}\n")), 0, "2,048 paths");
    assert_eq!(diagnostics(&format!("{never}{{{{ [] }}}}\n")), 0, "a list is no text");
    assert_eq!(diagnostics(&format!("{never}// text\n")), 3, "two axes and the text");
}
