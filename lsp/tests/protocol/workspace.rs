//! Pipelines, parts and templates of one folder: who shows what, panics, renames across files, watching.

use std::path::{Path, PathBuf};

use serde_json::{Value as Json, json};
use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::compose::Roots;
use umbragraph::low_level::session::{Session, Storage, Template, TemplateText};
use umbragraph::low_level::source::{FileId, Sources};
use umbragraph::{DiskStorage, with_templates};

use crate::editor::*;

/// A folder of its own with some files.
fn folder_of(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("umbragraph-lsp-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let folder = folder.canonicalize().expect("a folder");
    for (name, text) in files {
        std::fs::write(folder.join(name), text).expect("a file");
    }
    folder
}

/// Pipelines of one pass, whose parameter is in another file.
fn whole(part: &str, more: &str) -> String {
    format!(
        r#"{{
  "format": 1, "name": "whole", "include": ["{part}"],{more}
  "resources": {{
    "target": {{ "texture": {{ "format": "rgba8unorm", "size": ["=side", "=side"], "lifetime": "imported" }} }}
  }},
  "passes": {{ "fill": {{ "fullscreen": {{ "shader": "gradient.wgsl.jinja", "color": [{{ "to": "&target" }}] }} }} }}
}}
"#
    )
}

const PART: &str = "{ \"parameters\": { \"side\": { \"type\": \"u32\", \"default\": 64 } } }\n";

#[test]
fn panic_is_the_answer_and_the_next_request_is_answered() {
    struct Panicking;
    impl Storage for Panicking {
        fn read(
            &mut self,
            path: &Path,
            roots: Option<&Roots>,
            sources: &mut Sources,
        ) -> Result<FileId, Diagnostic> {
            DiskStorage.read(path, roots, sources)
        }

        fn identity(&self, path: &Path) -> PathBuf {
            assert!(!path.ends_with("panics.json"), "a defect");
            DiskStorage.identity(path)
        }
    }
    let folder = folder_of("panic", &[("part.json", PART), ("whole.json", &whole("part.json", ""))]);
    let session = || Session::new(Panicking, umbragraph::registry(), with_templates([]));
    let mut editor = Editor::start_with(&folder, session, json!({}));
    let whole = folder.join("whole.json");
    editor.open(&whole, &std::fs::read_to_string(&whole).expect("a text"));
    let outline = |editor: &mut Editor, path: &Path| {
        editor.try_ask("textDocument/documentSymbol", json!({ "textDocument": { "uri": uri(path) } }))
    };
    assert!(
        outline(&mut editor, &whole).is_ok_and(|found| found.as_array().is_some_and(|all| !all.is_empty()))
    );
    let panics = folder.join("panics.json");
    editor.open(&panics, "{}");
    let answer = outline(&mut editor, &panics);
    assert!(answer.as_ref().is_err_and(|message| message.contains("a defect")), "{answer:?}");
    assert!(
        outline(&mut editor, &whole).is_ok_and(|found| found.as_array().is_some_and(|all| !all.is_empty()))
    );
    std::fs::remove_dir_all(folder).expect("a folder");
}

