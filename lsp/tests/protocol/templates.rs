//! Templates and files of axes under an editor: outline, definition, references, hover, completion.

use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};

use crate::editor::*;

const AXES: &str = r#"{
  "inherits": ["part.wgsl.jinja"],
  "axes": { "light": { "type": "bool", "default": false, "description": "Light colors." } }
}"#;
const PART: &str = "// Twice a number.\nfn double(x: f32) -> f32 {\n    return x * 2.0;\n}\n";
const TEMPLATE: &str = r#"{# A color. #}
{% include "lib/fullscreen.wgsl.jinja" %}
{% include "part.wgsl.jinja" %}
struct Tint {
    strength: f32,
}

@group(1) @binding(0) var<uniform> tint: Tint;

@fragment
fn main(covered: Covered) -> @location(0) vec4<f32> {
    let half = double({% if light %}0.5{% else %}0.1{% endif %});
    return vec4<f32>(half * tint.strength, covered.uv, 1.0);
}
"#;

struct Opened {
    editor: Editor,
    template: PathBuf,
    axes: PathBuf,
    part: PathBuf,
    library: PathBuf,
    _folder: umbragraph_test_support::scratch::ScratchFolder,
}

impl Opened {
    fn new(name: &str) -> Self {
        let scratch = umbragraph_test_support::scratch::ScratchFolder::new(name);
        let folder = scratch.canonicalize().expect("a folder");
        let [template, axes, part] =
            ["own.wgsl.jinja", "own.axes.json", "part.wgsl.jinja"].map(|name| folder.join(name));
        for (path, text) in [(&template, TEMPLATE), (&axes, AXES), (&part, PART)] {
            std::fs::write(path, text).expect("a file");
        }
        let own = [template.clone(), axes.clone(), part.clone()];
        let mut editor = Editor::start_with(&folder, move || session_with(&own), json!({ "library": true }));
        for (path, text) in [(&template, TEMPLATE), (&axes, AXES), (&part, PART)] {
            editor.open(path, text);
        }
        let library = folder.join("library");
        Self { editor, template, axes, part, library, _folder: scratch }
    }

    /// The answer at the first place of a text in the template, some bytes after its start.
    fn at(&mut self, method: &str, text: &str, more: usize) -> Json {
        let template = self.template.clone();
        let offset = self.editor.texts[&uri(&template)].find(text).expect("the text") + more;
        let context = json!({ "context": { "includeDeclaration": true } });
        self.editor.at(method, &template, offset, context)
    }

    /// The places of an answer: file name, line and the text there.
    fn places(&mut self, method: &str, text: &str, more: usize) -> Vec<(String, u64, String)> {
        let answer = self.at(method, text, more);
        let place = |one: &Json| {
            let uri = one["uri"].as_str().expect("an address");
            let path = Path::new(uri.strip_prefix("file://").expect("a file"));
            let content = std::fs::read_to_string(path).expect("a text");
            let range = offset(&content, &one["range"]["start"])..offset(&content, &one["range"]["end"]);
            let name = path.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
            (name, one["range"]["start"]["line"].as_u64().expect("a line"), content[range].to_owned())
        };
        answer.as_array().expect("places").iter().map(place).collect()
    }

    fn labels(&mut self, path: &Path, text: &str, at: usize) -> Vec<String> {
        self.editor.change(path, text);
        let items = self.editor.at("textDocument/completion", path, at, Json::Null);
        let label = |item: &Json| item["label"].as_str().expect("a label").to_owned();
        items.as_array().map(|items| items.iter().map(label).collect()).unwrap_or_default()
    }
}

fn place(file: &str, line: u64, text: &str) -> (String, u64, String) {
    (file.to_owned(), line, text.to_owned())
}

#[test]
fn names_in_templates_lead_to_their_declarations() {
    let mut opened = Opened::new("lsp_names_in_templates");
    let mut definition = |text: &str, more| opened.places("textDocument/definition", text, more);
    assert_eq!(definition("double(", 2), [place("part.wgsl.jinja", 1, "double")]);
    assert_eq!(definition("half * ", 1), [place("own.wgsl.jinja", 11, "half")]);
    assert_eq!(definition("tint.strength", 6), [place("own.wgsl.jinja", 4, "strength")]);
    assert_eq!(definition("tint.strength", 1), [place("own.wgsl.jinja", 7, "tint")]);
    assert_eq!(definition("\"part.wgsl", 3), [place("part.wgsl.jinja", 0, "")]);
    assert_eq!(definition("light %}", 1), [place("own.axes.json", 2, "\"light\"")]);
    assert_eq!(definition("A color", 3), []);
    // What comes with the module is shown in a copy, and answers go on from there.
    assert_eq!(definition("Covered)", 2), [place("fullscreen.wgsl.jinja", 2, "Covered")]);
    let uses = opened.places("textDocument/references", "double(", 2);
    assert_eq!(uses, [place("part.wgsl.jinja", 1, "double"), place("own.wgsl.jinja", 11, "double")]);
    let copy = std::fs::read_dir(&opened.library).expect("a folder").count();
    assert_eq!(copy, 1);
    let copy = opened.library.join("shaders-templates/lib/fullscreen.wgsl.jinja");
    let text = std::fs::read_to_string(&copy).expect("a copy");
    opened.editor.open(&copy, &text);
    let hover =
        opened.editor.at("textDocument/hover", &copy, text.find("Covered(").expect("a use"), Json::Null);
    assert!(
        hover["contents"]["value"].as_str().is_some_and(|text| text.contains("struct Covered")),
        "{hover}"
    );
}

