//! The tokens of a text that may be no JSON.
//!
//! They are those of `jsonc-parser`'s scanner. Where it stops, at a string without an end or a character that begins
//! nothing, the rest of that string or word is one token, and scanning starts again behind it. So every text has tokens
//! up to its end; what stands between them is space and comments.
//!
//! A string ends on its line: one that goes on to the quotes of a later line is cut at the end of its own.

use std::borrow::Cow;
use std::collections::VecDeque;
use std::ops::Range;

use jsonc_parser::tokens::Token;
use jsonc_parser::{Scanner, ScannerOptions};

pub(super) const STRICT_TOKENS: ScannerOptions = ScannerOptions {
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// A token, or a piece of the source that is no valid token.
#[derive(Clone, Debug)]
pub(super) struct Lexeme<'t> {
    /// The token. Invalid pieces are strings or words.
    pub(super) token: Token<'t>,
    /// The byte range in the source.
    pub(super) range: Range<usize>,
    /// The reason for which the token is not valid JSON; `None` if it is valid.
    pub(super) fault: Option<Fault>,
}

/// The reason for which a token is not valid JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// A character that begins no token, or a token without an end.
    Malformed,
    /// A string with a control character that must be written as an escape.
    ControlCharacter,
    /// A string that does not end on its line.
    OpenString,
}

/// A tokenizer of a source text. It skips comments, and also accepts texts that are not valid JSON.
pub(super) struct Tokens<'t> {
    text: &'t str,
    scanner: Scanner<'t>,
    /// The byte offset in the source at which the scanner started.
    base: usize,
    /// Tokens that were put back, the next one first.
    back: VecDeque<Lexeme<'t>>,
    /// Missing closing brackets to insert, each with the byte offset before which it is inserted, in the order of the
    /// offsets.
    inserted: VecDeque<(usize, char)>,
}

impl<'t> Tokens<'t> {
    /// Creates a tokenizer of a text that inserts closing brackets before the given byte offsets.
    pub(super) fn new(text: &'t str, inserted: VecDeque<(usize, char)>) -> Self {
        Self { text, scanner: Scanner::new(text, &STRICT_TOKENS), base: 0, back: VecDeque::new(), inserted }
    }

