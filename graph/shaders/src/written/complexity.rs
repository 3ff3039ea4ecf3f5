//! Rejecting texts that are too deep for the shader compiler, before it sees them.
//!
//! naga bounds the nesting of brackets and braces, but not chains: it descends once per link of `1 + 1 + 1 + ..`, of
//! `else if`, of a constant defined by the next one, and some 100,000 links overflow any stack, which no one can catch.
//! Its time also grows with the square of a function's length. This pass counts such links lexically. The limits are
//! far above any shader and a factor of four below what overflows the stack that naga is given (debug build, which
//! needs most).

use std::ops::Range;

use super::rejection::{Rejection, Scope};
use crate::codes;

/// The maximum size of one WGSL module in bytes.
pub(crate) const MAX_BYTES: usize = 4 << 20;
/// The maximum number of operators in one WGSL expression.
const MAX_OPERATORS: usize = 8_192;
/// The maximum number of declarations in one WGSL module.
const MAX_DECLARATIONS: usize = 8_192;
/// The maximum number of `else` branches in one WGSL function.
const MAX_BRANCHES: usize = 8_192;
/// The maximum number of statements in one WGSL module.
const MAX_STATEMENTS: usize = 32_768;

/// Rejects WGSL that is too large or too complex for naga, or that contains a null character.
pub(crate) fn check(text: &str) -> Result<(), Rejection> {
    if text.len() > MAX_BYTES {
        return Err(rejection("the module is larger than 4 MiB", 0));
    }
    if let Some(at) = text.bytes().position(|byte| byte == 0) {
        let message = "the text has a null character, which WGSL allows nowhere, not even in comments";
        let rejection = Rejection::new(codes::WGSL_SYNTAX, message, naga::Span::UNDEFINED).of(Scope::Text);
        return Err(Rejection { range: Some(at..at + 1), ..rejection.help("remove it") });
    }
    // Every count is at most the length.
    if text.len() <= MAX_OPERATORS {
        return Ok(());
    }
    // An eighth of the time that the words take.
    if is_far_below(text.as_bytes()) {
        return Ok(());
    }
    let (mut operators, mut declarations, mut branches, mut statements, mut depth) = (0, 0, 0, 0, 0_usize);
    for word in words(text) {
        match text.as_bytes()[word.start] {
            b'+' | b'-' | b'*' | b'/' | b'%' | b'!' | b'~' | b'&' | b'|' | b'^' | b'<' | b'>' | b'.'
            | b'=' | b'@' => {
                operators += 1;
            }
            b';' => {
                operators = 0;
                statements += 1;
                declarations += usize::from(depth == 0);
            }
            b',' => operators = 0,
            b'{' => {
                operators = 0;
                depth += 1;
            }
            b'}' => {
                operators = 0;
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    declarations += 1;
                    branches = 0;
                }
            }
            _ => branches += usize::from(text.get(word.clone()) == Some("else")),
        }
        let exceeded = [
            (operators > MAX_OPERATORS, "an expression has more than 8,192 operators"),
            (declarations > MAX_DECLARATIONS, "the module has more than 8,192 declarations"),
            (branches > MAX_BRANCHES, "a function has more than 8,192 branches"),
            (statements > MAX_STATEMENTS, "the module has more than 32,768 statements"),
        ];
        if let Some((_, message)) = exceeded.into_iter().find(|(exceeded, _)| *exceeded) {
            return Err(rejection(message, word.start));
        }
    }
    Ok(())
}

/// An upper bound on the number of statements in a declaration; `None` if the declaration exceeds a limit by itself.
pub(crate) fn statements(declaration: &str) -> Option<usize> {
    check(declaration).ok()?;
    Some(declaration.bytes().filter(|byte| *byte == b';').count())
}

/// Returns `true` if a module meets all size limits. `statements` holds the result of [`statements`] for each
/// declaration.
pub(crate) fn is_small(text: &str, statements: impl Iterator<Item = Option<usize>>) -> bool {
    let add = |(count, sum): (usize, usize), each: Option<usize>| Some((count + 1, sum + each?));
    let all = statements.into_iter().try_fold((0, 0), add);
    text.len() <= MAX_BYTES
        && all.is_some_and(|(count, sum)| count <= MAX_DECLARATIONS && sum <= MAX_STATEMENTS)
}

/// Returns `true` if the WGSL contains so few operators, statements and blocks that no limit can be exceeded. This fast
/// scan of the bytes overestimates the numbers.
fn is_far_below(bytes: &[u8]) -> bool {
    let (mut operators, mut ends) = (0, 0);
    for chunk in bytes.chunks(255) {
        let (mut operators_here, mut ends_here) = (0_u8, 0_u8);
        for byte in chunk {
            // Whatever else there is counts as an operator.
            let harmless =
                matches!(byte, b' ' | b'\n' | b'\r' | b'\t' | b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z' | b'_');
            operators_here += u8::from(!harmless);
            ends_here += u8::from(matches!(byte, b';' | b'}'));
        }
        operators += usize::from(operators_here);
        ends += usize::from(ends_here);
    }
    // Each branch ends with a brace.
    operators <= MAX_OPERATORS && ends <= MAX_DECLARATIONS.min(MAX_BRANCHES)
}

/// Iterates over the byte ranges of words (names, keywords, numbers) and of single other characters in WGSL. White
/// space and comments are skipped.
pub(crate) fn words(text: &str) -> impl Iterator<Item = Range<usize>> {
    let bytes = text.as_bytes();
    let mut at = 0;
    std::iter::from_fn(move || {
        loop {
            let start = at;
            at += 1;
            match (*bytes.get(start)?, bytes.get(at)) {
                (b'/', Some(b'/')) => {
                    let end = bytes[at..].iter().position(|byte| matches!(byte, b'\n' | 0x0b | 0x0c | b'\r'));
                    at = end.map_or(bytes.len(), |end| at + end);
                }
                (b'/', Some(b'*')) => at = comment_end(bytes, start).unwrap_or(bytes.len()),
                (byte, _) if byte.is_ascii_whitespace() => {}
                (byte, _) => {
                    if is_of_word(&byte) {
                        at += bytes[at..].iter().take_while(|byte| is_of_word(byte)).count();
                    }
                    return Some(start..at);
                }
            }
        }
    })
}

/// Returns `true` if a byte of UTF-8 can be part of a WGSL name or number; names may contain letters of any script.
pub(crate) fn is_of_word(byte: &u8) -> bool {
    byte.is_ascii_alphanumeric() || *byte == b'_' || !byte.is_ascii()
}

/// The byte offset of the end of the block comment at `start`, including nested comments; `None` if it is not closed.
pub(super) fn comment_end(bytes: &[u8], start: usize) -> Option<usize> {
    let (mut at, mut depth) = (start, 0_usize);
    loop {
        match bytes.get(at..at + 2)? {
            b"/*" => depth += 1,
            b"*/" => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return Some(at);
        }
    }
}

fn rejection(message: &str, at: usize) -> Rejection {
    let help = "split the template into several passes, or let loops of WGSL do what is written out";
    let rejection =
        Rejection::new(codes::WGSL_TOO_LARGE, message, naga::Span::UNDEFINED).help(help).of(Scope::Text);
    Rejection { range: Some(at..at + 1), ..rejection }
}
