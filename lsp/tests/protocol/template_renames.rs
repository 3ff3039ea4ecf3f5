//! Renames in templates: of names of WGSL, of tags, and of bindings with the keys that bind them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};
use umbragraph::low_level::compose::Roots;
use umbragraph::low_level::session::{Session, Target, Template, TemplateText};
use umbragraph::{DiskStorage, with_templates};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

use crate::editor::*;
use crate::renames::{choice, overlay, replaced, shown};

const TEMPLATE: &str = r#"{% include "lib/fullscreen.wgsl.jinja" %}
{% include "part.wgsl.jinja" %}
struct Tint {
    strength: f32,
}
struct Mixed {
    near: f32,
    far: f32,
}
@group(0) @binding(0) var<uniform> tint: Tint;
const LIMIT = 2.0;
fn shade_{{ kind }}() -> f32 {
    return 1.0;
}
{% macro half(x) %}{{ x }} * 0.5{% endmacro %}
@fragment
fn main(covered: Covered) -> @location(0) vec4<f32> {
    let shade = double({% if light %}0.5{% else %}LIMIT{% endif %});
    var mixed: Mixed;
    mixed.near = {{ half("shade") }};
    mixed.far = shade_plain();
    return vec4<f32>(mixed.near * tint.strength, covered.uv, mixed.far);
}
"#;
const PART: &str = "fn double(number: f32) -> f32 {\n    return number * 2.0;\n}\n";
const AXES: &str = r#"{ "axes": {
  "light": { "type": "bool", "default": false, "description": "." },
  "kind": { "type": "enum", "values": ["plain"], "default": "plain", "description": "." }
} }"#;
const TEST: &str = "fn is_twice() { let a = double(1.0); }\n";

fn document(name: &str, more: &str) -> String {
    format!(
        r#"{{
  "format": 1, "name": "{name}",
  "parameters": {{ "power": {{ "type": "f32", "default": 1, "description": "." }} }},
  "resources": {{ "target": {{ "texture": {{ "format": "rgba8unorm", "size": "=viewport", "lifetime": "imported" }} }} }},
  "passes": {{
    "fill": {{ "fullscreen": {{
      "shader": "own.wgsl.jinja", "bind": {{ "tint": {{ "values": {{ "strength": "=power" }} }} }},{more}
      "color": [{{ "to": "&target" }}]
    }} }}
  }}
}}
"#
    )
}

struct Opened {
    editor: Editor,
    folder: PathBuf,
    files: BTreeMap<&'static str, String>,
    _folder: umbragraph_test_support::scratch::ScratchFolder,
}

impl Opened {
    fn new(name: &str) -> Self {
        Self::with(name, TEMPLATE)
    }

