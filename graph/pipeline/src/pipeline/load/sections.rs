//! Sections of a document whose key is misspelt.
//!
//! A section that is missing only because its key is misspelt would have every name in it missing too. Where the key
//! has a fix, everything after it is checked as if it had been made, so that the document has the diagnostics that it
//! will have then; [`as_written`](umbragraph_text::compose::as_written) lets their pointers name the section as it is
//! written.

use std::collections::BTreeMap;

use crate::node::Registry;
use umbragraph_text::compose::is_incomplete;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of, suggested_name};
use umbragraph_text::document::{self, Document, Entry};
use umbragraph_text::language::unknown_format;

/// Checks a document against the schema. The contents of sections with misspelt keys are checked too.
pub fn check_schema(document: &Document, registry: &Registry) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    registry.schema().check(&document.root, "", &mut diagnostics);
    if let Some(read) = as_suggested(document, &diagnostics) {
        let mut all: Diagnostics =
            diagnostics.into_iter().filter(|one| suggested_section(one).is_some()).collect();
        registry.schema().check(&read.root, "", &mut all);
        return with_formats(&read, all);
    }
    with_formats(document, diagnostics)
}

/// Moves diagnostics about texture formats to the place of the format.
fn with_formats(document: &Document, diagnostics: Diagnostics) -> Diagnostics {
    let named = |diagnostic: Diagnostic| {
        let is_word =
            diagnostic.code == codes::UNKNOWN_WORD && diagnostic.pointer.contains("/texture/format");
        let value = document.root.nearest(&diagnostic.pointer);
        match value.text().filter(|_| is_word && is_format(&diagnostic.pointer)) {
            Some(name) => unknown_format(name, value.span, diagnostic.pointer),
            None => with_declared(document, diagnostic),
        }
    };
    diagnostics.into_iter().map(named).collect()
}

/// Improves the diagnostic for a parameter or feature without a type. In a file that extends another file, a
/// declaration without a type changes a declaration of the other file, so the name may be misspelt.
fn with_declared(document: &Document, diagnostic: Diagnostic) -> Diagnostic {
    let pointer = diagnostic.pointer.clone();
    let way: Vec<&str> = pointer.split('/').collect();
    if let ["", "passes", name, _] = way[..] {
        return with_pass_below(document, name, diagnostic);
    }
    let ["", section @ ("parameters" | "features"), name] = way[..] else { return diagnostic };
    if diagnostic.code != codes::MISSING_KEY {
        return diagnostic;
    }
    let entries = document.root.entries_of(section);
    let Some(entry) = entries.iter().find(|entry| entry.key == name) else { return diagnostic };
    let declared = || entries.iter().filter(|entry| entry.value.get("type").is_some());
    let names = || declared().map(|entry| entry.key.as_str());
    let file = entry.key_span.file;
    let of_files_below: Vec<&str> =
        declared().filter(|entry| entry.key_span.file != file).map(|entry| entry.key.as_str()).collect();
    let mut diagnostic = diagnostic;
    if !of_files_below.is_empty() {
        let kind = section.trim_end_matches('s');
        diagnostic.message = format!(
            "\"{name}\" is no {kind} of the files that this one extends, and has no \"type\" of its own"
        );
        diagnostic.place = entry.key_span.into();
    }
    match suggested_name(name, names()) {
        Some(meant) if !of_files_below.is_empty() => {
            diagnostic.help(format!("is \"{meant}\" meant? A new one says its \"type\""))
        }
        Some(meant) => {
            let help = format!("did you mean \"{meant}\"? A new one says its \"type\"");
            diagnostic.help(help)
        }
        None if of_files_below.is_empty() => diagnostic,
        None => {
            diagnostic.help(format!("theirs are {}; a new one says its \"type\"", list_of(of_files_below)))
        }
    }
}

/// Improves the diagnostic for a pass whose settings lack a key, if a file below has a pass of nearly the same name:
/// the pass may be meant to change that one.
fn with_pass_below(document: &Document, name: &str, diagnostic: Diagnostic) -> Diagnostic {
    let entries = document.root.entries_of("passes");
    let own = entries.iter().find(|entry| entry.key == name);
    let (Some(own), codes::MISSING_KEY) = (own, diagnostic.code) else { return diagnostic };
    let is_below = |entry: &&Entry| entry.key_span.file != own.key_span.file;
    let below = entries.iter().filter(is_below).map(|entry| entry.key.as_str());
    let Some(meant) = suggested_name(name, below) else { return diagnostic };
    let place = diagnostic.place.clone();
    let missing = diagnostic.message.clone();
    let mut diagnostic = diagnostic;
    diagnostic.message = format!("\"{name}\" is a new pass, and {missing}");
    diagnostic.place = own.key_span.into();
    diagnostic.related(place, missing).help(format!("did you mean \"{meant}\", which the file below has?"))
}

/// Returns `true` if a JSON pointer leads to the format of a texture, or to one of its format candidates.
fn is_format(pointer: &str) -> bool {
    let mut way = pointer.rsplit('/').skip_while(|part| part.bytes().all(|byte| byte.is_ascii_digit()));
    let way: [Option<&str>; 4] = std::array::from_fn(|_| way.next());
    matches!(way, [Some("format"), Some("texture"), Some(_), Some("resources")])
}

/// The section that a misspelt key at the top level means, taken from the fix of its diagnostic; `None` for other
/// diagnostics.
fn suggested_section(diagnostic: &Diagnostic) -> Option<&str> {
    let is_section = diagnostic.code == codes::UNKNOWN_KEY && diagnostic.pointer.matches('/').count() == 1;
    let [edit] = diagnostic.fix.as_ref().filter(|_| is_section)?.edits.as_slice() else { return None };
    Some(edit.replacement.trim_matches('"'))
}

/// Returns the document with misspelt keys of sections corrected, to avoid errors about missing sections. `None` if
/// there are no such keys.
pub(super) fn as_suggested(document: &Document, schema_diagnostics: &Diagnostics) -> Option<Document> {
    let entries = document.root.entries()?;
    // What a file below says under the right key stays as it is.
    let is_there = |section: &str| entries.iter().any(|entry| entry.key == section);
    let suggested: BTreeMap<&str, &str> = schema_diagnostics
        .iter()
        .filter_map(|one| Some((one.pointer.strip_prefix('/')?, suggested_section(one)?)))
        .filter(|(_, section)| !is_there(section))
        .collect();
    if suggested.is_empty() {
        return None;
    }
    let renamed = entries.iter().map(|entry| {
        let key =
            suggested.get(entry.key.as_str()).map_or_else(|| entry.key.clone(), |key| (*key).to_owned());
        Entry { key, ..entry.clone() }
    });
    let kind = document::Kind::Object(renamed.collect());
    Some(Document { root: document::Value { kind, ..document.root.clone() } })
}

/// Returns `true` if a diagnostic concerns a pass that extends missing or broken shared settings, so that the
/// diagnostic may only follow from their error.
pub(super) fn is_of_incomplete(document: &Document, diagnostic: &Diagnostic) -> bool {
    let ends = diagnostic.pointer.match_indices('/').map(|(at, _)| at).chain([diagnostic.pointer.len()]);
    let owners = ends.map(|end| document.root.nearest(&diagnostic.pointer[..end]));
    owners.into_iter().any(is_incomplete)
}
