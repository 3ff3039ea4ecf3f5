//! The tokens of a text, and where each is in another text with the same tokens.
//!
//! Comments, spaces and line ends mean nothing to a document. Two texts with the same tokens are the same document, and
//! a place in one is found in the other by the token that it lies in, or ends with. A place between tokens has no such
//! counterpart.

use jsonc_parser::tokens::Token as Scanned;
use jsonc_parser::{Scanner, ScannerOptions};

use crate::graph::source::Span;

const OPTIONS: ScannerOptions = ScannerOptions {
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// The range of a token in its text, as byte offsets; `end` is exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    start: u32,
    end: u32,
}

impl Token {
    fn text(self, text: &str) -> Option<&str> {
        text.get(self.start as usize..self.end as usize)
    }
}

/// Returns the tokens of a JSON text, without comments; `None` if the text contains an invalid token.
pub(crate) fn tokens(text: &str) -> Option<Vec<Token>> {
    let mut scanner = Scanner::new(text, &OPTIONS);
    let mut tokens = Vec::new();
    while let Some(token) = scanner.scan().ok()? {
        if !matches!(token, Scanned::CommentLine(_) | Scanned::CommentBlock(_)) {
            let offset = |at: usize| u32::try_from(at).ok();
            tokens.push(Token { start: offset(scanner.token_start())?, end: offset(scanner.token_end())? });
        }
    }
    Some(tokens)
}

/// Returns the last token of a JSON text; `None` if the text has no token, or an invalid one.
pub(crate) fn last(text: &str) -> Option<&str> {
    tokens(text)?.last()?.text(text)
}

/// Returns `true` if two texts have the same tokens.
pub(crate) fn are_alike((a, a_text): (&[Token], &str), (b, b_text): (&[Token], &str)) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.text(a_text) == b.text(b_text))
}

/// Maps a source range in a text with the tokens `from` to a text with the same tokens `to`. Returns `None` if an end
/// of the range is between tokens.
pub(crate) fn moved(span: Span, from: &[Token], to: &[Token]) -> Option<Span> {
    let start = {
        let at = from.partition_point(|token| token.start <= span.start).checked_sub(1)?;
        let (old, new) = (from.get(at)?, to.get(at)?);
        (span.start < old.end).then_some(new.start + (span.start - old.start))
    };
    let end = {
        let at = from.partition_point(|token| token.start < span.end).checked_sub(1);
        let pair = at.and_then(|at| Some((from.get(at)?, to.get(at)?)));
        pair.filter(|(old, _)| span.end <= old.end).map(|(old, new)| new.start + (span.end - old.start))
    };
    let (start, end) = match (start, end) {
        (Some(start), _) if span.start == span.end => (start, start),
        (None, Some(end)) if span.start == span.end => (end, end),
        (start, end) => (start?, end?),
    };
    Some(Span { start, end, ..span })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::source::Sources;

    #[test]
    fn places_in_tokens_move_and_places_between_them_do_not() {
        let (old, new) = ("{ \"a\" : 1 }", "// c\n{\"a\"/* d */:\n 1}");
        let mut sources = Sources::new();
        let (old_file, new_file) = (sources.add("a", old), sources.add("a", new));
        let (from, to) = (tokens(old).unwrap(), tokens(new).unwrap());
        assert!(are_alike((&from, old), (&to, new)));
        let place = |range: std::ops::Range<usize>| {
            let moved = moved(Span::new(old_file, range), &from, &to)?;
            Some(sources.text(Span { file: new_file, ..moved }))
        };
        assert_eq!(place(2..5), Some("\"a\""));
        assert_eq!(place(3..4), Some("a"));
        assert_eq!(place(0..old.len()), Some("{\"a\"/* d */:\n 1}"));
        assert_eq!(place(5..5), Some(""));
        assert_eq!(place(1..5), None);
        assert_eq!(place(2..6), None);
        assert!(!are_alike((&from, old), (&tokens("{\"a\":2}").unwrap(), "{\"a\":2}")));
        assert!(tokens("{ \"a").is_none());
    }
}
