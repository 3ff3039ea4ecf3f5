//! Comparisons of an axis with a value that it cannot have.
//!
//! `{% if filter == "pfc" %}` renders without an error and is never true. The check covers comparisons of an axis with
//! a literal string or integer, in either order or as `in` a list. It covers only templates with a declaration of their
//! own: a part that any template can include has unknown axes.

use super::template::Template;
use super::tree::Compared;
use crate::axes::{Axes, Axis, AxisKind, AxisMode};
use crate::codes;
use umbragraph_text::diagnostic::{AxisValue, Diagnostic};
use umbragraph_text::source::Span;

/// Returns a warning for each variable that a loop assigns and that text behind the loop reads.
pub(crate) fn lost(template: &Template) -> impl Iterator<Item = Diagnostic> {
    template.prepared.names.lost.iter().map(|(name, range)| {
        let message =
            format!("\"{name}\" is set in a loop and read behind it, where it has the value from before the loop");
        let help = format!(
            "keep it in a namespace: {{% set ns = namespace({name}=…) %}} before the loop, {{% set ns.{name} = … %}} \
             in it, ns.{name} behind it"
        );
        Diagnostic::warning(codes::SET_LOST, Span::new(template.file, range.clone()), message).help(help)
    })
}

/// Returns an error for each comparison of a template axis with a literal that is not one of the axis's values.
pub(crate) fn check(template: &Template, axes: &Axes) -> Vec<Diagnostic> {
    let names = &template.prepared.names;
    let diagnostic = |compared: &Compared| {
        let axis = axes.get(&compared.variable).filter(|axis| axis.mode == AxisMode::Template)?;
        if names.bound.contains(&axis.name) { None } else { never(template, axis, compared) }
    };
    names.compared.iter().filter_map(diagnostic).collect()
}

fn never(template: &Template, axis: &Axis, compared: &Compared) -> Option<Diagnostic> {
    let written = template.text.get(compared.range.clone())?;
    let (value, range) = match compared.literal.as_str() {
        Some(name) => {
            let range = compared.range.start + 1..compared.range.end.checked_sub(1)?;
            // What is escaped, or put together of several texts, cannot be replaced.
            template.text.get(range.clone()).filter(|inside| *inside == name)?;
            (AxisValue::Name(name.to_owned()), range)
        }
        None if axis.kind != AxisKind::Bool => {
            (AxisValue::Integer(written.parse().ok()?), compared.range.clone())
        }
        None => return None,
    };
    if axis.kind.contains(&value) {
        return None;
    }
    let is_number = matches!(axis.kind, AxisKind::Integer { .. });
    let unquoted = value
        .to_string()
        .parse::<i64>()
        .ok()
        .filter(|number| axis.kind.contains(&AxisValue::Integer(*number)));
    if let (Some(number), true) = (unquoted, is_number) {
        let span = Span::new(template.file, compared.range.clone());
        let message = format!(
            "the axis \"{}\" is a number and {written} is a text, so that the two are never equal",
            axis.name
        );
        let diagnostic = Diagnostic::error(codes::AXIS_COMPARED, span, message)
            .related(axis.span, format!("declared here with {}", axis.kind.describe()));
        return Some(diagnostic.help(format!("write {number} without quotes")).fix(span, number.to_string()));
    }
    let span = Span::new(template.file, range);
    let message =
        format!("the axis \"{}\" is compared with {written}, which is none of its values", axis.name);
    let diagnostic = Diagnostic::error(codes::AXIS_COMPARED, span, message)
        .related(axis.span, format!("declared here with {}", axis.kind.describe()));
    let names: &[String] = match &axis.kind {
        AxisKind::Enum(names) | AxisKind::TextureFormat(names) => names,
        AxisKind::Bool | AxisKind::Integer { .. } => &[],
    };
    let text = value.to_string();
    Some(diagnostic.suggest(&text, names.iter().map(String::as_str), Some(span), |_| match axis.kind {
        AxisKind::Bool => format!("a boolean axis stands alone in a condition: {{% if {} %}}", axis.name),
        _ => format!("the values are {}", axis.kind.describe()),
    }))
}
