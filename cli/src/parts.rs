//! Files that are no pipelines, given to `check`: extensions, subgraphs and parameter files.
//!
//! The keys of a file tell its kind. Each file is held to the schema of its kind. Its fit with a pipeline is checked in
//! that pipeline.

use std::path::Path;

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::document::schema::Schema;
use umbragraph::low_level::document::{Document, Value};
use umbragraph::low_level::pipeline::{FileKind, schema_of};
use umbragraph::node::Registry;

/// The kind of a file by its keys; `None` for a pipeline, and for what could be one.
pub(crate) fn kind_of(document: &Document) -> Option<FileKind> {
    let has = |key| document.root.get(key).is_some();
    if has("inserts") {
        return Some(FileKind::Extension);
    }
    if has("inputs") {
        return Some(FileKind::Subgraph);
    }
    let sections = ["passes", "resources", "subgraphs", "extends", "include", "geometry", "name"];
    if sections.into_iter().any(has) {
        return None;
    }
    let is_declared = |value: &Value| value.get("type").is_some();
    let given = ["parameters", "features"].map(|key| document.root.get(key).and_then(Value::entries));
    let mut given = given.into_iter().flatten().flatten().peekable();
    let has_values = given.peek().is_some() || has("preset");
    (has_values && !given.any(|entry| is_declared(&entry.value))).then_some(FileKind::Parameters)
}

/// Holds a file to the schema of its kind.
pub(crate) fn check(document: &Document, kind: FileKind, registry: &Registry) -> Diagnostics {
    let schema = schema_of(kind, registry);
    let mut diagnostics = Diagnostics::new();
    Schema::new(&schema).check(&document.root, "", &mut diagnostics);
    diagnostics
}

/// One line about a file that is as its schema wants.
pub(crate) fn summary(path: &Path, kind: FileKind) -> String {
    let path = path.display();
    let (what, how) = match kind {
        FileKind::Pipeline => return String::new(),
        FileKind::Extension => ("an extension", format!("check PIPELINE --extension {path}")),
        FileKind::Subgraph => ("a subgraph", "check PIPELINE, of one that uses it,".to_owned()),
        FileKind::Parameters => ("a parameter file", format!("check PIPELINE --params {path}")),
    };
    format!("{path}: {what} of the form that its schema wants; `umbragraph {how}` checks it in a pipeline\n")
}