#[test]
fn hover_in_templates_explains_declarations_and_axes() {
    let mut opened = Opened::new("lsp_hover_in_templates");
    let mut hover = |text: &str, more| {
        let answer = opened.at("textDocument/hover", text, more);
        answer["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    assert_eq!(
        hover("double(", 2),
        "```wgsl\nfn double(x: f32) -> f32\n```\n\nTwice a number.\n\nin `part.wgsl.jinja`"
    );
    let axis = hover("light %}", 1);
    assert!(axis.starts_with("axis `light`") && axis.contains("Light colors."), "{axis}");
    assert!(hover("tint.strength", 6).contains("strength: f32"));
    assert!(hover("lib/fullscreen", 3).contains("full-screen"));
    assert_eq!(hover("covered: Covered", 1), "```wgsl\ncovered: Covered\n```");
    assert_eq!(hover("0.5", 1), "");
}

#[test]
fn outline_and_completion_of_templates_are_served() {
    let mut opened = Opened::new("lsp_outline_of_templates");
    let template = opened.template.clone();
    let of = json!({ "textDocument": { "uri": uri(&template) } });
    let outline = opened.editor.ask("textDocument/documentSymbol", of);
    let name = |one: &Json| one["name"].as_str().expect("a name").to_owned();
    let names: Vec<String> = outline.as_array().expect("symbols").iter().map(name).collect();
    assert_eq!(names, ["Tint", "tint", "main"]);
    assert_eq!(outline[0]["children"][0]["name"], "strength");
    let at = |text: &str, what: &str| text.find(what).expect("the text") + what.len();
    let text = TEMPLATE.replace("let half = double(", "let half = dou(");
    let labels = opened.labels(&template, &text, at(&text, "= dou"));
    assert!(
        ["double", "Covered", "tint", "main"].iter().all(|name| labels.contains(&(*name).to_owned())),
        "{labels:?}"
    );
    assert!(!labels.contains(&"strength".to_owned()), "{labels:?}");
    let text = TEMPLATE.replace("tint.strength", "tint.");
    let labels = opened.labels(&template, &text, at(&text, "tint."));
    assert!(labels.contains(&"strength".to_owned()) && !labels.contains(&"tint".to_owned()), "{labels:?}");
    let text = TEMPLATE.replace("{% if light %}", "{% if  %}");
    let labels = opened.labels(&template, &text, at(&text, "{% if "));
    assert_eq!(labels, ["light"]);
    let text = TEMPLATE.replace("part.wgsl", "pa");
    let labels = opened.labels(&template, &text, at(&text, "\"pa"));
    assert!(labels.contains(&"part.wgsl.jinja".to_owned()), "{labels:?}");
    assert_eq!(opened.labels(&template, TEMPLATE, at(TEMPLATE, "A col")), Vec::<String>::new());
    let part = opened.part.clone();
    assert_eq!(opened.labels(&part, PART, at(PART, "// Tw")), Vec::<String>::new());
}

#[test]
fn files_of_axes_have_keys_words_and_an_outline() {
    let mut opened = Opened::new("lsp_files_of_axes");
    let axes = opened.axes.clone();
    let of = json!({ "textDocument": { "uri": uri(&axes) } });
    let outline = opened.editor.ask("textDocument/documentSymbol", of);
    assert_eq!(outline[0]["children"][0]["name"], "light", "{outline}");
    let hover = opened.editor.at(
        "textDocument/hover",
        &axes,
        AXES.find("\"default\"").expect("a key") + 2,
        Json::Null,
    );
    assert!(hover["contents"]["value"].as_str().is_some_and(|text| !text.is_empty()), "{hover}");
    let at = |text: &str, what: &str| text.find(what).expect("the text") + what.len();
    let text = AXES.replace(", \"default\": false", ", \"d\"");
    let labels = opened.labels(&axes, &text, at(&text, ", \"d"));
    assert!(labels.contains(&"default".to_owned()) && !labels.contains(&"type".to_owned()), "{labels:?}");
    let text = AXES.replace("\"bool\"", "\"\"");
    let labels = opened.labels(&axes, &text, at(&text, "\"type\": \""));
    assert!(labels.contains(&"bool".to_owned()) && labels.contains(&"enum".to_owned()), "{labels:?}");
}

#[test]
fn declarations_of_all_templates_lead_to_themselves() {
    let mut session = session();
    let set = session.templates();
    let mut declared = 0;
    for name in set.names() {
        let file = set.file(name).expect("its file");
        let length = session.sources().get(file).expect("its text").text().len();
        for symbol in session.template_symbols(file).into_iter().step_by(31) {
            let at = symbol.place.start as usize;
            let places = session.template_definition(file, at);
            let is_of_tag = matches!(symbol.kind, umbragraph::low_level::session::TemplateItem::Block);
            assert!(places.contains(&symbol.place) || is_of_tag, "{name}: {symbol:?} leads to {places:?}");
            assert!(session.template_hover(file, at).is_some() || is_of_tag, "{name}: {symbol:?}");
            assert!(session.template_references(file, at).contains(&symbol.place) || is_of_tag, "{symbol:?}");
            declared += 1;
        }
        for at in [0, length / 3, length / 2, length] {
            let _ = (session.template_expected(file, at), session.template_hover(file, at));
        }
    }
    assert!(declared > 30, "{declared}");
}

const USER: &str = r#"{
  "format": 1, "name": "user",
  "resources": { "target": { "texture": { "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" } } },
  "passes": {
    "fill": { "fullscreen": {
      "shader": "own.wgsl.jinja", "bind": { "tint": { "values": { "strength": 1 } } },
      "color": [{ "to": "&target" }]
    } }
  }
}
"#;

