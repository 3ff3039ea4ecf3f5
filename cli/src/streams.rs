//! Standard output and standard error.
//!
//! Everything that commands print goes through here, in a form that commands no terminal: what names and excerpts of
//! files say to one is written out. Only what is a file's own text, for another program, goes out as it is, unless a
//! terminal is what reads it.
//!
//! A reader that has seen enough and closes its end, such as `head` or a pager, is no error, and the exit status does
//! not depend on it. Output that is lost otherwise, since a disk is full for one, is: [`is_lost`].

use std::io::{ErrorKind, IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};

use umbragraph::diagnostic::render::{visible, visible_json};

/// Set once a write to standard output has failed.
static LOST: AtomicBool = AtomicBool::new(false);
/// Set once the reader has closed standard output.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// Prints text for people to standard output; control characters are made visible.
pub(crate) fn print(text: &str) {
    write(visible(text).as_bytes());
}

/// Prints JSON to standard output; control characters are escaped.
pub(crate) fn print_json(text: &str) {
    write(visible_json(text).as_bytes());
}

/// Prints the contents of a file to standard output, unchanged unless it is a terminal.
pub(crate) fn print_contents(bytes: &[u8]) {
    if std::io::stdout().is_terminal() {
        print(&String::from_utf8_lossy(bytes));
    } else {
        write(bytes);
    }
}

/// Prints a text to standard error; diagnostics have colors on a terminal, unless `NO_COLOR` is set.
pub(crate) fn complain(text: &str) {
    let mut output = std::io::stderr().lock();
    let text = visible(text);
    let has_colors =
        output.is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    let text = if has_colors { colored(&text).into() } else { text };
    let _ = output.write_all(text.as_bytes()).and_then(|()| output.flush());
}

/// Adds terminal colors to diagnostics. Lines of source excerpts begin with a line number, so they stay uncolored.
fn colored(text: &str) -> String {
    const SEVERITIES: [(&str, &str); 3] = [("error", "1;31"), ("warning", "1;33"), ("note", "1;36")];
    let mut out = String::new();
    for line in text.split_inclusive('\n') {
        let severity = SEVERITIES
            .iter()
            .find(|(word, _)| line.strip_prefix(word).is_some_and(|rest| rest.starts_with(['[', ':'])));
        let end = line.find(": ").unwrap_or(0);
        let bare = line.trim_start();
        let (color, length) = match severity {
            Some((_, color)) => (*color, end),
            None if bare.starts_with("= help:") => ("32", line.len() - bare.len() + "= help:".len()),
            None if bare.starts_with("--> ") => ("34", line.trim_end().len()),
            None if bare.starts_with("| ") && bare.contains('^') && bare[1..].trim().starts_with('^') => {
                ("31", line.trim_end().len())
            }
            None => ("", 0),
        };
        if length == 0 {
            out.push_str(line);
        } else {
            out.push_str(&format!("\u{1b}[{color}m{}\u{1b}[0m{}", &line[..length], &line[length..]));
        }
    }
    out
}

/// Returns `true` if some output could not be written.
pub(crate) fn is_lost() -> bool {
    LOST.load(Ordering::Relaxed)
}

/// Returns `true` if the reader has closed standard output.
pub(crate) fn is_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

fn write(bytes: &[u8]) {
    let mut output = std::io::stdout().lock();
    let result = output.write_all(bytes).and_then(|()| output.flush());
    let Err(error) = result else { return };
    if error.kind() == ErrorKind::BrokenPipe {
        CLOSED.store(true, Ordering::Relaxed);
        return;
    }
    if !LOST.swap(true, Ordering::Relaxed) {
        complain(&format!("standard output cannot be written: {error}\n"));
    }
}
