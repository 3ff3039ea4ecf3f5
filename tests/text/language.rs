//! The pipeline language: subgraphs, loops, several files.

use crate::common::check;
use std::path::Path;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, render};
use umbragraph::low_level::compose::{self, Memory};
use umbragraph::low_level::document;
use umbragraph::low_level::source::{FileId, Sources};
use umbragraph::wgpu_types::TextureFormat;

const SHOW: &str = r#""shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" }"#;

fn subgraph(with: &str) -> String {
    format!(
        r#"{{ "format": 1, "name": "test",
  "subgraphs": {{ "soften": {{
      "inputs": {{ "image": "what is softened" }},
      "parameters": {{ "divisor": {{ "type": "u32", "default": 2, "min": 1, "max": 8 }} }},
      "resources": {{ "small": {{ "texture": {{ "format": "rgba8unorm", "size": "=image / divisor" }} }} }},
      "passes": {{
        "down": {{ "fullscreen": {{ {SHOW}, "bind": {{ "source": "&image" }}, "color": [{{ "to": "&small" }}] }} }},
        "up": {{ "fullscreen": {{ {SHOW}, "bind": {{ "source": "&small" }}, "color": [{{ "to": "&image", "blend": "add" }}] }} }} }} }} }},
  "resources": {{
    "color": {{ "texture": {{ "format": "rgba8unorm", "size": [64, 32] }} }},
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{
    "show": {{ "fullscreen": {{ {SHOW}, "bind": {{ "source": "&color" }}, "color": [{{ "to": "&target" }}] }} }},
    "soft": {{ "use": "soften", "with": {with} }},
    "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&color" }}] }} }} }} }}"#
    )
}

