//! The meaning of one string.

use std::ops::Range;

use crate::expression::{self, Expression, ExpressionKind};
use crate::language::{Expr, Written};

/// The meaning of a string.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// A word, a name, a path or a description.
    Word,
    /// An expression, or a reference; places in it are those in the string.
    Expression(Expression),
    /// A name put together: the expressions in its braces.
    Interpolation(Vec<Expression>),
    /// Neither of these: it has a syntax error.
    Invalid,
}

/// A name in a string.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Named {
    /// A name in an expression: a value, or the size of a resource.
    Value(String),
    /// A resource or published data, perhaps one that is put together.
    Resource(String),
    /// The pass that wrote a version.
    Version(String),
}

impl Content {
    /// Reads a string, by its sign.
    pub(super) fn read(text: &str) -> Self {
        match Written::of(text) {
            Written::Plain(_) if text.contains('{') => {
                let part = |range: Range<usize>| expression::parse_from(&text[..range.end], range.start).ok();
                let parts = braces(text).map(part).collect::<Option<_>>();
                parts.map_or(Content::Invalid, Content::Interpolation)
            }
            Written::Plain(_) => Content::Word,
            _ => Expr::parse_text(text).map_or(Content::Invalid, Content::Expression),
        }
    }

    /// The expression, if it is one.
    pub fn expression(&self) -> Option<&Expression> {
        match self {
            Content::Expression(expression) => Some(expression),
            _ => None,
        }
    }

    /// The names in a string, each with its place there.
    pub(super) fn names(&self, text: &str) -> Vec<(Named, Range<usize>)> {
        let mut names = Vec::new();
        let parts = match self {
            Content::Expression(expression) => std::slice::from_ref(expression),
            Content::Interpolation(parts) => parts,
            _ => &[],
        };
        for expression in parts {
            expression.visit(&mut |inner| match &inner.kind {
                ExpressionKind::Name(name) => names.push((Named::Value(name.clone()), inner.range.clone())),
                ExpressionKind::Reference(_) => {
                    let written = text.get(inner.range.clone()).unwrap_or_default();
                    of_reference(written, inner.range.start, &mut names);
                }
                _ => {}
            });
        }
        if matches!(self, Content::Interpolation(_)) {
            of_reference(text, 0, &mut names);
        }
        names
    }
}

/// The names in a reference that begins at a byte of a string.
fn of_reference(text: &str, at: usize, names: &mut Vec<(Named, Range<usize>)>) {
    let from = usize::from(text.starts_with('&'));
    let split = text.find('@').unwrap_or(text.len());
    names.push((Named::Resource(text[from..split].to_owned()), at + from..at + split));
    let version = text.get(split + 1..).unwrap_or_default();
    if !version.is_empty() && version != "0" && !version.starts_with('-') {
        names.push((Named::Version(version.to_owned()), at + split + 1..at + text.len()));
    }
}

/// What stands between braces.
fn braces(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        let open = at + text[at..].find('{')? + 1;
        let close = text[open..].find('}').map_or(text.len(), |length| open + length);
        at = close;
        Some(open..close)
    })
}

/// Whether a name that is put together can be this one.
pub(super) fn can_be(pattern: &str, name: &str) -> bool {
    let mut rest = name;
    let mut pieces = Vec::new();
    let mut at = 0;
    for range in braces(pattern) {
        pieces.push(&pattern[at..range.start - 1]);
        at = (range.end + 1).min(pattern.len());
    }
    pieces.push(&pattern[at..]);
    let last = pieces.len() - 1;
    for (number, piece) in pieces.iter().enumerate() {
        let found = match number {
            0 if last == 0 => (rest == *piece).then_some(piece.len()),
            0 => rest.starts_with(piece).then_some(piece.len()),
            _ if number == last => rest.ends_with(piece).then_some(rest.len()),
            _ => rest.find(piece).map(|at| at + piece.len()),
        };
        let Some(length) = found else { return false };
        rest = &rest[length..];
    }
    true
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
            ("chain@down.{level - 1}", vec!["level", "chain", "down.{level - 1}"]),
            ("=a +", vec![]),
        ] {
            let content = Content::read(text);
            let names: Vec<&str> = content.names(text).into_iter().map(|(_, range)| &text[range]).collect();
            assert_eq!(names, expected, "{text}");
        }
    }

    #[test]
    fn a_name_that_is_put_together_can_be_what_fits_around_it() {
        for (pattern, name, fits) in [
            ("soft_{a}_moments", "soft_spot_moments", true),
            ("soft_{a}_moments", "soft_moments", false),
            ("{a}", "any", true),
            ("x{a}y{b}", "x1y", true),
            ("plain", "plain", true),
            ("plain", "plainer", false),
        ] {
            assert_eq!(can_be(pattern, name), fits, "{pattern} {name}");
        }
    }
}
