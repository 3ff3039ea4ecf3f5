//! Lazy forking against going through every configuration, and what a check reports.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use umbragraph_test_support::property;

use super::{FRAGMENT, Fixture, values};
use crate::axes::Domain;
use crate::compile;
use crate::permutations::{Count, Opinion, Options, Permutations, Request, Validator, check};
use crate::rendering::render;
use crate::variant::compile::template_values;
use crate::{AxisValue, AxisValues, TargetProfile};
use umbragraph_text::diagnostic::{Place, Severity};

const AXES: &str = r#"{ "axes": {
    "a": { "type": "bool", "default": false },
    "b": { "type": "bool", "default": false },
    "c": { "type": "bool", "default": false, "excludes": ["mode=evsm"] },
    "taps": { "type": "integer", "min": 1, "max": 6, "default": 1 },
    "mode": { "type": "enum", "values": ["hard", "pcf", "evsm"], "default": "hard" } },
  "constraints": [ { "when": "mode=pcf", "requires": ["taps!=1"] }, { "when": "a", "requires": ["b"] } ] }"#;

/// Templates that read axes in ways that a lexical search would not find.
const READERS: &[&str] = &[
    "{% include 'i.wgsl.jinja' %}",
    "{% set a = a|default(true) %}{% if a %}// 1\n{% endif %}",
    "{% with a = a %}// {{ a }}\n{% endwith %}",
    "{% include ('i.wgsl.jinja' if a else 'j.wgsl.jinja') %}",
    "{% macro f() %}{% if a %}// 1\n{% endif %}{% endmacro %}{% if b %}{{ f() }}{% endif %}",
    "{% from 'l.wgsl.jinja' import f %}{{ f() }}",
    "{% if a and b %}// 1\n{% endif %}",
    "{% if a %}// 1\n{% else %}// 1\n{% endif %}",
    "{% extends 'base.wgsl.jinja' %}{% block x %}// {{ taps }}\n{% endblock %}",
    "{% for i in range(taps) %}// {{ i }} {{ mode }}\n{% endfor %}",
    "{% filter replace('x', mode) %}// x\n{% endfilter %}",
    "{% if c %}{% if mode == 'hard' %}// {{ taps }}\n{% endif %}{% elif a or b %}// ab\n{% endif %}",
    "// {{ 'on' if a else mode }}\n",
    "{% set ns = namespace(n=0) %}{% if b %}{% set ns.n = taps %}{% endif %}// {{ ns.n }}\n",
];

fn readers(reader: &str) -> Fixture {
    let fragment = if reader.contains("extends") { "" } else { FRAGMENT };
    let main = format!("{reader}\n{fragment}");
    Fixture::sound(&[
        ("main.wgsl.jinja", &main),
        ("main.axes.json", AXES),
        ("i.wgsl.jinja", "{% if mode != 'hard' %}// {{ taps }}\n{% endif %}"),
        ("j.wgsl.jinja", "// {{ b }}\n"),
        ("l.wgsl.jinja", "{% macro f() %}{% if mode == 'evsm' %}// 1\n{% endif %}{% endmacro %}"),
        ("base.wgsl.jinja", "{% block x %}// {{ b }}\n{% endblock %}{% if c %}// c\n{% endif %}"),
    ])
}

/// All combinations of axis values that the constraints of a template allow.
fn configurations(fixture: &Fixture, template: &str) -> Vec<AxisValues> {
    let axes = fixture.set.axes(template).unwrap();
    let mut all = vec![AxisValues::new()];
    for axis in axes.iter() {
        all = all
            .into_iter()
            .flat_map(|values| {
                let domain = Domain::of(&axis.kind);
                (0..domain.count()).filter_map(move |at| domain.value(at)).map(move |value| {
                    let mut values = values.clone();
                    values.insert(axis.name.clone(), value);
                    values
                })
            })
            .collect();
    }
    all.retain(|values| axes.violated(values).next().is_none());
    all
}

