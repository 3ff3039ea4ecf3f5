//! A language server for pipelines, over one session.
//!
//! [`serve`] speaks the Language Server Protocol: it reads requests of an editor from a connection and answers them with what
//! an [`umbragraph_session::Session`] says of files that are broken, and not saved. All knowledge of the language is in the
//! session; here is only how the protocol writes it.
//!
//! While an author types, the pipeline of the document is planned, and its diagnostics are published. When nothing comes in
//! for a moment, it is checked in all configurations, with the proofs of its shaders. The next message ends that check.

mod answers;
mod outline;
mod position;
mod workspace;

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, TryRecvError, unbounded};
use lsp_server::{Connection, ErrorCode, Message, Notification, ProtocolError, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidChangeWatchedFiles, DidCloseTextDocument, DidOpenTextDocument,
    DidSaveTextDocument, Exit, Notification as _, PublishDiagnostics,
};
use lsp_types::request::{RegisterCapability, Request as _, Shutdown};
use lsp_types::{
    CodeActionProviderCapability, CompletionOptions, DidChangeTextDocumentParams,
    DidChangeWatchedFilesParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams,
    HoverProviderCapability, OneOf, PositionEncodingKind, PublishDiagnosticsParams, RenameOptions,
    SemanticTokensFullOptions, SemanticTokensLegend, SemanticTokensOptions, ServerCapabilities,
    TextDocumentSyncKind, TextDocumentSyncOptions, TextDocumentSyncSaveOptions, Uri, WorkDoneProgressOptions,
};
use serde::de::DeserializeOwned;
use serde_json::{Value as Json, json};
use umbragraph_graph as graph;
use umbragraph_session as session;

use crate::graph::source::Sources;
use crate::position::Encoding;
use crate::session::{Judges, Session};
use crate::workspace::{Workspace, document_path};

/// The time without a message after which pipelines are checked in all configurations.
const QUIET: Duration = Duration::from_millis(500);

/// The files that pipelines are made of.
const WATCHED: &str = "**/*.{json,jsonc,jinja}";

/// Serves one client until it says that it is done. `open` makes the session for the folders of the client's workspace;
/// documents may name files below these if they are among its roots. `judges` adds to a check what a device would say of
/// plans. A panic is the answer to one message; the next is answered as usual.
///
/// # Errors
/// A client that breaks the protocol, or goes away.
pub fn serve(
    open: impl FnOnce(&[PathBuf]) -> Session,
    connection: &Connection,
    judges: Judges<'_>,
) -> Result<(), ProtocolError> {
    let (id, params) = connection.initialize_start()?;
    let encoding = encoding(&params);
    let answer = json!({
        "capabilities": capabilities(encoding),
        "serverInfo": { "name": "umbragraph", "version": env!("CARGO_PKG_VERSION") },
    });
    connection.initialize_finish(id, answer)?;
    let folders = folders(&params);
    let workspace = Workspace::new(open(&folders), folders, encoding);
    let (sender, receiver) = unbounded();
    std::thread::scope(|scope| {
        let cancel = workspace.cancel.clone();
        scope.spawn(move || {
            for message in &connection.receiver {
                let is_last = matches!(&message, Message::Notification(one) if one.method == Exit::METHOD);
                let is_sent = sender.send(message).is_ok();
                // Whoever waits for the message, ends what it is at.
                cancel.set();
                if is_last || !is_sent {
                    return;
                }
            }
        });
        let mut server = Server { workspace, connection, published: BTreeSet::new(), is_watching: false };
        server.watch(&params);
        // Ends with the messages, so that the thread above is not waited for in vain.
        let receiver = receiver;
        server.run(&receiver, judges);
    });
    Ok(())
}

/// Does what only a defect of this server makes panic. Returns the message of the panic.
fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
        format!("the language server has a defect: {text}")
    })
}

fn encoding(params: &Json) -> Encoding {
    let offered = params.pointer("/capabilities/general/positionEncodings").and_then(Json::as_array);
    match offered.is_some_and(|offered| offered.iter().any(|one| one == "utf-8")) {
        true => Encoding::Utf8,
        false => Encoding::Utf16,
    }
}

/// The folders of the workspace; of an older client the one folder.
fn folders(params: &Json) -> Vec<PathBuf> {
    let uri = |value: &Json| serde_json::from_value::<Uri>(value.clone()).ok();
    let listed = params.get("workspaceFolders").and_then(Json::as_array).into_iter().flatten();
    let mut folders: Vec<Uri> = listed.filter_map(|folder| uri(folder.get("uri")?)).collect();
    if folders.is_empty() {
        folders.extend(params.get("rootUri").and_then(uri));
    }
    folders.iter().filter_map(document_path).collect()
}

