//! Builds a tree from tokens, even if the text is not valid JSON.
//!
//! A reader that meets something else than it expects goes on as a person would:
//!
//! - a comma or colon that is missing is taken as read, one too many is passed over;
//! - a value that is missing is [`Kind::Missing`] in the tree, at the place where it should stand; a word that is no
//!   value is one, too;
//! - a key behind another key, or inside of a list, shows what was not finished before it;
//! - a closing bracket that fits an outer one closes those inside of it; one that fits none is passed over;
//! - what follows the whole is part of it, since a bracket has closed too early.
//!
//! Brackets that are never closed are closed where the [layout](super::brackets) says; the tokens have them then. Every
//! step takes a token or leaves a bracket, so reading is linear in the text.
//!
//! Limits: from the depth of 512 on, brackets are passed over with all that they hold. After 256 holes the rest is not
//! read.

use std::collections::VecDeque;
use std::str::FromStr as _;

use jsonc_parser::tokens::Token;

use super::tokens::{Fault, Lexeme, Tokens};
use super::{Entry, Expected, Hole, Keys, Kind, Value};
use crate::diagnostic::{Diagnostic, Diagnostics, MAX_DIAGNOSTICS, codes};
use crate::source::{FileId, Span};

/// The maximum depth of nested values, the same as that of `jsonc-parser`.
const MAX_DEPTH: usize = 512;

/// The maximum number of holes (positions at which something is missing or wrong), after which the rest of the text is
/// not read.
const MAX_HOLES: usize = 256;

/// Builds the tree of a document from the tokens of its source, even if the source is not valid JSON.
pub(super) struct Reader<'t> {
    file: FileId,
    text: &'t str,
    tokens: Tokens<'t>,
    /// The members read so far of all objects that are still open, those of the innermost object last. `elements`
    /// likewise holds the elements of the open arrays.
    entries: Vec<Entry>,
    elements: Vec<Value>,
    /// The number of open arrays, and the number of open objects.
    open: [usize; 2],
    /// The byte offset of the end of the last token.
    end: usize,
    /// Whether a member or element was read and properly ended since the last hole.
    is_calm: bool,
    /// The diagnostics about duplicate keys and unrepresentable numbers.
    pub(super) diagnostics: Diagnostics,
    pub(super) holes: Vec<Hole>,
    /// The byte range of a string with an unescaped control character, if that is the first error; otherwise `None`.
    pub(super) control_character: Option<std::ops::Range<usize>>,
}

impl<'t> Reader<'t> {
    pub(super) fn new(file: FileId, text: &'t str, inserted: VecDeque<(usize, char)>) -> Self {
        Self {
            file,
            text,
            tokens: Tokens::new(text, inserted),
            entries: Vec::new(),
            elements: Vec::new(),
            open: [0; 2],
            end: 0,
            is_calm: true,
            diagnostics: Diagnostics::new(),
            holes: Vec::new(),
            control_character: None,
        }
    }

    /// Reads the root value of the text.
    pub(super) fn document(&mut self) -> Value {
        let Some(first) = self.next() else {
            self.hole(Expected::Value, 0..self.text.len());
            return self.missing(0..self.text.len());
        };
        let mut root = self.value(first, 0);
        while let Some(lexeme) = self.next() {
            self.hole(Expected::End, lexeme.range.clone());
            // A bracket has closed too early: what follows belongs to the whole.
            if let (Kind::Object(entries), Token::Comma | Token::String(_)) = (&mut root.kind, &lexeme.token)
            {
                if !matches!(lexeme.token, Token::Comma) {
                    self.tokens.take_back(lexeme);
                }
                self.entries = std::mem::take(entries);
                *entries = self.object(0, 0);
                root.span = self.span(root.span.start as usize..self.end);
            }
        }
        root
    }

