//! The values of the expressions of a file, for one configuration.
//!
//! An expression has one value if it names parameters, features and derived values of the pipeline alone. One that
//! names an input of a subgraph, or the round of a loop, has a value for each use, and is left out. So are files of
//! subgraphs, and the subgraphs of other files.

use super::context::Context;
use crate::graph::document::{Entry, Value};
use crate::graph::expression::{Scope as _, evaluate, parse};
use crate::graph::pipeline::{FileKind, StaticScope};
use crate::graph::source::Span;

/// The maximum number of characters of a value that are shown.
const LONGEST: usize = 40;

/// An expression in a file, with its value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Computed {
    /// The source range of the string that holds the expression.
    pub place: Span,
    /// The value as text, cut off with `…` after 40 characters.
    pub value: String,
}

pub(super) fn computed(context: &Context<'_>) -> Vec<Computed> {
    let mut found = Vec::new();
    let is_part = context.kind == FileKind::Subgraph;
    let pipeline = if is_part { None } else { context.planned().report.pipeline };
    if let Some(pipeline) = pipeline {
        let is_wanted = |entry: &&Entry| entry.key != "subgraphs";
        let scope = pipeline.scope();
        for entry in context.document.root.entries().into_iter().flatten().filter(is_wanted) {
            below(&entry.value, &scope, &mut Vec::new(), &mut found);
        }
    }
    found
}

/// Adds the values of all expressions in a JSON value. Skips expressions that name one of `rounds`, the variables of
/// the enclosing loops.
fn below<'v>(value: &'v Value, scope: &StaticScope, rounds: &mut Vec<&'v str>, found: &mut Vec<Computed>) {
    let outer = rounds.len();
    let own = value.get("for_each").and_then(Value::entries);
    rounds.extend(own.into_iter().flatten().map(|entry| entry.key.as_str()));
    for entry in value.entries().into_iter().flatten() {
        below(&entry.value, scope, rounds, found);
    }
    for element in value.elements().into_iter().flatten() {
        below(element, scope, rounds, found);
    }
    rounds.truncate(outer);
    let Some(text) = value.text().and_then(|text| text.strip_prefix('=')) else { return };
    let Ok(expression) = parse(text) else { return };
    let names = expression.names();
    // A number or a word says its value itself.
    let says_itself = names.iter().all(|name| scope.borrow(name).is_none());
    if says_itself || names.iter().any(|name| rounds.contains(name)) {
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