/// Compares a check with rendering every combination: both must find the same modules with the same counts.
fn compare_with_exhaustive_rendering(fixture: &Fixture, template: &str) {
    let outcome = check(&fixture.set, &[Request::all(template, &[])], &Options::default());
    let report = &outcome.templates[0];
    let mut expected: BTreeMap<String, u128> = BTreeMap::new();
    let all = configurations(fixture, template);
    for values in &all {
        let values = template_values(&fixture.set, template, values);
        let text = render::render(&fixture.set, template, &values).unwrap().0.wgsl;
        *expected.entry(text).or_default() += 1;
    }
    let found: BTreeMap<String, u128> = report
        .variants
        .iter()
        .map(|each| (report.text(&fixture.set, each).unwrap(), each.configurations.number))
        .collect();
    assert_eq!(found, expected, "{template}");
    assert_eq!(report.configurations, Count { number: all.len() as u128, exact: true });
    assert_eq!(report.covered, report.configurations);
}

#[test]
fn lazy_forking_equals_exhaustive_rendering() {
    for reader in READERS {
        let fixture = readers(reader);
        compare_with_exhaustive_rendering(&fixture, "main.wgsl.jinja");
    }
}

#[test]
fn lazy_forking_equals_exhaustive_rendering_of_own_templates() {
    let fixture = Fixture::sound(umbragraph_shaders_templates::FILES);
    let names: Vec<&str> = fixture.set.names().collect();
    let mut compared = 0;
    for name in names {
        let counts = fixture.set.axes(name).unwrap().iter().map(|axis| axis.kind.count());
        let product = counts.fold(1, u64::saturating_mul);
        if product < 4096 {
            compare_with_exhaustive_rendering(&fixture, name);
            compared += 1;
        }
    }
    assert!(compared > 0);
}

#[test]
fn one_rendering_per_path() {
    let fixture = readers("{% if a %}{% if taps > 3 %}// 1\n{% endif %}{% endif %}");
    let report = &all(&fixture, &Options::default()).templates[0];
    assert_eq!((report.paths, report.variants.len()), (7, 2), "a off, and six taps with a on");
}

#[test]
fn thousands_of_values_are_all_proven() {
    let values: Vec<String> = (0..5000).map(|at| format!("\"v{at}\"")).collect();
    let axes = format!(
        r#"{{ "axes": {{ "n": {{ "type": "integer", "min": 0, "max": 4095, "default": 1 }},
             "e": {{ "type": "enum", "values": [{}], "default": "v0" }} }} }}"#,
        values.join(", ")
    );
    for (condition, paths) in [("n == 77", 4096), ("e == 'v7'", 5000)] {
        let main = format!("{{% if {condition} %}}const X = oops;{{% endif %}}\n{FRAGMENT}");
        let fixture = Fixture::sound(&[("main.wgsl.jinja", &main), ("main.axes.json", &axes)]);
        let outcome = all(&fixture, &Options::default());
        assert_eq!(outcome.templates[0].paths, paths);
        assert_eq!(outcome.templates[0].covered, outcome.templates[0].configurations);
        let diagnostics: Vec<_> = outcome.diagnostics.iter().collect();
        assert_eq!(diagnostics.len(), 1, "{:?}", fixture.lines(&outcome.diagnostics));
        assert_eq!(provocation(diagnostics[0]).len(), 1);
    }
}

