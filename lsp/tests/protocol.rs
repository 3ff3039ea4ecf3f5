//! The server as an editor meets it: random edits of every document of `pipelines/`, half of them broken, and what it then
//! says is what a fresh session, which the command asks, says of the same texts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use lsp_server::{Connection, Message, Notification, Request, RequestId};
use serde_json::{Value as Json, json};
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, Severity};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::compose::Roots;
use umbragraph::low_level::pipeline::claimed_profiles;
use umbragraph::low_level::session::{Choice, Session, Storage, Target, Template, TemplateText};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::source::{FileId, Sources};
use umbragraph::{DiskStorage, with_templates};
use umbragraph_test_support::edits::{documents, edited};
use umbragraph_test_support::property;
use umbragraph_test_support::random::Random;

/// Edits of each document; a hundredth of them, of a third of the documents, in ordinary tests.
const EDITS: usize = 300;

fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    root.canonicalize().expect("a folder")
}

fn session() -> Session {
    Session::new(DiskStorage, umbragraph::registry(), with_templates([]))
}

/// An editor with a server of its own.
struct Editor {
    connection: Connection,
    server: Option<std::thread::JoinHandle<()>>,
    last: i32,
    /// The texts that are open, by address.
    texts: BTreeMap<String, String>,
    /// Published diagnostics by address.
    published: BTreeMap<String, Json>,
    /// Requests of the server.
    asked: Vec<(String, Json)>,
}

impl Editor {
    fn start(folder: &Path) -> Self {
        Self::start_with(folder, session, json!({}))
    }

    fn start_with(folder: &Path, session: fn() -> Session, of_workspace: Json) -> Self {
        let (connection, servers) = Connection::memory();
        let server = std::thread::spawn(move || {
            // All configurations are the business of `check`, which has tests of its own.
            let judges: umbragraph::low_level::session::Judges<'_> =
                &mut |_| Box::new(|_| Diagnostics::new());
            let open = |folders: &[PathBuf]| {
                let mut session = session();
                session.set_roots(folders);
                session
            };
            umbragraph_lsp::serve(open, &servers, judges).expect("a client that keeps to the protocol");
        });
        let (texts, published, asked) = (BTreeMap::new(), BTreeMap::new(), Vec::new());
        let mut editor = Self { connection, server: Some(server), last: 0, texts, published, asked };
        let general = json!({ "positionEncodings": ["utf-8", "utf-16"] });
        let capabilities = json!({ "general": general, "workspace": of_workspace });
        let folders = json!([{ "uri": uri(folder), "name": "pipelines" }]);
        let answer =
            editor.ask("initialize", json!({ "capabilities": capabilities, "workspaceFolders": folders }));
        assert_eq!(answer["capabilities"]["positionEncoding"], "utf-8");
        editor.tell("initialized", json!({}));
        editor
    }

    fn tell(&self, method: &str, params: Json) {
        self.connection.sender.send(Notification::new(method.to_owned(), params).into()).expect("a server");
    }

