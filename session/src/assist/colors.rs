//! Colors in documents: values that are red, green, blue and perhaps alpha, from 0 to 1.
//!
//! The language has no type of colors. A list of three or four numbers is one as the value of a parameter whose name or
//! description says so, and as the clear value of a color attachment. Shaders compute with linear values, so a color of
//! a document is linear; the clear value of an attachment with an 8-bit format without "-srgb" is what is shown.
//!
//! Limits: expressions, and values below 0 or above 1, are no colors here.

use serde_json::Value as Json;

use super::context::Context;
use crate::graph::document::Value;
use crate::graph::edit::{EditError, Edits, set};
use crate::graph::model::DeclarationKind;
use crate::graph::source::Span;

/// Words in the name or description of a parameter that is a color.
const WORDS: [&str; 5] = ["color", "colour", "radiance", "tint", "albedo"];

/// A color in a document.
#[derive(Clone, Debug)]
pub struct Color {
    /// The red, green, blue and alpha to show, encoded as sRGB, from 0 to 1.
    pub shown: [f64; 4],
    /// Whether the document has linear values; `false` for values that are encoded as they are shown.
    pub is_linear: bool,
    /// The list of numbers.
    value: Value,
}

/// The largest difference of two components, as they are shown, that count as one: pickers round to steps of 1/255.
const SAME: f64 = 0.5 / 255.0 + 1e-6;

impl Color {
    /// The place of the list of numbers.
    pub fn place(&self) -> Span {
        self.value.span
    }

    /// Returns the numbers of a document for another color, encoded as sRGB, from 0 to 1. Components that stay keep
    /// their numbers.
    fn numbers(&self, shown: [f64; 4]) -> Vec<Json> {
        let number = |(at, old): (usize, &Value)| {
            let (new, old_shown) = (shown[at], self.shown[at]);
            if (new - old_shown).abs() < SAME {
                return old.to_json();
            }
            let number = if self.is_linear && at < 3 { to_linear(new) } else { new };
            let rounded = (number * 1e4).round() / 1e4;
            if rounded == rounded.trunc() { Json::from(rounded as i64) } else { Json::from(rounded) }
        };
        self.value.elements().into_iter().flatten().enumerate().map(number).collect()
    }

    /// Returns the edits of a document's text that set another color, given as it is shown, and a label with the new
    /// numbers.
    ///
    /// # Errors
    /// A text that is not the color's own.
    pub fn edits(&self, text: &str, shown: [f64; 4]) -> Result<(String, Edits), EditError> {
        let numbers = self.numbers(shown);
        let list: Vec<String> = numbers.iter().map(Json::to_string).collect();
        let encoding = if self.is_linear { "linear" } else { "sRGB" };
        let label = format!("[{}] {encoding}", list.join(", "));
        Ok((label, set(text, &self.value, &Json::from(numbers))?))
    }
}

/// Decodes an sRGB component, from 0 to 1 (IEC 61966-2-1).
fn to_linear(shown: f64) -> f64 {
    if shown <= 0.040_45 { shown / 12.92 } else { ((shown + 0.055) / 1.055).powf(2.4) }
}

/// Encodes a linear component, from 0 to 1, as sRGB (IEC 61966-2-1).
fn to_srgb(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Returns the colors of a file.
pub(super) fn colors(context: &Context<'_>) -> Vec<Color> {
    let mut found = Vec::new();
    below(context, &context.document.root, &mut Vec::new(), &context.document.root, &mut found);
    found
}

fn below<'v>(
    context: &Context<'_>,
    value: &'v Value,
    way: &mut Vec<&'v str>,
    parent: &'v Value,
    found: &mut Vec<Color>,
) {
    for entry in value.entries().into_iter().flatten() {
        way.push(&entry.key);
        below(context, &entry.value, way, value, found);
        way.pop();
    }
    let Some(elements) = value.elements() else { return };
    let numbers: Option<Vec<f64>> = elements.iter().map(|one| one.to_json().as_f64()).collect();
    let Some(numbers) = numbers else {
        way.push("");
        elements.iter().for_each(|one| below(context, one, way, value, found));
        way.pop();
        return;
    };
    if !matches!(numbers.len(), 3 | 4) || numbers.iter().any(|one| !(0.0..=1.0).contains(one)) {
        return;
    }
    let is_linear = match way.as_slice() {
        [.., "parameters", name, "default"] | [.., "parameters" | "with" | "values", name]
            if is_color(context, name) =>
        {
            true
        }
        [.., "color", "", "clear"] => match format(context, parent) {
            Some(format) if format.ends_with("int") => return,
            format => !format.is_some_and(|format| format.ends_with("8unorm")),
        },
        _ => return,
    };
    let encoded = |at: usize| {
        let number = numbers.get(at).copied().unwrap_or(1.0);
        if is_linear && at < 3 { to_srgb(number) } else { number }
    };
    found.push(Color { shown: [0, 1, 2, 3].map(encoded), is_linear, value: value.clone() });
}

/// Returns `true` for the name of a parameter that is a color by its name, unit or description.
fn is_color(context: &Context<'_>, name: &str) -> bool {
    let mut about = vec![name.to_owned()];
    let declared = context.model.declarations().map(|(_, one)| one);
    for one in declared.filter(|one| one.kind == DeclarationKind::Parameter && one.name == name) {
        let value = context.value_of(one);
        let texts = ["description", "unit"].map(|key| value.and_then(|value| value.get(key)?.text()));
        about.extend(texts.into_iter().flatten().map(str::to_owned));
    }
    is_about_color(about)
}

/// Returns `true` if a parameter is a color by its name, description or unit.
pub fn is_about_color(texts: impl IntoIterator<Item = impl AsRef<str>>) -> bool {
    texts.into_iter().any(|text| {
        let text = text.as_ref().to_lowercase();
        WORDS.iter().any(|word| text.contains(word))
    })
}

/// Returns the format of the texture of an attachment; `None` if it is not written as a word.
fn format<'a>(context: &Context<'a>, attachment: &Value) -> Option<&'a str> {
    let name = attachment.get("to")?.text()?.strip_prefix('&')?;
    let mut declared = context.model.declarations().map(|(_, one)| one);
    let resource = declared.find(|one| one.kind == DeclarationKind::Resource && one.name == name)?;
    context.value_of(resource)?.get("texture")?.get("format")?.text()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::document::parse;
    use crate::graph::source::Sources;

    #[test]
    fn a_picker_of_whole_steps_changes_only_what_was_picked() {
        let text = "[0.5, 0.25, 1] // warm";
        let mut sources = Sources::new();
        let file = sources.add("a", text);
        let value = parse(&sources, file).valid().expect("a list").root;
        let shown = [0.5, 0.25, 1.0, 1.0].map(to_srgb);
        let color = Color { shown, is_linear: true, value };
        let whole = shown.map(|one| (one * 255.0).round() / 255.0);
        let edited =
            |shown: [f64; 4]| color.edits(text, shown).expect("its own text").1.apply(text).expect("a text");
        assert_eq!(edited(whole), text, "nothing was picked");
        let [red, green, _, alpha] = whole;
        assert_eq!(edited([red, green, 0.0, alpha]), "[0.5, 0.25, 0] // warm");
        assert_ne!(edited([red - 1.0 / 255.0, green, 1.0, alpha]), text, "one step is a change");
    }
}
