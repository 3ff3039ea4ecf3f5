//! [`Server`]: answers to the messages of one client, without a connection.
//!
//! Whoever has a connection gives messages to [`Server::handle`], asks [`Server::tell`] when none waits, and
//! [`Server::check`] when none comes for a moment; all three return what is to be sent. There are no threads, clocks or
//! streams here, so that a page in a browser can do it too ([`Texts`]).

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use lsp_server::{ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidChangeWatchedFiles, DidCloseTextDocument, DidOpenTextDocument,
    DidSaveTextDocument, Notification as _, PublishDiagnostics, ShowMessage,
};
use lsp_types::request::{
    CodeLensRefresh, Completion, Formatting, HoverRequest, Initialize, InlayHintRefreshRequest,
    RegisterCapability, Request as _, SemanticTokensFullRequest, Shutdown,
};
use lsp_types::{
    DidChangeTextDocumentParams, DidChangeWatchedFilesParams, DidCloseTextDocumentParams,
    DidOpenTextDocumentParams, MessageType, PublishDiagnosticsParams, ShowMessageParams,
};
use serde::de::DeserializeOwned;
use serde_json::{Value as Json, json};

use crate::answers;
use crate::capabilities::{capabilities, encoding, folders};
use crate::workspace::{Workspace, document_path};
use umbragraph_graph::source::Sources;
use umbragraph_session::{Cancel, Judges, Session};

/// The glob pattern of the files that the client watches on disk: JSON documents and shader templates.
const WATCHED: &str = "**/*.{json,jsonc,jinja}";

/// The requests that are answered before changed pipelines are planned.
const WITHOUT_PLAN: [&str; 4] =
    [Completion::METHOD, HoverRequest::METHOD, SemanticTokensFullRequest::METHOD, Formatting::METHOD];

/// A language server for one client, without a connection: it turns each received message into messages to send.
pub struct Server {
    workspace: Workspace,
    /// Messages that are still to be sent.
    out: Vec<Message>,
    /// The files with published diagnostics.
    published: BTreeSet<PathBuf>,
    /// Whether the client reports which files changed on disk.
    is_watching: bool,
    /// Whether the client supports requests to fetch code lenses again.
    has_lens_refresh: bool,
    /// Whether the client can be told that inlay hints are others.
    has_hint_refresh: bool,
}

impl std::fmt::Debug for Server {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Server").field("published", &self.published).finish_non_exhaustive()
    }
}

/// Runs `work` and catches a panic, which only a defect of this server can cause. Returns an error message that
/// contains the panic's message.
fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        format!("the language server has a defect: {text}")
    })
}

impl Server {
    /// Creates a server from the parameters of the client's `initialize` request. `open` creates the session, given the
    /// folders of the client's workspace. Also returns the result to send in answer to that request.
    pub fn new(open: impl FnOnce(&[PathBuf]) -> Session, params: &Json) -> (Self, Json) {
        let (encoding, folders) = (encoding(params), folders(params));
        let answer = json!({
            "capabilities": capabilities(encoding),
            "serverInfo": { "name": "umbragraph", "version": env!("CARGO_PKG_VERSION") },
        });
        let workspace = Workspace::new(open(&folders), folders, encoding);
        let has_refresh = |of: &str| {
            let way = format!("/capabilities/workspace/{of}/refreshSupport");
            params.pointer(&way) == Some(&Json::Bool(true))
        };
        let mut server = Self {
            workspace,
            out: Vec::new(),
            published: BTreeSet::new(),
            is_watching: false,
            has_lens_refresh: has_refresh("codeLens"),
            has_hint_refresh: has_refresh("inlayHint"),
        };
        server.watch(params);
        (server, answer)
    }

    /// Sets the folder for copies of templates that come with the module, which "Go to Definition" opens. With `None`
    /// nothing is written, and a declaration in such a template has no place.
    pub fn keep_library_in(&mut self, folder: Option<PathBuf>) {
        self.workspace.library = folder;
    }

    /// Returns the switch that cancels a running check.
    pub fn cancel(&self) -> Cancel {
        self.workspace.cancel.clone()
    }

