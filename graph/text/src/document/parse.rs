//! The parser: a tree with spans, made directly of the tokens of `jsonc-parser`'s scanner.
//!
//! What is wrong with a text that is no JSON, [`super::syntax`] says.

use std::ops::Range;
use std::str::FromStr as _;

use jsonc_parser::tokens::Token;
use jsonc_parser::{Scanner, ScannerOptions};

use super::syntax::{control_character, syntax};
use super::{Document, Entry, Keys, Kind, Value};
use crate::diagnostic::{Diagnostic, Diagnostics, MAX_DIAGNOSTICS, codes};
use crate::source::{FileId, Sources, Span};

pub(super) const STRICT_TOKENS: ScannerOptions = ScannerOptions {
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// How deep a text may nest: as deep as `jsonc-parser` goes.
const MAX_DEPTH: usize = 512;

/// The maximum number of values that a text may have. The largest pipelines have 65,536 passes of a dozen values each.
const MAX_VALUES: usize = 1_500_000;

/// Where a text has more values than are read, counted by what begins or parts them outside of strings: a scan of a
/// hundredth of a second, where the tree of such a text would take seconds and gigabytes.
fn beyond_the_values(text: &str) -> Option<usize> {
    if text.len() <= MAX_VALUES {
        return None;
    }
    let (mut count, mut in_string, mut is_escaped) = (0, false, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' if in_string => is_escaped = true,
            b'"' => in_string = !in_string,
            b'{' | b'[' | b',' if !in_string => {
                count += 1;
                if count > MAX_VALUES {
                    return Some(at);
                }
            }
            _ => {}
        }
    }
    None
}

/// Parses a registered text.
///
/// # Errors
/// Every diagnostic: one syntax error at most (the parser stops there), and otherwise all duplicate keys and all
/// numbers that cannot be represented.
pub fn parse(sources: &Sources, file: FileId) -> Result<Document, Diagnostics> {
    let text = sources.get(file).map(|file| file.text().clone()).unwrap_or_else(|| "".into());
    if let Some(at) = beyond_the_values(&text) {
        let message = format!("from here on there are more than {MAX_VALUES} values");
        return Err(Diagnostic::error(codes::FILE_TOO_LARGE, Span::new(file, at..at + 1), message)
            .help("a pipeline has at most 65,536 passes: draw more in one pass, or split the pipeline")
            .into());
    }
    let mut reader = Reader::new(file, &text);
    match reader.document() {
        None => Err(match reader.control_character {
            Some(string) => control_character(file, &text, string),
            None => syntax(file, &text),
        }
        .into()),
        Some(root) if reader.diagnostics.is_empty() => Ok(Document { root }),
        Some(_) => Err(reader.diagnostics),
    }
}

/// Makes the tree while the text is scanned. Methods give `None` where the text is no JSON.
struct Reader<'t> {
    file: FileId,
    text: &'t str,
    scanner: Scanner<'t>,
    /// What is read of the objects and arrays that are not at their end yet, those of the innermost last.
    entries: Vec<Entry>,
    elements: Vec<Value>,
    diagnostics: Diagnostics,
    /// The string at which reading stopped, since a character in it has to be an escape.
    control_character: Option<Range<usize>>,
}

impl<'t> Reader<'t> {
    fn new(file: FileId, text: &'t str) -> Self {
        let scanner = Scanner::new(text, &STRICT_TOKENS);
        let (entries, elements, diagnostics) = (Vec::new(), Vec::new(), Diagnostics::new());
        Self { file, text, scanner, entries, elements, diagnostics, control_character: None }
    }

    fn document(&mut self) -> Option<Value> {
        let first = self.next()?;
        let root = self.value(first, 0)?;
        loop {
            match self.scanner.scan() {
                Ok(None) => return Some(root),
                Ok(Some(Token::CommentLine(_) | Token::CommentBlock(_))) => {}
                _ => return None,
            }
        }
    }

