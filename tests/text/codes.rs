//! Every diagnostic code is shown by a test: in an expected output, or in a test that is named here.

use std::collections::BTreeSet;

use crate::common::{With, check_with, files, root};

/// Folders of expected outputs.
const EXPECTED: [&str; 2] = ["tests/broken/expected", "graph/shaders/src/tests/broken"];

/// Codes that no document alone can bring about, by the file of the tests that do.
const ELSEWHERE: &[(&str, &[&str])] = &[
    ("tests/device/engine/adopter.rs", &["UG0623", "UG0624"]),
    ("tests/device/engine/devices.rs", &["UG0820", "UG0821"]),
    ("tests/device/live_parameters.rs", &["UG0230"]),
    ("cli/tests/command/status.rs", &["UG0004", "UG0005", "UG0801", "UG0808"]),
    ("cli/tests/command/diff.rs", &["UG0009"]),
    ("cli/tests/command/environment.rs", &["UG0815"]),
    ("cli/tests/command/imports.rs", &["UG0829"]),
    ("cli/tests/command/input.rs", &["UG0010"]),
    ("cli/tests/command/render.rs", &["UG0809", "UG0810", "UG0811"]),
    ("cli/tests/command/score.rs", &["UG0812", "UG0813"]),
    ("cli/tests/command/shader_tests.rs", &["UG0823", "UG0824", "UG0825"]),
    ("cli/tests/command/tune.rs", &["UG0814"]),
    ("cli/tests/command/view.rs", &["UG0816"]),
    ("cli/tests/command/check/mod.rs", &["UG0220"]),
    ("cli/tests/command/permutations/budgets.rs", &["UG0826", "UG0827", "UG0828"]),
    ("cli/tests/command/permutations/configurations.rs", &["UG0553"]),
    ("cli/tests/command/permutations/lock.rs", &["UG0818", "UG0819"]),
    ("cli/tests/command/permutations/shards.rs", &["UG0822"]),
    ("cli/tests/command/permutations/mod.rs", &["UG0560", "UG0561", "UG0562"]),
    ("cli/tests/command/why.rs", &["UG0008"]),
    ("graph/shaders/src/tests/compiling.rs", &["UG0513"]),
    ("tests/pictures/learn.rs", &["UG0219", "UG0609"]),
    ("graph/shaders/src/module/wgsl.rs", &["UG0523"]),
    ("graph/shaders/src/tests/exploring.rs", &["UG0511"]),
    (
        "scene/tests/scenes/bad_input.rs",
        &["UG0700", "UG0701", "UG0702", "UG0703", "UG0704", "UG0706", "UG0707", "UG0722", "UG0725"],
    ),
    (
        "scene/tests/scenes/bad_meshes.rs",
        &[
            "UG0705", "UG0708", "UG0709", "UG0710", "UG0711", "UG0712", "UG0713", "UG0720", "UG0721",
            "UG0724", "UG0726",
        ],
    ),
    ("scene/tests/scenes/bad_nodes.rs", &["UG0714", "UG0716", "UG0717", "UG0718", "UG0719"]),
    ("scene/tests/scenes/hostile_input.rs", &["UG0715"]),
    ("scene/tests/scenes/loading.rs", &["UG0723"]),
    ("tests/device/executing/hosts.rs", &["UG0803", "UG0805"]),
    ("tests/device/executing/plans.rs", &["UG0804"]),
    ("tests/device/executing/steady.rs", &["UG0806", "UG0807"]),
    ("tests/device/executor.rs", &["UG0608", "UG0802"]),
    ("tests/text/graph_orders.rs", &["UG0408"]),
    ("tests/pictures/lights.rs", &["UG0620", "UG0621", "UG0622"]),
    ("tests/text/language.rs", &["UG0210"]),
    ("tests/text/systems.rs", &["UG0213"]),
    ("tests/text/session/bad_input.rs", &["UG0011"]),
    ("tests/text/hopeless.rs", &["UG0002", "UG0003"]),
    ("tests/text/codes.rs", &["UG0507", "UG0524", "UG0606"]),
];

