//! Standard output and standard error.
//!
//! Everything that commands print goes through here. A reader that has seen enough and closes its end, such as `head` or
//! a pager, is no error, and the exit status does not depend on it; the macros of the standard library would panic.

use std::io::Write as _;

/// Prints a text to standard output.
pub(crate) fn print(text: &str) {
    print_bytes(text.as_bytes());
}

/// Prints bytes to standard output: a binary module, for one.
pub(crate) fn print_bytes(bytes: &[u8]) {
    let mut output = std::io::stdout().lock();
    let _ = output.write_all(bytes).and_then(|()| output.flush());
}

/// Prints a text to standard error.
pub(crate) fn complain(text: &str) {
    let mut output = std::io::stderr().lock();
    let _ = output.write_all(text.as_bytes()).and_then(|()| output.flush());
}