    /// Handles a message from the client. Returns the messages to send: for a request, its answer and the diagnostics
    /// that changed since the last call.
    pub fn handle(&mut self, message: Message) -> Vec<Message> {
        match message {
            Message::Request(request) if request.method == Shutdown::METHOD => {
                self.send(Response::new_ok(request.id, Json::Null));
            }
            Message::Request(request) => {
                let id = request.id.clone();
                let response = caught(|| self.answer(request))
                    .unwrap_or_else(|defect| Response::new_err(id, ErrorCode::InternalError as i32, defect));
                self.send(response);
            }
            // A notification has no answer: the panic is on standard error.
            Message::Notification(notification) => drop(caught(|| self.note(notification))),
            Message::Response(_) => {}
        }
        std::mem::take(&mut self.out)
    }

    /// Plans the pipelines that changed. Returns the messages to send, which publish the diagnostics that changed.
    pub fn tell(&mut self) -> Vec<Message> {
        drop(caught(|| self.publish_changes()));
        std::mem::take(&mut self.out)
    }

    /// Checks one changed pipeline in all configurations. Returns messages with the diagnostics that changed; `None` if
    /// no unchecked pipeline is left, or if the switch of [`Server::cancel`] ended the check.
    pub fn check(&mut self, judges: Judges<'_>) -> Option<Vec<Message>> {
        match caught(|| self.workspace.check(&mut *judges)) {
            Ok(files) => self.publish(files?),
            Err(_) => self.workspace.skip_check(),
        }
        Some(std::mem::take(&mut self.out))
    }

    /// Registers file watching with the client, if the client supports it.
    fn watch(&mut self, params: &Json) {
        let way = "/capabilities/workspace/didChangeWatchedFiles/dynamicRegistration";
        self.is_watching = params.pointer(way) == Some(&Json::Bool(true));
        if self.is_watching {
            let options = json!({ "watchers": [{ "globPattern": WATCHED }] });
            let watched =
                json!({ "id": "files", "method": DidChangeWatchedFiles::METHOD, "registerOptions": options });
            let params = json!({ "registrations": [watched] });
            self.send(Request::new("watch".to_owned().into(), RegisterCapability::METHOD.to_owned(), params));
        }
    }

    fn publish_changes(&mut self) {
        let before = self.workspace.told();
        let files = self.workspace.tell();
        // Templates have lenses of pipelines that are told of, and these have none while they are broken.
        let is_reconfigured = self.workspace.take_reconfigured();
        let has_other_lenses = is_reconfigured || !files.is_empty() || self.workspace.told() != before;
        if self.has_lens_refresh && has_other_lenses {
            let refresh = CodeLensRefresh::METHOD.to_owned();
            self.send(Request::new("lenses".to_owned().into(), refresh, Json::Null));
        }
        if self.has_hint_refresh && is_reconfigured {
            let refresh = InlayHintRefreshRequest::METHOD.to_owned();
            self.send(Request::new("hints".to_owned().into(), refresh, Json::Null));
        }
        self.publish(files);
    }

    fn publish(&mut self, files: BTreeSet<PathBuf>) {
        for path in files {
            let diagnostics: Vec<_> =
                self.workspace.of_file(&path).into_iter().map(|(one, _)| one.clone()).collect();
            let is_empty = diagnostics.is_empty();
            let had_some = self.published.remove(&path);
            if !is_empty {
                self.published.insert(path.clone());
            }
            if let Some(uri) = self.workspace.uri(&path).filter(|_| had_some || !is_empty) {
                let params = PublishDiagnosticsParams { uri, diagnostics, version: None };
                self.send(Notification::new(PublishDiagnostics::METHOD.to_owned(), params));
            }
        }
    }

    fn send(&mut self, message: impl Into<Message>) {
        self.out.push(message.into());
    }

    fn answer(&mut self, request: Request) -> Response {
        let Request { id, method, params } = request;
        // Fixes are of the texts as they are. While one types, diagnostics can wait for what needs no plan.
        if !WITHOUT_PLAN.contains(&method.as_str()) {
            self.publish_changes();
        }
        let answered = answers::answer(&mut self.workspace, &method, params);
        for message in std::mem::take(&mut self.workspace.warnings) {
            let params = ShowMessageParams { typ: MessageType::WARNING, message };
            self.send(Notification::new(ShowMessage::METHOD.to_owned(), params));
        }
        match answered {
            Some(Ok(answer)) => Response::new_ok(id, answer),
            Some(Err(message)) => Response::new_err(id, ErrorCode::InvalidParams as i32, message),
            None => {
                Response::new_err(id, ErrorCode::MethodNotFound as i32, format!("{method} is not served"))
            }
        }
    }

