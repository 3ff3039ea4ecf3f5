//! The shadow term of a pipeline: the picture of how much of the lights arrives.
//!
//! A pipeline shows it where its parameter `debug_view` is `shadow_term`: grey, 255 lit, with alpha 255 where there is
//! geometry.

use umbragraph::diagnostic::{Diagnostic, Place};
use umbragraph::low_level::document::Value;

use crate::arguments::Choices;
use crate::codes;

/// The parameter that selects the debug view.
pub(crate) const PARAMETER: &str = "debug_view";

/// The value that selects the shadow term.
const VALUE: &str = "shadow_term";

/// Adds the setting that makes the shadow term the picture, unless the parameter is already set.
pub(crate) fn choices(choices: &Choices) -> Choices {
    let mut choices = choices.clone();
    let is_said = |set: &String| set.split_once('=').is_some_and(|(name, _)| name == PARAMETER);
    if !choices.settings.set.iter().any(is_said) {
        choices.settings.set.push(format!("{PARAMETER}={VALUE}"));
    }
    choices
}

/// Checks that a pipeline document has a parameter value for the shadow term.
///
/// # Errors
/// A document without the value.
pub(crate) fn required(document: &Value) -> Result<(), Diagnostic> {
    let view = document.get("parameters").and_then(|parameters| parameters.get(PARAMETER));
    let values = view.and_then(|view| view.get("values")).and_then(Value::elements).unwrap_or_default();
    if values.iter().any(|value| value.text() == Some(VALUE)) {
        return Ok(());
    }
    let place = view.map_or(Place::Nowhere, |view| Place::Span(view.span));
    let message = "the pipeline shows no shadow term";
    Err(Diagnostic::error(codes::SCORE, place, message).help(
        "declare the parameter \"debug_view\": { \"type\": \"enum\", \"values\": [\"off\", \"shadow_term\"], \"default\": \"off\" }, \
         and with \"shadow_term\" write how much of the lights arrives as grey, with alpha 1 where there is geometry",
    ))
}