    fn next(&mut self) -> Option<Lexeme<'t>> {
        if self.holes.len() >= MAX_HOLES {
            return None;
        }
        let lexeme = self.tokens.next()?;
        self.end = lexeme.range.end;
        if let Some(fault) = lexeme.fault {
            let is_string = matches!(lexeme.token, Token::String(_));
            if fault != Fault::Malformed && self.holes.is_empty() {
                // With the end of the line that it does not end on.
                let end = lexeme.range.end + usize::from(fault == Fault::OpenString);
                self.control_character = Some(lexeme.range.start..end);
            }
            // A word is a hole where it stands for a value or a key.
            if is_string || lexeme.range.len() > 1 && self.text[lexeme.range.clone()].starts_with("/*") {
                self.hole(Expected::Escape, lexeme.range.clone());
            }
        }
        // The rest of the text is a comment that never ends.
        if matches!(lexeme.token, Token::Word("")) { None } else { Some(lexeme) }
    }

    fn span(&self, range: std::ops::Range<usize>) -> Span {
        Span::new(self.file, range)
    }

    fn missing(&self, range: std::ops::Range<usize>) -> Value {
        Value { span: self.span(range), kind: Kind::Missing }
    }

    fn hole(&mut self, expected: Expected, range: std::ops::Range<usize>) {
        if self.holes.len() < MAX_HOLES {
            let is_independent = std::mem::take(&mut self.is_calm);
            self.holes.push(Hole { place: self.span(range), expected, is_independent });
        }
    }

    /// Reads the value that begins with the token `first`.
    fn value(&mut self, first: Lexeme<'t>, depth: usize) -> Value {
        let start = first.range.start;
        if depth > MAX_DEPTH {
            return self.too_deep(first);
        }
        let kind = match first.token {
            Token::Null => Kind::Null,
            Token::Boolean(value) => Kind::Bool(value),
            Token::String(text) => Kind::Text(text.into_owned()),
            Token::Number(digits) => self.number(digits, first.range),
            Token::OpenBracket => Kind::Array(self.array(depth)),
            Token::OpenBrace => {
                let from = self.entries.len();
                Kind::Object(self.object(from, depth))
            }
            _ => {
                self.hole(Expected::Value, first.range.clone());
                Kind::Missing
            }
        };
        Value { span: self.span(start..self.end), kind }
    }

    /// Skips a value that is nested too deep, and returns a missing value.
    fn too_deep(&mut self, first: Lexeme<'t>) -> Value {
        let start = first.range.start;
        self.hole(Expected::Value, first.range.clone());
        let mut open = 0_usize;
        let mut next = Some(first);
        while let Some(lexeme) = next {
            match lexeme.token {
                Token::OpenBrace | Token::OpenBracket => open += 1,
                Token::CloseBrace | Token::CloseBracket => open = open.saturating_sub(1),
                _ => {}
            }
            next = if open > 0 { self.next() } else { None };
        }
        self.missing(start..self.end)
    }

    fn number(&mut self, digits: &str, range: std::ops::Range<usize>) -> Kind {
        if let Ok(number) = serde_json::Number::from_str(digits) {
            return Kind::Number(number);
        }
        if self.diagnostics.len() < MAX_DIAGNOSTICS {
            let message = format!("the number {} cannot be represented", shorten(digits));
            self.diagnostics.push(
                Diagnostic::error(codes::NUMBER_RANGE, self.span(range), message)
                    .help("numbers are 64-bit floating point or 64-bit integers, without leading zeros"),
            );
        }
        Kind::Null
    }

    fn array(&mut self, depth: usize) -> Vec<Value> {
        let start = self.elements.len();
        self.open[0] += 1;
        // Whether an element has to come, behind a comma.
        let mut is_wanted = false;
        // Whether a comma has to come before the next element.
        let mut needs_comma = false;
        loop {
            let Some(lexeme) = self.next() else {
                self.unclosed(']');
                break;
            };
            match lexeme.token {
                Token::CloseBracket => {
                    self.closes(is_wanted, lexeme.range);
                    break;
                }
                Token::CloseBrace if self.open[1] > 0 => {
                    self.hole(Expected::Closer(']'), lexeme.range.clone());
                    self.tokens.take_back(lexeme);
                    break;
                }
                Token::Comma if needs_comma => (is_wanted, needs_comma, self.is_calm) = (true, false, true),
                Token::Comma | Token::Colon | Token::CloseBrace => self.hole(Expected::Value, lexeme.range),
                _ => {
                    let is_text = matches!(lexeme.token, Token::String(_));
                    // A key of the object around it: the array has no end.
                    if is_text && self.open[1] > 0 && self.colon_follows() {
                        self.hole(Expected::Closer(']'), lexeme.range.clone());
                        self.tokens.take_back(lexeme);
                        break;
                    }
                    if needs_comma {
                        self.hole(Expected::Comma, self.end_before(&lexeme)..lexeme.range.start);
                    }
                    let element = self.value(lexeme, depth + 1);
                    self.elements.push(element);
                    (is_wanted, needs_comma) = (false, true);
                }
            }
        }
        self.open[0] -= 1;
        self.elements.split_off(start)
    }

    /// Reads the members of an object; `start` is the index in `entries` of the object's first member.
    fn object(&mut self, start: usize, depth: usize) -> Vec<Entry> {
        let mut keys = Keys::default();
        let mut end_before = 0;
        self.open[1] += 1;
        let mut is_wanted = false;
        let mut needs_comma = false;
        loop {
            let Some(lexeme) = self.next() else {
                self.unclosed('}');
                break;
            };
            let key = match lexeme.token {
                Token::CloseBrace => {
                    self.closes(is_wanted, lexeme.range);
                    break;
                }
                Token::CloseBracket if self.open[0] > 0 => {
                    self.hole(Expected::Closer('}'), lexeme.range.clone());
                    self.tokens.take_back(lexeme);
                    break;
                }
                Token::Comma if needs_comma => {
                    (is_wanted, needs_comma, self.is_calm) = (true, false, true);
                    continue;
                }
                Token::String(key) => {
                    if needs_comma {
                        self.hole(Expected::Comma, end_before as usize..lexeme.range.start);
                    }
                    key
                }
                Token::Word(word) => {
                    self.hole(Expected::Key, lexeme.range.clone());
                    if !self.colon_follows() {
                        continue;
                    }
                    word.into()
                }
                Token::OpenBrace | Token::OpenBracket => {
                    // Nobody knows what it is for.
                    self.hole(Expected::Key, lexeme.range.clone());
                    self.value(lexeme, depth + 2);
                    continue;
                }
                _ => {
                    self.hole(Expected::Key, lexeme.range);
                    continue;
                }
            };
            let key_span = self.span(lexeme.range);
            let value = self.member(depth);
            (is_wanted, needs_comma) = (false, true);
            let end = std::mem::replace(&mut end_before, value.span.end);
            let twin = keys.find(&self.entries[start..], &key);
            match twin {
                Some(twin) => self.stands_twice(start + twin, key_span, &value, end),
                None => self.entries.push(Entry { key: key.into_owned(), key_span, value }),
            }
        }
        self.open[1] -= 1;
        self.entries.split_off(start)
    }

    /// Reads the colon and the value of a member.
    fn member(&mut self, depth: usize) -> Value {
        let end = self.end;
        let mut next = self.next();
        if matches!(next, Some(Lexeme { token: Token::Colon, .. })) {
            next = self.next();
        } else {
            self.hole(Expected::Colon, end..end);
        }
        let Some(lexeme) = next else {
            let end = self.end;
            self.hole(Expected::Value, end..end);
            return self.missing(end..end);
        };
        let is_next = match &lexeme.token {
            Token::Comma | Token::CloseBrace | Token::CloseBracket => true,
            Token::String(_) | Token::Word(_) => self.colon_follows(),
            _ => false,
        };
        if is_next {
            let end = self.end_before(&lexeme);
            self.hole(Expected::Value, end..end);
            self.tokens.take_back(lexeme);
            return self.missing(end..end);
        }
        // The key and the value are a level each.
        self.value(lexeme, depth + 2)
    }

    /// The byte offset of the end of the source before a token, without trailing white space.
    fn end_before(&self, lexeme: &Lexeme<'t>) -> usize {
        self.text.get(..lexeme.range.start).map_or(0, |text| text.trim_end().len())
    }

    fn colon_follows(&mut self) -> bool {
        let end = self.end;
        let Some(next) = self.tokens.next() else { return false };
        let is_colon = matches!(next.token, Token::Colon);
        self.tokens.take_back(next);
        self.end = end;
        is_colon
    }

    /// Ends an object or an array; `is_wanted` is `true` after a trailing comma, which is an error.
    fn closes(&mut self, is_wanted: bool, closer: std::ops::Range<usize>) {
        if is_wanted {
            self.hole(Expected::End, closer);
        } else {
            self.is_calm = true;
        }
    }

    fn unclosed(&mut self, closer: char) {
        let end = self.text.len();
        self.end = self.text.trim_end().len();
        self.hole(Expected::Closer(closer), end..end);
    }

    /// Reports a duplicate key. `first` is the index of the earlier entry with the key, and `end` the byte offset at
    /// which the member before the duplicate ends.
    fn stands_twice(&mut self, first: usize, key_span: Span, value: &Value, end: u32) {
        if self.diagnostics.len() >= MAX_DIAGNOSTICS {
            return;
        }
        let first = &self.entries[first];
        let message = format!("the key \"{}\" appears twice in one object", first.key);
        let mut diagnostic = Diagnostic::error(codes::DUPLICATE_KEY, key_span, message)
            .related(first.key_span, "it stands here first")
            .help("remove one of the two, or rename it");
        // From the end of the entry before, unless a comment would be lost.
        let removed = Span { start: end, ..value.span };
        let between = self.text.get(end as usize..key_span.start as usize).unwrap_or_default();
        if between.trim() == "," && first.value.to_json() == value.to_json() {
            diagnostic = diagnostic.fix(removed, "");
        }
        self.diagnostics.push(diagnostic);
    }
}

fn shorten(text: &str) -> String {
    if text.chars().count() <= 24 {
        text.to_owned()
    } else {
        text.chars().take(24).chain("…".chars()).collect()
    }
}
