//! Comparisons of an axis with what is none of its values.
//!
//! `{% if filter == "pfc" %}` renders without complaint and never holds. A comparison of an axis with a string or a whole
//! number that is written out, in either order or as `in` a list, is seen in the words of its tag. Only templates that
//! have a declaration of their own are looked at: what axes a part has that any template may include is not known.

use super::axes::{Axes, Axis, AxisKind, AxisMode};
use super::scan::{Tag, Word, WordKind};
use super::template::Template;
use super::{codes, names};
use crate::diagnostic::{AxisValue, Diagnostic};
use crate::source::Span;

/// The diagnostics about a template with these axes.
pub(super) fn check(template: &Template, axes: &Axes) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    for tag in &template.scan.tags {
        let words = Words { text: &template.text, tag };
        for at in 0..tag.words.len() {
            let Some(axis) = words.text(at).and_then(|name| axes.get(name)) else { continue };
            if axis.mode != AxisMode::Template
                || words.is_part_of_more(at.checked_sub(1))
                || names::binds(template, &axis.name)
            {
                continue;
            }
            let literals = words.compared_with(at);
            diagnostics.extend(literals.into_iter().filter_map(|word| never(template, axis, word)));
        }
    }
    diagnostics
}

struct Words<'t> {
    text: &'t str,
    tag: &'t Tag,
}

impl<'t> Words<'t> {
    fn text(&self, at: usize) -> Option<&'t str> {
        self.tag.word(self.text, at)
    }

    /// Whether a word beside another one makes them parts of a larger expression.
    fn is_part_of_more(&self, at: Option<usize>) -> bool {
        let signs = [".", "|", "~", "+", "-", "*", "/", "//", "**", "%"];
        at.and_then(|at| self.text(at)).is_some_and(|word| signs.contains(&word))
    }

    fn is_comparison(&self, at: usize) -> bool {
        matches!(self.text(at), Some("==" | "!="))
    }

    /// The literals that the word at an index is compared with.
    fn compared_with(&self, at: usize) -> Vec<&'t Word> {
        let literal = |at: usize| self.tag.words.get(at).filter(|word| word.kind != WordKind::Identifier);
        if self.is_comparison(at + 1) {
            return literal(at + 2).filter(|_| !self.is_part_of_more(Some(at + 3))).into_iter().collect();
        }
        if at >= 2 && self.is_comparison(at - 1) {
            let alone = !self.is_part_of_more(Some(at + 1)) && !self.is_part_of_more(at.checked_sub(3));
            return literal(at - 2).filter(|_| alone).into_iter().collect();
        }
        let list = match (self.text(at + 1), self.text(at + 2)) {
            (Some("in"), Some("[" | "(")) => at + 3,
            (Some("not"), Some("in")) if matches!(self.text(at + 3), Some("[" | "(")) => at + 4,
            _ => return Vec::new(),
        };
        let rest = self.tag.words.get(list..).unwrap_or_default();
        let written = |word: &Word| self.text.get(word.range.clone()).unwrap_or_default();
        let Some(end) = rest.iter().position(|word| matches!(written(word), "]" | ")")) else {
            return Vec::new();
        };
        let elements = rest[..end].iter().filter(|word| written(word) != ",");
        let plain = |word: &&Word| matches!(word.kind, WordKind::Text | WordKind::Number);
        if elements.clone().all(|word| plain(&word)) { elements.collect() } else { Vec::new() }
    }
}

fn never(template: &Template, axis: &Axis, word: &Word) -> Option<Diagnostic> {
    let written = template.text.get(word.range.clone())?;
    let (value, range) = match word.kind {
        WordKind::Text => {
            let range = word.range.start + 1..word.range.end.checked_sub(1)?;
            (AxisValue::Name(template.text.get(range.clone())?.to_owned()), range)
        }
        WordKind::Number if axis.kind != AxisKind::Bool => {
            (AxisValue::Integer(written.parse().ok()?), word.range.clone())
        }
        _ => return None,
    };
    if axis.kind.contains(&value) || written.contains('\\') {
        return None;
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
