//! Renames by the language server, in copies of the project's pipelines and templates: the command draws what it drew.

use std::collections::BTreeMap;
use std::io::{BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Output, Stdio};

use lsp_server::{Message, Notification, Request, RequestId};
use serde_json::{Value as Json, json};
use umbragraph_test_support::command::text;
use umbragraph_test_support::gpu;
use umbragraph_test_support::scratch::ScratchFolder;

/// The names of a kind that are renamed in each pipeline.
const RENAMES: usize = 2;
/// The sections of a document whose keys are names.
const SECTIONS: [&str; 5] = ["passes", "resources", "parameters", "features", "presets"];

/// A language server as an editor starts it, over a folder with `pipelines` and `templates`.
struct Editor {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    last: i32,
    folder: PathBuf,
}

impl Editor {
    fn start(folder: &Path) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
        command.args(["lsp", "--templates", "templates"]).current_dir(folder);
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("the command");
        let (input, output) = (child.stdin.take().expect("piped"), child.stdout.take().expect("piped"));
        let folder = folder.canonicalize().expect("a folder");
        let mut editor = Self { child, input, output: BufReader::new(output), last: 0, folder };
        let encodings = json!({ "general": { "positionEncodings": ["utf-8"] } });
        let folders = json!([{ "uri": uri(&editor.folder), "name": "copy" }]);
        let parameters = json!({ "capabilities": encodings, "workspaceFolders": folders });
        editor.ask("initialize", parameters).expect("an answer");
        editor.tell("initialized", json!({}));
        editor
    }

    fn tell(&mut self, method: &str, params: Json) {
        let message = Message::from(Notification::new(method.to_owned(), params));
        message.write(&mut self.input).and_then(|()| self.input.flush()).expect("a server");
    }

    fn ask(&mut self, method: &str, params: Json) -> Result<Json, String> {
        self.last += 1;
        let id = RequestId::from(self.last);
        let message = Message::from(Request::new(id.clone(), method.to_owned(), params));
        message.write(&mut self.input).and_then(|()| self.input.flush()).expect("a server");
        loop {
            match Message::read(&mut self.output).expect("a message").expect("a server") {
                Message::Response(response) if response.id == id => {
                    return response.response_result.map_err(|error| error.message);
                }
                _ => {}
            }
        }
    }

    /// Renames what stands at a byte of a file, and writes the files. Returns `false` if the server refuses it.
    fn rename(&mut self, path: &Path, offset: usize, new: &str) -> bool {
        let text = std::fs::read_to_string(path).expect("a text");
        let parameters = json!({
            "textDocument": { "uri": uri(path) }, "position": position(&text, offset), "newName": new
        });
        let Ok(edit) = self.ask("textDocument/rename", parameters) else { return false };
        let Some(changes) = edit["changes"].as_object() else { return false };
        for (uri, edits) in changes {
            let path = uri.strip_prefix("file://").expect("a file");
            let text = std::fs::read_to_string(path).expect("a text");
            std::fs::write(path, changed(&text, edits)).expect("a file of the copy");
        }
        true
    }

    fn symbols(&mut self, path: &Path) -> Vec<Json> {
        let parameters = json!({ "textDocument": { "uri": uri(path) } });
        let symbols = self.ask("textDocument/documentSymbol", parameters).expect("an outline");
        symbols.as_array().cloned().unwrap_or_default()
    }

    /// Renames the first names of a file that the server accepts, of those that `find` returns with the byte of each.
    /// Returns the renamed ones.
    fn rename_some(
        &mut self,
        path: &Path,
        mut find: impl FnMut(&mut Self, &str) -> Vec<(String, usize)>,
    ) -> Vec<String> {
        let mut renamed = Vec::new();
        let read = || std::fs::read_to_string(path).expect("a text");
        let names: Vec<String> = find(self, &read()).into_iter().map(|(name, _)| name).collect();
        for name in names {
            // Each rename moves the others.
            let now = find(self, &read());
            let Some((_, offset)) = now.into_iter().find(|(one, _)| *one == name) else { continue };
            if renamed.len() < RENAMES && self.rename(path, offset, &format!("{name}_again")) {
                renamed.push(name);
            }
        }
        renamed
    }

    /// Renames names of every kind in a pipeline and in its templates. Returns them by kind.
    fn rename_all_kinds(&mut self, path: &Path) -> BTreeMap<&'static str, Vec<String>> {
        let mut renamed = BTreeMap::new();
        for section in SECTIONS {
            let found = self.rename_some(path, |editor, text| {
                let sections = editor.symbols(path);
                let section = sections.iter().find(|one| one["name"] == section);
                let names = section.and_then(|one| one["children"].as_array().cloned()).unwrap_or_default();
                names.iter().map(|one| place(text, one, 1)).collect()
            });
            renamed.insert(section, found);
        }
        let bindings = self.rename_some(path, |_, text| {
            quoted(text, "\"bind\": { \"").chain(quoted(text, "\"bind\": {\n")).collect()
        });
        renamed.insert("bindings", bindings);
        let document = std::fs::read_to_string(path).expect("a text");
        let templates: Vec<PathBuf> = quoted(&document, "\"shader\": \"")
            .map(|(name, _)| self.folder.join("templates").join(name))
            .filter(|path| path.is_file())
            .collect();
        for (kind, is_entry) in [("functions", false), ("entry points", true)] {
            let mut all = Vec::new();
            for template in &templates {
                all.extend(self.rename_some(template, |editor, text| {
                    let functions = editor.symbols(template).into_iter().filter(|one| one["kind"] == 12);
                    let mut places: Vec<_> = functions.map(|one| place(text, &one, 0)).collect();
                    places.retain(|(_, offset)| {
                        let attributes = text[..*offset].rsplit("\n\n").next().unwrap_or_default();
                        let stages = ["@vertex", "@fragment", "@compute"];
                        stages.iter().any(|stage| attributes.contains(stage)) == is_entry
                    });
                    places
                }));
            }
            renamed.insert(kind, all);
        }
        renamed
    }
}