    /// The answer to a request; what is published before it is noted.
    fn ask(&mut self, method: &str, params: Json) -> Json {
        self.try_ask(method, params).unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    fn try_ask(&mut self, method: &str, params: Json) -> Result<Json, String> {
        self.last += 1;
        let id = RequestId::from(self.last);
        self.connection
            .sender
            .send(Request::new(id.clone(), method.to_owned(), params).into())
            .expect("a server");
        loop {
            match self.connection.receiver.recv_timeout(Duration::from_secs(240)).expect("an answer") {
                Message::Response(response) if response.id == id => {
                    return response.response_result.map_err(|error| error.message);
                }
                Message::Request(request) => {
                    self.asked.push((request.method, request.params));
                }
                Message::Notification(one) if one.method == "textDocument/publishDiagnostics" => {
                    let uri = one.params["uri"].as_str().expect("an address").to_owned();
                    self.published.insert(uri, one.params["diagnostics"].clone());
                }
                _ => {}
            }
        }
    }

    fn open(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": uri(path), "languageId": "jsonc", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
        self.texts.insert(uri(path), text.to_owned());
    }

    /// Changes a text by what differs: the part between what both begin and end with.
    fn change(&mut self, path: &Path, new: &str) {
        let old = self.texts.insert(uri(path), new.to_owned()).expect("an open text");
        let shared = |mut a: Vec<char>, mut b: Vec<char>| {
            a.truncate(b.len());
            b.truncate(a.len());
            a.iter().zip(&b).take_while(|(a, b)| a == b).map(|(a, _)| a.len_utf8()).sum::<usize>()
        };
        let start = shared(old.chars().collect(), new.chars().collect());
        let tail = |text: &str| text[start..].chars().rev().collect::<Vec<char>>();
        let end = shared(tail(&old), tail(new));
        let range = json!({ "start": position(&old, start), "end": position(&old, old.len() - end) });
        let change = json!({ "range": range, "text": new[start..new.len() - end] });
        let document = json!({ "uri": uri(path), "version": 2 });
        self.tell("textDocument/didChange", json!({ "textDocument": document, "contentChanges": [change] }));
    }

    fn close(&mut self, path: &Path) {
        self.tell("textDocument/didClose", json!({ "textDocument": { "uri": uri(path) } }));
        self.texts.remove(&uri(path));
    }

    /// The published diagnostics of a file as lines, once all changes are told of.
    fn diagnostics(&mut self, path: &Path) -> Vec<String> {
        self.ask("textDocument/documentSymbol", json!({ "textDocument": { "uri": uri(path) } }));
        let published = self.published.get(&uri(path)).and_then(Json::as_array).cloned().unwrap_or_default();
        let line = |one: &Json| {
            let at =
                |side: &str| format!("{}:{}", one["range"][side]["line"], one["range"][side]["character"]);
            let message = one["message"].as_str().expect("a message").lines().next().unwrap_or_default();
            format!("{} {} {} {} {message}", at("start"), at("end"), one["code"], one["severity"])
        };
        let mut lines: Vec<String> = published.iter().map(line).collect();
        lines.sort();
        lines
    }

    fn at(&mut self, method: &str, path: &Path, offset: usize, more: Json) -> Json {
        let text = &self.texts[&uri(path)];
        let mut params = json!({ "textDocument": { "uri": uri(path) }, "position": position(text, offset) });
        for (key, value) in more.as_object().into_iter().flatten() {
            params[key] = value.clone();
        }
        self.ask(method, params)
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            self.ask("shutdown", Json::Null);
            self.tell("exit", Json::Null);
            if let Some(server) = self.server.take() {
                server.join().expect("no panic");
            }
        }
    }
}

fn uri(path: &Path) -> String {
    format!("file://{}", path.to_str().expect("a text"))
}

/// A position in bytes.
fn position(text: &str, offset: usize) -> Json {
    let before = &text[..offset];
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    json!({ "line": before.matches('\n').count(), "character": offset - start })
}

/// The byte of a position.
fn offset(text: &str, position: &Json) -> usize {
    let line = position["line"].as_u64().expect("a line") as usize;
    let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
    start + position["character"].as_u64().expect("a column") as usize
}

/// A text with the edits of an answer made.
fn changed(text: &str, edits: &Json) -> String {
    let mut edits = edits.as_array().cloned().unwrap_or_default();
    let start = |edit: &Json| offset(text, &edit["range"]["start"]);
    edits.sort_by_key(|edit| std::cmp::Reverse(start(edit)));
    edits.iter().fold(text.to_owned(), |mut changed, edit| {
        let range = start(edit)..offset(text, &edit["range"]["end"]);
        changed.replace_range(range, edit["newText"].as_str().expect("a text"));
        changed
    })
}

/// The diagnostics of a file by a fresh session, as lines; and whether there are errors, in whichever file.
fn fresh(path: &Path, text: &str) -> (Vec<String>, bool) {
    let mut session = session();
    session.set_roots(&[root().join("pipelines")]);
    session.overlay(path, text.as_bytes());
    let target = Target::new(path);
    let diagnostics = match session.check_part(path) {
        Some((_, diagnostics)) => diagnostics,
        None => {
            let loaded = session.load(&target).expect("nothing cancels");
            let profiles = loaded
                .understood()
                .map(|composed| claimed_profiles(&composed.document, &mut Diagnostics::new()));
            let profile =
                profiles.and_then(|all| all.into_iter().next()).unwrap_or_else(TargetProfile::webgpu);
            session
                .plan(&target, &Choice::new(profile, PlanOptions::new(1280, 720)))
                .expect("nothing cancels")
                .1
        }
    };
    (lines(&diagnostics, session.sources(), path), diagnostics.has_errors())
}