#[test]
fn documents_of_other_programs_get_no_diagnostics() {
    let folder = folder_of("others", &[]);
    let mut editor = Editor::start(&folder);
    for (name, text) in [
        ("package.json", r#"{ "name": "a", "version": "1.0.0", "scripts": {} }"#),
        ("tsconfig.json", r#"{ "extends": "./base.json", "include": ["src"], "compilerOptions": {} }"#),
        ("tasks.json", r#"{ "version": "2.0.0", "tasks": [], "inputs": [] }"#),
    ] {
        let path = folder.join(name);
        editor.open(&path, text);
        assert_eq!(editor.diagnostics(&path), Vec::<String>::new(), "{name}");
        let items = editor.at("textDocument/completion", &path, 2, Json::Null);
        assert!(items.is_null(), "{name}: {items}");
    }
    let path = folder.join("new.json");
    editor.open(&path, "{ \"form\" }");
    let items = editor.at("textDocument/completion", &path, 5, Json::Null).to_string();
    assert!(items.contains("\"format\""), "{items}");
    editor.change(&path, "{ \"format\": 1, \"name\": \"a\", \"dependencies\": {} }");
    assert!(editor.diagnostics(&path).iter().any(|line| line.contains("dependencies")));
    std::fs::remove_dir_all(folder).expect("a folder");
}

#[test]
fn rename_reaches_every_pipeline_that_reads_the_file() {
    let one = whole("part.json", "");
    let files = [("part.json", PART), ("one.json", &one), ("two.json", &one)];
    let folder = folder_of("rename", &files);
    let mut editor = Editor::start(&folder);
    let path = folder.join("one.json");
    editor.open(&path, &one);
    let at = one.find("=side").expect("a use") + 2;
    let edit = editor.at("textDocument/rename", &path, at, json!({ "newName": "width" }));
    let changes = edit["changes"].as_object().expect("changes");
    for (name, text) in files {
        let edits = changes.get(&uri(&folder.join(name))).unwrap_or_else(|| panic!("{name}: {edit}"));
        let new = text.replace("\"side\"", "\"width\"").replace("=side", "=width");
        assert_eq!(changed(text, edits), new, "{name}");
    }
    // One pipeline has the name: the refusal says which.
    let other = whole("part.json", r#" "parameters": { "width": { "type": "u32", "default": 1 } },"#);
    std::fs::write(folder.join("two.json"), other).expect("a file");
    let params = json!({
        "textDocument": { "uri": uri(&path) }, "position": position(&one, at), "newName": "width"
    });
    let refused = editor.try_ask("textDocument/rename", params).expect_err("a name that is taken");
    assert!(refused.contains("two.json") && refused.contains("width"), "{refused}");
    std::fs::remove_dir_all(folder).expect("a folder");
}

#[test]
fn part_moves_to_the_pipeline_that_begins_to_read_it() {
    let alone = whole("part.json", "").replace("\"part.json\"", "").replace("=side", "=viewport");
    let folder = folder_of("revised", &[("part.json", PART), ("whole.json", &alone)]);
    let mut editor = Editor::start(&folder);
    let (part, path) = (folder.join("part.json"), folder.join("whole.json"));
    editor.open(&part, PART);
    editor.open(&path, &alone);
    let wrong = PART.replace("64", "true");
    editor.change(&part, &wrong);
    assert_eq!(editor.diagnostics(&part), Vec::<String>::new(), "nothing reads it");
    editor.change(&path, &whole("part.json", ""));
    assert!(!editor.diagnostics(&part).is_empty(), "{:?}", editor.published);
    editor.change(&path, &alone);
    assert_eq!(editor.diagnostics(&part), Vec::<String>::new(), "nothing reads it");
    std::fs::remove_dir_all(folder).expect("a folder");
}

#[test]
fn client_that_watches_is_asked_and_another_is_read_after() {
    let watching = json!({ "didChangeWatchedFiles": { "dynamicRegistration": true } });
    let whole = whole("part.json", "");
    let folder = folder_of("watch", &[("part.json", PART), ("whole.json", &whole)]);
    let path = folder.join("whole.json");
    let mut editor = Editor::start_with(&folder, session, watching);
    editor.open(&path, &whole);
    assert_eq!(editor.diagnostics(&path), Vec::<String>::new());
    let asked: Vec<&str> = editor.asked.iter().map(|(method, _)| method.as_str()).collect();
    assert_eq!(asked, ["client/registerCapability"]);
    assert!(editor.asked[0].1.to_string().contains("**/*.{json,jsonc,jinja}"));
    let mut editor = Editor::start(&folder);
    editor.open(&path, &whole);
    assert_eq!(editor.diagnostics(&path), Vec::<String>::new());
    assert!(editor.asked.is_empty());
    std::fs::write(folder.join("part.json"), "{}").expect("a file");
    editor.tell("textDocument/didSave", json!({ "textDocument": { "uri": uri(&path) } }));
    assert!(editor.diagnostics(&path).iter().any(|line| line.contains("side")));
    std::fs::remove_dir_all(folder).expect("a folder");
}

#[test]
fn diagnostic_of_a_foreign_template_is_not_on_its_lines() {
    let session = || {
        let text = "\n\n\n{{ missing }}\n";
        let own = Template { name: "own.wgsl.jinja".to_owned(), text: TemplateText::Text(text.into()) };
        Session::new(DiskStorage, umbragraph::registry(), with_templates([own]))
    };
    let text = whole("part.json", "").replace("gradient.wgsl.jinja", "own.wgsl.jinja");
    let folder = folder_of("foreign", &[("part.json", PART), ("whole.json", &text)]);
    let path = folder.join("whole.json");
    let mut editor = Editor::start_with(&folder, session, json!({}));
    editor.open(&path, &text);
    let found = editor.diagnostics(&path);
    let line = text.lines().position(|line| line.contains("own.wgsl")).expect("a use").to_string();
    let is_placed = |one: &String| one.starts_with("0:0 0:0") || one.starts_with(&(line.clone() + ":"));
    assert!(!found.is_empty() && found.iter().all(is_placed), "{found:?}");
    std::fs::remove_dir_all(folder).expect("a folder");
}
