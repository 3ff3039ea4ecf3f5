//! The configuration that an author chooses: its lens, values, WGSL and diagnostics.

use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};

use crate::editor::*;

const DOCUMENT: &str = r#"{
  "format": 1, "name": "own",
  "features": {
    "bright": { "type": "bool", "default": false, "description": "Light colors." },
    "red": { "type": "bool", "default": false, "one_of": "tint" },
    "blue": { "type": "bool", "default": true, "one_of": "tint" },
    "green": { "type": "bool", "default": false, "one_of": "tint" },
    "grain": { "type": "enum", "values": ["none", "fine"], "default": "none" }
  },
  "presets": { "noon": { "description": "By day.", "features": { "bright": true } } },
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": {
    "fill": {
      "fullscreen": { "shader": "own.wgsl.jinja", "axes": { "light": "=bright && !red" }, "color": [{ "to": "&target" }] }
    }
  }
}"#;
const AXES: &str =
    r#"{ "axes": { "light": { "type": "bool", "default": false, "description": "Light colors." } } }"#;
const TEMPLATE: &str = "{% include \"lib/fullscreen.wgsl.jinja\" %}\n\n@fragment\nfn main() -> @location(0) vec4<f32> {\n    return vec4<f32>({% if light %}0.75{% else %}0.25{% endif %});\n}\n";

/// A folder with the files above, open in an editor.
struct Opened {
    editor: Editor,
    pipeline: PathBuf,
    template: PathBuf,
    _folder: umbragraph_test_support::scratch::ScratchFolder,
}

impl Opened {
    fn new(name: &str) -> Self {
        let scratch = umbragraph_test_support::scratch::ScratchFolder::new(name);
        let folder = scratch.canonicalize().expect("a folder");
        let (pipeline, template) = (folder.join("own.json"), folder.join("own.wgsl.jinja"));
        let axes = folder.join("own.axes.json");
        for (path, text) in [(&pipeline, DOCUMENT), (&template, TEMPLATE), (&axes, AXES)] {
            std::fs::write(path, text).expect("a file");
        }
        let own = [template.clone(), axes];
        let refresh = json!({ "refreshSupport": true });
        let of_workspace = json!({ "codeLens": refresh, "inlayHint": refresh });
        let mut editor = Editor::start_with(&folder, move || session_with(&own), of_workspace);
        editor.open(&pipeline, DOCUMENT);
        editor.open(&template, TEMPLATE);
        assert_eq!(editor.diagnostics(&pipeline), Vec::<String>::new());
        Self { editor, pipeline, template, _folder: scratch }
    }

    fn lenses(&mut self, path: &Path) -> Vec<Json> {
        let of = json!({ "textDocument": { "uri": uri(path) } });
        self.editor.ask("textDocument/codeLens", of).as_array().expect("lenses").clone()
    }

    fn titles(&mut self, path: &Path) -> Vec<String> {
        let title = |lens: &Json| lens["command"]["title"].as_str().expect("a title").to_owned();
        self.lenses(path).iter().map(title).collect()
    }

    fn listed(&mut self) -> Vec<(String, Json)> {
        let run = json!({ "command": "umbragraph.configurations", "arguments": [{ "pipeline": uri(&self.pipeline) }] });
        let listed = self.editor.ask("workspace/executeCommand", run);
        let one =
            |one: &Json| (one["label"].as_str().expect("a text").to_owned(), one["configuration"].clone());
        listed.as_array().expect("a list").iter().map(one).collect()
    }

    fn configure(&mut self, configuration: &Json) -> Result<Json, String> {
        let argument = json!({ "pipeline": uri(&self.pipeline), "configuration": configuration });
        let run = json!({ "command": "umbragraph.configure", "arguments": [argument] });
        self.editor.try_ask("workspace/executeCommand", run)
    }

    fn choose(&mut self, label: &str) {
        let listed = self.listed();
        let labels: Vec<&String> = listed.iter().map(|(label, _)| label).collect();
        let found = listed.iter().find(|(known, _)| known == label);
        let (_, configuration) = found.unwrap_or_else(|| panic!("{label} is not in {labels:?}"));
        assert_eq!(self.configure(configuration), Ok(Json::Null));
    }

    /// The generated text of the pass, by its lens in the template.
    fn wgsl(&mut self) -> String {
        let template = self.template.clone();
        let lenses = self.lenses(&template);
        let lens =
            lenses.iter().find(|lens| lens["command"]["command"] == "umbragraph.showWgsl").expect("a lens");
        let run = json!({ "command": "umbragraph.wgsl", "arguments": lens["command"]["arguments"] });
        self.editor.ask("workspace/executeCommand", run)["text"].as_str().expect("a text").to_owned()
    }
}