#[test]
fn beyond_the_limits_is_an_error_and_no_axis_is_called_dead() {
    let values: Vec<String> = (0..20_000).map(|at| format!("\"v{at}\"")).collect();
    let switches: Vec<String> =
        (0..17).map(|at| format!("\"b{at:02}\": {{ \"type\": \"bool\", \"default\": false }}")).collect();
    let reads: String = (0..17).map(|at| format!("{{% if b{at:02} %}}{{% endif %}}")).collect();
    let cases = [
        (
            "\"n\": { \"type\": \"integer\", \"min\": 0, \"max\": 16384, \"default\": 1 }".to_owned(),
            "{% if n == 77 %}oops{% endif %}",
            3,
            "prove",
        ),
        (
            format!(
                "\"n\": {{ \"type\": \"enum\", \"values\": [{}], \"default\": \"v0\" }}",
                values.join(", ")
            ),
            "{% if n == 'v77' %}oops{% endif %}",
            2,
            "fewer values",
        ),
        (switches.join(", "), reads.as_str(), 1 << 16, "constraints"),
    ];
    for (axes, reader, covered, help) in property::part(cases, 2) {
        let main = format!("{reader}\n{FRAGMENT}");
        let axes = format!("{{ \"axes\": {{ {axes} }} }}");
        let fixture = Fixture::sound(&[("main.wgsl.jinja", &main), ("main.axes.json", &axes)]);
        let outcome = all(&fixture, &Options { report_dead: true, ..Options::default() });
        let report = &outcome.templates[0];
        assert_eq!(report.covered, Count { number: covered, exact: false });
        assert!(report.configurations.exact && report.configurations.number > covered);
        assert_eq!(report.dead_axes, Vec::<String>::new());
        let diagnostics: Vec<_> = outcome.diagnostics.iter().collect();
        assert_eq!(diagnostics.len(), 1, "{:?}", fixture.lines(&outcome.diagnostics));
        assert_eq!((diagnostics[0].code.id, diagnostics[0].severity), ("UG0552", Severity::Error));
        assert!(diagnostics[0].help.iter().any(|text| text.contains(help)), "{:?}", diagnostics[0].help);
    }
}

fn all(fixture: &Fixture, options: &Options<'_>) -> Permutations {
    check(&fixture.set, &[Request::all("main.wgsl.jinja", &TargetProfile::all())], options)
}

#[test]
fn axes_that_nothing_reads_cost_nothing() {
    let free: String =
        (0..34).map(|at| format!(", \"free{at}\": {{ \"type\": \"bool\", \"default\": false }}")).collect();
    let axes = AXES.replacen("} },\n  \"constraints\"", &format!("}}{free} }},\n  \"constraints\""), 1);
    let main = format!("{}\n{FRAGMENT}", READERS[11]);
    let fixture = Fixture::sound(&[("main.wgsl.jinja", &main), ("main.axes.json", &axes)]);
    let start = Instant::now();
    let report = &all(&fixture, &Options { threads: 1, ..Options::default() }).templates[0];
    assert!(
        report.configurations.exact && report.configurations.number > 10_u128.pow(10),
        "{}",
        report.configurations
    );
    assert_eq!(report.covered, report.configurations);
    assert!(report.variants.len() < 10 && start.elapsed() < Duration::from_secs(60));
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let fixture = readers(
        "{% if a %}const X = oops;\n{% endif %}{% if mode == 'pcf' %}const Y = {{ taps }}u + 1i;\n{% endif %}",
    );
    let outcome = |threads| {
        let outcome = all(&fixture, &Options { threads, report_dead: true, ..Options::default() });
        let reports = serde_json::to_string(&outcome.templates).unwrap();
        (fixture.lines(&outcome.diagnostics), reports)
    };
    let one = outcome(1);
    assert_eq!(one.0.len(), 2, "{:?}", one.0);
    for threads in [2, 5, 64] {
        assert_eq!(outcome(threads), one, "{threads} threads");
    }
}

#[test]
fn cancelled_check_ends_before_the_next_text() {
    let fixture = readers(READERS[9]);
    let cancelled = AtomicBool::new(false);
    let most = AtomicUsize::new(0);
    let stop = |_: usize, of: usize| {
        most.fetch_max(of, Ordering::Relaxed);
        cancelled.store(true, Ordering::Relaxed);
    };
    let options = Options { threads: 1, progress: &stop, cancelled: &cancelled, ..Options::default() };
    let outcome = all(&fixture, &options);
    assert_eq!((outcome.proven, outcome.templates.len()), (0, 0));
    assert_eq!(most.load(Ordering::Relaxed), 1, "the texts that were found");
    cancelled.store(false, Ordering::Relaxed);
    assert!(all(&fixture, &Options { threads: 1, ..Options::default() }).texts > 10);
}

