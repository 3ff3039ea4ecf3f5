//! The values of the expressions of a file, for one configuration.
//!
//! An expression has one value where all of its names are parameters, features or derived values of the pipeline. One that
//! names an input of a subgraph, or the round of a loop, has a value for each use, and is left out; so is a part of a file
//! that declares subgraphs.

use super::context::Context;
use crate::graph::document::{Entry, Value};
use crate::graph::expression::{Scope as _, evaluate, parse};
use crate::graph::pipeline::{FileKind, StaticScope};
use crate::graph::source::Span;

/// The characters of a value that are shown.
const LONGEST: usize = 40;

/// An expression and its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Computed {
    /// The place of the string that holds the expression.
    pub place: Span,
    /// The value; of a long one the beginning.
    pub value: String,
}

pub(super) fn computed(context: &Context<'_>) -> Vec<Computed> {
    let mut found = Vec::new();
    let pipeline = context.planned.report.pipeline.as_deref().filter(|_| context.kind != FileKind::Subgraph);
    if let Some(pipeline) = pipeline {
        let is_wanted = |entry: &&Entry| entry.key != "subgraphs";
        let scope = pipeline.scope();
        for entry in context.document.root.entries().into_iter().flatten().filter(is_wanted) {
            below(&entry.value, &scope, &mut found);
        }
    }
    found
}

fn below(value: &Value, scope: &StaticScope, found: &mut Vec<Computed>) {
    for entry in value.entries().into_iter().flatten() {
        below(&entry.value, scope, found);
    }
    for element in value.elements().into_iter().flatten() {
        below(element, scope, found);
    }
    let Some(text) = value.text().and_then(|text| text.strip_prefix('=')) else { return };
    let Ok(expression) = parse(text) else { return };
    // A number or a word says its value itself.
    if expression.names().into_iter().all(|name| scope.borrow(name).is_none()) {
        return;
    }
    if let Ok(computed) = evaluate(&expression, scope) {
        found.push(Computed { place: value.span, value: shortened(computed.to_string()) });
    }
}

fn shortened(mut value: String) -> String {
    if let Some((at, _)) = value.char_indices().nth(LONGEST) {
        value.truncate(at);
        value.push('…');
    }
    value
}
