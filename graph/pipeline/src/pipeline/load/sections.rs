//! Keys of a document that are misspelt: those of sections, and all within passes.
//!
//! A section that is missing only because its key is misspelt would have every name in it missing too, and a pass with
//! a misspelt key would have no other diagnostics. Where the key has a fix, everything after it is checked as if it had
//! been made, so that the document has the diagnostics that it will have then;
//! [`as_written`](umbragraph_text::compose::as_written) lets their pointers name the section as it is written. Other
//! unknown keys of passes are left out.

use std::collections::BTreeSet;

use crate::node::Registry;
use umbragraph_text::compose::is_incomplete;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of, suggested_name};
use umbragraph_text::document::{Document, Entry, Kind, Value};
use umbragraph_text::language::unknown_format;

/// A document whose misspelt keys are corrected.
pub(super) struct AsMeant {
    pub(super) document: Document,
    /// The JSON pointers of the keys as they are written; those within a corrected key have the correct one.
    pub(super) corrected: BTreeSet<String>,
}

/// The maximum number of misspelt keys that contain one another.
const MAX_WITHIN: usize = 8;

/// Checks a document against the schema. The contents of sections and passes with misspelt keys are checked too.
pub fn check_schema(document: &Document, registry: &Registry) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    registry.schema().check(&document.root, "", &mut diagnostics);
    let mut read: Option<AsMeant> = None;
    for _ in 0..MAX_WITHIN {
        let Some(next) = as_meant(document, &diagnostics) else { break };
        if read.as_ref().is_some_and(|read| read.corrected == next.corrected) {
            break;
        }
        diagnostics = diagnostics.into_iter().filter(|one| next.corrected.contains(&one.pointer)).collect();
        registry.schema().check(&next.document.root, "", &mut diagnostics);
        read = Some(next);
    }
    with_formats(read.as_ref().map_or(document, |read| &read.document), diagnostics)
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

/// Returns the document with misspelt keys of sections and passes corrected, to avoid errors about missing parts. Other
/// unknown keys of passes are removed. `None` if there are no such keys.
pub(super) fn as_meant(document: &Document, schema_diagnostics: &Diagnostics) -> Option<AsMeant> {
    let is_of_key = |one: &&Diagnostic| one.code == codes::UNKNOWN_KEY;
    let mut keys: Vec<&Diagnostic> = schema_diagnostics.iter().filter(is_of_key).collect();
    if keys.is_empty() {
        return None;
    }
    // A key within another one is found under the correct key of that.
    keys.sort_by_key(|one| one.pointer.matches('/').count());
    let mut read = AsMeant { document: document.clone(), corrected: BTreeSet::new() };
    for one in keys {
        let Some((above, key)) = one.pointer.rsplit_once('/') else { continue };
        let key = unescaped(key);
        let meant = match one.fix.as_ref().map(|fix| fix.edits.as_slice()) {
            Some([edit]) if above.is_empty() || above.starts_with("/passes/") => {
                Some(edit.replacement.trim_matches('"'))
            }
            None if above.starts_with("/passes/") && one.message == format!("unknown key \"{key}\"") => None,
            _ => continue,
        };
        let Some(entries) = entries_at(&mut read.document.root, above) else { continue };
        // What a file below says under the right key stays as it is.
        let is_taken = entries.iter().any(|entry| Some(entry.key.as_str()) == meant);
        let Some(at) = entries.iter().position(|entry| entry.key == key && !is_taken) else { continue };
        match meant {
            Some(meant) => meant.clone_into(&mut entries[at].key),
            None => drop(entries.remove(at)),
        }
        read.corrected.insert(one.pointer.clone());
    }
    (!read.corrected.is_empty()).then_some(read)
}

fn unescaped(token: &str) -> String {
    token.replace("~1", "/").replace("~0", "~")
}

/// The members of the object at a JSON pointer; `None` if there is no object.
fn entries_at<'v>(root: &'v mut Value, pointer: &str) -> Option<&'v mut Vec<Entry>> {
    let below = |value: &'v mut Value, token: &str| match &mut value.kind {
        Kind::Object(entries) => {
            let key = unescaped(token);
            entries.iter_mut().find(|entry| entry.key == key).map(|entry| &mut entry.value)
        }
        Kind::Array(elements) => elements.get_mut(token.parse::<usize>().ok()?),
        _ => None,
    };
    match &mut pointer.split('/').skip(1).try_fold(root, below)?.kind {
        Kind::Object(entries) => Some(entries),
        _ => None,
    }
}

/// Returns `true` if a diagnostic concerns a pass that extends missing or broken shared settings, so that the
/// diagnostic may only follow from their error.
pub(super) fn is_of_incomplete(document: &Document, diagnostic: &Diagnostic) -> bool {
    let ends = diagnostic.pointer.match_indices('/').map(|(at, _)| at).chain([diagnostic.pointer.len()]);
    let owners = ends.map(|end| document.root.nearest(&diagnostic.pointer[..end]));
    owners.into_iter().any(is_incomplete)
}
