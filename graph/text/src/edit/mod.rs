//! Changes of texts as values: made of a document, applied, composed and taken back.
//!
//! An editor, a formatter and a graph that is changed by hand all want the same: to change little in a text that
//! somebody laid out and commented. So an edit is a function from a text and a [value](crate::document::Value) in it to
//! [`Edits`], replacements of byte ranges, and never prints the document again:
//!
//! - [`set`] a value, and of an array or object only what differs;
//! - [`insert`], [`remove`] and [`reorder`] members and elements, each with its comma, its comments and the layout of
//!   its neighbours (`layout` finds what belongs to a member, `arrange` writes);
//! - [`rename_declaration`] and all its uses, or [`rename`] what stands at places, perhaps in several files and in
//!   strings with escapes;
//! - [`between`] two texts that differ in space only, as formatting leaves them;
//! - [`mend`] what diagnostics have fixes for.
//!
//! [`Edits::inverse`] gives the text back byte for byte. [`Edits::and`] makes two changes of one text one;
//! [`Edits::then`] makes two changes one after the other one.
//!
//! Comments stay, except those that belong to what is removed: those before it up to a blank line, and those behind it
//! on its line. New lines end as the first line of the text ends, and are indented as their neighbours.
//!
//! Limits: a value that is replaced by one of another kind takes the comments inside it along. Values are those of one
//! text, as [`parse`](crate::document::parse) gives them, and not of several that were composed.

mod arrange;
mod layout;
mod mend;
mod rename;
mod set;
mod space;
#[cfg(test)]
mod tests;

pub use arrange::{Item, insert, remove, reorder};
pub use mend::mend;
pub use rename::{rename, rename_declaration, written};
pub use set::{save, set};
pub use space::between;

use std::ops::Range;

/// A replacement of a byte range of a source text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// The byte range to replace; an empty range is an insertion.
    pub range: Range<usize>,
    /// The text that replaces the range; empty to remove the range.
    pub replacement: String,
}

/// Edits of one source text, in the order of their byte ranges and without overlaps.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Edits {
    list: Vec<Edit>,
}

/// The error of an edit that cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EditError {
    /// Two replacements of the same bytes, two insertions at one position, or an insertion next to a removed range.
    #[error("the bytes {0:?} and {1:?} of one text are to be replaced at once")]
    Overlap(Range<usize>, Range<usize>),
    /// A byte range beyond the end of the text, or with a bound inside a character.
    #[error("the text has no part {0:?}")]
    Outside(Range<usize>),
    /// A value that is neither an array nor an object, or that has members outside of the edited text.
    #[error("this is no array or object of the text")]
    NoContainer,
    /// A position beyond the last member or element of the object or array.
    #[error("there is no position {at} among {count}")]
    NoPosition {
        /// The requested position, from 0.
        at: usize,
        /// The number of positions that exist.
        count: usize,
    },
    /// An object member without a key, or an array element with a key.
    #[error("members of an object have keys, and elements of an array none")]
    Key,
    /// A key that the object already has, or a new name that another declaration already has.
    #[error("\"{0}\" is there already")]
    KeyTaken(String),
    /// A string that is not a valid name: an ASCII letter followed by ASCII letters, digits and underscores.
    #[error("\"{0}\" is no name: names begin with a letter and consist of letters, digits and \"_\"")]
    NoName(String),
    /// A new name that the expression language reserves, such as `viewport`.
    #[error("\"{0}\" is a word of the expression language; choose another name")]
    Reserved(String),
    /// A use of a declaration whose source does not spell out the name, such as a name composed with a loop variable.
    #[error("{file} uses \"{name}\" at the bytes {range:?} and does not write the name there")]
    NotWritten {
        /// The name that is used.
        name: String,
        /// The name of the file that contains the use.
        file: String,
        /// The byte range of the use.
        range: Range<usize>,
    },
}

impl Edits {
    /// Collects edits of one text, in any order.
    ///
    /// # Errors
    /// Edits that overlap.
    pub fn new(edits: impl IntoIterator<Item = Edit>) -> Result<Self, EditError> {
        let mut list: Vec<Edit> = edits.into_iter().collect();
        list.sort_by_key(|edit| (edit.range.start, edit.range.end));
        let clash = list.windows(2).find(|two| {
            let [first, second] = [&two[0].range, &two[1].range];
            // What is inserted beside something that is removed was meant to stand beside it.
            let is_lost =
                |one: &Edit, other: &Edit| one.range.is_empty() && other.replacement.trim().is_empty();
            second.start < first.end
                || first == second
                || second.start == first.end && (is_lost(&two[0], &two[1]) || is_lost(&two[1], &two[0]))
        });
        match clash {
            Some(two) => Err(EditError::Overlap(two[0].range.clone(), two[1].range.clone())),
            None => Ok(Self { list }),
        }
    }