#[test]
fn progress_reaches_every_text() {
    let fixture = readers(READERS[9]);
    let seen = std::sync::Mutex::new(BTreeSet::new());
    let note = |done: usize, of: usize| {
        seen.lock().unwrap().insert((done, of));
    };
    let outcome = all(&fixture, &Options { progress: &note, ..Options::default() });
    let seen = seen.into_inner().unwrap();
    // One proof may settle more texts than one.
    assert!(seen.iter().all(|(done, of)| done <= of && *of <= outcome.texts), "{seen:?}");
    assert!(seen.contains(&(outcome.texts, outcome.texts)), "{seen:?}");
}

#[test]
fn an_unused_axis_breaks_no_constraint_by_its_default() {
    let axes = r#"{ "axes": {
        "view": { "type": "enum", "values": ["width", "blockers"], "default": "width" },
        "filter": { "type": "enum", "values": ["hard", "pcss"], "default": "hard" },
        "lights": { "type": "bool", "default": false } },
        "constraints": [{ "when": "view=blockers", "requires": ["filter=pcss"] }] }"#;
    let main = "@fragment fn main() -> @location(0) vec4<f32> { return vec4<f32>(\
                {% if view == \"blockers\" %}1.0{% elif lights and filter == \"pcss\" %}0.5{% else %}0.0{% endif %}); }";
    let fixture = Fixture::sound(&[("main.wgsl.jinja", main), ("main.axes.json", axes)]);
    let chosen = values(&[("view", "blockers".into()), ("filter", "pcss".into())]);
    let profile = TargetProfile::webgpu();
    let module = compile(&fixture.set, "main.wgsl.jinja", &chosen, &profile).expect("a module");
    assert_eq!(module.axes, values(&[("view", "blockers".into())]), "the text does not depend on the filter");
    let one = Request::one(&fixture.set, "main.wgsl.jinja", &module.axes, &[profile]);
    let outcome = check(&fixture.set, &[one], &Options::default());
    assert_eq!(fixture.lines(&outcome.diagnostics), Vec::<String>::new());
    assert_eq!(outcome.proven, 1);
}

#[test]
fn a_request_narrows_the_space() {
    let fixture = readers(READERS[11]);
    let values: AxisValues = [("c".to_owned(), true.into())].into();
    let one = Request::one(&fixture.set, "main.wgsl.jinja", &values, &[TargetProfile::webgpu()]);
    let report = &check(&fixture.set, &[one], &Options::default()).templates[0];
    assert_eq!((report.variants.len(), report.configurations.number), (1, 1));
    let allowed = [("mode".to_owned(), vec!["pcf".into()]), ("taps".to_owned(), vec![1.into()])].into();
    let narrowed = Request { allowed, ..Request::all("main.wgsl.jinja", &[]) };
    let diagnostics = check(&fixture.set, &[narrowed], &Options::default()).diagnostics;
    assert_eq!(
        fixture.lines(&diagnostics),
        [
            "UG0516 main.axes.json:7:20 the constraints of \"main.wgsl.jinja\" leave no configuration with mode=pcf, taps=1"
        ]
    );
    let misspelt = Request {
        allowed: [("mdoe".to_owned(), vec!["pcf".into()])].into(),
        ..Request::all("main.wgsl.jinja", &[])
    };
    let diagnostics = check(&fixture.set, &[misspelt], &Options::default()).diagnostics;
    assert_eq!(fixture.lines(&diagnostics), ["UG0511 - \"main.wgsl.jinja\" has no axis \"mdoe\""]);
    let unknown =
        check(&fixture.set, &[Request::all("mian.wgsl.jinja", &[])], &Options::default()).diagnostics;
    assert_eq!(fixture.lines(&unknown), ["UG0500 - there is no template \"mian.wgsl.jinja\""]);
}

