//! The places that set the values of a thing.
//!
//! The values of a thing are the leaves below its JSON pointer: whatever is no object, and lists whole where they come
//! from one file. Each leaf knows its place; what it replaced hangs below the same pointer. Values that a file deleted
//! have no leaf, and are listed behind with the place of the `null`.

use serde::{Serialize, Serializer};

use super::subject::Subject;
use umbragraph_pipeline::compose::{Layer, SharedPlaces};
use umbragraph_pipeline::document::{self, Kind, Value, pointer_join};
use umbragraph_pipeline::source::{Sources, Span};

/// A source location: file, line and column.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Location {
    /// The name of the file, as diagnostics show it.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The column in characters, from 1.
    pub column: u32,
}

impl std::fmt::Display for Location {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// One value with the place that set it, and the earlier values that it replaced.
#[derive(Clone, Debug, Serialize)]
pub struct Origin {
    /// The path of the value: keys joined by dots.
    pub path: String,
    /// The effective value, with the place that set it.
    #[serde(flatten)]
    pub written: Written,
    /// The values that the effective one replaced, the newest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub replaced: Vec<Written>,
}

/// A value with the place in a file at which it is written.
#[derive(Clone, Debug, Serialize)]
pub struct Written {
    /// The value as JSON text; for a value that was deleted, "null".
    #[serde(serialize_with = "as_json")]
    pub value: String,
    /// The place of the value in a file.
    pub at: Location,
    /// The role of the file in the composed document, such as an included file.
    pub layer: Layer,
    /// The name of the group of shared settings that contains the value; `None` if the value is not shared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shared_settings: Option<String>,
}

/// Serializes JSON text as the value that it represents, and other text as a string.
pub(super) fn as_json<S: Serializer>(text: &str, serializer: S) -> Result<S::Ok, S::Error> {
    match serde_json::from_str::<serde_json::Value>(text) {
        Ok(value) => value.serialize(serializer),
        Err(_) => serializer.serialize_str(text),
    }
}

/// Converts a source place to its file, line and column.
pub(super) fn location(sources: &Sources, span: Span) -> Location {
    match sources.get(span.file) {
        Some(file) => {
            let position = file.line_column(span.start);
            Location { file: file.name().to_owned(), line: position.line, column: position.column }
        }
        None => Location { file: String::new(), line: 1, column: 1 },
    }
}

/// Formats the value of an expression as JSON on one line.
pub(super) fn computed(value: &umbragraph_pipeline::expression::Value) -> String {
    use umbragraph_pipeline::expression::Value as V;
    match value {
        V::Text(_) | V::Reference(_) => serde_json::Value::from(value.to_string()).to_string(),
        V::List(list) => format!("[{}]", list.iter().map(computed).collect::<Vec<_>>().join(", ")),
        V::Bool(_) | V::Number(_) => value.to_string(),
    }
}

/// Formats a value of a document as JSON on one line.
pub(super) fn json(value: &Value) -> String {
    match &value.kind {
        Kind::Array(elements) => {
            let list: Vec<String> = elements.iter().map(json).collect();
            format!("[{}]", list.join(", "))
        }
        Kind::Object(entries) if entries.is_empty() => "{}".to_owned(),
        Kind::Object(entries) => {
            let list: Vec<String> = entries
                .iter()
                .map(|entry| {
                    format!("{}: {}", serde_json::Value::from(entry.key.as_str()), json(&entry.value))
                })
                .collect();
            format!("{{ {} }}", list.join(", "))
        }
        _ => value.to_json().to_string(),
    }
}

/// Returns the values below a JSON pointer, each with the places that set it. Each path begins with `prefix`.
pub(super) fn origins(subject: &Subject<'_>, pointer: &str, value: &Value, prefix: &str) -> Vec<Origin> {
    let mut origins = Vec::new();
    let mut leaves = Vec::new();
    leaf(subject, pointer, value, prefix, &mut origins, &mut leaves);
    let below = format!("{pointer}/");
    for (deleted, place) in subject.composed.deleted.range(below.clone()..) {
        let Some(rest) = deleted.strip_prefix(&below) else { break };
        // A higher file may have put it back.
        if leaves.iter().any(|leaf: &String| leaf == deleted || leaf.starts_with(&format!("{deleted}/"))) {
            continue;
        }
        origins.push(Origin {
            path: join(prefix, &rest.replace('/', ".")),
            written: Written {
                value: "null".to_owned(),
                at: location(subject.sources, *place),
                layer: layer(subject, *place),
                shared_settings: None,
            },
            replaced: older(subject, deleted),
        });
    }
    origins
}

fn leaf(
    subject: &Subject<'_>,
    pointer: &str,
    value: &Value,
    path: &str,
    origins: &mut Vec<Origin>,
    leaves: &mut Vec<String>,
) {
    match &value.kind {
        Kind::Object(entries) if !entries.is_empty() => {
            for entry in entries {
                let at = pointer_join(pointer, &entry.key);
                leaf(subject, &at, &entry.value, &join(path, &entry.key), origins, leaves);
            }
        }
        Kind::Array(elements) if is_mixed(value) => {
            for (at, element) in elements.iter().enumerate() {
                let below = format!("{pointer}/{at}");
                leaf(subject, &below, element, &join(path, &at.to_string()), origins, leaves);
            }
        }
        _ => {
            leaves.push(pointer.to_owned());
            origins.push(Origin {
                path: path.to_owned(),
                written: written(subject, pointer, value.span, json(value)),
                replaced: older(subject, pointer),
            });
        }
    }
}

/// Returns `true` if each element of a list gets a line of its own, because the list holds objects or comes from
/// several files.
fn is_mixed(value: &Value) -> bool {
    value.elements().unwrap_or_default().iter().any(|element| {
        element.span.file != value.span.file || element.entries().is_some_and(|entries| !entries.is_empty())
    })
}

/// The earlier values at a JSON pointer that were replaced, the newest first.
pub(super) fn older(subject: &Subject<'_>, pointer: &str) -> Vec<Written> {
    let places = subject.composed.replaced.get(pointer).map(Vec::as_slice).unwrap_or_default();
    let older = places.iter().map(|place| written(subject, pointer, *place, text(subject.sources, *place)));
    older.collect()
}

fn written(subject: &Subject<'_>, pointer: &str, place: Span, value: String) -> Written {
    Written {
        value,
        at: location(subject.sources, place),
        layer: layer(subject, place),
        shared_settings: shared_settings(subject, pointer, place),
    }
}

/// Formats the value at a source place as JSON on one line.
fn text(sources: &Sources, place: Span) -> String {
    let mut scratch = Sources::new();
    let file = scratch.add("", sources.text(place));
    match document::parse(&scratch, file).valid() {
        Ok(document) => json(&document.root),
        Err(_) => sources.text(place).split_whitespace().collect::<Vec<_>>().join(" "),
    }
}

/// The role, in the composed document, of the file that contains a source place.
pub(super) fn layer(subject: &Subject<'_>, place: Span) -> Layer {
    subject.composed.layers.get(&place.file).copied().unwrap_or(Layer::Pipeline)
}

/// The name of the group of shared settings that contains a value of a pass; `None` if the value is not shared.
fn shared_settings(subject: &Subject<'_>, pointer: &str, place: Span) -> Option<String> {
    let is_pass = pointer.contains("/passes/") && !pointer.contains("/shared_settings/");
    is_pass.then(|| SharedPlaces::of(&subject.composed.document).find(place).map(str::to_owned)).flatten()
}

fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
