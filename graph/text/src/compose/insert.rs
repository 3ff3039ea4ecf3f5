//! Extensions: passes that another file puts at the named points of a pipeline.
//!
//! A pipeline names points at which it can be extended, with the passes between which they lie:
//!
//! ```jsonc
//! "extension_points": { "after_shading": { "after": ["shade"], "before": ["present"], "description": "scene-referred color" } }
//! ```
//!
//! An extension is a file of its own with `inserts`, and with parameters, features, resources and presets beside:
//!
//! ```jsonc
//! { "format": 1, "name": "grain", "inserts": { "after_shading": { "grain": { "fullscreen": { … } } } } }
//! ```
//!
//! Passes put at one point run in the order in which they are given. The pipeline's own file is not changed: what is
//! put in reads and writes its resources by name, and since references mean the newest version, the passes after the
//! point see what was put in.

use std::collections::BTreeSet;

use super::merge::{self, Changes};
use super::shared_settings::take_over;
use crate::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use crate::document::{Entry, Kind, Value};
use crate::source::Span;

/// Inserts an extension's passes at the extension points of a document, and adds its other sections to those of the
/// document.
pub fn insert(document: &mut Value, extension: Value, diagnostics: &mut Diagnostics) {
    put_in(document, extension, diagnostics);
}

/// Inserts an extension as [`insert`] does, and returns the shared settings that its passes override or delete.
pub(super) fn put_in(document: &mut Value, mut extension: Value, diagnostics: &mut Diagnostics) -> Changes {
    let mut changes = Changes::default();
    let Kind::Object(entries) = &mut extension.kind else {
        diagnostics.push(
            Diagnostic::error(codes::WRONG_TYPE, extension.span, "an extension is an object")
                .help("start it with { and \"inserts\""),
        );
        return changes;
    };
    let inserts = entries.iter().position(|entry| entry.key == "inserts").map(|at| entries.remove(at));
    let Some(inserts) = inserts else {
        diagnostics.push(
            Diagnostic::error(codes::MISSING_KEY, extension.span, "the key \"inserts\" is missing here")
                .help("an extension says under \"inserts\" which passes go to which extension point"),
        );
        return changes;
    };
    let mut passes = Vec::new();
    let mut before: Vec<(String, String, Span)> = Vec::new();
    let points = inserts.value.entries().unwrap_or_default();
    for point in points {
        let Some(limits) = extension_point(document, point, points, diagnostics) else { continue };
        let mut previous = last_inserted(document, &limits.0);
        for pass in point.value.entries().unwrap_or_default() {
            let mut pass = pass.clone();
            let mut after: Vec<(String, Span)> = limits.0.clone();
            after.extend(previous.take());
            add_after(&mut pass.value, &after);
            before.extend(limits.1.iter().map(|name| (name.clone(), pass.key.clone(), pass.key_span)));
            previous = Some((pass.key.clone(), pass.key_span));
            passes.push(pass);
        }
    }
    if let Kind::Object(entries) = &mut extension.kind {
        let span = inserts.value.span;
        for entry in entries.extract_if(.., |entry| entry.key == "passes") {
            diagnostics.push(
                Diagnostic::error(codes::UNKNOWN_KEY, entry.key_span, "an extension cannot say \"passes\"")
                    .pointer("/passes")
                    .help("put them at an extension point of the pipeline, under \"inserts\""),
            );
        }
        entries.push(Entry {
            key: "passes".to_owned(),
            key_span: inserts.key_span,
            value: Value { span, kind: Kind::Object(passes) },
        });
    }
    let keys = |section: &str| -> BTreeSet<String> {
        extension.entries_of(section).iter().map(|entry| entry.key.clone()).collect()
    };
    let (own_passes, own_subgraphs) = (keys("passes"), keys("subgraphs"));
    merge::beside(document, extension, diagnostics);
    let is_own = |section: &str, name: &str| match section {
        "passes" => own_passes.contains(name),
        _ => own_subgraphs.contains(name),
    };
    take_over(document, &is_own, &mut changes, diagnostics);
    for (later, earlier, place) in before {
        let mut passes = document.entries_of_mut("passes").into_iter().flatten();
        if let Some(pass) = passes.find(|pass| pass.key == later) {
            add_after(&mut pass.value, &[(earlier, place)]);
        }
    }
    changes
}

type Names = Vec<(String, Span)>;

/// Returns the names of the passes before and after an extension point; `None` after reporting an unknown extension
/// point. `beside` lists all points that the extension names.
fn extension_point(
    document: &Value,
    point: &Entry,
    beside: &[Entry],
    diagnostics: &mut Diagnostics,
) -> Option<(Names, Vec<String>)> {
    let points = document.entries_of("extension_points");
    let Some(found) = points.iter().find(|known| known.key == point.key) else {
        let names = points.iter().map(|entry| entry.key.as_str());
        let message = format!("there is no extension point \"{}\"", point.key);
        let diagnostic = Diagnostic::error(codes::UNKNOWN_EXTENSION_POINT, point.key_span, message);
        let taken = |name: &str| beside.iter().any(|other| other.key == name);
        let written = Some(point.key_span);
        diagnostics.push(diagnostic.suggest_unless(&point.key, names, written, taken, |names| match names {
            [] => "the pipeline names no extension points".to_owned(),
            names => format!("the extension points are {}", list_of(names)),
        }));
        return None;
    };
    let names = |key: &str| -> Names {
        let list = found.value.elements_of(key);
        list.iter().filter_map(|value| Some((value.text()?.to_owned(), value.span))).collect()
    };
    Some((names("after"), names("before").into_iter().map(|(name, _)| name).collect()))
}

/// Returns the last pass that an earlier extension inserted after the passes `after`; `None` if there is none. The next
/// pass inserted there runs after the returned one.
fn last_inserted(document: &Value, after: &Names) -> Option<(String, Span)> {
    let wanted: Vec<&str> = after.iter().map(|(name, _)| name.as_str()).collect();
    let inserted = document.entries_of("passes").iter().rev().find(|pass| {
        let list = pass.value.elements_of("after");
        let names: Vec<&str> = list.iter().filter_map(Value::text).collect();
        !wanted.is_empty()
            && wanted.iter().all(|name| names.contains(name))
            && list.iter().any(|value| value.span.file != pass.key_span.file)
    });
    inserted.map(|pass| (pass.key.clone(), pass.key_span))
}

/// Adds the names of passes to the `after` list of a pass.
fn add_after(pass: &mut Value, names: &[(String, Span)]) {
    if names.is_empty() {
        return;
    }
    let text = |(name, span): &(String, Span)| Value { span: *span, kind: Kind::Text(name.clone()) };
    let span = pass.span;
    let Kind::Object(entries) = &mut pass.kind else { return };
    match entries.iter_mut().find(|entry| entry.key == "after") {
        Some(Entry { value: Value { kind: Kind::Array(list), .. }, .. }) => {
            list.extend(names.iter().map(text));
        }
        Some(_) => {}
        None => entries.push(Entry {
            key: "after".to_owned(),
            key_span: span,
            value: Value { span, kind: Kind::Array(names.iter().map(text).collect()) },
        }),
    }
}
