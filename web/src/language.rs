//! [`Language`]: the language server of editors, over the files of a page.
//!
//! A page is one client. Its files have the addresses `file:///PATH`, and templates that come with the module
//! `file:///NAME`, so that an edited one stands in place of the module's own, as in [`crate::Project`].

use std::path::PathBuf;

use umbragraph::low_level::session::Session;
use umbragraph_lsp::Texts;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::project::{Pages, library, session};

type Open = Box<dyn FnOnce(&[PathBuf]) -> Session>;

/// A language server (LSP) for editors in a web page. Messages are JSON-RPC objects as strings.
#[wasm_bindgen]
pub struct Language {
    files: Pages,
    server: Texts<Open>,
}

impl Default for Language {
    fn default() -> Self {
        Self::new()
    }
}

#[wasm_bindgen]
impl Language {
    /// Creates a language server with the bundled templates as its only files. The server ignores messages before the
    /// client's `initialize` request.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        let files = Pages::default();
        library().for_each(|(name, text)| files.write(&format!("/{name}"), text));
        let known = files.clone();
        let open: Open = Box::new(move |_| session(&known, &known.templates()));
        Self { files, server: Texts::new(open) }
    }

    /// Writes a file to the in-memory disk of the page. The client then sends the notification
    /// `workspace/didChangeWatchedFiles`.
    pub fn write(&mut self, path: &str, text: &str) {
        self.files.write(&format!("/{path}"), text);
    }

    /// Handles a message of the client. Returns the messages to send to the client.
    pub fn handle(&mut self, message: &str) -> Vec<String> {
        self.server.handle(message)
    }

    /// Plans the pipelines that have changed; to be called when no message waits. Returns the messages with changed
    /// diagnostics to send to the client.
    pub fn tell(&mut self) -> Vec<String> {
        self.server.tell()
    }
}
