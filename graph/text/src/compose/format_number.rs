//! The number of the format that a file is written in: one that this version does not know ends the reading of the file.
//!
//! Such a file may mean something else by the same words, so its number is the only mistake that is reported.

use crate::diagnostic::{Diagnostic, codes};
use crate::document::{Kind, Value};

/// The version of the file format that this version of the engine reads.
const KNOWN: f64 = 1.0;

/// Returns a diagnostic if the number under `"format"` is not 1. `None` also for a missing key or a value that is not a
/// number, which the schema check reports.
pub fn other_format(root: &Value) -> Option<Diagnostic> {
    let value = root.get("format")?;
    let Kind::Number(number) = &value.kind else { return None };
    let number = number.as_f64()?;
    let help = if number > KNOWN {
        "a newer version of umbragraph reads it; a file for this version says \"format\": 1"
    } else {
        "write \"format\": 1"
    };
    (number != KNOWN).then(|| {
        let message = format!("this file is of format {number}; this version reads format {KNOWN}");
        Diagnostic::error(codes::OTHER_FORMAT, value.span, message).pointer("/format").help(help)
    })
}
