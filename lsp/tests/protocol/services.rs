//! Fixes, renames, completion, outline, tokens and layout, as an editor asks for them.

use std::path::Path;

use serde_json::{Value as Json, json};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::session::{Choice, Target};
use umbragraph::low_level::shader::TargetProfile;

use crate::editor::*;

#[test]
fn part_is_told_of_in_the_pipeline_that_reads_it() {
    let (mut editor, path, text) = Editor::with_pipeline("awsm/filters.json");
    assert_eq!(editor.diagnostics(&path), Vec::<String>::new());
    editor.change(&path, &text.replacen("\"default\": 0.12", "\"default\": 1200", 1));
    let found = editor.diagnostics(&path);
    assert!(found.iter().any(|line| line.contains("1200")), "{found:?}");
    // What another file uses is found from here.
    let at = text.find("\"light_filter\": {").expect("a feature") + 3;
    let uses = editor.at(
        "textDocument/references",
        &path,
        at,
        json!({ "context": { "includeDeclaration": false } }),
    );
    let files: Vec<&str> =
        uses.as_array().expect("places").iter().filter_map(|one| one["uri"].as_str()).collect();
    assert!(files.iter().any(|file| !file.ends_with("filters.json")), "{files:?}");
}

#[test]
fn fix_of_a_diagnostic_is_a_quick_fix_that_mends_it() {
    let folder = root().join("pipelines");
    let path = folder.join("learn/01-smallest.json");
    let text = std::fs::read_to_string(&path).expect("a text");
    let broken = text.replacen("\"fullscreen\"", "\"fulscreen\"", 1);
    assert_ne!(text, broken);
    let mut editor = Editor::start(&folder);
    editor.open(&path, &broken);
    assert!(!editor.diagnostics(&path).is_empty());
    let at = broken.find("fulscreen").expect("the mistake");
    let range = json!({ "start": position(&broken, at), "end": position(&broken, at) });
    let params =
        json!({ "textDocument": { "uri": uri(&path) }, "range": range, "context": { "diagnostics": [] } });
    let actions = editor.ask("textDocument/codeAction", params);
    let mended = changed(&broken, &actions[0]["edit"]["changes"][uri(&path)]);
    assert_eq!(mended, text, "{actions}");
    editor.change(&path, &mended);
    assert_eq!(editor.diagnostics(&path), Vec::<String>::new());
}

#[test]
fn rename_across_files_leaves_the_same_plan() {
    let (mut editor, path, text) = Editor::with_pipeline("learn/07-include.json");
    let at = text.find("canvas_side").or_else(|| text.find("&canvas")).expect("a name of the part") + 2;
    let edit = editor.at("textDocument/rename", &path, at, json!({ "newName": "renamed" }));
    let changes = edit["changes"].as_object().expect("changes");
    assert!(changes.len() > 1, "{edit}");
    let mut session = session();
    let target = Target::new(&path);
    let choice = Choice::new(TargetProfile::webgpu(), PlanOptions::new(640, 480));
    let mut plan = || {
        let (planned, diagnostics) = session.plan(&target, &choice).expect("nothing cancels");
        assert!(diagnostics.is_empty(), "{diagnostics:?}");
        let plan = serde_json::to_string(planned.report.plan.as_deref().expect("a plan")).expect("JSON");
        for (uri, edits) in changes {
            let path = Path::new(uri.strip_prefix("file://").expect("a file"));
            let text = std::fs::read_to_string(path).expect("a text");
            session.overlay(path, changed(&text, edits).into_bytes());
        }
        plan
    };
    let (before, after) = (plan(), plan());
    assert_ne!(before, after);
    let name = &text[at - 2..].trim_start_matches('&');
    let name: String = name.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
    // Places are not part of what a plan says of passes and sizes.
    let passes = |plan: &str| {
        let plan: Json = serde_json::from_str(plan).expect("JSON");
        plan["passes"].to_string().replace("renamed", &name)
    };
    assert_eq!(passes(&after), passes(&before));
}

