//! Names that are written in several places, and get another at once.
//!
//! [`rename_declaration`] takes the places from the [model](crate::model): the declaration, its uses, and the same keys
//! in every file of the document. Files declare over what they extend, and so do their presets and arguments.
//!
//! Limits: a name that a use puts together (`soft_{i}`) is an error, since no text there is the name. Texts that
//! another file replaced are not in the document, and keep the old name. Templates are not known here: an axis takes
//! the value of its own name, which the session's rename keeps.

use std::collections::BTreeMap;
use std::ops::Range;

use super::{Edit, EditError, Edits};
use crate::compose::{Composed, Layer};
use crate::document::{Document, parse, pointer_join};
use crate::model::{Declaration, DeclarationKind, Id, Model};
use crate::source::{Sources, Span};

/// Names that no declaration can have, because the expression language uses them.
const RESERVED: [&str; 3] = ["viewport", "true", "false"];

/// Returns the edits that replace the source at the given spans with a name, grouped by file name.
///
/// Each span must lie inside a JSON string, between its quotes; [`written`] finds the span in a string with escapes.
/// Characters of the name that JSON does not allow in strings are escaped.
///
/// # Errors
/// Spans that overlap, or that are outside of their file.
pub fn rename(
    sources: &Sources,
    places: impl IntoIterator<Item = Span>,
    name: &str,
) -> Result<BTreeMap<String, Edits>, EditError> {
    let quoted = serde_json::Value::from(name).to_string();
    let name = &quoted[1..quoted.len() - 1];
    in_files(sources, places.into_iter().map(|place| (place, name.to_owned())))
}

/// Returns the edits that rename a declaration and all its uses, grouped by file name.
///
/// # Errors
/// An old or new name that is not a valid identifier; the path of a subgraph file is none. A new name that expressions
/// reserve, or that another declaration visible in the same scope already has. A use whose source does not spell out
/// the old name.
pub fn rename_declaration(
    sources: &Sources,
    composed: &Composed,
    model: &Model,
    id: Id,
    name: &str,
) -> Result<BTreeMap<String, Edits>, EditError> {
    let declaration = model.declaration(id);
    let is_name = |name: &str| {
        name.starts_with(|first: char| first.is_ascii_alphabetic()) && name.chars().all(is_of_name)
    };
    // A subgraph in a file of its own is named by its path.
    if let Some(other) = [name, &declaration.name].into_iter().find(|name| !is_name(name)) {
        return Err(EditError::NoName(other.to_owned()));
    }
    if RESERVED.contains(&name) {
        return Err(EditError::Reserved(name.to_owned()));
    }
    // The variable of a loop is seen where its pass is.
    let owner = |one: &Declaration| match one.kind {
        DeclarationKind::Variable => one.owner.and_then(|pass| model.declaration(pass).owner),
        _ => one.owner,
    };
    let own = owner(declaration);
    let is_seen = |other: &Declaration| {
        let of_other = owner(other);
        of_other == own || of_other.is_none() || own.is_none()
    };
    if model.declarations().any(|(_, other)| other.name == name && is_seen(other)) {
        return Err(EditError::KeyTaken(name.to_owned()));
    }
    let mut places = vec![name_at(sources, declaration.place, &declaration.name)?];
    for one in model.uses_of(id) {
        places.push(name_at(sources, one.place, &declaration.name)?);
    }
    let pointers = keys_of(model, declaration);
    for file in &composed.files {
        let of_file = sources.get(*file).map_or("", |file| file.name());
        // A subgraph in a file of its own stands in the document under its path.
        let subgraph = match composed.layers.get(file) {
            Some(Layer::Used) => pointer_join("/subgraphs", of_file),
            _ => String::new(),
        };
        let Document { root } = parse(sources, *file).document;
        for pointer in pointers.iter().filter_map(|pointer| pointer.strip_prefix(subgraph.as_str())) {
            let (above, _) = pointer.rsplit_once('/').unwrap_or_default();
            let owner = above.split('/').skip(1).try_fold(&root, |value, key| value.get(&unescaped(key)));
            if let Some(entry) = owner.and_then(|owner| owner.entry(&declaration.name)) {
                places.push(name_at(sources, entry.key_span, &declaration.name)?);
            }
        }
    }
    rename(sources, places, name)
}

/// Returns the JSON pointers at which files can have the name of a declaration as a key: the declaration itself, and
/// the presets and passes that can give it a value. A file may replace or delete the value of another one there.
fn keys_of(model: &Model, declaration: &Declaration) -> Vec<String> {
    use DeclarationKind as K;
    let Declaration { kind, name, owner, pointer, .. } = declaration;
    if *kind == K::Data {
        return Vec::new();
    }
    let mut pointers = vec![pointer.clone()];
    let mut push = |above: &str, key| pointers.push(pointer_join(&format!("{above}/{key}"), name));
    for (_, other) in model.declarations() {
        match (other.kind, kind) {
            (K::Preset, K::Parameter) if owner.is_none() => push(&other.pointer, "parameters"),
            (K::Preset, K::Feature) if owner.is_none() => push(&other.pointer, "features"),
            (K::Pass, K::Resource | K::Input) if other.owner == *owner => push(&other.pointer, "passthrough"),
            _ => {}
        }
    }
    if let (K::Parameter | K::Input, Some(subgraph)) = (kind, *owner) {
        model.uses_of(subgraph).for_each(|used| push(&model.declaration(used.within).pointer, "with"));
    }
    pointers
}

/// Returns the span of a name inside the span `place`: at the start of `place`, or as the only occurrence of the word
/// in a JSON string. An error if the name is not found, or occurs several times in the string.
fn name_at(sources: &Sources, place: Span, name: &str) -> Result<Span, EditError> {
    let text = sources.text(place);
    let begins = |text: &str| text.strip_prefix(name).is_some_and(|rest| !rest.starts_with(is_of_name));
    let found = if begins(text) {
        Some(place.inside(0..name.len()))
    } else {
        // A string that has escapes is all that is known of the place.
        let said: Option<String> = serde_json::from_str(text).ok();
        let said = said.unwrap_or_default();
        let ends_word =
            |at: &usize| begins(&said[*at..]) && !said[..*at].ends_with(|c| is_of_name(c) || c == '.');
        let mut found = said.match_indices(name).map(|(at, _)| at).filter(ends_word);
        let first = found.next().filter(|_| found.next().is_none());
        first.and_then(|at| written(sources, place, at..at + name.len()))
    };
    let file = sources.get(place.file).map_or("", |file| file.name());
    found.ok_or_else(|| EditError::NotWritten {
        name: name.to_owned(),
        file: file.to_owned(),
        range: place.range(),
    })
}

fn is_of_name(character: char) -> bool {
    character.is_ascii_alphanumeric() || character == '_'
}

fn unescaped(key: &str) -> String {
    key.replace("~1", "/").replace("~0", "~")
}

/// Converts a byte range of a JSON string's unescaped contents to the span of the source that encodes it. `string` is
/// the span of the string with its quotes. `None` if the range exceeds the contents or cuts a character.
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

/// Converts replacements of spans to edits, grouped by file name. Duplicate replacements are made only once.
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