    fn next(&mut self) -> Option<Token<'t>> {
        loop {
            match self.scanner.scan().ok()?? {
                Token::CommentLine(_) | Token::CommentBlock(_) => {}
                // The scanner takes them; JSON does not.
                Token::String(text) if text.bytes().any(|byte| byte < 0x20) && self.is_control_written() => {
                    return None;
                }
                token => return Some(token),
            }
        }
    }

    /// Whether the last string has a control character that is not an escape.
    fn is_control_written(&mut self) -> bool {
        let written = self.scanner.token_start()..self.scanner.token_end();
        let found = self.text.get(written.clone()).is_some_and(|text| text.bytes().any(|byte| byte < 0x20));
        if found {
            self.control_character = Some(written);
        }
        found
    }

    /// The place of the last token.
    fn span(&self) -> Span {
        Span::new(self.file, self.scanner.token_start()..self.scanner.token_end())
    }

    /// The value that starts with a token.
    fn value(&mut self, token: Token<'t>, depth: usize) -> Option<Value> {
        if depth > MAX_DEPTH {
            return None;
        }
        let first = self.span();
        let kind = match token {
            Token::Null => Kind::Null,
            Token::Boolean(value) => Kind::Bool(value),
            Token::String(text) => Kind::Text(text.into_owned()),
            Token::Number(digits) => self.number(digits),
            Token::OpenBracket => Kind::Array(self.array(depth)?),
            Token::OpenBrace => Kind::Object(self.object(depth)?),
            _ => return None,
        };
        Some(Value { span: Span { end: self.span().end, ..first }, kind })
    }

    fn number(&mut self, digits: &str) -> Kind {
        if let Ok(number) = serde_json::Number::from_str(digits) {
            return Kind::Number(number);
        }
        if self.diagnostics.len() < MAX_DIAGNOSTICS {
            let message = format!("the number {} cannot be represented", shorten(digits));
            self.diagnostics.push(
                Diagnostic::error(codes::NUMBER_RANGE, self.span(), message)
                    .help("numbers are 64-bit floating point or 64-bit integers, without leading zeros"),
            );
        }
        Kind::Null
    }

    fn array(&mut self, depth: usize) -> Option<Vec<Value>> {
        let start = self.elements.len();
        let mut token = self.next()?;
        if matches!(token, Token::CloseBracket) {
            return Some(Vec::new());
        }
        loop {
            let element = self.value(token, depth + 1)?;
            self.elements.push(element);
            match self.next()? {
                Token::Comma => token = self.next()?,
                Token::CloseBracket => return Some(self.elements.split_off(start)),
                _ => return None,
            }
        }
    }

    fn object(&mut self, depth: usize) -> Option<Vec<Entry>> {
        let start = self.entries.len();
        let mut keys = Keys::default();
        let mut end_before = 0;
        let mut token = self.next()?;
        if matches!(token, Token::CloseBrace) {
            return Some(Vec::new());
        }
        loop {
            let Token::String(key) = token else { return None };
            let key_span = self.span();
            if !matches!(self.next()?, Token::Colon) {
                return None;
            }
            let first = self.next()?;
            // The key and the value are a level each.
            let value = self.value(first, depth + 2)?;
            let end = std::mem::replace(&mut end_before, value.span.end);
            let entries = &self.entries[start..];
            let twin = keys.find(entries, &key);
            match twin {
                Some(twin) => self.stands_twice(start + twin, key_span, &value, end),
                None => self.entries.push(Entry { key: key.into_owned(), key_span, value }),
            }
            match self.next()? {
                Token::Comma => token = self.next()?,
                Token::CloseBrace => return Some(self.entries.split_off(start)),
                _ => return None,
            }
        }
    }

    /// Finds a key that an object has already; `end` is that of the entry before.
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

#[cfg(test)]
mod tests {
    use jsonc_parser::{CollectOptions, parse_to_ast};

    use super::super::syntax::STRICT;
    use super::*;

    fn parse_text(text: &str) -> (Sources, Result<Document, Diagnostics>) {
        let mut sources = Sources::new();
        let file = sources.add("t.json", text);
        let result = parse(&sources, file);
        (sources, result)
    }

    #[test]
    fn every_value_knows_its_place() {
        let (sources, document) = parse_text("{ // c\n \"a\": [1, {\"b\": \"x\"}] }");
        let root = document.unwrap().root;
        assert_eq!(sources.text(root.nearest("/a/1/b").span), "\"x\"");
        assert_eq!(sources.text(root.nearest("/a/1/missing").span), "{\"b\": \"x\"}");
        assert_eq!(sources.text(root.entry("a").unwrap().key_span), "\"a\"");
    }

    #[test]
    fn leniencies_are_diagnostics() {
        for text in [
            "{\"a\":1,}",
            "{a:1}",
            "{'a':1}",
            "[0x1]",
            "[+1]",
            "[.5]",
            "[NaN]",
            "[1 2]",
            "",
            "{} {}",
            "[1e999]",
        ] {
            let (_, result) = parse_text(text);
            assert!(result.is_err(), "{text} must be rejected");
        }
    }

    #[test]
    fn a_key_that_stands_twice_is_found_with_both_places() {
        let (_, result) = parse_text("{\"a\":1,\"b\":2,\"a\":3}");
        let diagnostics = result.unwrap_err();
        let diagnostic = diagnostics.iter().next().unwrap();
        assert_eq!(diagnostic.code, codes::DUPLICATE_KEY);
        assert_eq!(diagnostic.related.len(), 1);
    }

    #[test]
    fn deep_nesting_is_a_diagnostic_and_not_a_stack_overflow() {
        let (_, result) = parse_text(&"[".repeat(100_000));
        assert!(result.is_err());
    }

    #[test]
    fn a_text_is_read_if_and_only_if_the_parser_of_the_scanner_takes_it() {
        let whole = r#"/* c */ {"a": [1, -2.5e3, true, null, {}, []], // c
            "b": {"c": "x\"\u0041", "d": [[], {"e": "ä"}]}} // c"#;
        let deep =
            |open: &str, close: &str, count: usize| format!("{}1{}", open.repeat(count), close.repeat(count));
        let mut texts = vec![whole.to_owned()];
        for count in [255, 256, 257, 511, 512, 513, 514] {
            texts.extend([deep("[", "]", count), deep("{\"a\":", "}", count)]);
        }
        for (at, character) in whole.char_indices() {
            let (before, after) = (&whole[..at], &whole[at + character.len_utf8()..]);
            texts.extend([before.to_owned(), format!("{before}{after}")]);
            for new in ["{", "}", "[", "]", ",", ":", "\"", "1", " ", "\\", "/", "-", "a", "'"] {
                texts.extend([format!("{before}{new}{after}"), format!("{before}{new}{character}{after}")]);
            }
        }
        let mut read = 0;
        for text in &texts {
            let (sources, _) = parse_text(text);
            let is_read = Reader::new(sources.iter().next().unwrap().0, text).document().is_some();
            let parsed = parse_to_ast(text, &CollectOptions::default(), &STRICT);
            assert_eq!(is_read, parsed.is_ok_and(|parsed| parsed.value.is_some()), "{text}");
            read += usize::from(is_read);
        }
        assert!(read > 100 && read < texts.len() / 2, "{read} of {}", texts.len());
    }
}
