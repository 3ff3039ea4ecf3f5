//! The meaning of one string.

use std::ops::Range;

use crate::expression::{Expression, ExpressionKind};
use crate::language::{Expr, Written};

/// The parsed meaning of a string in a pipeline document.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A word, a name, a path or a description.
    Word,
    /// An expression or a reference; its ranges are byte offsets in the string.
    Expression(Expression),
    /// An expression or reference with a syntax error.
    Invalid,
}

/// A name that a string uses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Named {
    /// A name in an expression: a value, or the size of a resource.
    Value(String),
    /// A resource or published data.
    Resource(String),
    /// The pass whose version of a resource is referenced.
    Version(String),
}

impl Content {
    /// Parses a string: an expression after `=`, a reference after `&`, otherwise a word.
    pub(super) fn read(text: &str) -> Self {
        match Written::of(text) {
            Written::Plain(_) => Content::Word,
            _ => Expr::parse_text(text).map_or(Content::Invalid, Content::Expression),
        }
    }

    /// The expression or reference; `None` for a word or an invalid string.
    pub fn expression(&self) -> Option<&Expression> {
        match self {
            Content::Expression(expression) => Some(expression),
            _ => None,
        }
    }

    /// The names that the string `text` uses, each with its byte range in `text`.
    pub(super) fn names(&self, text: &str) -> Vec<(Named, Range<usize>)> {
        let mut names = Vec::new();
        if let Some(expression) = self.expression() {
            expression.visit(&mut |inner| match &inner.kind {
                ExpressionKind::Name(name) => names.push((Named::Value(name.clone()), inner.range.clone())),
                ExpressionKind::Reference(_) => {
                    let written = text.get(inner.range.clone()).unwrap_or_default();
                    of_reference(written, inner.range.start, &mut names);
                }
                _ => {}
            });
        }
        names
    }
}

/// Appends the names in the reference `text` to `names`; `at` is the byte offset of the reference in its string.
fn of_reference(text: &str, at: usize, names: &mut Vec<(Named, Range<usize>)>) {
    let from = usize::from(text.starts_with('&'));
    let split = text.find('@').unwrap_or(text.len());
    names.push((Named::Resource(text[from..split].to_owned()), at + from..at + split));
    let version = text.get(split + 1..).unwrap_or_default();
    if !version.is_empty() && version != "0" && !version.starts_with('-') {
        names.push((Named::Version(version.to_owned()), at + split + 1..at + text.len()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_where_they_are_written() {
        for (text, expected) in [
            ("=ceil(a.width / b)", vec!["a.width", "b"]),
            ("=soft ? 'x' : 'y'", vec!["soft"]),
            ("less", vec![]),
            ("&maps@blur.1", vec!["maps", "blur.1"]),
            ("=soft ? &maps@blur[i] : &maps", vec!["soft", "maps", "blur", "i", "maps"]),
            ("&maps@-1", vec!["maps"]),
            ("=a +", vec![]),
        ] {
            let content = Content::read(text);
            let names: Vec<&str> = content.names(text).into_iter().map(|(_, range)| &text[range]).collect();
            assert_eq!(names, expected, "{text}");
        }
    }
}
