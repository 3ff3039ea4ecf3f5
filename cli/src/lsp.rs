//! `umbragraph lsp`

use lsp_server::Connection;
use umbragraph::low_level::session::Judges;

use crate::arguments::LspArguments;
use crate::session::{Session, dry_run};
use crate::streams::complain;

/// Serves an editor on standard input and output until it is done; whether it kept to the protocol.
pub(crate) fn run(arguments: &LspArguments) -> bool {
    let session = Session::new(&arguments.files).into_session();
    let (connection, threads) = Connection::stdio();
    let judges: Judges<'_> = &mut |profile| Box::new(dry_run(profile));
    let served = umbragraph_lsp::serve(session, &connection, judges);
    drop(connection);
    let closed = threads.join();
    let failed = served.err().map(|error| error.to_string()).or(closed.err().map(|error| error.to_string()));
    if let Some(error) = &failed {
        complain(&format!("the connection ended: {error}\n"));
    }
    failed.is_none()
}
