//! Colors in documents: where they are, and what another color changes.

use std::path::Path;

use serde_json::{Value as Json, json};

use crate::editor::*;

const DOCUMENT: &str = r#"{
  "format": 1, "name": "own",
  "parameters": {
    "sky": {
      "type": "f32[]", "default": [0.5, /* green */ 0.25, 1], "min_length": 3, "max_length": 3,
      "description": "The color above."
    },
    "sun": { "type": "f32[]", "default": [2, 1, 1], "description": "The color of the sun." },
    "up": { "type": "f32[]", "default": [0, 1, 0], "description": "The way up." }
  },
  "presets": { "night": { "parameters": { "sky": [0, 0, 0.1] } } },
  "resources": {
    "light": { "texture": { "format": "rgba16float", "size": "=viewport" } },
    "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } }
  },
  "passes": {
    "paint": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&light", "clear": [0.5, 0, 0, 1] }] } },
    "fill": { "fullscreen": { "shader": "gradient.wgsl.jinja", "color": [{ "to": "&target", "clear": [0.5, 0, 0, 0.5] }] } }
  }
}"#;
const VALUES: &str = r#"{ "parameters": { "sky_color": [0, 0.5, 0], "up": [0, 1, 0] } }"#;

fn colors(editor: &mut Editor, path: &Path, text: &str) -> Vec<(String, [f64; 4])> {
    let found = editor.ask("textDocument/documentColor", json!({ "textDocument": { "uri": uri(path) } }));
    let color = |one: &Json| {
        let range = offset(text, &one["range"]["start"])..offset(text, &one["range"]["end"]);
        let part = |name: &str| (one["color"][name].as_f64().expect("a number") * 1e3).round() / 1e3;
        (text[range].to_owned(), ["red", "green", "blue", "alpha"].map(part))
    };
    found.as_array().expect("colors").iter().map(color).collect()
}

#[test]
fn colors_are_shown_and_changed_in_their_form() {
    let folder = umbragraph_test_support::scratch::ScratchFolder::new("lsp_colors");
    let folder = folder.canonicalize().expect("a folder");
    let (path, values) = (folder.join("own.json"), folder.join("values.json"));
    std::fs::write(&path, DOCUMENT).expect("a file");
    std::fs::write(&values, VALUES).expect("a file");
    let mut editor = Editor::start(&folder);
    editor.open(&path, DOCUMENT);
    editor.open(&values, VALUES);
    let found = colors(&mut editor, &path, DOCUMENT);
    let expected = [
        ("[0.5, /* green */ 0.25, 1]".to_owned(), [0.735, 0.537, 1.0, 1.0]),
        ("[0, 0, 0.1]".to_owned(), [0.0, 0.0, 0.349, 1.0]),
        // Light is linear; an 8-bit target has what is shown.
        ("[0.5, 0, 0, 1]".to_owned(), [0.735, 0.0, 0.0, 1.0]),
        ("[0.5, 0, 0, 0.5]".to_owned(), [0.5, 0.0, 0.0, 0.5]),
    ];
    assert_eq!(found, expected);
    assert_eq!(colors(&mut editor, &values, VALUES), [("[0, 0.5, 0]".to_owned(), [0.0, 0.735, 0.0, 1.0])]);
    let document = json!({ "textDocument": { "uri": uri(&path) } });
    let all = editor.ask("textDocument/documentColor", document.clone());
    let mut changed_to = |at: usize, red: f64| {
        let mut color = all[at]["color"].clone();
        color["red"] = json!(red);
        let mut params = document.clone();
        (params["color"], params["range"]) = (color, all[at]["range"].clone());
        let one = editor.ask("textDocument/colorPresentation", params)[0].clone();
        (one["label"].clone(), changed(DOCUMENT, &json!([one["textEdit"]])))
    };
    let (label, text) = changed_to(0, 0.5);
    assert_eq!(label, "[0.214, 0.25, 1] linear");
    assert_eq!(text, DOCUMENT.replace("[0.5, /* green", "[0.214, /* green"));
    let (label, text) = changed_to(3, 1.0);
    assert_eq!(label, "[1, 0, 0, 0.5] sRGB");
    assert_eq!(text, DOCUMENT.replace("[0.5, 0, 0, 0.5]", "[1, 0, 0, 0.5]"));
}

#[test]
fn words_of_the_language_are_explained() {
    let (mut editor, path, text) = Editor::with_pipeline("learn/01-smallest.json");
    let mut hover = |text: &str, what: &str| {
        editor.change(&path, text);
        let at = text.find(what).expect("the text") + 2;
        let hover = editor.at("textDocument/hover", &path, at, Json::Null);
        hover["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    let format = hover(&text, "rgba8unorm");
    for part in ["4 bytes per texel", "filterable", "renderable", "blendable", "storage (write)"] {
        assert!(format.contains(part), "{format}");
    }
    let compressed = text.replacen("rgba8unorm", "bc1-rgba-unorm", 1);
    let format = hover(&compressed, "bc1-rgba");
    assert!(format.contains("8 bytes per block of 4 × 4 texels") && format.contains("not there"), "{format}");
    let sized = text.replacen("=viewport", "=max(viewport, 1)", 1);
    let function = hover(&sized, "max(");
    assert!(function.starts_with("`max(") && function.contains("Function of expressions"), "{function}");
}