#[test]
fn completion_outline_tokens_and_layout_are_served() {
    let (mut editor, path, text) = Editor::with_pipeline("learn/01-smallest.json");
    let document = json!({ "textDocument": { "uri": uri(&path) } });
    let outline = editor.ask("textDocument/documentSymbol", document.clone());
    let names: Vec<&str> =
        outline.as_array().expect("symbols").iter().filter_map(|one| one["name"].as_str()).collect();
    assert_eq!(names, ["resources", "passes"]);
    let at = text.find("\"&target\"").expect("a reference") + 2;
    let items = editor.at("textDocument/completion", &path, at, Json::Null);
    let item =
        items.as_array().expect("items").iter().find(|item| item["label"] == "target").expect("the resource");
    assert_eq!(item["textEdit"]["newText"], "\"&target\"");
    let hover = editor.at("textDocument/hover", &path, at, Json::Null);
    assert!(hover["contents"]["value"].as_str().is_some_and(|text| text.contains("target")), "{hover}");
    let tokens = editor.ask("textDocument/semanticTokens/full", document.clone());
    let kinds: Vec<u64> = tokens["data"]
        .as_array()
        .expect("numbers")
        .iter()
        .skip(3)
        .step_by(5)
        .filter_map(Json::as_u64)
        .collect();
    assert!([0, 1, 2].iter().all(|kind| kinds.contains(kind)), "{kinds:?}");
    let loose = text.replace("\": ", "\":   ");
    editor.change(&path, &loose);
    let options = json!({ "tabSize": 2, "insertSpaces": true });
    let edits = editor
        .ask("textDocument/formatting", json!({ "textDocument": { "uri": uri(&path) }, "options": options }));
    assert_eq!(changed(&loose, &edits), text);
    assert!(editor.server.as_ref().is_some_and(|server| !server.is_finished()));
}

/// The values that stand behind the expressions of a text.
fn hints(editor: &mut Editor, path: &Path, text: &str) -> Vec<(String, String)> {
    let range = json!({ "start": position(text, 0), "end": position(text, text.len()) });
    let params = json!({ "textDocument": { "uri": uri(path) }, "range": range });
    let hint = |hint: &Json| {
        let before = &text[..offset(text, &hint["position"])];
        let expression = before.rsplit('"').nth(1).unwrap_or_default().to_owned();
        (expression, hint["label"].as_str().unwrap_or_default().to_owned())
    };
    editor.ask("textDocument/inlayHint", params).as_array().expect("hints").iter().map(hint).collect()
}

#[test]
fn expressions_are_followed_by_their_values() {
    let (mut editor, path, text) = Editor::with_pipeline("nebula.json");
    let pair = |expression: &str, value: &str| (expression.to_owned(), value.to_owned());
    let found = hints(&mut editor, &path, &text);
    assert!(found.contains(&pair("=!cached", "true")), "{found:?}");
    assert!(found.contains(&pair("=scroll ? 'scene' : 'casters'", "casters")), "{found:?}");
    // A number is its own value.
    let changed = text.replacen("\"=!cached\"", "\"=1 < 2\"", 1);
    editor.change(&path, &changed);
    let found = hints(&mut editor, &path, &changed);
    assert!(found.contains(&pair("=cached", "false")), "{found:?}");
    assert!(!found.iter().any(|(expression, _)| expression == "=1 < 2"), "{found:?}");
}

#[test]
fn rounds_of_a_loop_hide_a_parameter_of_their_name() {
    let (mut editor, path, text) = Editor::with_pipeline("learn/01-smallest.json");
    let parameter =
        r#""parameters": { "i": { "type": "u32", "default": 3, "description": "." } }, "resources""#;
    let once = text.replacen("\"resources\"", parameter, 1).replacen(
        "\"fill\": {",
        "\"fill\": { \"when\": \"=i == 3\",",
        1,
    );
    editor.change(&path, &once);
    assert_eq!(hints(&mut editor, &path, &once), [("=i == 3".to_owned(), "true".to_owned())]);
    let looped = once.replacen("\"when\"", "\"for_each\": { \"i\": [3] }, \"when\"", 1);
    editor.change(&path, &looped);
    assert_eq!(hints(&mut editor, &path, &looped), []);
    assert_eq!(editor.diagnostics(&path), Vec::<String>::new());
}

