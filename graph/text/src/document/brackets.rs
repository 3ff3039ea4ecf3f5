//! Brackets that are never closed, found by how a text is laid out on lines.
//!
//! A parser sees that a `}` is missing at the end of the file only, since every later one closes what stands further
//! out. A reader sees it in the indentation: what a bracket holds stands deeper than the line that opens it. So the
//! first line that begins at or left of the line of a bracket, without closing it, stands where it should have been
//! closed; and so does a `}` where a `[` is open.
//!
//! One scan of the tokens, linear in the text. Limits: a text whose outermost bracket holds lines
//! that are not indented says nothing; tabs count as one space.

use std::ops::Range;

use jsonc_parser::Scanner;
use jsonc_parser::tokens::Token;

use super::tokens::STRICT_TOKENS;

/// The maximum depth of nested brackets; deeper texts are not examined.
const MAX_DEPTH: usize = 1024;
/// The maximum number of unclosed brackets that are reported; later ones are probably consequences.
const MAX_FOUND: usize = 4;

/// A bracket that is not closed where the indentation suggests its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Unclosed {
    /// The byte offset of the bracket.
    pub(super) at: usize,
    /// The closing bracket that is missing.
    pub(super) closer: char,
    /// The byte range from the position before which the bracket should be closed to the end of that line. Empty at the
    /// end of the text.
    pub(super) before: Range<usize>,
    /// The byte offset and the characters to insert to close the bracket, with a comma if one is needed.
    pub(super) correction: (usize, String),
}

/// The unclosed brackets of a text.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// The unclosed brackets found by indentation, in the order in which they should be closed.
    pub(super) by_layout: Vec<Unclosed>,
    /// The innermost bracket that is open at the end of the text; `None` if all are closed.
    pub(super) at_the_end: Option<Unclosed>,
    /// Whether the last line begins with a closing bracket that is not indented deeper than the outermost bracket's
    /// line. If so, the text is probably not cut off.
    pub(super) is_whole: bool,
}

#[derive(Clone, Copy)]
struct Open {
    at: usize,
    /// The byte offset of the start of the bracket's line; `indentation` is the indentation of that line in bytes.
    line: usize,
    indentation: usize,
    is_brace: bool,
}

/// The state of a scan for unclosed brackets.
struct Scan<'t> {
    text: &'t str,
    open: Vec<Open>,
    /// The number of open `[`, and the number of open `{`.
    count: [usize; 2],
    found: Found,
    /// The byte offset of the start of the current line; `indentation` is the line's indentation in bytes, or `None`
    /// before the first token of the line.
    line: usize,
    indentation: Option<usize>,
    /// Whether the contents of the outermost bracket are indented; `None` before their first line.
    is_laid_out: Option<bool>,
    /// The byte offset of the end of the last token other than a comma, the byte offset at which its line starts, and
    /// whether a comma follows.
    last: (usize, usize, bool),
}

/// Finds the unclosed brackets of a text.
pub(super) fn unclosed(text: &str) -> Found {
    let mut scan = Scan {
        text,
        open: Vec::new(),
        count: [0; 2],
        found: Found::default(),
        line: 0,
        indentation: None,
        is_laid_out: None,
        last: (0, 0, false),
    };
    let mut scanner = Scanner::new(text, &STRICT_TOKENS);
    let mut before = 0;
    loop {
        let token = match scanner.scan() {
            Ok(Some(token)) => token,
            Ok(None) => break,
            // No bracket mends a text in which something is no token.
            Err(_) => return Found::default(),
        };
        let (start, end) = (scanner.token_start(), scanner.token_end());
        if let Some(newline) = text[before..start].rfind('\n') {
            (scan.line, scan.indentation) = (before + newline + 1, None);
        }
        match token {
            Token::CommentLine(_) => {}
            Token::CommentBlock(_) => {
                scan.line = text[start..end].rfind('\n').map_or(scan.line, |newline| start + newline + 1);
            }
            _ => scan.token(start, end),
        }
        if scan.open.len() > MAX_DEPTH {
            return Found::default();
        }
        before = end;
    }
    let end = text.len()..text.len();
    scan.found.at_the_end = scan.open.last().map(|open| scan.diagnostic(open, end));
    scan.found
}

impl Scan<'_> {
    fn token(&mut self, start: usize, end: usize) {
        let byte = self.text.as_bytes()[start];
        let is_closer = matches!(byte, b'}' | b']');
        if self.indentation.is_none() {
            let indentation = start - self.line;
            self.indentation = Some(indentation);
            self.first_of_line(start, indentation, is_closer);
        }
        match byte {
            b'{' | b'[' => {
                let is_brace = byte == b'{';
                self.count[usize::from(is_brace)] += 1;
                let indentation = self.indentation.unwrap_or_default();
                self.open.push(Open { at: start, line: self.line, indentation, is_brace });
            }
            b'}' | b']' => self.close(start, byte == b'}'),
            _ => {}
        }
        match byte {
            b',' => self.last.2 = true,
            _ => self.last = (end, self.line, false),
        }
    }

    /// Reports open brackets that the indentation of a new line shows to be unclosed.
    fn first_of_line(&mut self, start: usize, indentation: usize, is_closer: bool) {
        let Some(outermost) = self.open.first() else { return };
        let is_left = indentation <= outermost.indentation;
        let is_laid_out = *self.is_laid_out.get_or_insert(!is_left);
        self.found.is_whole = is_left && is_closer;
        if !is_laid_out {
            return;
        }
        while let Some(open) = self.open.last().copied() {
            let fits =
                if is_closer { open.indentation <= indentation } else { open.indentation < indentation };
            if fits {
                break;
            }
            self.give_up(open, start);
        }
    }

    fn close(&mut self, at: usize, is_brace: bool) {
        // What closes nothing is too much, and leaves nothing open.
        if self.count[usize::from(is_brace)] == 0 {
            return;
        }
        while let Some(open) = self.open.last().copied().filter(|open| open.is_brace != is_brace) {
            self.give_up(open, at);
        }
        self.open.pop();
        self.count[usize::from(is_brace)] -= 1;
    }

    /// Reports the innermost open bracket as unclosed before the byte offset `start`, and treats it as closed.
    fn give_up(&mut self, open: Open, start: usize) {
        if self.found.by_layout.len() < MAX_FOUND {
            let rest = &self.text[start..];
            let line = rest.split('\n').next().unwrap_or(rest).trim_end();
            let diagnostic = self.diagnostic(&open, start..start + line.len());
            self.found.by_layout.push(diagnostic);
        }
        self.open.pop();
        self.count[usize::from(open.is_brace)] -= 1;
    }

    fn diagnostic(&self, open: &Open, before: Range<usize>) -> Unclosed {
        let closer = if open.is_brace { '}' } else { ']' };
        let (end, line, has_comma) = self.last;
        let is_last = matches!(self.text.as_bytes().get(before.start), None | Some(b'}' | b']' | b','));
        let comma = if is_last || has_comma { "" } else { "," };
        let indentation = self.text.get(open.line..open.line + open.indentation).unwrap_or_default();
        let written = match (line == open.line, open.is_brace) {
            (true, true) => format!(" {closer}{comma}"),
            (true, false) => format!("{closer}{comma}"),
            (false, _) => format!("\n{indentation}{closer}{comma}"),
        };
        Unclosed { at: open.at, closer, before, correction: (end, written) }
    }
}
