//! Constraints: which values of parameters, features and derived values go together.
//!
//! ```jsonc
//! "constraints": { "order": { "holds": "=near < far", "message": "nothing lies between the planes" } }
//! ```
//!
//! One that does not hold is a diagnostic of the severity that it says, at its condition, with the parameters and
//! features that the condition follows from, through derived values too, and where each was set.
//!
//! Limits: sizes, which are not known yet, have no part in constraints; a subgraph has none of its own.

use std::collections::BTreeSet;

use crate::pipeline::load::settings::Settings;
use crate::pipeline::load::sound::{Sound, section};
use crate::pipeline::names::expression_diagnostic::expression_diagnostic;
use crate::pipeline::settings::live::Constraint;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, Severity, codes};
use umbragraph_text::document::{Document, Value as Json, pointer_join};
use umbragraph_text::expression::{self, ErrorKind, Expression, ExpressionError, Value};
use umbragraph_text::language::{ConstraintSeverity, Expr};
use umbragraph_text::source::Span;

/// Reports each constraint that is violated or whose condition is invalid. Returns the constraints of severity error
/// that hold.
pub(super) fn check(
    document: &Document,
    sound: &Sound,
    settings: &Settings,
    diagnostics: &mut Diagnostics,
) -> Vec<Constraint> {
    let scope = settings.scope();
    let mut all = Vec::new();
    for entry in section(document, "constraints") {
        let Some(constraint) = sound.constraints.get(&entry.key) else { continue };
        let pointer = pointer_join("/constraints", &entry.key) + "/holds";
        let value = entry.value.get("holds").unwrap_or(&entry.value);
        let result = constraint.holds.parse().and_then(|expression| {
            expression::unknown_word(&expression, &scope).map_or(Ok(()), Err)?;
            match expression::evaluate(&expression, &scope)? {
                Value::Bool(holds) => Ok((holds, expression)),
                other => {
                    let message = format!("a boolean is wanted, this is {}", other.kind_name());
                    Err(ExpressionError::new(ErrorKind::Type, expression.range, message))
                }
            }
        });
        match result {
            Ok((true, holds)) if constraint.severity == ConstraintSeverity::Error => {
                let (message, place) = (constraint.message.clone(), value.span);
                all.push(Constraint { holds, message, place, pointer });
            }
            Ok((true, _)) => {}
            Ok((false, expression)) => {
                let severity = match constraint.severity {
                    ConstraintSeverity::Error => Severity::Error,
                    ConstraintSeverity::Warning => Severity::Warning,
                };
                let message = constraint.message.clone();
                let mut diagnostic =
                    Diagnostic::error(codes::CONSTRAINT, value.span, message).pointer(pointer);
                diagnostic.severity = severity;
                let mut names = BTreeSet::new();
                collect(&expression, document, &mut names);
                let known = |name: &String| {
                    let parameter = settings.parameters.get(name).map(|one| (one.place, &one.value));
                    parameter.or_else(|| settings.features.get(name).map(|one| (one.place, &one.value)))
                };
                let mut decide: Vec<_> =
                    names.iter().filter_map(|name| Some((name.as_str(), known(name)?))).collect();
                // What somebody chose, where anybody chose anything, brought it about.
                let is_chosen = |(name, (place, _)): &(&str, (Span, &Value))| {
                    let declared = |what| section(document, what).iter().find(|entry| entry.key == *name);
                    let declared = declared("parameters").or_else(|| declared("features"));
                    let default = declared.and_then(|entry| entry.value.get("default"));
                    default.is_none_or(|default| default.span != *place)
                };
                if decide.iter().any(is_chosen) {
                    decide.retain(is_chosen);
                }
                for (name, (place, value)) in &decide {
                    diagnostic = diagnostic.related(*place, format!("\"{name}\" is {value}"));
                }
                let names: Vec<&str> = decide.iter().map(|(name, _)| *name).collect();
                diagnostics.push(match names.as_slice() {
                    [] => diagnostic.help("it never holds: remove it, or mend its condition"),
                    names => diagnostic.help(format!("change {}", names.join(", or "))),
                });
            }
            Err(error) => diagnostics.extend(expression_diagnostic(&error, value, &pointer)),
        }
    }
    all
}

/// Collects the names in an expression, and the names in the expressions of the derived values that it uses.
fn collect(expression: &Expression, document: &Document, names: &mut BTreeSet<String>) {
    for name in expression.names() {
        let derived = document.root.get("derived").and_then(|derived| derived.get(name));
        if names.insert(name.to_owned())
            && let Some(Ok(expression)) = derived.map(Json::to_json).map(|text| Expr(text).parse())
        {
            collect(&expression, document, names);
        }
    }
}