#[test]
fn lens_of_a_pass_shows_its_wgsl_with_the_way_back() {
    let (mut editor, path, text) = Editor::with_pipeline("learn/32-own-lighting.json");
    let of_document = json!({ "textDocument": { "uri": uri(&path) } });
    let texts = |editor: &mut Editor| {
        let lenses = editor.ask("textDocument/codeLens", of_document.clone());
        let mut lenses = lenses.as_array().expect("lenses").clone();
        lenses.retain(|lens| lens["command"]["command"] != "umbragraph.chooseConfiguration");
        lenses
    };
    let lenses = texts(&mut editor);
    assert!(!lenses.is_empty());
    for lens in lenses {
        // It stands at the key of the pass that it names.
        let command = &lens["command"];
        assert_eq!(command["command"], "umbragraph.showWgsl");
        let line = lens["range"]["start"]["line"].as_u64().expect("a line") as usize;
        let pass = command["arguments"][0]["pass"].as_str().expect("a pass");
        assert!(text.lines().nth(line).expect("a line").contains(&format!("\"{pass}\"")), "{lens}");
        let run = json!({ "command": "umbragraph.wgsl", "arguments": command["arguments"] });
        let shown = editor.ask("workspace/executeCommand", run);
        let wgsl = shown["text"].as_str().expect("a text");
        assert!(wgsl.contains("@fragment") || wgsl.contains("@compute"), "{wgsl}");
        assert_eq!(shown["lines"].as_array().expect("lines").len(), wgsl.split_inclusive('\n').count());
    }
    let unknown =
        json!({ "command": "umbragraph.wgsl", "arguments": [{ "pipeline": uri(&path), "pass": "none" }] });
    let refused = editor.try_ask("workspace/executeCommand", unknown).expect_err("no such pass");
    assert!(refused.contains("\"none\""), "{refused}");
    // While it is broken there is nothing to show.
    editor.change(&path, &text.replacen("\"passes\"", "\"passe\"", 1));
    assert_eq!(texts(&mut editor), Vec::<Json>::new());
}

#[test]
fn lens_of_a_template_leads_back_to_its_lines() {
    let folder = umbragraph_test_support::scratch::ScratchFolder::new("lsp_lens_of_a_template");
    let folder = folder.canonicalize().expect("a folder");
    let (pipeline, template) = (folder.join("own.json"), folder.join("own.wgsl.jinja"));
    let document = r#"{
  "format": 1, "name": "own",
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": { "fill": { "fullscreen": { "shader": "own.wgsl.jinja", "color": [{ "to": "&target" }] } } }
}"#;
    let text = "{% include \"lib/fullscreen.wgsl.jinja\" %}\n\n@fragment\nfn main() -> @location(0) vec4<f32> {\n    return vec4<f32>(0.25);\n}\n";
    std::fs::write(&pipeline, document).expect("a file");
    std::fs::write(&template, text).expect("a file");
    let own = [template.clone()];
    let mut editor = Editor::start_with(&folder, move || session_with(&own), json!({ "library": true }));
    editor.open(&pipeline, document);
    editor.open(&template, text);
    let of_template = json!({ "textDocument": { "uri": uri(&template) } });
    assert_eq!(editor.diagnostics(&pipeline), Vec::<String>::new());
    let lenses = editor.ask("textDocument/codeLens", of_template);
    assert_eq!(lenses[0]["command"]["title"], "WGSL of fill in own", "{lenses}");
    let run = json!({ "command": "umbragraph.wgsl", "arguments": lenses[0]["command"]["arguments"] });
    let shown = editor.ask("workspace/executeCommand", run);
    let wgsl = shown["text"].as_str().expect("a text");
    let line = wgsl.lines().position(|line| line.contains("0.25")).expect("the line");
    let from = &shown["lines"][line];
    assert_eq!(
        (&from["uri"], &from["range"]["start"]["line"]),
        (&json!(uri(&template)), &json!(4)),
        "{from}"
    );
    // A line of a template that comes with the module leads to a copy of it.
    let line = wgsl.lines().position(|line| line.contains("struct Covered")).expect("the line");
    let from = &shown["lines"][line];
    let copy = folder.join("library/shaders-templates/lib/fullscreen.wgsl.jinja");
    assert_eq!(from["uri"], json!(uri(&copy)), "{from}");
    let copied = std::fs::read_to_string(&copy).expect("a copy");
    let at = from["range"]["start"]["line"].as_u64().expect("a line") as usize;
    assert!(copied.lines().nth(at).is_some_and(|line| line.contains("struct Covered")), "{from}");
}