#[test]
fn chosen_configuration_is_that_of_lenses_hints_and_wgsl() {
    let mut opened = Opened::new("lsp_chosen_configuration");
    let (pipeline, template) = (opened.pipeline.clone(), opened.template.clone());
    assert_eq!(opened.titles(&pipeline), ["Configuration: defaults", "WGSL"]);
    assert_eq!(opened.titles(&template), ["Configuration of own: defaults", "WGSL of fill in own"]);
    assert!(opened.wgsl().contains("0.25"));
    let labels: Vec<String> = opened.listed().into_iter().map(|(label, _)| label).collect();
    assert_eq!(
        labels,
        ["defaults", "preset noon", "bright on", "red on", "blue off", "green on", "grain fine"]
    );
    opened.choose("bright on");
    assert_eq!(opened.titles(&pipeline), ["Configuration: bright on", "WGSL"]);
    assert!(opened.wgsl().contains("0.75"));
    let hints = |opened: &mut Opened| {
        let end = position(DOCUMENT, DOCUMENT.len());
        let range = json!({ "start": position(DOCUMENT, 0), "end": end });
        let params = json!({ "textDocument": { "uri": uri(&opened.pipeline) }, "range": range });
        let hints = opened.editor.ask("textDocument/inlayHint", params);
        hints.as_array().expect("hints").iter().map(|hint| hint["label"].clone()).collect::<Vec<_>>()
    };
    assert!(hints(&mut opened).contains(&json!("true")));
    // Of a group another one takes the place of the one that was chosen.
    opened.choose("red on");
    opened.choose("green on");
    assert_eq!(opened.titles(&pipeline)[0], "Configuration: bright on, green on");
    opened.choose("preset noon");
    assert_eq!(opened.titles(&pipeline)[0], "Configuration: preset noon");
    assert!(opened.wgsl().contains("0.75"));
    opened.choose("defaults");
    assert!(opened.wgsl().contains("0.25"));
    let refreshed = |what: &str| opened.editor.asked.iter().filter(|(method, _)| method == what).count();
    assert!(refreshed("workspace/codeLens/refresh") >= 5, "{:?}", opened.editor.asked);
    assert!(refreshed("workspace/inlayHint/refresh") >= 5, "{:?}", opened.editor.asked);
}

#[test]
fn template_shows_errors_of_the_chosen_variant_at_once() {
    let mut opened = Opened::new("lsp_errors_of_the_chosen_variant");
    let template = opened.template.clone();
    let broken = TEMPLATE.replace("0.75", "mistake");
    // By default the branch is not there; the check of all configurations comes later.
    opened.editor.change(&template, &broken);
    assert_eq!(opened.editor.diagnostics(&template), Vec::<String>::new());
    opened.editor.change(&template, TEMPLATE);
    opened.choose("bright on");
    opened.editor.change(&template, &broken);
    let found = opened.editor.diagnostics(&template);
    assert!(
        matches!(&found[..], [one] if one.starts_with("4:35 4:42") && one.contains("mistake")),
        "{found:?}"
    );
    // The way back to another configuration is there while it is broken.
    assert_eq!(opened.titles(&template), ["Configuration of own: bright on"]);
    opened.choose("defaults");
    assert_eq!(opened.titles(&template), ["Configuration of own: defaults", "WGSL of fill in own"]);
}

#[test]
fn configuration_that_a_pipeline_lacks_is_refused() {
    let mut opened = Opened::new("lsp_configuration_that_is_refused");
    let pipeline = opened.pipeline.clone();
    opened.choose("bright on");
    for (configuration, said) in [
        (json!({ "features": { "brigth": true } }), "brigth"),
        (json!({ "preset": "night" }), "night"),
        (json!({ "feature": { "bright": true } }), "feature"),
        (json!({ "features": { "grain": "coarse" } }), "coarse"),
        (json!({ "features": { "red": true, "green": true } }), "tint"),
    ] {
        let refused = opened.configure(&configuration).expect_err("no such configuration");
        assert!(refused.contains(said), "{configuration}: {refused}");
        assert_eq!(opened.titles(&pipeline)[0], "Configuration: bright on");
    }
    assert_eq!(opened.editor.diagnostics(&pipeline), Vec::<String>::new());
    // A feature that is renamed leaves the choice behind.
    let renamed = DOCUMENT.replace("bright", "sunny");
    opened.editor.change(&pipeline, &renamed);
    let found = opened.editor.diagnostics(&pipeline);
    assert!(matches!(&found[..], [one] if one.contains("\"bright\"")), "{found:?}");
    opened.choose("defaults");
    assert_eq!(opened.editor.diagnostics(&pipeline), Vec::<String>::new());
    let unknown = json!({ "command": "umbragraph.nothing", "arguments": [] });
    let refused = opened.editor.try_ask("workspace/executeCommand", unknown).expect_err("no such command");
    assert!(refused.contains("umbragraph.configure"), "{refused}");
}