/// The codes in a text.
fn codes_in(text: &str) -> BTreeSet<String> {
    let starts = text.match_indices("UG").map(|(at, _)| at);
    let candidates = starts.filter_map(|at| text.get(at..at + 6));
    candidates.filter(|code| code[2..].bytes().all(|byte| byte.is_ascii_digit())).map(str::to_owned).collect()
}

#[test]
fn own_templates_provoke_codes_that_documents_cannot() {
    let pass = |shader: &str| {
        format!(
            r#"{{ "format": 1, "name": "one", "geometry": {{ "scene": {{ "vertex": {{ "position": "float32x3" }}, "variants": ["alpha_masked"] }} }},
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{ "eye": {{ "camera": {{ "to": "&eye" }} }}, "draw": {{ {shader} }} }} }}"#
        )
    };
    let fill = pass(r#""fullscreen": { "shader": "own.jinja", "color": [{ "to": "&target" }] }"#);
    let draw = pass(
        r#""draw": { "shader": "own.wgsl.jinja", "geometry": "scene", "views": "&eye", "mesh_filter": "opaque", "color": [{ "to": "&target" }] }"#,
    );
    let found = |text: &str, templates: &[(&str, &str)]| {
        let outcome = check_with("one.json", text, &With { templates, ..With::default() });
        assert!(outcome.diagnostics.iter().all(|diagnostic| diagnostic.help.is_some()), "{}", outcome.text());
        outcome.codes()
    };
    let vertex = "@vertex fn vertex() -> @builtin(position) vec4<f32> { return vec4<f32>(); }\n";
    assert!(found(&fill, &[("own.jinja", vertex), ("own.jinja", vertex)]).contains(&"UG0507"));
    let many: String = (0..9_000).map(|at| format!("const C{at} = 1;\n")).collect();
    assert!(found(&fill, &[("own.jinja", &many)]).contains(&"UG0524"));
    let varying = "@group(0) @binding(0) var<uniform> tint: {% if alpha_masked %}vec4<f32>{% else %}vec2<f32>{% endif %};\n\
        @vertex fn vertex(@location(0) position: vec3<f32>) -> @builtin(position) vec4<f32> { return vec4<f32>(position, tint.x); }\n\
        @fragment fn fragment() -> @location(0) vec4<f32> { return vec4<f32>(tint.x); }\n";
    let axes = r#"{ "axes": { "alpha_masked": { "type": "bool", "default": false } } }"#;
    let codes = found(&draw, &[("own.wgsl.jinja", varying), ("own.axes.json", axes)]);
    assert!(codes.contains(&"UG0606"), "{codes:?}");
}

#[test]
fn every_code_is_shown_by_a_test() {
    let commands = std::fs::read_to_string(root().join("cli/src/codes.rs")).unwrap();
    let mut all: BTreeSet<String> = umbragraph::codes().iter().map(|code| code.id.to_owned()).collect();
    all.append(&mut codes_in(&commands));
    let mut shown = BTreeSet::new();
    for folder in EXPECTED {
        let mut found = Vec::new();
        files(&root().join(folder), &mut found);
        for path in found {
            shown.extend(codes_in(&std::fs::read_to_string(path).unwrap()));
        }
    }
    for (file, codes) in ELSEWHERE {
        let text =
            std::fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        for id in *codes {
            assert!(all.contains(*id), "{id} is no code");
            assert!(text.contains(id), "{file} does not mention {id}");
            assert!(!shown.contains(*id), "{id} has an expected output: take it out of this table");
        }
        shown.extend(codes.iter().map(|code| (*code).to_owned()));
    }
    let missing: Vec<_> = all.difference(&shown).collect();
    assert!(missing.is_empty(), "{} of {} codes are shown by no test: {missing:?}", missing.len(), all.len());
}