    fn note(&mut self, notification: Notification) {
        let Notification { method, params } = notification;
        match method.as_str() {
            DidOpenTextDocument::METHOD => {
                if let Some(DidOpenTextDocumentParams { text_document }) = read(params)
                    && let Some(path) = document_path(&text_document.uri)
                {
                    self.workspace.open(&path, text_document.text);
                }
            }
            DidChangeTextDocument::METHOD => {
                if let Some(params) = read(params) {
                    self.change(params);
                }
            }
            DidCloseTextDocument::METHOD => {
                if let Some(DidCloseTextDocumentParams { text_document }) = read(params)
                    && let Some(path) = document_path(&text_document.uri)
                {
                    self.workspace.close(&path);
                }
            }
            DidSaveTextDocument::METHOD if !self.is_watching => self.workspace.refresh(),
            DidChangeWatchedFiles::METHOD => {
                let changes = read(params).map(|DidChangeWatchedFilesParams { changes }| changes);
                for path in changes.iter().flatten().filter_map(|change| document_path(&change.uri)) {
                    self.workspace.changed_on_disk(&path);
                }
            }
            _ => {}
        }
    }

    fn change(&mut self, params: DidChangeTextDocumentParams) {
        let Some(path) = document_path(&params.text_document.uri) else { return };
        let Some(mut text) = self.workspace.text(&path).map(str::to_owned) else { return };
        for change in params.content_changes {
            let Some(range) = change.range else {
                text = change.text;
                continue;
            };
            let mut sources = Sources::new();
            let id = sources.add("", text.as_str());
            let Some(file) = sources.get(id) else { continue };
            let encoding = self.workspace.encoding;
            let (start, end) = (encoding.offset(file, range.start), encoding.offset(file, range.end));
            text.replace_range(start..end.max(start), &change.text);
        }
        self.workspace.write(&path, text);
    }
}

fn read<T: DeserializeOwned>(params: Json) -> Option<T> {
    serde_json::from_value(params).ok()
}

/// A language server whose messages are JSON strings, for a host without a connection, such as a page in a browser.
#[derive(Debug)]
pub struct Texts<F> {
    open: Option<F>,
    server: Option<Server>,
}

impl<F: FnOnce(&[PathBuf]) -> Session> Texts<F> {
    /// Creates a server that waits for the client's `initialize` request. `open` creates the session, as in
    /// [`Server::new`].
    pub fn new(open: F) -> Self {
        Self { open: Some(open), server: None }
    }

    /// Handles a message, given as JSON. Returns the messages to send, as JSON; none before `initialize`, or if `text`
    /// is not a valid message.
    pub fn handle(&mut self, text: &str) -> Vec<String> {
        let Ok(message) = serde_json::from_str::<Message>(text) else { return Vec::new() };
        if let (None, Message::Request(request)) = (&self.server, &message)
            && request.method == Initialize::METHOD
            && let Some(open) = self.open.take()
        {
            let (server, answer) = Server::new(open, &request.params);
            self.server = Some(server);
            return written(vec![Response::new_ok(request.id.clone(), answer).into()]);
        }
        let Some(server) = &mut self.server else { return Vec::new() };
        written(server.handle(message))
    }

    /// Plans the pipelines that changed, like [`Server::tell`]. Returns the messages to send as JSON; none before
    /// `initialize`.
    pub fn tell(&mut self) -> Vec<String> {
        self.server.as_mut().map(|server| written(server.tell())).unwrap_or_default()
    }
}

fn written(messages: Vec<Message>) -> Vec<String> {
    let text = |message| {
        let mut value = serde_json::to_value(message).unwrap_or_default();
        value["jsonrpc"] = Json::from("2.0");
        value.to_string()
    };
    messages.into_iter().map(text).collect()
}
