//! The first character of a string says what the string is.
//!
//! ```jsonc
//! "size": "=viewport / 2",       // computed
//! "source": "&maps@blur",        // refers to a resource or to published data
//! "compare": "less-equal"        // a word, a file or a declared name, as its key says
//! ```
//!
//! This is the one place that knows the signs.

use super::Value;
use crate::diagnostic::{Diagnostic, codes};
use crate::expression::{Reference, parse};

/// A string of a document, classified by its first character, the sign `=` or `&`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written<'a> {
    /// An expression, without its `=`.
    Expression(&'a str),
    /// A reference, without its `&`.
    Reference(&'a str),
    /// A word, a file or a declared name.
    Plain(&'a str),
}

impl<'a> Written<'a> {
    /// Classifies a string by its first character.
    pub fn of(text: &'a str) -> Self {
        match (text.strip_prefix('='), text.strip_prefix('&')) {
            (Some(expression), _) => Self::Expression(expression),
            (None, Some(reference)) => Self::Reference(reference),
            (None, None) => Self::Plain(text),
        }
    }
}

/// The first characters, `=` or `&`, of which the JSON Schema requires one in a string.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signs {
    /// An expression: `=`.
    Expression,
    /// A reference, or an expression that yields one: `&` or `=`.
    Reference,
}

impl Signs {
    /// Returns the signs that the JSON Schema keyword `pattern` requires with `^=` or `^[&=]`; `None` for any other
    /// pattern.
    pub fn of_pattern(pattern: &str) -> Option<Self> {
        match pattern {
            "^=" => Some(Self::Expression),
            "^[&=]" => Some(Self::Reference),
            _ => None,
        }
    }

    /// Returns a diagnostic if the string `value` lacks the required sign. The diagnostic has a fix if the string
    /// becomes valid with the sign. `None` for strings with the sign and for values that are not strings.
    pub fn check(self, value: &Value) -> Option<Diagnostic> {
        let text = value.text()?;
        let (wanted, sign, code) = match (self, Written::of(text)) {
            (_, Written::Expression(_)) | (Self::Reference, Written::Reference(_)) => return None,
            (Self::Expression, _) => ("an expression", '=', codes::EXPRESSION_SYNTAX),
            (Self::Reference, Written::Plain(_)) => ("a reference", '&', codes::BAD_REFERENCE),
        };
        let message = match Written::of(text) {
            Written::Reference(_) => format!("{wanted} is wanted here, this is the reference \"{text}\""),
            _ => format!("{wanted} is wanted here, this is the word \"{text}\""),
        };
        let diagnostic = Diagnostic::error(code, value.span, message);
        if let (Self::Expression, Written::Reference(_)) = (self, Written::of(text)) {
            return Some(diagnostic.help("write a number, or an expression, which begins with \"=\""));
        }
        let is_color =
            |rest: &str| matches!(rest.len(), 3 | 4 | 6 | 8) && u32::from_str_radix(rest, 16).is_ok();
        if text.strip_prefix('#').is_some_and(is_color) {
            let help = "a color is [red, green, blue, alpha], each from 0 to 1, such as [0, 0, 0, 1]";
            return Some(diagnostic.help(help));
        }
        let is_one = match self {
            Self::Expression => parse(text).is_ok(),
            Self::Reference => {
                Reference::parse(text).is_ok_and(|_| !text.contains(|c: char| " '{}()?:/".contains(c)))
            }
        };
        if !is_one {
            return Some(diagnostic.help(format!("{wanted} begins with \"{sign}\"")));
        }
        let diagnostic = diagnostic.help(format!("{wanted} begins with \"{sign}\": write \"{sign}{text}\""));
        Some(match value.span_within(0..0) {
            Some(place) => diagnostic.fix(place, sign),
            None => diagnostic,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Sources;

    fn checked(signs: Signs, text: &str) -> Option<(String, Option<String>)> {
        let mut sources = Sources::new();
        let file = sources.add("t", serde_json::to_string(text).unwrap());
        let value = crate::document::parse(&sources, file).valid().unwrap().root;
        let diagnostic = signs.check(&value)?;
        let fixed = diagnostic.fix.map(|fix| {
            let mut text = sources.get(file).unwrap().text().to_string();
            fix.edits.iter().for_each(|edit| text.replace_range(edit.span.range(), &edit.replacement));
            text
        });
        Some((diagnostic.message, fixed))
    }

    #[test]
    fn a_string_without_its_sign_is_told_with_a_mend() {
        let fix = |signs, text| checked(signs, text).unwrap().1;
        assert_eq!(fix(Signs::Expression, "viewport / 2").as_deref(), Some("\"=viewport / 2\""));
        assert_eq!(fix(Signs::Reference, "maps@-1").as_deref(), Some("\"&maps@-1\""));
        assert_eq!(fix(Signs::Expression, "1 +"), None);
        assert_eq!(fix(Signs::Reference, "maps_{level}"), None);
        let (message, fix) = checked(Signs::Expression, "&maps").unwrap();
        assert_eq!(message, "an expression is wanted here, this is the reference \"&maps\"");
        assert_eq!(fix, None);
        for (signs, text) in
            [(Signs::Expression, "=1"), (Signs::Reference, "&a"), (Signs::Reference, "=a ? &b : &c")]
        {
            assert_eq!(checked(signs, text), None);
        }
    }
}
