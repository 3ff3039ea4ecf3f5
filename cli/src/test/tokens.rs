//! Tokens of WGSL with strings, which shader tests have for their messages.
//!
//! Only what the scan for tests needs is told apart: words, strings and single characters. Comments are left out.

use std::ops::Range;

/// A token of a shader source.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    pub(super) range: Range<usize>,
    pub(super) kind: TokenKind,
}

/// The kind of a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TokenKind {
    /// An identifier, a keyword or a number.
    Word,
    /// A string with its quotes.
    Text,
    /// Any other character.
    Sign(u8),
}

/// Splits a shader source into tokens; comments and white space are skipped.
pub(super) fn tokens(text: &str) -> Vec<Token> {
    let bytes = text.as_bytes();
    let is_word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_' || byte >= 0x80;
    let run = |start: usize, is_part: &dyn Fn(u8) -> bool| {
        bytes[start..].iter().position(|byte| !is_part(*byte)).map_or(bytes.len(), |length| start + length)
    };
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some(byte) = bytes.get(at).copied() {
        let start = at;
        let kind = match byte {
            _ if byte.is_ascii_whitespace() => {
                at += 1;
                continue;
            }
            b'/' if bytes.get(at + 1) == Some(&b'/') => {
                at = run(at, &|byte| byte != b'\n');
                continue;
            }
            b'/' if bytes.get(at + 1) == Some(&b'*') => {
                at = end_of_comment(bytes, at);
                continue;
            }
            b'"' => {
                at = end_of_string(bytes, at);
                TokenKind::Text
            }
            _ if is_word(byte) => {
                at = run(at, &is_word);
                TokenKind::Word
            }
            _ => {
                at += 1;
                TokenKind::Sign(byte)
            }
        };
        found.push(Token { range: start..at, kind });
    }
    found
}

/// Returns the byte offset of the end of a block comment; block comments nest.
fn end_of_comment(bytes: &[u8], start: usize) -> usize {
    let (mut at, mut depth) = (start, 0_usize);
    while at < bytes.len() {
        match bytes.get(at..at + 2) {
            Some(b"/*") => (at, depth) = (at + 2, depth + 1),
            Some(b"*/") => (at, depth) = (at + 2, depth - 1),
            _ => at += 1,
        }
        if depth == 0 {
            return at;
        }
    }
    bytes.len()
}

/// Returns the byte offset of the end of a string, at the latest the end of its line.
fn end_of_string(bytes: &[u8], start: usize) -> usize {
    let mut at = start + 1;
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'"' => return at + 1,
            b'\n' => return at,
            b'\\' => at += 2,
            _ => at += 1,
        }
    }
    bytes.len()
}
