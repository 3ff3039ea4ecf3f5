//! Parameters and features that can have values which the axes that they feed do not have.
//!
//! An axis without a value in a pass takes that of the parameter or feature of its name. A range that is wider than the
//! axis is an error only for whoever gives a value beyond, so a check of the defaults does not meet it.
//!
//! Limits: shaders whose name an expression gives are left out, and ranges that no declaration states.

use crate::graph::diagnostic::{Diagnostic, Diagnostics, Severity};
use crate::graph::document::{Entry, Value, pointer_join};
use crate::graph::shader::codes::AXIS_VALUE;
use crate::graph::shader::{Axis, AxisKind, TemplateSet};

/// Adds a diagnostic for each parameter or feature of a document, and of its subgraphs, that allows what an axis does not.
pub(crate) fn check(root: &Value, templates: &TemplateSet, diagnostics: &mut Diagnostics) {
    let subgraphs = root
        .entries_of("subgraphs")
        .iter()
        .map(|subgraph| (pointer_join("/subgraphs", &subgraph.key), &subgraph.value));
    for (pointer, owner) in subgraphs.chain([(String::new(), root)]) {
        for pass in owner.entries_of("passes") {
            for kind in pass.value.entries().unwrap_or_default() {
                let shader = kind.value.get("shader").and_then(Value::text);
                let Some((template, axes)) = shader.and_then(|name| Some((name, templates.axes(name)?)))
                else {
                    continue;
                };
                for axis in axes.iter() {
                    let given = kind.value.get("axes").and_then(|axes| axes.get(&axis.name));
                    let is_own = given.is_some_and(|given| given.text() != Some(&format!("={}", axis.name)));
                    let mut sections = ["parameters", "features"].into_iter();
                    let declared = sections.find_map(|section| {
                        let mut entries = owner.entries_of(section).iter();
                        Some((section, entries.find(|entry| entry.key == axis.name)?))
                    });
                    let Some((section, declared)) = declared.filter(|_| !is_own) else { continue };
                    let at = pointer_join(&format!("{pointer}/{section}"), &declared.key);
                    diagnostics.extend(misfit(declared, template, axis).map(|one| one.pointer(at)));
                }
            }
        }
    }
}

/// The diagnostic for a declaration that allows what an axis does not; `None` if it fits.
fn misfit(declared: &Entry, template: &str, axis: &Axis) -> Option<Diagnostic> {
    let name = &declared.key;
    let kind = declared.value.get("type").and_then(Value::text)?;
    let takes =
        format!("the axis \"{name}\" of {template}, which takes its value, has {}", axis.kind.describe());
    let is_of_kind = match &axis.kind {
        AxisKind::Bool => kind == "bool",
        AxisKind::Integer { .. } => ["u32", "i32"].contains(&kind),
        AxisKind::Enum(_) | AxisKind::TextureFormat(_) => kind == "enum",
    };
    let diagnostic = |message: String| {
        let error = Diagnostic::error(AXIS_VALUE, declared.key_span, message);
        error.related(axis.span, "the axis is declared here")
    };
    if !is_of_kind {
        let wanted = match &axis.kind {
            AxisKind::Bool => "{ \"type\": \"bool\" }".to_owned(),
            AxisKind::Integer { .. } => "{ \"type\": \"u32\" }".to_owned(),
            AxisKind::Enum(words) | AxisKind::TextureFormat(words) => {
                format!("{{ \"type\": \"enum\", \"values\": {} }}", serde_json::json!(words))
            }
        };
        let message = format!("\"{name}\" is of the type \"{kind}\", but {takes}");
        return Some(diagnostic(message).help(format!("declare it {wanted}, or rename the axis")));
    }
    if let AxisKind::Enum(words) = &axis.kind {
        let beyond = declared.value.elements_of("values").iter().filter_map(Value::text);
        let beyond = { beyond }.find(|word| !words.iter().any(|known| known == word))?;
        let message = format!("\"{name}\" can be \"{beyond}\", but {takes}");
        let help = "remove the word, or give the axis one";
        return Some(diagnostic(message).help(help).severity(Severity::Warning));
    }
    let AxisKind::Integer { min, max } = axis.kind else { return None };
    let bound = |key: &str| declared.value.get(key).and_then(|value| value.to_json().as_i64());
    let (low, high) = (bound("min").unwrap_or(min), bound("max").unwrap_or(max));
    if min <= low && high <= max {
        return None;
    }
    let message = format!("\"{name}\" goes from {low} to {high}, but {takes}");
    let help = format!("write \"min\": {min}, \"max\": {max}, or let the axis have more values");
    Some(diagnostic(message).help(help).severity(Severity::Warning))
}