    /// Returns `true` if there are no edits.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Iterates over the edits in the order of their ranges.
    pub fn iter(&self) -> std::slice::Iter<'_, Edit> {
        self.list.iter()
    }

    /// Returns the text with the edits applied.
    ///
    /// # Errors
    /// A range outside of the text, which happens if the edits belong to another text.
    pub fn apply(&self, text: &str) -> Result<String, EditError> {
        let mut edited = String::with_capacity(text.len());
        let mut at = 0;
        for Edit { range, replacement } in &self.list {
            edited.push_str(part(text, at..range.start)?);
            edited.push_str(replacement);
            part(text, range.clone())?;
            at = range.end;
        }
        edited.push_str(part(text, at..text.len())?);
        Ok(edited)
    }

    /// Returns the edits that restore `text` from the result of applying these edits to it.
    ///
    /// # Errors
    /// A range outside of the text.
    pub fn inverse(&self, text: &str) -> Result<Self, EditError> {
        let mut inverse: Vec<Edit> = Vec::new();
        let (mut at, mut new) = (0, 0);
        for Edit { range, replacement } in &self.list {
            new += part(text, at..range.start)?.len();
            let old = part(text, range.clone())?;
            at = range.end;
            let (start, end) = (new, new + replacement.len());
            new = end;
            match inverse.last_mut().filter(|last| last.range.end == start) {
                // What was removed side by side is put back at one place.
                Some(last) => {
                    last.range.end = end;
                    last.replacement.push_str(old);
                }
                None => inverse.push(Edit { range: start..end, replacement: old.to_owned() }),
            }
        }
        Ok(Self { list: inverse })
    }

    /// Joins these edits with others of the same text.
    ///
    /// # Errors
    /// Edits that overlap.
    pub fn and(&self, others: &Self) -> Result<Self, EditError> {
        Self::new(self.iter().chain(others.iter()).cloned())
    }

    /// Combines these edits with `next`, edits of the resulting text, into one set of edits of the original text.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        let (mut pieces, mut kept, mut at) = (Pieces::of(self), Vec::new(), 0);
        for Edit { range, replacement } in &next.list {
            kept.append(&mut pieces.take(range.start - at));
            pieces.take(range.len());
            kept.push(Piece::New(replacement));
            at = range.end;
        }
        kept.append(&mut pieces.take(usize::MAX));
        let (mut list, mut at, mut replacement) = (Vec::new(), 0, String::new());
        for piece in kept {
            match piece {
                Piece::New(text) => replacement.push_str(text),
                Piece::Old(range) => {
                    if at < range.start || !replacement.is_empty() {
                        list.push(Edit {
                            range: at..range.start,
                            replacement: std::mem::take(&mut replacement),
                        });
                    }
                    at = range.end;
                }
            }
        }
        Self { list }
    }
}

/// A part of an edited text: a byte range of the original text, or new text.
enum Piece<'t> {
    Old(Range<usize>),
    New(&'t str),
}

/// The remaining parts of an edited text in reverse order, so that the next one is last.
struct Pieces<'t> {
    rest: Vec<Piece<'t>>,
}

impl<'t> Pieces<'t> {
    /// Returns the parts of the edited text. The length of the original text is unknown, so the last byte range is
    /// unbounded.
    fn of(edits: &'t Edits) -> Self {
        let (mut rest, mut at) = (Vec::new(), 0);
        for Edit { range, replacement } in &edits.list {
            rest.extend([Piece::Old(at..range.start), Piece::New(replacement)]);
            at = range.end;
        }
        rest.push(Piece::Old(at..usize::MAX));
        rest.reverse();
        Self { rest }
    }

    /// Removes and returns the parts that make up the next `bytes` bytes of the edited text.
    fn take(&mut self, mut bytes: usize) -> Vec<Piece<'t>> {
        let mut taken = Vec::new();
        while bytes > 0
            && let Some(piece) = self.rest.pop()
        {
            let (first, rest, length) = match piece {
                Piece::Old(Range { start, end }) => {
                    let cut = end.min(start.saturating_add(bytes));
                    (Piece::Old(start..cut), Piece::Old(cut..end), cut - start)
                }
                Piece::New(text) => {
                    let (first, rest) = text.split_at_checked(bytes).unwrap_or((text, ""));
                    (Piece::New(first), Piece::New(rest), first.len())
                }
            };
            bytes -= length;
            if bytes == 0 {
                self.rest.push(rest);
            }
            if length > 0 {
                taken.push(first);
            }
        }
        taken
    }
}

fn part(text: &str, range: Range<usize>) -> Result<&str, EditError> {
    text.get(range.clone()).ok_or(EditError::Outside(range))
}