fn capabilities(encoding: Encoding) -> ServerCapabilities {
    let kind = match encoding {
        Encoding::Utf8 => PositionEncodingKind::UTF8,
        Encoding::Utf16 => PositionEncodingKind::UTF16,
    };
    let sync = TextDocumentSyncOptions {
        open_close: Some(true),
        change: Some(TextDocumentSyncKind::INCREMENTAL),
        save: Some(TextDocumentSyncSaveOptions::Supported(true)),
        ..TextDocumentSyncOptions::default()
    };
    let triggers = ["\"", "&", "=", "@", ".", ":", "'", "{", ","];
    ServerCapabilities {
        position_encoding: Some(kind),
        text_document_sync: Some(sync.into()),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some(triggers.map(str::to_owned).to_vec()),
            ..CompletionOptions::default()
        }),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        rename_provider: Some(OneOf::Right(RenameOptions {
            prepare_provider: Some(true),
            work_done_progress_options: WorkDoneProgressOptions::default(),
        })),
        document_symbol_provider: Some(OneOf::Left(true)),
        inlay_hint_provider: Some(OneOf::Left(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        code_action_provider: Some(CodeActionProviderCapability::Simple(true)),
        semantic_tokens_provider: Some(
            SemanticTokensOptions {
                legend: SemanticTokensLegend {
                    token_types: outline::TOKEN_TYPES.to_vec(),
                    token_modifiers: Vec::new(),
                },
                full: Some(SemanticTokensFullOptions::Bool(true)),
                ..SemanticTokensOptions::default()
            }
            .into(),
        ),
        ..ServerCapabilities::default()
    }
}

struct Server<'c> {
    workspace: Workspace,
    connection: &'c Connection,
    /// Files for which something is published.
    published: BTreeSet<PathBuf>,
    /// Whether the client says which files changed on disk.
    is_watching: bool,
}

impl Server<'_> {
    /// Asks the client to watch files, if it can be asked.
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

    fn run(mut self, messages: &Receiver<Message>, judges: Judges<'_>) {
        while let Some(message) = self.next(messages, &mut *judges) {
            match message {
                Message::Request(request) if request.method == Shutdown::METHOD => {
                    self.send(Response::new_ok(request.id, Json::Null));
                }
                Message::Request(request) => {
                    let id = request.id.clone();
                    let response = caught(|| self.answer(request)).unwrap_or_else(|defect| {
                        Response::new_err(id, ErrorCode::InternalError as i32, defect)
                    });
                    self.send(response);
                }
                Message::Notification(one) if one.method == Exit::METHOD => return,
                // A notification has no answer: the panic is on standard error.
                Message::Notification(notification) => drop(caught(|| self.note(notification))),
                Message::Response(_) => {}
            }
        }
    }

    /// The next message; while there is none, what changed is told of, and then checked. `None` for a client that is gone.
    fn next(&mut self, messages: &Receiver<Message>, judges: Judges<'_>) -> Option<Message> {
        match messages.try_recv() {
            Ok(message) => return Some(message),
            Err(TryRecvError::Disconnected) => return None,
            Err(TryRecvError::Empty) => drop(caught(|| self.publish_changes())),
        }
        loop {
            match messages.recv_timeout(QUIET) {
                Ok(message) => return Some(message),
                Err(RecvTimeoutError::Disconnected) => return None,
                Err(RecvTimeoutError::Timeout) => {}
            }
            self.workspace.cancel.clear();
            if !messages.is_empty() {
                continue;
            }
            match caught(|| self.workspace.check(&mut *judges)) {
                Ok(Some(files)) => self.publish(files),
                Ok(None) => return messages.recv().ok(),
                Err(_) => self.workspace.skip_check(),
            }
        }
    }

    fn publish_changes(&mut self) {
        let files = self.workspace.tell();
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

    /// Sends a message; to a client that is gone, none.
    fn send(&self, message: impl Into<Message>) {
        let _ = self.connection.sender.send(message.into());
    }

    fn answer(&mut self, request: Request) -> Response {
        // What is asked is asked of the texts as they are, and so are fixes.
        self.publish_changes();
        let Request { id, method, params } = request;
        match answers::answer(&mut self.workspace, &method, params) {
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