    /// Returns the next token; `None` at the end of the source.
    pub(super) fn next(&mut self) -> Option<Lexeme<'t>> {
        let lexeme = self.back.pop_front().or_else(|| self.scan());
        let start = lexeme.as_ref().map_or(self.text.len(), |lexeme| lexeme.range.start);
        if let Some((_, closer)) = self.inserted.front().copied().filter(|(before, _)| *before <= start) {
            self.inserted.pop_front();
            lexeme.into_iter().for_each(|lexeme| self.back.push_front(lexeme));
            let token = if closer == '}' { Token::CloseBrace } else { Token::CloseBracket };
            return Some(Lexeme { token, range: start..start, fault: None });
        }
        lexeme
    }

    /// Puts a token back, so that [`Self::next`] returns it again.
    pub(super) fn take_back(&mut self, lexeme: Lexeme<'t>) {
        self.back.push_front(lexeme);
    }

    fn scan(&mut self) -> Option<Lexeme<'t>> {
        loop {
            let scanned = self.scanner.scan();
            let start = self.base + self.scanner.token_start();
            let range = start..self.base + self.scanner.token_end();
            return match scanned {
                Ok(None) => None,
                Ok(Some(Token::CommentLine(_) | Token::CommentBlock(_))) => continue,
                // The scanner takes them; JSON does not.
                Ok(Some(Token::String(text))) if text.bytes().any(|byte| byte < 0x20) => {
                    Some(self.with_control_characters(text, range))
                }
                Ok(Some(token)) => Some(Lexeme { token, range, fault: None }),
                Err(_) => self.malformed(start),
            };
        }
    }

    fn with_control_characters(&mut self, text: Cow<'t, str>, range: Range<usize>) -> Lexeme<'t> {
        let written = self.text.get(range.clone()).unwrap_or_default();
        if !written.bytes().any(|byte| byte < 0x20) {
            return Lexeme { token: Token::String(text), range, fault: None };
        }
        let line = written.split(['\n', '\r']).next().unwrap_or_default();
        if line.len() == written.len() {
            return Lexeme { token: Token::String(text), range, fault: Some(Fault::ControlCharacter) };
        }
        let end = range.start + line.len();
        self.go_on_at(end);
        let inside = line[1..].trim_end();
        let token = Token::String(inside.strip_suffix(',').unwrap_or(inside).into());
        Lexeme { token, range: range.start..end, fault: Some(Fault::OpenString) }
    }
    /// Returns a token for the source at the byte offset `start`, which the scanner rejects. Scanning continues after
    /// the token.
    fn malformed(&mut self, start: usize) -> Option<Lexeme<'t>> {
        let rest = self.text.get(start..).filter(|rest| !rest.is_empty())?;
        let line = || rest.split(['\n', '\r']).next().unwrap_or_default();
        let first = rest.chars().next();
        let (length, token) = if rest.starts_with("/*") {
            // The rest of the text is a comment.
            (rest.len(), None)
        } else if let Some(quote) = first.filter(|first| matches!(first, '"' | '\'')) {
            let line = line();
            let closed = closing(line, quote);
            let inside = closed.map_or(line[1..].trim_end(), |end| &line[1..end]);
            let inside = if closed.is_some() { inside } else { inside.strip_suffix(',').unwrap_or(inside) };
            (closed.map_or(line.len(), |end| end + 1), Some(Token::String(inside.into())))
        } else {
            let is_part = |c: char| c.is_alphanumeric() || matches!(c, '_' | '$' | '.' | '+' | '-');
            let length = rest.find(|c| !is_part(c)).unwrap_or(rest.len());
            let length = length.max(first.map_or(1, char::len_utf8));
            (length, Some(Token::Word(&rest[..length])))
        };
        self.go_on_at(start + length);
        let fault = Some(Fault::Malformed);
        Some(Lexeme { token: token.unwrap_or(Token::Word("")), range: start..start + length, fault })
    }

    fn go_on_at(&mut self, at: usize) {
        self.base = at;
        self.scanner = Scanner::new(self.text.get(at..).unwrap_or_default(), &STRICT_TOKENS);
    }
}

/// Returns the byte offset of the quote that closes the string at the start of `line`; `None` if the string does not
/// end on the line.
fn closing(line: &str, quote: char) -> Option<usize> {
    let mut is_escaped = false;
    line.char_indices().skip(1).find_map(|(at, c)| {
        let closes = c == quote && !is_escaped;
        is_escaped = c == '\\' && !is_escaped;
        closes.then_some(at)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tokens(text: &str) -> Vec<&str> {
        let mut tokens = Tokens::new(text, VecDeque::new());
        std::iter::from_fn(|| tokens.next()).map(|lexeme| &text[lexeme.range]).collect()
    }

    #[test]
    fn what_is_no_token_is_one_and_scanning_goes_on_behind_it() {
        for (text, expected) in [
            ("{ \"a\": \"x,\n \"b\": 1 }", vec!["{", "\"a\"", ":", "\"x,", "\"b\"", ":", "1", "}"]),
            ("['it', +1, .5e3]", vec!["[", "'it'", ",", "+1", ",", ".5e3", "]"]),
            ("{ a: b, c }", vec!["{", "a", ":", "b", ",", "c", "}"]),
            ("[1; ä§ 2]", vec!["[", "1", ";", "ä", "§", "2", "]"]),
            ("[\"\\x\", \"b\\", vec!["[", "\"\\x\"", ",", "\"b\\"]),
            ("[1] /* open", vec!["[", "1", "]", "/* open"]),
        ] {
            assert_eq!(tokens(text), expected, "{text}");
        }
    }
}
