//! An editor that speaks to the server over memory, and its texts and positions.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use lsp_server::{Connection, Message, Notification, Request, RequestId};
use serde_json::{Value as Json, json};
use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compose::Roots;
use umbragraph::low_level::session::{Session, Template, TemplateText};
use umbragraph::{DiskStorage, with_templates};

pub(crate) fn root() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace");
    root.canonicalize().expect("a folder")
}

pub(crate) fn session() -> Session {
    Session::new(DiskStorage, umbragraph::registry(), with_templates([]))
}

/// An editor with a server of its own.
pub(crate) struct Editor {
    pub(crate) connection: Connection,
    pub(crate) server: Option<std::thread::JoinHandle<()>>,
    pub(crate) last: i32,
    /// The texts that are open, by address.
    pub(crate) texts: BTreeMap<String, String>,
    /// Published diagnostics by address.
    pub(crate) published: BTreeMap<String, Json>,
    /// Requests of the server.
    pub(crate) asked: Vec<(String, Json)>,
    /// Messages that the server showed to the user.
    pub(crate) told: Vec<String>,
}

impl Editor {
    pub(crate) fn start(folder: &Path) -> Self {
        Self::start_with(folder, session, json!({}))
    }

    /// An editor of the project's pipelines with one of them open, its path and its text.
    pub(crate) fn with_pipeline(name: &str) -> (Self, PathBuf, String) {
        let folder = root().join("pipelines");
        let path = folder.join(name);
        let text = std::fs::read_to_string(&path).expect("a text");
        let mut editor = Self::start(&folder);
        editor.open(&path, &text);
        (editor, path, text)
    }

    pub(crate) fn start_with(
        folder: &Path,
        session: impl FnOnce() -> Session + Send + 'static,
        of_workspace: Json,
    ) -> Self {
        let (connection, servers) = Connection::memory();
        let library = Some(folder.join("library")).filter(|_| of_workspace["library"] == true);
        let server = std::thread::spawn(move || {
            // All configurations are the business of `check`, which has tests of its own.
            let judges: umbragraph::low_level::session::Judges<'_> =
                &mut |_| Box::new(|_| Diagnostics::new());
            let open = |folders: &[PathBuf]| {
                let mut session = session();
                session.set_roots(folders);
                session
            };
            umbragraph_lsp::serve(open, &servers, library, judges)
                .expect("a client that keeps to the protocol");
        });
        let (texts, published, asked, told) = (BTreeMap::new(), BTreeMap::new(), Vec::new(), Vec::new());
        let mut editor = Self { connection, server: Some(server), last: 0, texts, published, asked, told };
        let general = json!({ "positionEncodings": ["utf-8", "utf-16"] });
        let capabilities = json!({ "general": general, "workspace": of_workspace });
        let folders = json!([{ "uri": uri(folder), "name": "pipelines" }]);
        let answer =
            editor.ask("initialize", json!({ "capabilities": capabilities, "workspaceFolders": folders }));
        assert_eq!(answer["capabilities"]["positionEncoding"], "utf-8");
        editor.tell("initialized", json!({}));
        editor
    }

    pub(crate) fn tell(&self, method: &str, params: Json) {
        self.connection.sender.send(Notification::new(method.to_owned(), params).into()).expect("a server");
    }

    /// The answer to a request; what is published before it is noted.
    pub(crate) fn ask(&mut self, method: &str, params: Json) -> Json {
        self.try_ask(method, params).unwrap_or_else(|error| panic!("{method}: {error}"))
    }

    pub(crate) fn try_ask(&mut self, method: &str, params: Json) -> Result<Json, String> {
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
                Message::Notification(one) if one.method == "window/showMessage" => {
                    self.told.push(one.params["message"].as_str().expect("a message").to_owned());
                }
                _ => {}
            }
        }
    }

    pub(crate) fn open(&mut self, path: &Path, text: &str) {
        let document = json!({ "uri": uri(path), "languageId": "jsonc", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
        self.texts.insert(uri(path), text.to_owned());
    }

    /// Changes a text by what differs: the part between what both begin and end with.
    pub(crate) fn change(&mut self, path: &Path, new: &str) {
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

    pub(crate) fn close(&mut self, path: &Path) {
        self.tell("textDocument/didClose", json!({ "textDocument": { "uri": uri(path) } }));
        self.texts.remove(&uri(path));
    }

    /// The published diagnostics of a file as lines, once all changes are told of.
    pub(crate) fn diagnostics(&mut self, path: &Path) -> Vec<String> {
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

    pub(crate) fn at(&mut self, method: &str, path: &Path, offset: usize, more: Json) -> Json {
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

/// A session with templates of files.
pub(crate) fn session_with(templates: &[PathBuf]) -> Session {
    let template = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        let text = TemplateText::File { path: path.clone(), roots: Roots::of(path) };
        Template { name, text }
    };
    Session::new(DiskStorage, umbragraph::registry(), with_templates(templates.iter().map(template)))
}

pub(crate) fn uri(path: &Path) -> String {
    format!("file://{}", path.to_str().expect("a text"))
}

/// A position in bytes.
pub(crate) fn position(text: &str, offset: usize) -> Json {
    let before = &text[..offset];
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    json!({ "line": before.matches('\n').count(), "character": offset - start })
}

/// The byte of a position.
pub(crate) fn offset(text: &str, position: &Json) -> usize {
    let line = position["line"].as_u64().expect("a line") as usize;
    let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
    start + position["character"].as_u64().expect("a column") as usize
}

/// A text with the edits of an answer made.
pub(crate) fn changed(text: &str, edits: &Json) -> String {
    let mut edits = edits.as_array().cloned().unwrap_or_default();
    let start = |edit: &Json| offset(text, &edit["range"]["start"]);
    edits.sort_by_key(|edit| std::cmp::Reverse(start(edit)));
    edits.iter().fold(text.to_owned(), |mut changed, edit| {
        let range = start(edit)..offset(text, &edit["range"]["end"]);
        changed.replace_range(range, edit["newText"].as_str().expect("a text"));
        changed
    })
}
