//! Laying one document over another, and putting one beside another.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use crate::document::{Entry, Keys, Kind, Pointer, Value};
use crate::source::Span;

/// The sections of a pipeline to which an included file may add members.
pub const SECTIONS: &[&str] = &[
    "parameters",
    "features",
    "derived",
    "constraints",
    "geometry",
    "resources",
    "passes",
    "toggles",
    "presets",
    "extension_points",
    "shared_settings",
    "subgraphs",
];

/// The values that other files have overridden or deleted, by JSON pointer.
#[derive(Debug, Default)]
pub(super) struct Changes {
    /// The spans of the overridden values, newest first.
    pub(super) replaced: BTreeMap<String, Vec<Span>>,
    /// The spans of the `null`s that deleted values, by the JSON pointer of the deleted value.
    pub(super) deleted: BTreeMap<String, Span>,
}

impl Changes {
    fn remember(&mut self, pointer: &Pointer<'_>, span: Span) {
        self.replaced.entry(pointer.to_string()).or_default().insert(0, span);
    }
}

/// Returns `base` overridden by `value`: objects are merged by key, other values replaced, and `null` deletes members.
pub(super) fn over(
    base: Value,
    value: Value,
    pointer: &Pointer<'_>,
    changes: &mut Changes,
    diagnostics: &mut Diagnostics,
) -> Value {
    lay_over(base, value, pointer, false, changes, diagnostics)
}

/// Overrides `base` with `value`, as [`over`] does. If `keeps` is `true`, `null`s that delete members stay in the
/// result. A pass that extends shared settings needs them, since they delete members of the group later.
fn lay_over(
    base: Value,
    value: Value,
    pointer: &Pointer<'_>,
    keeps: bool,
    changes: &mut Changes,
    diagnostics: &mut Diagnostics,
) -> Value {
    let (mut entries, newer) = match (base.kind, value.kind) {
        (Kind::Object(entries), Kind::Object(newer)) => (entries, newer),
        (base_kind, kind) => {
            // What stood below an object goes with it; a file that several files extend replaces nothing of its own.
            if base.span == value.span {
                return Value { span: value.span, kind };
            }
            changes.remember(pointer, Value { span: base.span, kind: base_kind }.span);
            let mut value = Value { span: value.span, kind };
            if !keeps {
                reject_deletions(&mut value, pointer, changes, diagnostics);
            }
            return value;
        }
    };
    let keeps = keeps || takes_over(&newer, pointer) || takes_over(&entries, pointer);
    // The keys that a misspelt deletion cannot have meant.
    let deletes = newer.iter().any(|entry| matches!(entry.value.kind, Kind::Null));
    let written: Vec<String> = newer.iter().filter(|_| deletes).map(|entry| entry.key.clone()).collect();
    let mut keys = Keys::default();
    let mut deleted: BTreeSet<usize> = BTreeSet::new();
    for mut entry in newer {
        let at = pointer.key(&entry.key);
        match (keys.find(&entries, &entry.key), &entry.value.kind) {
            (Some(index), Kind::Null) => {
                changes.remember(&at, entries[index].value.span);
                changes.deleted.insert(at.to_string(), entry.value.span);
                match keeps {
                    true => entries[index] = entry,
                    false => drop(deleted.insert(index)),
                }
            }
            // A file below has lost what stood there.
            (None, Kind::Null) if changes.deleted.get(&at.to_string()) == Some(&entry.value.span) => {}
            (None, Kind::Null) if !keeps => {
                let message = format!("there is no \"{}\" to delete", entry.key);
                let diagnostic = Diagnostic::error(codes::DELETES_NOTHING, entry.key_span, message);
                let left = entries.iter().enumerate().filter(|(index, _)| !deleted.contains(index));
                let names = left.map(|(_, known)| known.key.as_str());
                let taken = |name: &str| written.iter().any(|key| key == name);
                let diagnostic =
                    diagnostic.suggest_unless(&entry.key, names, Some(entry.key_span), taken, |_| {
                        "null deletes what the extended file has under that key".to_owned()
                    });
                diagnostics.push(diagnostic.pointer(&at));
            }
            (Some(index), _) => {
                let span = entries[index].value.span;
                let below = std::mem::replace(&mut entries[index].value, Value { span, kind: Kind::Null });
                entries[index].value = lay_over(below, entry.value, &at, keeps, changes, diagnostics);
                entries[index].key_span = entry.key_span;
            }
            (None, _) => {
                if !keeps {
                    reject_deletions(&mut entry.value, &at, changes, diagnostics);
                }
                entries.push(entry);
            }
        }
    }
    let mut index = 0..entries.len();
    entries.retain(|_| !index.next().is_some_and(|index| deleted.contains(&index)));
    Value { span: value.span, kind: Kind::Object(entries) }
}