impl Drop for Editor {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn uri(path: &Path) -> String {
    format!("file://{}", path.to_str().expect("a text"))
}

fn position(text: &str, offset: usize) -> Json {
    let start = text[..offset].rfind('\n').map_or(0, |at| at + 1);
    json!({ "line": text[..offset].matches('\n').count(), "character": offset - start })
}

fn offset(text: &str, position: &Json) -> usize {
    let number = |key: &str| usize::try_from(position[key].as_u64().expect("a number")).expect("a place");
    let start: usize = text.split_inclusive('\n').take(number("line")).map(str::len).sum();
    start + number("character")
}

/// The name of a symbol, and the byte at which it stands, `quotes` behind its start.
fn place(text: &str, symbol: &Json, quotes: usize) -> (String, usize) {
    let name = symbol["name"].as_str().expect("a name").to_owned();
    (name, offset(text, &symbol["selectionRange"]["start"]) + quotes)
}

/// The names that stand behind a text, up to the next quote, with their bytes.
fn quoted<'t>(text: &'t str, before: &'t str) -> impl Iterator<Item = (String, usize)> + 't {
    text.match_indices(before).filter_map(move |(at, _)| {
        let rest = &text[at + before.len()..];
        let skipped = rest.len() - rest.trim_start_matches([' ', '"']).len();
        let name = rest[skipped..].split('"').next()?;
        Some((name.to_owned(), at + before.len() + skipped))
    })
}

fn changed(text: &str, edits: &Json) -> String {
    let mut edits = edits.as_array().cloned().unwrap_or_default();
    edits.sort_by_key(|edit| std::cmp::Reverse(offset(text, &edit["range"]["start"])));
    edits.iter().fold(text.to_owned(), |mut changed, edit| {
        let range = offset(text, &edit["range"]["start"])..offset(text, &edit["range"]["end"]);
        changed.replace_range(range, edit["newText"].as_str().expect("a text"));
        changed
    })
}

fn copy(from: &Path, to: &Path, ends: &[&str]) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder").map(|entry| entry.expect("a file")) {
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        let is_kept = |end: &&str| path.to_str().is_some_and(|path| path.ends_with(end));
        if path.is_dir() {
            copy(&path, &to, ends);
        } else if ends.iter().any(is_kept) {
            std::fs::copy(&path, &to).expect("a file");
        }
    }
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_umbragraph"));
    command.args(arguments).args(["--templates", "templates"]).current_dir(folder);
    let output = command.output().expect("the command");
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
    output
}