#[test]
fn sizes_and_names_of_variants_are_reported() {
    let fixture = readers("{% if a %}// 12345\n{% endif %}");
    let report = &all(&fixture, &Options::default()).templates[0];
    assert_eq!(report.bytes_of_values.len(), 1);
    assert_eq!((report.bytes_of_values[0].axis.as_str(), report.bytes_of_values[0].bytes), ("a", 9));
    assert_eq!(report.dead_axes, ["b", "c", "mode", "taps"]);
    let names: Vec<String> = report.variants.iter().map(|each| each.file_name("forward/main")).collect();
    assert!(names[0].starts_with("forward_main.a=false.") && names[0].ends_with(".wgsl"), "{names:?}");
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
}

/// A validator that rejects modules that contain a certain name. `None` makes it unavailable.
struct Names(Option<&'static str>);

impl Validator for Names {
    fn name(&self) -> &str {
        "names"
    }

    fn place(&self) -> Place {
        Place::Nowhere
    }

    fn judge(&self, wgsl: &str) -> Opinion {
        let Some(odd) = self.0 else { return Opinion::Unavailable("it is not there".to_owned()) };
        let found = wgsl.lines().zip(1..).find_map(|(line, at)| Some((at, line.find(odd)? + 1)));
        found.map_or(Opinion::Accepts, |place| Opinion::Rejects {
            message: "odd name".to_owned(),
            place: Some(place),
        })
    }
}

#[test]
fn another_validator_judges_texts_and_its_messages_are_mapped() {
    let fixture = readers("{% if a %}// 12345\n{% endif %}const ODD = 1;\n{% include 'i.wgsl.jinja' %}");
    let external: [&dyn Validator; 2] = [&Names(Some("ODD")), &Names(None)];
    let outcome = all(&fixture, &Options { external: &external, ..Options::default() });
    assert_eq!(
        fixture.lines(&outcome.diagnostics),
        ["UG0561 main.wgsl.jinja:2:18 names rejects this: odd name", "UG0560 - it is not there"]
    );
}

/// Parses the axis values in the message `provoked by a=true, taps=6` of a diagnostic.
fn provocation(diagnostic: &umbragraph_text::diagnostic::Diagnostic) -> AxisValues {
    let effect = diagnostic.related.iter().find_map(|related| related.message.split_once("provoked by "));
    let (_, list) = effect.expect("the diagnostic says what provokes it");
    let value = |text: &str| match (text.parse::<bool>(), text.parse::<i64>()) {
        (Ok(value), _) => value.into(),
        (_, Ok(value)) => value.into(),
        _ => text.into(),
    };
    list.split(", ")
        .filter_map(|pair| pair.split_once('='))
        .map(|(name, text)| (name.to_owned(), value(text)))
        .collect()
}

#[test]
fn a_provocation_is_sufficient_and_minimal() {
    let conditions = [
        "b and mode == 'pcf'",
        "taps == 5",
        "not b and mode != 'hard'",
        "(a and taps > 3) or mode == 'evsm'",
        "c or (b and taps == 2)",
    ];
    for condition in conditions {
        let fixture = readers(&format!(
            "// {{{{ a }}}} {{{{ mode }}}}\n{{% if {condition} %}}\nconst X = oops;\n{{% endif %}}"
        ));
        let diagnostic = all(&fixture, &Options::default()).diagnostics.into_iter().next().unwrap();
        let provoked = provocation(&diagnostic);
        let fails = |values: &AxisValues| {
            let values = template_values(&fixture.set, "main.wgsl.jinja", values);
            render::render(&fixture.set, "main.wgsl.jinja", &values).unwrap().0.wgsl.contains("oops")
        };
        let all = configurations(&fixture, "main.wgsl.jinja");
        let always_fails = |values: &AxisValues| {
            let agreeing =
                all.iter().filter(|each| values.iter().all(|(name, value)| each.get(name) == Some(value)));
            agreeing.clone().count() > 0 && agreeing.into_iter().all(fails)
        };
        assert!(always_fails(&provoked), "{condition}: {provoked:?}");
        for name in provoked.keys() {
            let mut fewer = provoked.clone();
            fewer.remove(name);
            assert!(!always_fails(&fewer), "{condition}: {name} of {provoked:?} is not needed");
        }
    }
}

#[test]
fn a_number_that_is_only_a_size_is_proven_by_its_ends() {
    let text = "const A = array<u32, {{ size }}>();\n@compute @workgroup_size(1) fn main() {}\n";
    let axes = |prove: &str| {
        format!(
            r#"{{ "axes": {{ "size": {{ "type": "integer", "min": 1, "max": 16385, "default": 32{prove} }} }} }}"#
        )
    };
    let checked = |axes: &str, allowed: &[i64]| {
        let fixture = Fixture::new(&[("a.wgsl.jinja", text), ("a.axes.json", axes)]);
        let mut request = Request::all("a.wgsl.jinja", &[TargetProfile::webgpu()]);
        if !allowed.is_empty() {
            request.allowed =
                [("size".to_owned(), allowed.iter().map(|at| AxisValue::Integer(*at)).collect())].into();
        }
        let outcome = check(&fixture.set, &[request], &Options::default());
        (outcome.templates[0].variants.len(), outcome.diagnostics.len() + fixture.diagnostics.len())
    };
    assert_eq!(checked(&axes(", \"prove\": \"ends\""), &[]), (3, 0));
    assert_eq!(checked(&axes(", \"prove\": \"ends\""), &[5, 6]), (2, 0));
    // Unsaid, the same is an error.
    assert_eq!(checked(&axes(""), &[]), (3, 1));
    assert_eq!(
        Fixture::new(&[("a.wgsl.jinja", text), ("a.axes.json", &axes(", \"prove\": \"some\""))])
            .diagnostics
            .len(),
        1
    );
}

#[test]
fn what_constraints_leave_beside_the_ends_is_proven_too() {
    let text = "const A = array<u32, {{ size }}>();\n{% if mode %}broken here{% endif %}\n@compute @workgroup_size(1) fn main() {}\n";
    for constraint in [
        r#"{ "when": "mode", "requires": ["size=64"] }"#,
        r#"{ "when": "mode", "excludes": ["size=1", "size=32", "size=4096"] }"#,
    ] {
        let axes = format!(
            r#"{{ "axes": {{ "mode": {{ "type": "bool", "default": false }},
                "size": {{ "type": "integer", "min": 1, "max": 4096, "default": 32, "prove": "ends" }} }},
                "constraints": [{constraint}] }}"#
        );
        let fixture = Fixture::sound(&[("a.wgsl.jinja", text), ("a.axes.json", &axes)]);
        let request = Request::all("a.wgsl.jinja", &[TargetProfile::webgpu()]);
        let outcome = check(&fixture.set, &[request], &Options::default());
        assert!(outcome.diagnostics.has_errors(), "{constraint}");
    }
}