/// Returns `true` if `entries` are the members of a pass, or of a group of shared settings, that extends shared
/// settings. `pointer` is the JSON pointer of that pass or group.
fn takes_over(entries: &[Entry], pointer: &Pointer<'_>) -> bool {
    let names = |entry: &Entry| matches!(entry.value.kind, Kind::Text(_) | Kind::Array(_));
    if !entries.iter().any(|entry| entry.key == "extends" && names(entry)) {
        return false;
    }
    let pointer = pointer.to_string();
    let way: Vec<&str> = pointer.split('/').skip(1).collect();
    matches!(
        way.as_slice(),
        ["passes" | "shared_settings", _]
            | ["subgraphs", _, "passes" | "shared_settings", _]
            | ["inserts", _, _]
    )
}

/// Removes and reports `null`s that delete nothing, so that they are not read as values.
pub(super) fn reject_deletions(
    value: &mut Value,
    pointer: &Pointer<'_>,
    changes: &Changes,
    diagnostics: &mut Diagnostics,
) {
    match &mut value.kind {
        Kind::Object(entries) if takes_over(entries, pointer) => {}
        Kind::Object(entries) => entries.retain_mut(|entry| {
            let at = pointer.key(&entry.key);
            if !matches!(entry.value.kind, Kind::Null) {
                reject_deletions(&mut entry.value, &at, changes, diagnostics);
                return true;
            }
            // A file below has lost what stood there.
            if changes.deleted.get(&at.to_string()) == Some(&entry.value.span) {
                return false;
            }
            let message = format!("there is no \"{}\" to delete", entry.key);
            diagnostics.push(
                Diagnostic::error(codes::DELETES_NOTHING, entry.key_span, message)
                    .pointer(&at)
                    .help("null deletes what an extended file has under that key; leave the key out"),
            );
            false
        }),
        Kind::Array(elements) => {
            for (at, element) in elements.iter_mut().enumerate() {
                reject_deletions(element, &pointer.element(at), changes, diagnostics);
            }
        }
        _ => {}
    }
}

/// Adds the sections of an included document to `whole`; a member that exists in both documents is an error.
pub(super) fn beside(whole: &mut Value, part: Value, diagnostics: &mut Diagnostics) {
    let Kind::Object(part_entries) = part.kind else {
        let message = "an included file is an object with sections of a pipeline";
        diagnostics.push(
            Diagnostic::error(codes::WRONG_TYPE, part.span, message)
                .help("start it with { and a section such as \"parameters\""),
        );
        return;
    };
    let Kind::Object(entries) = &mut whole.kind else { return };
    let sections: Vec<String> = part_entries.iter().map(|section| section.key.clone()).collect();
    for section in part_entries {
        if matches!(section.key.as_str(), "$schema" | "format" | "name" | "description") {
            continue;
        }
        if !SECTIONS.contains(&section.key.as_str()) {
            let message = format!("an included file cannot say \"{}\"", section.key);
            let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, section.key_span, message);
            let (known, written) = (SECTIONS.iter().copied(), Some(section.key_span));
            let taken = |name: &str| sections.iter().any(|key| key == name);
            diagnostics.push(diagnostic.suggest_unless(&section.key, known, written, taken, |known| {
                format!("its sections are {}", list_of(known))
            }));
            continue;
        }
        let Some(index) = entries.iter().position(|known| known.key == section.key) else {
            entries.push(section);
            continue;
        };
        let (Kind::Object(known), Kind::Object(added)) = (&mut entries[index].value.kind, section.value.kind)
        else {
            continue;
        };
        let mut keys = Keys::default();
        for entry in added {
            match keys.find(known, &entry.key).and_then(|at| known.get(at)) {
                Some(other) if other.key_span == entry.key_span => diagnostics.push(
                    Diagnostic::error(
                        codes::DUPLICATE_KEY,
                        entry.key_span,
                        format!("the file with \"{}\" is included twice", entry.key),
                    )
                    .help("include it once, in the file that includes those that need it"),
                ),
                Some(other) => diagnostics.push(
                    Diagnostic::error(
                        codes::DUPLICATE_KEY,
                        entry.key_span,
                        format!(
                            "\"{}\" of the included file stands in \"{}\" already",
                            entry.key, section.key
                        ),
                    )
                    .related(other.key_span, "it stands here")
                    .help(
                        "an include adds and never changes; a file changes what another says if it extends it: \
                         \"extends\": [\"one.json\", \"other.json\"], where the last counts",
                    ),
                ),
                None => known.push(entry),
            }
        }
    }
}
