//! Names that are written in several places, and get another at once.

use std::collections::BTreeMap;
use std::ops::Range;

use super::{Edit, EditError, Edits};
use crate::source::{Sources, Span};

/// Writes another name at places, perhaps of several files; the edits by the names of the files.
///
/// A place is a part of a string between its quotes, as it is written: [`written`] finds it where the string has escapes.
/// What JSON does not take as it is, is written as an escape.
///
/// # Errors
/// Places that overlap, or that a file does not have.
pub fn rename(
    sources: &Sources,
    places: impl IntoIterator<Item = Span>,
    name: &str,
) -> Result<BTreeMap<String, Edits>, EditError> {
    let quoted = serde_json::Value::from(name).to_string();
    let name = &quoted[1..quoted.len() - 1];
    in_files(sources, places.into_iter().map(|place| (place, name.to_owned())))
}

/// The place of a range of what a string says, in the text of the string. It has its quotes, and perhaps escapes.
pub fn written(sources: &Sources, string: Span, range: Range<usize>) -> Option<Span> {
    let text = sources.text(string).strip_prefix('"')?.strip_suffix('"')?;
    let (mut said, mut at) = (0, 0);
    let mut start = None;
    loop {
        if said == range.start {
            start.get_or_insert(at);
        }
        if said >= range.end {
            let start = start.filter(|_| said == range.end)?;
            return Some(string.inside(start + 1..at + 1));
        }
        let rest = text.get(at..)?;
        let (length, meant) = match rest.as_bytes() {
            [b'\\', b'u', ..] => match code_unit(rest)? {
                // Half of a pair.
                0xd800..0xdc00 => (12, 4),
                unit => (6, char::from_u32(unit)?.len_utf8()),
            },
            [b'\\', ..] => (2, 1),
            _ => rest.chars().next().map(|character| (character.len_utf8(), character.len_utf8()))?,
        };
        (at, said) = (at + length, said + meant);
    }
}

fn code_unit(escape: &str) -> Option<u32> {
    u32::from_str_radix(escape.get(2..6)?, 16).ok()
}

/// The edits of replacements in files, by the names of these. The very same twice is made once.
pub(super) fn in_files(
    sources: &Sources,
    replacements: impl IntoIterator<Item = (Span, String)>,
) -> Result<BTreeMap<String, Edits>, EditError> {
    let mut files: BTreeMap<String, Vec<Edit>> = BTreeMap::new();
    for (span, replacement) in replacements {
        let range = span.range();
        let file = sources.get(span.file).filter(|file| file.text().get(range.clone()).is_some());
        let file = file.ok_or(EditError::Outside(range.clone()))?;
        let (edits, edit) = (files.entry(file.name().to_owned()).or_default(), Edit { range, replacement });
        if !edits.contains(&edit) {
            edits.push(edit);
        }
    }
    files.into_iter().map(|(name, edits)| Ok((name, Edits::new(edits)?))).collect()
}