/// The words of `check` about a pipeline, and the bytes of its picture.
fn drawn(folder: &Path, pipeline: &str, preset: Option<&str>) -> (String, Vec<u8>) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let scene = root.join("examples/scenes/courtyard.glb");
    let mut arguments = vec!["render", pipeline, "--scene", scene.to_str().expect("a text")];
    arguments.extend(["--size", "96x54", "--out", "picture.png"]);
    arguments.extend(preset.iter().flat_map(|preset| ["--preset", preset]));
    run(folder, &arguments);
    let checked = run(folder, &["check", pipeline, "--no-cache"]);
    let picture = std::fs::read(folder.join("picture.png")).expect("a picture");
    (text(&checked.stderr), picture)
}

/// Renames in some pipelines, each with one of its presets. `wanted` are the kinds of names that have to be renamed.
fn pictures_stay(test: &str, pipelines: &[(&str, Option<&str>)], wanted: &[&str]) {
    if gpu::device().is_none() {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    let folder = ScratchFolder::new(test);
    copy(&root.join("pipelines"), &folder.join("pipelines"), &[".json"]);
    copy(&root.join("shaders-templates"), &folder.join("templates"), &[".wgsl.jinja", ".axes.json"]);
    let mut editor = Editor::start(&folder);
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (pipeline, preset) in pipelines {
        let pipeline = format!("pipelines/{pipeline}");
        let before = drawn(&folder, &pipeline, *preset);
        let renamed = editor.rename_all_kinds(&editor.folder.join(&pipeline));
        let is_renamed = |preset: &str| renamed["presets"].iter().any(|one| one == preset);
        let preset = preset.map(|one| if is_renamed(one) { format!("{one}_again") } else { one.to_owned() });
        let after = drawn(&folder, &pipeline, preset.as_deref());
        assert_eq!(after.0, before.0, "{pipeline}: {renamed:?}");
        assert!(after.1 == before.1, "{pipeline} is drawn otherwise after renames of {renamed:?}");
        for (kind, names) in renamed {
            *counts.entry(kind).or_default() += names.len();
        }
    }
    for kind in wanted {
        assert!(counts.get(kind).is_some_and(|count| *count > 0), "no rename of {kind}: {counts:?}");
    }
}

#[test]
fn lessons_keep_their_pictures_after_renames() {
    let pipelines = [
        ("learn/10-features.json", None),
        ("learn/13-presets.json", Some("low")),
        ("learn/17-toggles.json", None),
        ("learn/25-shared-settings.json", None),
        ("learn/28-bloom.json", None),
    ];
    let wanted = ["passes", "resources", "parameters", "features", "presets", "bindings", "functions"];
    pictures_stay("lsp_renames_lessons", &pipelines, &wanted);
}

#[test]
fn systems_keep_their_pictures_after_renames() {
    let pipelines = [("mantis.json", None), ("lore.json", Some("low")), ("umbra.json", None)];
    let wanted = ["passes", "resources", "parameters", "features", "presets", "bindings", "entry points"];
    pictures_stay("lsp_renames_systems", &pipelines, &wanted);
}