#[test]
fn variants_agree_on_bindings_unless_an_axis_picks_the_layout() {
    let main = "{% if a %}@group(0) @binding(0) var image: texture_2d<f32>;\n\
                {% else %}@group(0) @binding(0) var image: texture_2d<u32>;\n{% endif %}\
                @fragment fn main() -> @location(0) vec4<f32> {\
                 return vec4<f32>(f32(textureLoad(image, vec2<i32>(), 0).x)); }\n";
    let conflicts = |own: &str| {
        let axes = format!(r#"{{ "axes": {{ "a": {{ "type": "bool", "default": false{own} }} }} }}"#);
        let fixture = Fixture::sound(&[("main.wgsl.jinja", main), ("main.axes.json", &axes)]);
        // Each configuration is a request of its own, as a check of a pipeline makes them.
        let one = |a: bool| {
            Request::one(
                &fixture.set,
                "main.wgsl.jinja",
                &values(&[("a", a.into())]),
                &[TargetProfile::webgpu()],
            )
        };
        let found = check(&fixture.set, &[one(false), one(true)], &Options::default()).diagnostics;
        fixture.lines(&found)
    };
    assert_eq!(
        conflicts(""),
        ["UG0540 main.wgsl.jinja:1:37 two variants of \"main.wgsl.jinja\" disagree: \
          \"image\" is a texture_2d<u32> in one and a texture_2d<f32> in the other"]
    );
    assert_eq!(conflicts(r#", "own_layout": true"#), Vec::<String>::new());
}

#[test]
fn variants_that_read_no_layout_axis_agree_with_each_layout() {
    // Without maps nothing depends on how they are stored, so that both layouts stand beside the variant without maps.
    let main = "{% if maps %}{% if packed %}@group(0) @binding(0) var image: texture_2d<u32>;\n\
                {% else %}@group(0) @binding(0) var image: texture_2d<f32>;\n{% endif %}{% endif %}\
                @group(0) @binding(1) var other: texture_2d<{{ 'u32' if not maps and wide else 'f32' }}>;\n\
                @fragment fn main() -> @location(0) vec4<f32> {\
                 return vec4<f32>(f32(textureLoad(other, vec2<i32>(), 0).x)\
                 {% if maps %} + f32(textureLoad(image, vec2<i32>(), 0).x){% endif %}); }\n";
    let lines = |wide: bool| {
        let axes = format!(
            r#"{{ "axes": {{ "maps": {{ "type": "bool", "default": true }},
                "wide": {{ "type": "bool", "default": {wide} }},
                "packed": {{ "type": "bool", "default": false, "own_layout": true }} }} }}"#
        );
        let fixture = Fixture::sound(&[("main.wgsl.jinja", main), ("main.axes.json", &axes)]);
        let mut request = Request::all("main.wgsl.jinja", &[TargetProfile::webgpu()]);
        request.allowed.insert("wide".to_owned(), vec![wide.into()]);
        fixture.lines(&check(&fixture.set, &[request], &Options::default()).diagnostics)
    };
    assert_eq!(lines(false), Vec::<String>::new());
    assert_eq!(
        lines(true),
        ["UG0540 main.wgsl.jinja:3:49 two variants of \"main.wgsl.jinja\" disagree: \
          \"other\" is a texture_2d<u32> in one and a texture_2d<f32> in the other"]
    );
}

