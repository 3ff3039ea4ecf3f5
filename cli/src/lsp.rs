//! `umbragraph lsp`: serves editors over standard input and output.

use std::path::{Path, PathBuf};

use lsp_server::Connection;
use umbragraph::low_level::compose::normalize;
use umbragraph::low_level::session::Judges;

use crate::arguments::{Files, LspArguments};
use crate::cache::users_folder;
use crate::session::{Session, dry_run};
use crate::streams::complain;

/// Runs the language server on standard input and output until the editor ends it. Returns `true` if the editor
/// followed the protocol.
pub(crate) fn run(arguments: &LspArguments) -> bool {
    let session = |folders: &[PathBuf]| {
        let templates = arguments.templates.as_deref().map(|path| whole(path, folders));
        let root = arguments.root.iter().map(|path| whole(path, folders)).chain(folders.iter().cloned());
        Session::new(&Files { extension: Vec::new(), templates, root: root.collect() }).into_session()
    };
    let library = users_folder().map(|folder| folder.join("templates").join(env!("CARGO_PKG_VERSION")));
    let (connection, threads) = Connection::stdio();
    let judges: Judges<'_> = &mut |profile| Box::new(dry_run(profile));
    let served = umbragraph_lsp::serve(session, &connection, library, judges);
    drop(connection);
    let closed = threads.join();
    let failed = served.err().map(|error| error.to_string()).or(closed.err().map(|error| error.to_string()));
    if let Some(error) = &failed {
        complain(&format!("the connection ended: {error}\n"));
    }
    failed.is_none()
}

/// Returns the absolute path of a folder: below the current folder, or below the first workspace folder if it exists
/// only there.
fn whole(path: &Path, folders: &[PathBuf]) -> PathBuf {
    let here = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let there = folders.first().map(|folder| folder.join(path));
    normalize(&there.filter(|there| !here.is_dir() && there.is_dir()).unwrap_or(here))
}