/// The first lines of a template's diagnostics, and the text after each of its fixes.
fn told(editor: &mut Editor, template: &Path) -> (Vec<String>, Vec<String>) {
    let found = editor.diagnostics(template);
    let text = editor.texts[&uri(template)].clone();
    let whole = json!({ "start": position(&text, 0), "end": position(&text, text.len()) });
    let context = json!({ "diagnostics": [] });
    let document = json!({ "uri": uri(template) });
    let params = json!({ "textDocument": document, "range": whole, "context": context });
    let actions = editor.ask("textDocument/codeAction", params);
    let mended = actions.as_array().expect("actions").iter();
    (found, mended.map(|one| changed(&text, &one["edit"]["changes"][uri(template)])).collect())
}

#[test]
fn template_alone_is_checked_with_pipelines_of_the_folder() {
    let scratch = umbragraph_test_support::scratch::ScratchFolder::new("lsp_template_alone");
    let folder = scratch.canonicalize().expect("a folder");
    let [template, axes, part] =
        ["own.wgsl.jinja", "own.axes.json", "part.wgsl.jinja"].map(|name| folder.join(name));
    for (path, text) in [(&template, TEMPLATE), (&axes, AXES), (&part, PART)] {
        std::fs::write(path, text).expect("a file");
    }
    let own = [template.clone(), axes, part.clone()];
    std::fs::write(folder.join("user.json"), USER).expect("a file");
    let mut editor = Editor::start_with(&folder, move || session_with(&own), json!({}));
    editor.open(&template, TEMPLATE);
    assert_eq!(told(&mut editor, &template), (Vec::new(), Vec::new()));
    // A member, a function of the module and one of WGSL: each is found and has a fix.
    for (right, wrong) in [
        ("tint.strength", "tint.stregnth"),
        ("= double(", "= duoble("),
        ("double({%", "smoothstp(0.0, 1.0, {%"),
    ] {
        editor.change(&template, &TEMPLATE.replacen(right, wrong, 1));
        let (found, mended) = told(&mut editor, &template);
        assert!(found.len() == 1 && found[0].contains("UG05"), "{wrong}: {found:?}");
        let wanted = TEMPLATE.replacen(right, &wrong.replace("smoothstp", "smoothstep"), 1);
        let wanted = if wrong.contains("stp") { wanted } else { TEMPLATE.to_owned() };
        assert_eq!(mended, [wanted], "{wrong}");
    }
    // A part that only others include.
    editor.close(&template);
    editor.open(&part, &PART.replace("x * 2.0", "numbre * 2.0"));
    let found = editor.diagnostics(&part);
    assert!(found.len() == 1 && found[0].contains("numbre"), "{found:?}");
    editor.close(&part);
    assert_eq!(editor.diagnostics(&part), Vec::<String>::new());
}

#[test]
fn template_that_no_pipeline_uses_is_checked_itself() {
    let mut opened = Opened::new("lsp_template_of_none");
    let template = opened.template.clone();
    let mut first = |text: &str| {
        opened.editor.change(&template, text);
        opened.editor.diagnostics(&template)
    };
    assert_eq!(first(&format!("{TEMPLATE}\n")), Vec::<String>::new());
    let found = first(&TEMPLATE.replace("{% endif %}", ""));
    assert!(found.len() == 1 && found[0].contains("UG05"), "{found:?}");
    let found = first(&TEMPLATE.replace("tint.strength", "tint.power"));
    assert!(found.len() == 1 && found[0].contains("power"), "{found:?}");
    assert_eq!(first(TEMPLATE), Vec::<String>::new());
}