#[test]
fn a_fault_in_one_of_many_texts_is_found() {
    let axes = r#"{ "axes": { "n": { "type": "integer", "min": 0, "max": 599, "default": 0 } } }"#;
    for broken in [0, 1, 333, 599] {
        let main = format!(
            "const N = {{{{ 'oops' if n == {broken} else n }}}};\n@compute @workgroup_size(1) fn main() {{}}\n"
        );
        let fixture = Fixture::sound(&[("main.wgsl.jinja", &main), ("main.axes.json", axes)]);
        let request = Request::all("main.wgsl.jinja", &[TargetProfile::webgpu()]);
        let found = check(&fixture.set, &[request], &Options::default());
        assert_eq!((found.texts, fixture.lines(&found.diagnostics).len()), (600, 1), "{broken}");
    }
}

#[test]
fn what_lies_within_a_block_may_differ() {
    let main = "struct Block { {% for i in range(n) %}m{{ i }}: vec4<f32>, {% endfor %} }\n\
                @group(0) @binding(0) var<uniform> block: Block;\n\
                @fragment fn main() -> @location(0) vec4<f32> { return block.m0; }\n";
    let axes = r#"{ "axes": { "n": { "type": "integer", "min": 1, "max": 3, "default": 1 } } }"#;
    let fixture = Fixture::sound(&[("main.wgsl.jinja", main), ("main.axes.json", axes)]);
    let request = Request::all("main.wgsl.jinja", &[TargetProfile::webgpu()]);
    let outcome = check(&fixture.set, &[request], &Options::default());
    assert_eq!(fixture.lines(&outcome.diagnostics), Vec::<String>::new());
    // The layout of all three is for the largest.
    let [report] = outcome.templates.as_slice() else { panic!("{:?}", outcome.templates) };
    let sizes: Vec<_> = report.interface.iter().map(|binding| binding.entry.ty).collect();
    assert!(matches!(
        sizes.as_slice(),
        [wgpu_types::BindingType::Buffer { min_binding_size: Some(size), .. }] if size.get() == 48
    ));
}
