//! The canonical layout of pipeline texts.
//!
//! A text is parsed first, so that only what the parser takes is ever touched. Then its raw tokens are read into a tree
//! that keeps comments and the author's line breaks (`scan`), and the tree is printed (`print`). Keys and scalars are
//! copied letter by letter: no value can change.
//!
//! As in gofmt the author decides where lines end, and the formatter everything else. A container that stands on one
//! line stays on one if it fits into [`WIDTH`] characters; one that is broken stays broken, and its members that share
//! a line go on sharing it while they fit. A container on one line that is too long is broken with one member per line,
//! an array of scalars with as many as fit; where a container has one member, which is a container itself, the two open
//! and close together: `[{ … }]`. At most one blank line stands between two members.
//!
//! Comments stay with what they are about: those behind an element on its line, those before the next. Between a key
//! and its value there is no room for any; they go before the key.
//!
//! Formatting twice is formatting once.

mod print;
mod scan;
#[cfg(test)]
pub(crate) mod tests;
mod tree;

pub(crate) use print::print_value;

use super::{Document, parse};
use crate::diagnostic::Diagnostics;
use crate::edit::{Edits, between};
use crate::source::{FileId, Sources};

/// The maximum width, in characters, of a line that holds several members. A key with its scalar, or a comment, may be
/// longer.
pub const WIDTH: usize = 140;

/// The number of spaces of indentation for each level.
pub(crate) const INDENT: usize = 2;

/// Returns the edits that give a registered source text the canonical layout, with its comments kept.
///
/// # Errors
/// The diagnostics of [`parse`].
pub fn format(sources: &Sources, file: FileId) -> Result<Edits, Diagnostics> {
    parse(sources, file).valid()?;
    let text = sources.get(file).map(|file| file.text().clone()).unwrap_or_else(|| "".into());
    Ok(between(&text, &print::print(&scan::scan(&text))))
}

/// Prints a document as strict JSON (RFC 8259) without comments. Equal values give equal text, whatever the layout of
/// their source.
pub fn strict(document: &Document) -> String {
    print_value(None, &document.root.to_json(), 0, 0, 0) + "\n"
}
