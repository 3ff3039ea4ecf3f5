//! Errors of expressions as diagnostics.

use umbragraph_text::diagnostic::{Diagnostic, codes, suggested_name};
use umbragraph_text::document;
use umbragraph_text::expression::{ErrorKind, ExpressionError, parse_from};

/// Returns the diagnostic for an error in an expression, placed inside the string if the string has no escape
/// sequences. `None` for an error that only follows from another diagnostic.
pub fn expression_diagnostic(
    error: &ExpressionError,
    value: &document::Value,
    pointer: &str,
) -> Option<Diagnostic> {
    let (value, pointer) = invalid(error, value, pointer).unwrap_or((value, pointer.to_owned()));
    let end = error.range.end.max(error.range.start + 1);
    // What is missing at the end is missing at the closing quote.
    let is_placed = error.range != (0..0) && value.span_within(0..0).is_some();
    let place = is_placed.then(|| value.span.inside(error.range.start + 1..end + 1));
    let code = match error.kind {
        ErrorKind::Syntax => codes::EXPRESSION_SYNTAX,
        ErrorKind::Follows => return None,
        ErrorKind::Reference => codes::BAD_REFERENCE,
        ErrorKind::UnknownName => codes::EXPRESSION_NAME,
        ErrorKind::UnknownWord => codes::UNKNOWN_WORD,
        ErrorKind::Type => codes::EXPRESSION_TYPE,
        ErrorKind::Arithmetic => codes::EXPRESSION_ARITHMETIC,
    };
    let diagnostic =
        Diagnostic::error(code, place.unwrap_or(value.span), error.message.clone()).pointer(pointer);
    let help = || {
        error.help.clone().unwrap_or_else(|| match error.kind {
            ErrorKind::Syntax => "expressions look like \"ceil(viewport.width / 16)\"".to_owned(),
            ErrorKind::UnknownName | ErrorKind::Follows => {
                "expressions know parameters, features, resources and viewport".to_owned()
            }
            ErrorKind::UnknownWord => "the declaration lists the words".to_owned(),
            ErrorKind::Reference => "write \"&NAME\"".to_owned(),
            ErrorKind::Type => "see `umbragraph reference UG0312` for the types of expressions".to_owned(),
            ErrorKind::Arithmetic => "guard the operation, with max(…, 1) for one".to_owned(),
        })
    };
    let Some(unknown) = &error.unknown else { return Some(diagnostic.help(help())) };
    let known = unknown.known.iter().map(String::as_str);
    // Textures and the viewport have sides, not coordinates.
    let side = unknown.name.rsplit_once('.').and_then(|(head, member)| match member {
        "x" => Some(format!("{head}.width")),
        "y" => Some(format!("{head}.height")),
        _ => None,
    });
    if let Some(side) = side.filter(|side| known.clone().any(|name| name == side)) {
        let range = error.range.start..error.range.start + unknown.name.len();
        let is_written = value.text().and_then(|text| text.get(range.clone())) == Some(&unknown.name);
        let diagnostic = diagnostic.help(format!("did you mean \"{side}\"?"));
        return Some(match value.span_within(range).filter(|_| is_written) {
            Some(place) => diagnostic.fix(place, side),
            None => diagnostic,
        });
    }
    // Of a resource's property the resource may be what is misspelt.
    let name = match unknown.name.split_once('.') {
        Some((head, _)) if suggested_name(&unknown.name, known.clone()).is_none() => head,
        _ => unknown.name.as_str(),
    };
    let range = error.range.start..error.range.start + name.len();
    // Inside a subgraph a name may be written in another way than it reads outside.
    let is_written = value.text().and_then(|text| text.get(range.clone())) == Some(name);
    let written = value.span_within(range).filter(|_| is_written);
    Some(diagnostic.suggest(name, known, written, |_| help()))
}

/// Finds the element of a list of expressions that an error is about, and its JSON pointer. `None` if no element, or
/// more than one, can have the error.
fn invalid<'v>(
    error: &ExpressionError,
    value: &'v document::Value,
    pointer: &str,
) -> Option<(&'v document::Value, String)> {
    let elements = value.elements()?.iter().enumerate();
    let Some(unknown) = error.unknown.as_deref() else {
        let places = elements.map(|(at, element)| (element, format!("{pointer}/{at}")));
        let mut found = places.filter(|(element, _)| element.text().is_some_and(|text| has(text, error)));
        return found.next().filter(|_| found.next().is_none());
    };
    let mut found =
        elements.map(|(at, element)| (element, format!("{pointer}/{at}"))).filter_map(|(element, at)| {
            let has_it = element.text().is_some_and(|text| {
                text.get(error.range.start..).is_some_and(|rest| rest.starts_with(&unknown.name))
            });
            if has_it { Some((element, at)) } else { invalid(error, element, &at) }
        });
    found.next()
}

/// Returns `true` if the expression in a string has a part of exactly the range of an error, or has the error itself.
fn has(text: &str, error: &ExpressionError) -> bool {
    let mut found = false;
    match parse_from(text, 1) {
        _ if !text.starts_with('=') => {}
        Ok(expression) => expression.visit(&mut |part| found |= part.range == error.range),
        Err(own) => found = own.range == error.range && own.message == error.message,
    }
    found
}