#[test]
fn misspelt_key_hides_no_other_error_of_its_pass() {
    let (mut editor, path, text) = Editor::with_pipeline("learn/01-smallest.json");
    editor.change(&path, &text.replace("\"color\"", "\"colour\"").replace("\"&target\"", "\"&tagret\""));
    let found = editor.diagnostics(&path);
    assert!(found.len() == 2 && found.iter().any(|line| line.contains("colour")), "{found:?}");
    assert!(found.iter().any(|line| line.contains("tagret")), "{found:?}");
    // Nothing follows from a key that is only unknown, either.
    editor.change(&path, &text.replace("\"color\"", "\"unheard\": 1, \"color\""));
    let found = editor.diagnostics(&path);
    assert!(found.len() == 1 && found[0].contains("unheard"), "{found:?}");
}

#[test]
fn completion_knows_members_of_blocks_and_words_of_axes() {
    let labels = |editor: &mut Editor, path: &Path, at: usize| -> Vec<String> {
        let items = editor.at("textDocument/completion", path, at, Json::Null);
        let items = items.as_array().expect("items");
        items.iter().filter_map(|item| Some(item["label"].as_str()?.to_owned())).collect()
    };
    let (mut editor, path, text) = Editor::with_pipeline("learn/27-ssao.json");
    let at = text.find("\"radius\": \"=").expect("a member") + 2;
    // "strength" is there already.
    assert_eq!(labels(&mut editor, &path, at), ["radius"]);
    let (mut editor, path, text) = Editor::with_pipeline("awsm/debug_views.json");
    let at = text.find("\"cascades\",").expect("a word") + 2;
    let found = labels(&mut editor, &path, at);
    assert!(["cascades", "shadow_term"].iter().all(|word| found.contains(&(*word).to_owned())), "{found:?}");
}

#[test]
fn own_declarations_are_proposed_before_inherited_ones() {
    let (mut editor, path, text) = Editor::with_pipeline("umbra.json");
    let document = json!({ "textDocument": { "uri": uri(&path) } });
    let outline = editor.ask("textDocument/documentSymbol", document);
    let sections = outline.as_array().expect("symbols").iter();
    let own: Vec<&str> = sections
        .filter(|section| section["name"] == "parameters" || section["name"] == "features")
        .flat_map(|section| section["children"].as_array().expect("names"))
        .filter(|one| one["detail"].is_string())
        .filter_map(|one| one["name"].as_str())
        .collect();
    let at = text.find("\"=").expect("an expression") + 2;
    let items = editor.at("textDocument/completion", &path, at, Json::Null);
    let mut items = items.as_array().expect("items").clone();
    items.sort_by_key(|item| item["sortText"].as_str().expect("an order").to_owned());
    let place = |name: &str| items.iter().position(|item| item["label"] == name).expect("a candidate");
    let last = own.iter().map(|name| place(name)).max().expect("names of its own");
    assert!(last < place("filter_radius") && !own.contains(&"filter_radius"), "{own:?}");
}
