//! A language server for pipelines, over one session.
//!
//! [`serve`] speaks the Language Server Protocol: it reads requests of an editor from a connection and answers them
//! with what an [`umbragraph_session::Session`] says of files that are broken, and not saved. All knowledge of the
//! language is in the session; here is only how the protocol writes it.
//!
//! While an author types, the pipeline of the document is planned, and its diagnostics are published. When nothing
//! comes in for a moment, it is checked in all configurations, with the proofs of its shaders. The next message ends
//! that check.

mod answers;
mod capabilities;
mod colors;
mod configuration;
mod generated;
mod outline;
mod position;
mod renames;
mod server;
mod templates;
mod workspace;

use std::path::PathBuf;
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError, TryRecvError, unbounded};
use lsp_server::{Connection, Message, ProtocolError};
use lsp_types::notification::{Exit, Notification as _};

use umbragraph_session::{Judges, Session};

pub use server::{Server, Texts};

/// The time without a message after which pipelines are checked in all configurations.
const QUIET: Duration = Duration::from_millis(500);

/// Serves one client of the Language Server Protocol until its `exit` notification. `open` creates the session, given
/// the folders of the client's workspace. Documents may name files below these folders if `open` sets them as [roots of
/// the session](Session::set_roots). Copies of templates that come with the module, for editors to open, are written
/// below `library`; with `None` nothing is written. `judges` adds further checks of plans to the check of all configurations, such as
/// a dry run on a device. A panic fails only the message that is being handled.
///
/// # Errors
/// Returns an error if the `initialize` handshake fails, because the client violates the protocol or disconnects.
pub fn serve(
    open: impl FnOnce(&[PathBuf]) -> Session,
    connection: &Connection,
    library: Option<PathBuf>,
    judges: Judges<'_>,
) -> Result<(), ProtocolError> {
    let (id, params) = connection.initialize_start()?;
    let (mut server, answer) = Server::new(open, &params);
    server.keep_library_in(library);
    connection.initialize_finish(id, answer)?;
    let cancel = server.cancel();
    let (sender, receiver) = unbounded();
    std::thread::scope(|scope| {
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
        // Ends with the messages, so that the thread above is not waited for in vain.
        let receiver = receiver;
        while let Some(message) = next(&mut server, &receiver, connection, &mut *judges) {
            if matches!(&message, Message::Notification(one) if one.method == Exit::METHOD) {
                return;
            }
            send(connection, server.handle(message));
        }
    });
    Ok(())
}

/// Returns the next message from the client; `None` once the client is gone. While no message arrives, checks changed
/// pipelines and sends their diagnostics.
fn next(
    server: &mut Server,
    messages: &Receiver<Message>,
    connection: &Connection,
    judges: Judges<'_>,
) -> Option<Message> {
    match messages.try_recv() {
        Ok(message) => return Some(message),
        Err(TryRecvError::Disconnected) => return None,
        Err(TryRecvError::Empty) => send(connection, server.tell()),
    }
    loop {
        match messages.recv_timeout(QUIET) {
            Ok(message) => return Some(message),
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) => {}
        }
        server.cancel().clear();
        if !messages.is_empty() {
            continue;
        }
        match server.check(&mut *judges) {
            Some(found) => send(connection, found),
            None => return messages.recv().ok(),
        }
    }
}

/// Sends messages to the client. Does nothing if the client has disconnected.
fn send(connection: &Connection, messages: Vec<Message>) {
    for message in messages {
        let _ = connection.sender.send(message);
    }
}