#[test]
fn a_subgraph_sees_its_inputs_and_prefixes_its_own_names() {
    let outcome = check(&subgraph(r#"{ "image": "&color@fill", "divisor": "=2 + 2" }"#));
    assert_eq!(outcome.order(), ["fill", "soft.down", "soft.up", "show"]);
    let small = outcome.plan().resources["soft.small"].size.unwrap();
    assert_eq!((small.width, small.height), (16, 8));
}

#[test]
fn format_follows_from_a_parameter_of_each_use() {
    let text = subgraph(r#"{ "image": "&color@fill", "precise": true }"#)
        .replace(
            r#""small": { "texture": { "format": "rgba8unorm""#,
            r#""small": { "texture": { "format": "=small_format""#,
        )
        .replace(
            r#""parameters": {"#,
            r#""derived": { "small_format": "=precise ? 'rgba16float' : 'rgba8unorm'" },
      "parameters": { "precise": { "type": "bool", "default": false },"#,
        )
        .replace(
            r#""fill": {"#,
            r#""again": { "use": "soften", "with": { "image": "&color@soft" } }, "fill": {"#,
        );
    let outcome = check(&text);
    let format = |name: &str| outcome.plan().resources[name].format;
    assert_eq!(format("soft.small"), Some(TextureFormat::Rgba16Float));
    assert_eq!(format("again.small"), Some(TextureFormat::Rgba8Unorm));
}

#[test]
fn a_subgraph_used_wrongly_is_told_so() {
    assert_eq!(check(&subgraph(r#"{ "imgae": "color" }"#)).codes(), ["UG0102"]);
    assert_eq!(check(&subgraph("{}")).codes(), ["UG0106"]);
    assert_eq!(check(&subgraph(r#"{ "image": "&color@fill", "divisor": 9 }"#)).codes(), ["UG0204"]);
    let cycle = subgraph(r#"{ "image": "&color" }"#);
    assert_eq!(check(&cycle).codes(), ["UG0403"], "without a version, down waits for up");
    let itself = subgraph(r#"{ "image": "&color@fill" }"#).replace(
        "\"down\": {",
        "\"again\": { \"use\": \"soften\", \"with\": { \"image\": \"&small\" } }, \"down\": {",
    );
    assert!(check(&itself).codes().contains(&"UG0212"));
}

#[test]
fn a_disabled_subgraph_or_loop_may_still_be_waited_for() {
    let text = subgraph(r#"{ "image": "&color@fill" }, "when": false"#)
        .replace("\"show\": {", "\"show\": { \"after\": [\"soft\"],");
    assert_eq!(check(&text).order(), ["fill", "show"]);
}

/// Two uses of one subgraph that draws twice to what it is given, with further members of each use.
fn two_uses(first: &str, second: &str) -> String {
    format!(
        r#"{{ "format": 1, "name": "test",
  "subgraphs": {{ "strokes": {{
      "inputs": {{ "picture": "what is drawn to" }},
      "passes": {{
        "broad": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&picture", "blend": "add" }}] }} }},
        "fine": {{ "after": ["broad"], "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&picture", "blend": "add" }}] }} }} }} }} }},
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{
    "clear": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }},
    "u": {{ "use": "strokes", "with": {{ "picture": "&target" }}{first} }},
    "v": {{ "use": "strokes", "with": {{ "picture": "&target" }}{second} }} }} }}"#
    )
}

#[test]
fn a_use_of_a_subgraph_waits_for_passes_and_for_other_uses() {
    let behind = r#", "after": ["clear"]"#;
    let outcome = check(&two_uses(behind, r#", "after": ["u"]"#));
    assert_eq!(outcome.order(), ["clear", "u.broad", "u.fine", "v.broad", "v.fine"]);
    let reversed = check(&two_uses(r#", "after": ["v"]"#, behind));
    assert_eq!(reversed.order(), ["clear", "v.broad", "v.fine", "u.broad", "u.fine"]);
    let one = check(&two_uses(behind, r#", "after": ["u.fine"]"#));
    assert_eq!(one.order(), ["clear", "u.broad", "u.fine", "v.broad", "v.fine"]);
    let unordered = check(&two_uses(behind, behind));
    assert_eq!(unordered.codes(), ["UG0402"]);
    assert!(unordered.text().contains(r#"add "after": ["u"] to "v", or"#), "{}", unordered.text());
    let cycle = check(&two_uses(r#", "after": ["v"]"#, r#", "after": ["u"]"#));
    assert_eq!(cycle.codes(), ["UG0403"]);
}

#[test]
fn rounds_of_uses_wait_too_and_are_waited_for() {
    let rounds = r#", "for_each": { "round": 2 }, "after": ["clear", "=round == 0 ? 'clear' : 'u.0'"]"#;
    let whole = check(&two_uses(rounds, r#", "after": ["u"]"#));
    let order = ["clear", "u.0.broad", "u.0.fine", "u.1.broad", "u.1.fine", "v.broad", "v.fine"];
    assert_eq!(whole.order(), order);
    assert_eq!(check(&two_uses(rounds, r#", "after": ["u.1.fine"]"#)).order(), order);
}

#[test]
fn order_inside_of_a_subgraph_is_asked_for_inside() {
    let text =
        two_uses(r#", "after": ["clear"]"#, r#", "after": ["u"]"#).replace(r#""after": ["broad"],"#, "");
    let outcome = check(&text);
    assert_eq!(outcome.codes(), ["UG0402"]);
    assert!(outcome.text().contains(r#"add "after": ["broad"] to "fine" in "u", or"#), "{}", outcome.text());
}

#[test]
fn a_use_that_waits_for_what_is_not_there_is_told_so() {
    let unknown = |second: &str| check(&two_uses(r#", "after": ["clear"]"#, second));
    for (wrong, suggested) in [("claer", "clear"), ("u.fien", "u.fine"), ("w", "")] {
        let outcome = unknown(&format!(r#", "after": ["u", "{wrong}"]"#));
        assert_eq!(outcome.codes(), ["UG0207"], "{wrong}");
        let suggested = format!("did you mean \"{suggested}\"?");
        assert!(wrong == "w" || outcome.text().contains(&suggested), "{}", outcome.text());
    }
    let rounds = unknown(r#", "for_each": { "round": 3 }, "after": ["u", "nothing"]"#);
    assert_eq!(rounds.codes().iter().filter(|code| **code == "UG0207").count(), 1, "{}", rounds.text());
}

#[test]
fn a_side_effect_of_a_use_keeps_all_of_its_passes() {
    let text = |member: &str| {
        two_uses("", member)
            .replacen(r#", "blend": "add""#, "", 1)
            .replace(r#""u": { "use": "strokes", "with": { "picture": "&target" } },"#, "")
            .replace(
                r#""resources": {"#,
                r#""resources": { "unread": { "texture": { "format": "rgba8unorm", "size": [4, 4] } }, "#,
            )
            .replace(
                r#""v": { "use": "strokes", "with": { "picture": "&target" }"#,
                r#""v": { "use": "strokes", "with": { "picture": "&unread" }"#,
            )
    };
    assert_eq!(check(&text("")).order(), ["clear"]);
    assert_eq!(check(&text(r#", "side_effect": true"#)).order(), ["clear", "v.broad", "v.fine"]);
}

#[test]
fn too_many_pairs_in_an_order_are_a_diagnostic() {
    let pass = r#"{ "for_each": { "round": 1200 }, "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target", "blend": "add" }] } }"#;
    let text = two_uses("", "");
    let begin = text.find(r#""u": {"#).unwrap();
    let passes = format!(r#""u": {pass}, "v": {} }} }}"#, pass.replacen('{', r#"{ "after": ["u"],"#, 1));
    let outcome = check(&format!("{}{passes}", &text[..begin]));
    assert!(outcome.codes().contains(&"UG0211"), "{}", outcome.text());
}

#[test]
fn subgraphs_that_use_themselves_end_at_once() {
    let text = r#"{ "format": 1, "name": "bomb", "subgraphs": { "a": { "passes": { "x": { "for_each": { "i": 4096 }, "use": "a" } } } },
        "passes": { "p": { "use": "a" } } }"#;
    assert_eq!(check(text).codes()[0], "UG0212");
    let nested: Vec<String> = (0..10)
        .map(|at| {
            format!(
                r#""s{at}": {{ "passes": {{ "x": {{ "for_each": {{ "i": 100 }}, "use": "s{}" }} }} }}"#,
                at + 1
            )
        })
        .chain([r#""s10": { "passes": {} }"#.to_owned()])
        .collect();
    let text = format!(
        r#"{{ "format": 1, "name": "bomb", "subgraphs": {{ {} }}, "passes": {{ "p": {{ "use": "s0" }} }} }}"#,
        nested.join(",")
    );
    assert!(check(&text).codes().contains(&"UG0211"));
}

#[test]
fn an_error_in_a_subgraph_is_reported_once_with_its_uses() {
    let text = subgraph(r#"{ "image": "&color@fill" }"#)
        .replace("\"bind\": { \"source\": \"&small\" }", "\"bind\": { \"source\": \"&smal\" }");
    let text = text.replace(
        "\"fill\": {",
        "\"more\": { \"use\": \"soften\", \"with\": { \"image\": \"&color@fill\" } }, \"fill\": {",
    );
    let outcome = check(&text);
    assert_eq!(outcome.codes(), ["UG0301"], "{}", outcome.text());
    assert!(outcome.text().contains("used here"));
}

#[test]
fn a_size_inside_a_subgraph_tells_where_it_is_used() {
    let outcome = check(&subgraph(r#"{ "image": "&color@fill" }"#).replace("\"=image / divisor\"", "[0, 8]"));
    assert_eq!(outcome.codes(), ["UG0321"], "{}", outcome.text());
    assert!(outcome.text().contains("used here"), "{}", outcome.text());
}

#[test]
fn a_loop_makes_a_pass_for_each_round() {
    let text = format!(
        r#"{{ "format": 1, "name": "test",
  "parameters": {{ "levels": {{ "type": "u32", "default": 3 }} }},
  "resources": {{
    "chain": {{ "texture": {{ "format": "rgba8unorm", "size": [64, 64], "mips": "=levels + 1" }} }},
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{
    "show": {{ "after": ["down"], "fullscreen": {{ {SHOW}, "bind": {{ "source": {{ "texture": {{ "name": "=&chain@down[levels - 1]", "mip": "=levels" }} }} }}, "color": [{{ "to": "&target" }}] }} }},
    "down": {{ "for_each": {{ "level": "=levels" }}, "fullscreen": {{ {SHOW},
      "bind": {{ "source": {{ "texture": {{ "name": "&chain", "mip": "=level" }} }} }}, "color": [{{ "to": "&chain", "mip": "=level + 1" }}] }} }},
    "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&chain", "mip": 0 }}] }} }} }} }}"#
    );
    assert_eq!(check(&text).order(), ["fill", "down.0", "down.1", "down.2", "show"]);
    for rounds in ["1e9", "-1", "1.5", "true"] {
        let broken = text.replace("\"level\": \"=levels\"", &format!("\"level\": \"={rounds}\""));
        assert_eq!(check(&broken).codes(), ["UG0211"], "{rounds}");
    }
}

/// Composes files; the first is the pipeline. Returns the document and the diagnostics as text.
fn composed(files: &[(&str, &str)]) -> (Option<serde_json::Value>, String) {
    let mut memory =
        Memory(files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect());
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let file = sources.add(files[0].0, files[0].1);
    let composed = compose::compose(file, Path::new(files[0].0), &mut memory, &mut sources, &mut diagnostics);
    (composed.map(|composed| composed.document.root.to_json()), render::human_all(&diagnostics, &sources))
}

#[test]
fn extends_merges_objects_replaces_others_deletes_with_null() {
    let (document, diagnostics) = composed(&[
        (
            "a/top.json",
            r#"{ "extends": "../base.json", "parameters": { "x": { "default": 2 }, "y": null }, "list": [3] }"#,
        ),
        (
            "base.json",
            r#"{ "parameters": { "x": { "type": "u32", "default": 1 }, "y": { "default": 0 } }, "list": [1, 2] }"#,
        ),
    ]);
    assert_eq!(diagnostics, "");
    assert_eq!(
        document.unwrap(),
        serde_json::json!({ "parameters": { "x": { "type": "u32", "default": 2 } }, "list": [3] })
    );
}

#[test]
fn extending_nothing_changes_nothing() {
    let text = r#"{ "name": "x", "passes": { "a": { "b": [1, { "c": true }] } } }"#;
    let (document, diagnostics) = composed(&[("a.json", text)]);
    assert_eq!(diagnostics, "");
    assert_eq!(document.unwrap(), serde_json::from_str::<serde_json::Value>(text).unwrap());
}

#[test]
fn cyclic_and_missing_files_are_diagnostics_at_the_path() {
    let (document, diagnostics) =
        composed(&[("a.json", r#"{ "extends": "b.json" }"#), ("b.json", r#"{ "include": ["a.json"] }"#)]);
    assert!(document.is_none());
    assert!(diagnostics.contains("UG0007") && diagnostics.contains("b.json:1:15"), "{diagnostics}");
    let (_, diagnostics) = composed(&[("a.json", r#"{ "extends": "gone.json" }"#)]);
    assert!(diagnostics.contains("UG0001") && diagnostics.contains("a.json:1:14"), "{diagnostics}");
    let (_, diagnostics) =
        composed(&[("a.json", r#"{ "extends": "gone.json", "x": null, "y": { "z": null } }"#)]);
    assert!(diagnostics.contains("UG0001") && !diagnostics.contains("UG0109"), "{diagnostics}");
    let base = ("b.json", r#"{ "x": 1 }"#);
    let (_, diagnostics) = composed(&[("a.json", r#"{ "extend": "b.json", "x": null }"#), base]);
    assert!(diagnostics.contains("UG0102") && !diagnostics.contains("UG0109"), "{diagnostics}");
    let (_, diagnostics) = composed(&[("a.json", r#"{ "extends": "b.json", "x": null }"#), ("b.json", "{}")]);
    assert!(diagnostics.contains("UG0109"), "{diagnostics}");
}

#[test]
fn a_base_of_several_bases_is_laid_once_below_them() {
    let (document, diagnostics) = composed(&[
        ("a.json", r#"{ "extends": ["b.json", "c.json"], "parameters": { "x": 4 } }"#),
        ("b.json", r#"{ "extends": "base.json", "parameters": { "y": 2, "z": null } }"#),
        ("c.json", r#"{ "extends": "base.json", "parameters": { "w": 3 } }"#),
        ("base.json", r#"{ "parameters": { "x": 1, "y": 1, "z": 1 } }"#),
    ]);
    let parameters = document.map(|document| document["parameters"].clone());
    assert_eq!(parameters, Some(serde_json::json!({ "x": 4, "y": 2, "w": 3 })), "{diagnostics}");
    assert_eq!(diagnostics, "");
}

#[test]
fn an_include_adds_and_never_changes() {
    let files = |section: &str| {
        composed(&[
            ("a.json", r#"{ "include": "parts.json", "parameters": { "x": 1 } }"#),
            ("parts.json", &format!(r#"{{ "parameters": {{ "{section}": 2 }} }}"#)),
        ])
    };
    assert_eq!(files("y").0.unwrap()["parameters"], serde_json::json!({ "x": 1, "y": 2 }));
    assert!(files("x").1.contains("UG0103"));
}

#[test]
fn an_extension_puts_its_passes_at_a_named_point() {
    let base = r#"{ "extension_points": { "late": { "after": ["shade"], "before": ["show"] } },
        "passes": { "shade": {}, "show": {} } }"#;
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let mut parse = |name: &str, text: &str| {
        let file = sources.add(name, text);
        document::parse(&sources, file).valid().unwrap().root
    };
    let mut document = parse("base.json", base);
    let extension = parse(
        "more.json",
        r#"{ "inserts": { "late": { "grain": {}, "glow": {} } }, "parameters": { "amount": {} } }"#,
    );
    let wrong = parse("wrong.json", r#"{ "inserts": { "lat": { "x": {} } } }"#);
    compose::insert(&mut document, extension, &mut diagnostics);
    assert!(diagnostics.is_empty());
    let json = document.to_json();
    assert_eq!(json["passes"]["grain"]["after"], serde_json::json!(["shade"]));
    assert_eq!(json["passes"]["glow"]["after"], serde_json::json!(["shade", "grain"]));
    assert_eq!(json["passes"]["show"]["after"], serde_json::json!(["grain", "glow"]));
    assert!(json["parameters"]["amount"].is_object());
    compose::insert(&mut document, wrong, &mut diagnostics);
    assert_eq!(diagnostics.iter().next().unwrap().code.id, "UG0210");
}

/// Files in memory, and which of them were read.
struct Counted(Memory, Vec<String>);

impl compose::Files for Counted {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        self.1.push(path.to_string_lossy().into_owned());
        self.0.read(path, sources)
    }
}

#[test]
fn a_subgraph_file_is_read_once_however_often_it_is_used() {
    let top = r#"{ "extends": "parts/base.json", "passes": { "a": { "use": "parts/blur.json" }, "gone": { "use": "other.json" } } }"#;
    let base = r#"{ "format": 1, "subgraphs": { "own": { "passes": { "in": { "use": "./blur.json" } } } },
        "passes": { "b": { "use": "deep/half.json" }, "gone": { "use": "nowhere.json" }, "c": { "use": "own" } },
        "shared_settings": { "blurred": { "use": "shared.json" } } }"#;
    let half = r#"{ "passes": { "x": { "use": "../blur.json" }, "y": { "use": "../blur.json" } } }"#;
    let extension =
        r#"{ "inserts": { "point": { "d": { "use": "parts/blur.json" }, "e": { "use": "new.json" } } } }"#;
    let one = r#"{ "passes": {} }"#;
    let files = [
        ("top.json", top),
        ("parts/base.json", base),
        ("parts/blur.json", one),
        ("parts/deep/half.json", half),
        ("parts/shared.json", one),
        ("other.json", one),
        ("new.json", one),
        ("extension.json", extension),
    ];
    let memory = files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect();
    let mut counted = Counted(Memory(memory), Vec::new());
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let file = sources.add("top.json", top);
    let composed =
        compose::compose(file, Path::new("top.json"), &mut counted, &mut sources, &mut diagnostics);
    let mut composed = composed.unwrap_or_else(|| panic!("{}", render::human_all(&diagnostics, &sources)));
    assert_eq!(
        counted.1,
        ["parts/base.json", "parts/deep/half.json", "other.json", "parts/blur.json", "parts/shared.json"]
    );
    let file = sources.add("extension.json", extension);
    let path = Path::new("extension.json");
    let extension = compose::compose(file, path, &mut counted, &mut sources, &mut diagnostics).unwrap();
    composed.insert(extension, &mut diagnostics);
    let text = render::human_all(&diagnostics, &sources);
    assert!(text.contains("UG0210") && diagnostics.len() == 1, "only the extension point is missing: {text}");
    let document = composed.document.root.to_json();
    let names: Vec<&String> = document["subgraphs"].as_object().unwrap().keys().collect();
    assert_eq!(
        names,
        ["own", "parts/deep/half.json", "other.json", "parts/blur.json", "parts/shared.json", "new.json"]
    );
    let used = |pointer: &str| document.pointer(pointer).unwrap().as_str().unwrap().to_owned();
    assert_eq!(used("/passes/gone/use"), "other.json");
    assert_eq!(used("/subgraphs/own/passes/in/use"), "parts/blur.json");
    assert_eq!(used("/subgraphs/parts~1deep~1half.json/passes/y/use"), "parts/blur.json");
}

/// Takes several files, of which the first is the pipeline, all the way to a plan.
fn check_files(files: &[(&str, &str)]) -> crate::common::Outcome {
    let mut memory =
        Memory(files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect());
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let templates = umbragraph::templates(&mut sources, &mut diagnostics);
    let (name, text) = files[0];
    let file = sources.add(name, text);
    let composed =
        compose::compose(file, Path::new(name), &mut memory, &mut sources, &mut diagnostics).unwrap();
    let options = umbragraph::low_level::CheckOptions {
        registry: &umbragraph::registry(),
        templates: &templates,
        profile: &umbragraph::low_level::shader::TargetProfile::webgpu(),
        overrides: &umbragraph::low_level::pipeline::Overrides::default(),
        plan: &umbragraph::low_level::compiler::PlanOptions::new(640, 480),
    };
    let checked =
        umbragraph::low_level::check_document(&composed.document, &options, &sources, &mut diagnostics);
    crate::common::Outcome { sources, diagnostics, checked }
}

#[test]
fn a_subgraph_file_sees_only_its_arguments() {
    let part = r#"{ "inputs": { "image": "what is drawn" },
        "resources": { "small": { "texture": { "format": "rgba8unorm", "size": "=image / divisor" } } },
        "passes": { "down": { "fullscreen": { "shader": "tonemap.wgsl.jinja", "axes": { "debug_view": "shadow_term" },
            "bind": { "source": "&image" }, "color": [{ "to": "&small" }] }, "side_effect": true } } }"#;
    let given = part.replace(
        "\"resources\"",
        r#""parameters": { "divisor": { "type": "u32", "default": 2 }, "encode_srgb": { "type": "bool", "default": true } }, "resources""#,
    );
    let pipeline = |used: &str, with: &str| {
        format!(
            r#"{{ "format": 1, "name": "x", "parameters": {{ "divisor": {{ "type": "u32", "default": 8 }} }},
  "features": {{ "encode_srgb": {{ "type": "bool", "default": false }} }}, "subgraphs": {{ "own": {part} }},
  "resources": {{ "color": {{ "texture": {{ "format": "rgba8unorm", "size": [64, 64] }} }} }},
  "passes": {{ "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&color" }}] }} }},
    "soft": {{ "use": "{used}", "with": {{ "image": "&color"{with} }} }} }} }}"#
        )
    };
    let seen = |used: &str, with: &str, part: &str| {
        let outcome = check_files(&[("top.json", &pipeline(used, with)), ("parts/blur.json", part)]);
        if !outcome.diagnostics.is_empty() {
            return Err(outcome.text());
        }
        let plan = outcome.plan();
        let program = plan.pipeline.programs.iter().find(|one| one.template == "tonemap.wgsl.jinja").unwrap();
        let encodes = program.axes.get("encode_srgb").map(ToString::to_string);
        Ok((plan.resources["soft.small"].size.unwrap().width, encodes))
    };
    // Around it: the parameter, and the feature that has the name of an axis.
    assert_eq!(seen("own", "", part), Ok((8, Some("false".to_owned()))));
    let alone = part.replace("divisor", "2");
    assert_eq!(seen("parts/blur.json", "", &alone), Ok((32, None)));
    let rejected = seen("parts/blur.json", "", part).unwrap_err();
    assert!(rejected.contains("a subgraph file does not see \"divisor\" of the pipeline"), "{rejected}");
    assert!(
        rejected.contains("pass it through \"with\"") && rejected.contains("parts/blur.json:2:"),
        "{rejected}"
    );
    assert!(rejected.ends_with("1 error\n"), "{rejected}");
    assert_eq!(seen("parts/blur.json", "", &given), Ok((32, Some("true".to_owned()))));
    assert_eq!(
        seen("parts/blur.json", ", \"divisor\": \"=divisor * 2\", \"encode_srgb\": \"=encode_srgb\"", &given),
        Ok((4, Some("false".to_owned())))
    );
}

#[test]
fn an_input_is_never_what_has_its_name_outside() {
    let part = r#"{ "inputs": { "color": "what is measured" },
        "resources": { "small": { "texture": { "format": "rgba8unorm", "size": "=color / 2" } } },
        "passes": { "down": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&small" }] }, "side_effect": true } } }"#;
    let pipeline = |given: &str| {
        format!(
            r#"{{ "format": 1, "name": "x",
  "resources": {{ "color": {{ "texture": {{ "format": "rgba8unorm", "size": [64, 64] }} }}, "other": {{ "texture": {{ "format": "rgba8unorm", "size": [16, 16] }} }} }},
  "passes": {{ "a": {{ "use": "parts/a.json", "with": {{ "color": "&{given}" }} }} }} }}"#
        )
    };
    let check = |given: &str| check_files(&[("top.json", &pipeline(given)), ("parts/a.json", part)]);
    let width = |given: &str| check(given).plan().resources["a.small"].size.unwrap().width;
    assert_eq!((width("color"), width("other")), (32, 8));
    let rejected = check("othr");
    assert_eq!(rejected.codes(), ["UG0301"], "{}", rejected.text());
    assert!(rejected.text().contains("did you mean \"other\"?"), "{}", rejected.text());
}

#[test]
fn passes_of_an_extension_outside_a_point_are_a_diagnostic() {
    let mut sources = Sources::new();
    let pipeline = r#"{ "extension_points": { "point": {} }, "passes": {} }"#;
    let extension = r#"{ "inserts": { "point": {} }, "passes": { "lost": {} } }"#;
    let (pipeline, extension) = (sources.add("a.json", pipeline), sources.add("b.json", extension));
    let mut document = document::parse(&sources, pipeline).valid().expect("JSON").root;
    let extension = document::parse(&sources, extension).valid().expect("JSON").root;
    let mut diagnostics = Diagnostics::new();
    compose::insert(&mut document, extension, &mut diagnostics);
    let codes: Vec<&str> = diagnostics.iter().map(|diagnostic| diagnostic.code.id).collect();
    assert_eq!(codes, ["UG0102"]);
}
