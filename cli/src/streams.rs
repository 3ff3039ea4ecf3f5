//! Standard output and standard error.
//!
//! Everything that commands print goes through here, in a form that commands no terminal: what names and excerpts of
//! files say to one is written out. Only what is a file's own text, for another program, goes out as it is, unless a
//! terminal is what reads it.
//!
//! A reader that has seen enough and closes its end, such as `head` or a pager, is no error, and the exit status does not
//! depend on it. Output that is lost otherwise, since a disk is full for one, is: [`is_lost`].

use std::io::{ErrorKind, IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};

use umbragraph::diagnostic::render::{visible, visible_json};

/// Whether something could not be written to standard output.
static LOST: AtomicBool = AtomicBool::new(false);

/// Prints a text for people to standard output.
pub(crate) fn print(text: &str) {
    write(visible(text).as_bytes());
}

/// Prints JSON to standard output.
pub(crate) fn print_json(text: &str) {
    write(visible_json(text).as_bytes());
}

/// Prints the contents of a file, or of what is to become one, to standard output.
pub(crate) fn print_contents(bytes: &[u8]) {
    if std::io::stdout().is_terminal() {
        print(&String::from_utf8_lossy(bytes));
    } else {
        write(bytes);
    }
}

/// Prints a text to standard error.
pub(crate) fn complain(text: &str) {
    let mut output = std::io::stderr().lock();
    let _ = output.write_all(visible(text).as_bytes()).and_then(|()| output.flush());
}

/// Whether something that was printed is lost.
pub(crate) fn is_lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

fn write(bytes: &[u8]) {
    let mut output = std::io::stdout().lock();
    let result = output.write_all(bytes).and_then(|()| output.flush());
    let Some(error) = result.err().filter(|error| error.kind() != ErrorKind::BrokenPipe) else { return };
    if !LOST.swap(true, Ordering::Relaxed) {
        complain(&format!("standard output cannot be written: {error}\n"));
    }
}