fn lines(diagnostics: &Diagnostics, sources: &Sources, path: &Path) -> Vec<String> {
    let mut lines = Vec::new();
    for one in diagnostics {
        let related = one.related.iter().map(|one| &one.place);
        let spans = std::iter::once(&one.place).chain(related).filter_map(|place| match place {
            Place::Span(span) => Some(*span),
            _ => None,
        });
        let mut spans = spans
            .filter(|span| sources.get(span.file).is_some_and(|file| Path::new(file.name()).is_absolute()));
        let severity = match one.severity {
            Severity::Error => 1,
            Severity::Warning => 2,
            Severity::Note => 3,
        };
        let (start, end) = match spans.next() {
            Some(span) => {
                let file = sources.get(span.file).expect("a file");
                if Path::new(file.name()) != path {
                    continue;
                }
                let at = |offset: u32| {
                    let position = position(file.text(), offset as usize);
                    format!("{}:{}", position["line"], position["character"])
                };
                (at(span.start), at(span.end))
            }
            None => continue,
        };
        lines.push(format!("{start} {end} \"{}\" {severity} {}", one.code.id, one.message));
    }
    lines.sort();
    lines.dedup();
    lines
}

/// Edits the documents whose number has this remainder, so that threads share the work.
fn answers_after_edits_are_those_of_a_fresh_session(remainder: usize, of: usize) {
    let folder = root().join("pipelines");
    let mut editor = Editor::start(&folder);
    let mut compared = 0;
    let documents = documents(&folder).into_iter().enumerate().filter(|(at, _)| at % of == remainder);
    for (number, path) in property::part(documents, 3) {
        let text = std::fs::read_to_string(&path).expect("a text");
        // A part that is not right alone is told of as part of a whole: see the test of parts.
        let stands_alone =
            session().check_part(&path).is_some() || !fresh(&path, &text).1 && text.contains("\"passes\"");
        let mut random = Random(property::seed().wrapping_mul(3_000).wrapping_add(number as u64));
        editor.open(&path, &text);
        let edits: Vec<String> = (0..EDITS).map(|_| edited(&text, &mut random)).collect();
        for now in property::part(edits, 100) {
            editor.change(&path, &now);
            let found = editor.diagnostics(&path);
            if stands_alone {
                let mut all = found.clone();
                all.retain(|line| !line.starts_with("0:0 0:0"));
                let (mut expected, _) = fresh(&path, &now);
                expected.retain(|line| !line.starts_with("0:0 0:0"));
                assert_eq!(all, expected, "{}:\n{now}", path.display());
                compared += 1;
            }
            let mut at = random.below(now.len() + 1);
            while !now.is_char_boundary(at) {
                at -= 1;
            }
            for method in ["completion", "hover", "definition", "prepareRename"] {
                editor.at(&format!("textDocument/{method}"), &path, at, Json::Null);
            }
            editor.at(
                "textDocument/references",
                &path,
                at,
                json!({ "context": { "includeDeclaration": true } }),
            );
            let whole = json!({ "start": position(&now, 0), "end": position(&now, now.len()) });
            let document = json!({ "uri": uri(&path) });
            editor.ask("textDocument/semanticTokens/full", json!({ "textDocument": document }));
            let context = json!({ "diagnostics": [] });
            editor.ask(
                "textDocument/codeAction",
                json!({ "textDocument": document, "range": whole, "context": context }),
            );
        }
        editor.close(&path);
    }
    assert!(compared > 0, "no document stands alone");
}

#[test]
fn answers_after_edits_are_those_of_a_fresh_session_in_part_1() {
    answers_after_edits_are_those_of_a_fresh_session(0, 2);
}

#[test]
fn answers_after_edits_are_those_of_a_fresh_session_in_part_2() {
    answers_after_edits_are_those_of_a_fresh_session(1, 2);
}

#[test]
fn part_is_told_of_in_the_pipeline_that_reads_it() {
    let folder = root().join("pipelines");
    let path = folder.join("awsm/filters.json");
    let text = std::fs::read_to_string(&path).expect("a text");
    let mut editor = Editor::start(&folder);
    editor.open(&path, &text);
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
    let folder = root().join("pipelines");
    let path = folder.join("learn/07-include.json");
    let text = std::fs::read_to_string(&path).expect("a text");
    let mut editor = Editor::start(&folder);
    editor.open(&path, &text);
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
    let folder = root().join("pipelines");
    let path = folder.join("learn/01-smallest.json");
    let text = std::fs::read_to_string(&path).expect("a text");
    let mut editor = Editor::start(&folder);
    editor.open(&path, &text);
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