    fn with(name: &str, template: &str) -> Self {
        let scratch = umbragraph_test_support::scratch::ScratchFolder::new(name);
        let folder = scratch.canonicalize().expect("a folder");
        let files = BTreeMap::from([
            ("own.wgsl.jinja", template.to_owned()),
            ("part.wgsl.jinja", PART.to_owned()),
            ("own.axes.json", AXES.to_owned()),
            ("one.json", document("one", "")),
            ("two.json", document("two", r#" "entry_points": { "fragment": "main" },"#)),
            ("part.test.wgsl", TEST.to_owned()),
            ("values.json", r#"{ "parameters": { "power": 2 } }"#.to_owned()),
        ]);
        for (name, text) in &files {
            std::fs::write(folder.join(name), text).expect("a file");
        }
        let own = ["own.wgsl.jinja", "part.wgsl.jinja", "own.axes.json"].map(|name| folder.join(name));
        let mut editor = Editor::start_with(&folder, move || session_with(&own), json!({}));
        for name in ["own.wgsl.jinja", "part.wgsl.jinja", "one.json", "two.json"] {
            editor.open(&folder.join(name), &files[name]);
        }
        assert_eq!(editor.diagnostics(&folder.join("one.json")), Vec::<String>::new());
        Self { editor, folder, files, _folder: scratch }
    }

    fn try_at(&mut self, method: &str, file: &str, text: &str, more: Json) -> Result<Json, String> {
        let path = self.folder.join(file);
        let (before, _) = text.split_once('|').expect("a cursor");
        let at = self.files[file].find(&text.replace('|', "")).expect("the text") + before.len();
        let mut params = json!({
            "textDocument": { "uri": uri(&path) }, "position": position(&self.files[file], at),
            "context": { "includeDeclaration": true }
        });
        for (key, value) in more.as_object().into_iter().flatten() {
            params[key] = value.clone();
        }
        self.editor.try_ask(method, params)
    }

    /// The files after a rename, which have to be without diagnostics.
    fn renamed(&mut self, file: &str, text: &str, new: &str) -> Result<BTreeMap<String, String>, String> {
        let edit = self.try_at("textDocument/rename", file, text, json!({ "newName": new }))?;
        let mut after = BTreeMap::new();
        for (name, text) in &self.files {
            let edits = &edit["changes"][uri(&self.folder.join(name))];
            if !edits.is_null() {
                after.insert((*name).to_owned(), changed(text, edits));
            }
        }
        let (editor, folder) = (&mut self.editor, &self.folder);
        let open = ["own.wgsl.jinja", "part.wgsl.jinja", "one.json", "two.json"];
        for name in open {
            editor.change(&folder.join(name), after.get(name).unwrap_or(&self.files[name]));
        }
        for name in ["one.json", "two.json"] {
            assert_eq!(editor.diagnostics(&folder.join(name)), Vec::<String>::new(), "{text} to {new}");
        }
        for name in open {
            editor.change(&folder.join(name), &self.files[name]);
        }
        Ok(after)
    }
}

#[test]
fn names_of_templates_are_renamed_in_all_texts() {
    let mut opened = Opened::new("lsp_template_renames");
    let after = opened.renamed("own.wgsl.jinja", "dou|ble(", "twice").expect("a rename");
    assert_eq!(after["own.wgsl.jinja"], TEMPLATE.replace("double", "twice"));
    assert_eq!(after["part.wgsl.jinja"], PART.replace("double", "twice"));
    let told = opened.editor.told.last().expect("a warning");
    assert!(told.contains("part.test.wgsl") && told.contains("\"double\""), "{told}");
    let mut all = |file: &str, text: &str, old: &str, new: &str| {
        let after = opened.renamed(file, text, new).expect("a rename");
        assert_eq!(after[file], replaced(&opened.files[file], old, new), "{text}");
    };
    all("own.wgsl.jinja", "LIM|IT", "LIMIT", "most");
    all("own.wgsl.jinja", "Mix|ed", "Mixed", "Values");
    all("own.wgsl.jinja", "mixed.ne|ar", "near", "nearest");
    all("own.wgsl.jinja", "macro ha|lf", "half", "halved");
    all("part.wgsl.jinja", "num|ber: f32", "number", "x");
    // An entry point has its name in a pipeline, too.
    let after = opened.renamed("own.wgsl.jinja", "fn ma|in", "paint").expect("a rename");
    assert!(after["two.json"].contains(r#""fragment": "paint""#) && !after.contains_key("one.json"));
}

#[test]
fn bindings_are_renamed_in_templates_and_pipelines() {
    let mut opened = Opened::new("lsp_binding_renames");
    for (file, text) in
        [("own.wgsl.jinja", "> ti|nt: T"), ("own.wgsl.jinja", "ti|nt.strength"), ("two.json", "\"ti|nt\"")]
    {
        let after = opened.renamed(file, text, "hue").expect("a rename");
        assert_eq!(after.len(), 3, "{after:?}");
        assert_eq!(after["one.json"], opened.files["one.json"].replace("\"tint\"", "\"hue\""));
        assert_eq!(after["own.wgsl.jinja"], TEMPLATE.replace("> tint:", "> hue:").replace("tint.s", "hue.s"));
    }
    let prepared = opened.try_at("textDocument/prepareRename", "two.json", "\"ti|nt\"", json!({}));
    assert_eq!(prepared.expect("a name")["placeholder"], "tint");
    // From the declaration to the keys, and from a use to the declaration.
    let mut places = |method: &str, text: &str| {
        let found = opened.try_at(method, "own.wgsl.jinja", text, json!({})).expect("places");
        let name = |one: &Json| {
            one["uri"].as_str().and_then(|uri| uri.rsplit('/').next()).unwrap_or_default().to_owned()
        };
        found.as_array().expect("places").iter().map(name).collect::<Vec<_>>()
    };
    assert_eq!(places("textDocument/definition", "> ti|nt: T"), ["one.json", "two.json"]);
    assert_eq!(places("textDocument/definition", "ti|nt.strength"), ["own.wgsl.jinja"]);
    let uses = ["own.wgsl.jinja", "own.wgsl.jinja", "one.json", "two.json"];
    assert_eq!(places("textDocument/references", "ti|nt.strength"), uses);
}

#[test]
fn renames_that_are_not_safe_are_refused_with_a_reason() {
    let mut opened = Opened::new("lsp_refused_renames");
    for (text, new, reason) in [
        ("dou|ble(", "fn", "word of the language"),
        ("dou|ble(", "max", "word of the language"),
        ("dou|ble(", "2x", "no name"),
        ("dou|ble(", "LIMIT", "own.wgsl.jinja has the name \"LIMIT\""),
        ("dou|ble(", "Covered", "fullscreen.wgsl.jinja has the name \"Covered\""),
        ("dou|ble(", "shade_soft", "writes \"shade_{{ kind }}\""),
        ("dou|ble(", "light", "axis"),
        ("{% if lig|ht", "dark", "axis"),
        ("fn sha|de_{", "other", "tags write the name"),
        ("let sha|de", "other", "a tag of own.wgsl.jinja has the text \"shade\""),
        ("stren|gth: f32", "power", "a binding has the structure \"Tint\""),
        ("covered: Cov|ered", "Seen", "comes with the module"),
    ] {
        let refused = opened.renamed("own.wgsl.jinja", text, new).expect_err(text);
        assert!(refused.contains(reason), "{text} to {new}: {refused}");
    }
    let refused = opened.try_at("textDocument/prepareRename", "own.wgsl.jinja", "stren|gth: f32", json!({}));
    assert!(refused.is_err_and(|reason| reason.contains("Tint")));
    // A parameter file keeps the name, and the user is told so.
    let after = opened.renamed("one.json", "\"po|wer\"", "strength").expect("a rename");
    assert_eq!(after.len(), 1);
    let told = opened.editor.told.last().expect("a warning");
    assert!(told.contains("values.json") && told.contains("\"power\""), "{told}");
}

#[test]
fn words_with_another_meaning_keep_their_name() {
    let more = "const LIMIT = 2.0;
fn faded(tint: f32) -> f32 {
    return tint;
}
{% block first %}{% endblock %}
{% for at in range(2) %}{% if loop.first and not half(1) %}{% endif %}{% endfor %}
{% set third = 1 %}{% macro third() %}{% endmacro %}";
    let template = TEMPLATE.replace("const LIMIT = 2.0;", more);
    let mut opened = Opened::with("lsp_words_with_another_meaning", &template);
    let mut renamed = |text: &str, new: &str| {
        opened.renamed("own.wgsl.jinja", text, new).map(|after| after["own.wgsl.jinja"].clone())
    };
    let block = template.replace("block first", "block begin");
    assert_eq!(renamed("block fi|rst", "begin"), Ok(block), "an attribute of the loop is no block");
    let refused = renamed("loop.fi|rst", "begin").expect_err("no block");
    assert!(refused.contains("\"first\""), "{refused}");
    assert_eq!(renamed("macro ha|lf", "halved"), Ok(replaced(&template, "half", "halved")));
    // A name of the module that a function gives to a parameter, and a macro that shares its name with a variable.
    let refused = renamed("> ti|nt: T", "hue").expect_err("a parameter has the name");
    assert!(refused.contains("has a local name \"tint\", too"), "{refused}");
    let refused = renamed("macro thi|rd", "fourth").expect_err("a variable has the name");
    assert!(refused.contains("a variable or an argument the name \"third\""), "{refused}");
}

#[test]
fn functions_of_wgsl_are_explained_and_proposed() {
    let mut opened = Opened::new("lsp_wgsl_functions");
    let path = opened.folder.join("part.wgsl.jinja");
    let text = PART.replace("number * 2.0", "clamp(number, 0.0, 1.0)");
    opened.editor.change(&path, &text);
    let at = text.find("clamp").expect("a call") + 2;
    let hover = opened.editor.at("textDocument/hover", &path, at, Json::Null);
    let told = hover["contents"]["value"].as_str().unwrap_or_default();
    assert!(told.contains("clamp(e: T, low: T, high: T) -> T"), "{told}");
    let items = opened.editor.at("textDocument/completion", &path, at, Json::Null);
    let item = items.as_array().and_then(|items| items.iter().find(|item| item["label"] == "smoothstep"));
    assert!(item.is_some_and(|item| item["detail"].as_str().is_some_and(|text| text.contains("low: T"))));
}

/// A session in which the templates of the project are an author's own.
fn own_library() -> Session {
    let folder = root().join("shaders-templates");
    let mut own = Vec::new();
    let mut folders = vec![folder.clone()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).expect("a folder").flatten() {
            let path = entry.path();
            let name =
                path.strip_prefix(&folder).expect("below").to_str().expect("a name").replace('\\', "/");
            if path.is_dir() {
                folders.push(path);
            } else if [".wgsl.jinja", ".axes.json"].iter().any(|end| name.ends_with(end)) {
                let text = TemplateText::File { roots: Roots::of(&path), path };
                own.push(Template { name, text });
            }
        }
    }
    let mut session = Session::new(DiskStorage, umbragraph::registry(), with_templates(own));
    session.set_roots(&[root()]);
    session
}

/// A value with a name replaced in all its texts.
fn replaced_in(value: &Json, name: &str, by: &str) -> Json {
    match value {
        Json::String(text) => replaced(text, name, by).into(),
        Json::Array(list) => list.iter().map(|one| replaced_in(one, name, by)).collect(),
        Json::Object(members) => {
            let member = |(key, one): (&String, &Json)| (replaced(key, name, by), replaced_in(one, name, by));
            members.iter().map(member).collect()
        }
        other => other.clone(),
    }
}

#[test]
fn renames_in_templates_keep_generated_wgsl() {
    let mut session = own_library();
    let pipelines = ["nebula.json", "learn/32-own-lighting.json"];
    let targets = pipelines.map(|name| Target::new(root().join("pipelines").join(name)));
    // Programs with the name given back, and diagnostics.
    let all = |session: &mut Session, new: &str, old: &str| -> Vec<(Json, Vec<String>)> {
        let of_target = |target: &Target| {
            let choice = choice(session, target);
            let (planned, diagnostics) = session.plan(target, &choice).expect("nothing cancels");
            assert!(planned.report.plan.is_some(), "{diagnostics:?}");
            let (_, programs, lines) = shown(&planned, &diagnostics, new, old);
            (replaced_in(&programs, new, old), lines)
        };
        targets.iter().map(of_target).collect()
    };
    let new = "zz_fresh_name";
    let before = all(&mut session, new, new);
    let text = format!("{before:?}");
    let mut names = Vec::new();
    let set = session.templates();
    for name in set.names() {
        let file = set.file(name).expect("a file");
        let symbols = session.template_symbols(file).into_iter().filter(|one| text.contains(&one.name));
        names.extend(symbols.map(|symbol| (name.to_owned(), symbol)));
    }
    let mut random = Random(property::seed().wrapping_mul(9_000));
    random.shuffle(&mut names);
    let most = if property::times() == 1 { 10 } else { usize::MAX };
    let (mut renamed, mut bound, mut refused) = (0, 0, BTreeMap::<String, usize>::new());
    for (template, symbol) in names {
        let at = symbol.place.start as usize;
        let edits = session.template_rename(symbol.place.file, at, new, &targets).expect("nothing cancels");
        let edits = match edits {
            Some(Ok(edits)) => edits,
            Some(Err(error)) => {
                *refused.entry(error.to_string()).or_default() += 1;
                continue;
            }
            None => continue,
        };
        let is_bound = edits.keys().any(|file| Path::new(file).extension().is_some_and(|end| end == "json"));
        if renamed >= most && !(is_bound && bound == 0) {
            continue;
        }
        overlay(&mut session, &edits);
        assert_eq!(all(&mut session, new, &symbol.name), before, "{template}: {symbol:?}");
        (renamed, bound) = (renamed + 1, bound + usize::from(is_bound));
        edits.keys().for_each(|file| session.close(file));
    }
    assert!(renamed >= 10 && bound > 0, "{renamed} renamed, {bound} bound: {refused:#?}");
}
