//! The parser: a text to a tree with spans, and all that is wrong with it.
//!
//! [`super::read`] makes the tree, also of a text that is no JSON; what is said of such a text, [`super::syntax`]
//! finds. Of further places that are wrong, those are told that do not follow from the first: where a bracket or the
//! end of a string is missing, none.

use std::collections::VecDeque;

use super::brackets::unclosed;
use super::read::Reader;
use super::{Document, Expected, Hole, Kind, Value, syntax};
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::source::{FileId, Sources, Span};

/// The maximum number of values in a document. The largest pipelines have 65,536 passes of a dozen values each.
const MAX_VALUES: usize = 1_500_000;

/// The maximum number of further syntax errors that are reported after the first.
const MAX_FURTHER: usize = 3;

/// Returns the byte offset at which a text exceeds the maximum number of values; `None` if it does not. Brackets and
/// commas outside of strings are counted, which avoids building a huge tree.
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

/// The result of parsing a text, which may be invalid JSON.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The document. If there are diagnostics, it has the parts that could be understood.
    pub document: Document,
    /// The positions at which something is missing or wrong, in the order of the source.
    pub holes: Vec<Hole>,
    /// The diagnostics. For invalid JSON, the first syntax error and a few independent ones; otherwise all duplicate
    /// keys and unrepresentable numbers.
    pub diagnostics: Diagnostics,
}

impl Parsed {
    /// Returns the document if there are no diagnostics.
    ///
    /// # Errors
    /// The diagnostics of the text.
    pub fn valid(self) -> Result<Document, Diagnostics> {
        if self.diagnostics.is_empty() { Ok(self.document) } else { Err(self.diagnostics) }
    }
}

/// Parses a registered source text as JSON with comments.
pub fn parse(sources: &Sources, file: FileId) -> Parsed {
    let text = sources.get(file).map(|file| file.text().clone()).unwrap_or_else(|| "".into());
    if let Some(at) = beyond_the_values(&text) {
        let message = format!("from here on there are more than {MAX_VALUES} values");
        let diagnostic = Diagnostic::error(codes::FILE_TOO_LARGE, Span::new(file, at..at + 1), message)
            .help("a pipeline has at most 65,536 passes: draw more in one pass, or split the pipeline");
        let root = Value { span: Span::new(file, 0..text.len()), kind: Kind::Missing };
        return Parsed { document: Document { root }, holes: Vec::new(), diagnostics: diagnostic.into() };
    }
    let mut reader = Reader::new(file, &text, VecDeque::new());
    let root = reader.document();
    let Reader { holes, diagnostics, control_character, .. } = reader;
    let parsed = Parsed { document: Document { root }, holes, diagnostics };
    if parsed.holes.is_empty() {
        return parsed;
    }
    let first = match control_character {
        Some(string) => syntax::control_character(file, &text, string),
        None => syntax::syntax(file, &text),
    };
    let breaks_off =
        |hole: &Hole| matches!(hole.expected, Expected::Closer(_) | Expected::Escape | Expected::End);
    let is_clear = !parsed.holes.iter().any(breaks_off);
    let further = parsed.holes.iter().skip(1).filter(|hole| is_clear && hole.is_independent);
    let diagnostics = std::iter::once(first).chain(further.take(MAX_FURTHER).map(syntax::further));
    Parsed { diagnostics: diagnostics.collect(), ..closed(parsed, file, &text) }
}

/// Parses a text with unclosed brackets again, with one or all of them closed where the indentation suggests. Returns
/// the result with the fewest holes.
fn closed(parsed: Parsed, file: FileId, text: &str) -> Parsed {
    if !parsed.holes.iter().any(|hole| matches!(hole.expected, Expected::Closer(_))) {
        return parsed;
    }
    let unclosed = unclosed(text).by_layout;
    let all: VecDeque<_> = unclosed.iter().map(|one| (one.before.start, one.closer)).collect();
    let each = all.iter().map(|one| VecDeque::from([*one]));
    let mut best = parsed;
    for missing in each.chain([all.clone()]) {
        let place = |at: usize| Span::new(file, at..at);
        let hole = |(at, closer): &(usize, char)| Hole {
            place: place(*at),
            expected: Expected::Closer(*closer),
            is_independent: false,
        };
        let mut holes: Vec<Hole> = missing.iter().map(hole).collect();
        let mut reader = Reader::new(file, text, missing);
        let root = reader.document();
        // A comma before a bracket that is put there is no hole.
        let follows = |hole: &Hole| {
            matches!(hole.expected, Expected::End | Expected::Comma)
                && holes.iter().any(|closer| closer.place.start == hole.place.end)
        };
        reader.holes.retain(|hole| !follows(hole));
        if reader.holes.len() < best.holes.len() {
            holes.append(&mut reader.holes);
            holes.sort_by_key(|hole| hole.place);
            best = Parsed { document: Document { root }, holes, diagnostics: best.diagnostics };
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use jsonc_parser::{CollectOptions, parse_to_ast};

    use super::super::syntax::STRICT;
    use super::*;

    fn parse_text(text: &str) -> (Sources, Result<Document, Diagnostics>) {
        let mut sources = Sources::new();
        let file = sources.add("t.json", text);
        let result = parse(&sources, file).valid();
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

    /// Returns the tree of a text in a short notation, with `_` for missing values, and the messages of the
    /// diagnostics.
    fn understood(text: &str) -> (String, Vec<String>) {
        fn shown(value: &Value) -> String {
            match &value.kind {
                Kind::Missing => "_".to_owned(),
                Kind::Array(elements) => {
                    format!("[{}]", elements.iter().map(shown).collect::<Vec<_>>().join(" "))
                }
                Kind::Object(entries) => {
                    let one = |entry: &super::super::Entry| format!("{}:{}", entry.key, shown(&entry.value));
                    format!("{{{}}}", entries.iter().map(one).collect::<Vec<_>>().join(" "))
                }
                _ => value.to_json().to_string().replace('"', ""),
            }
        }
        let mut sources = Sources::new();
        let file = sources.add("t.json", text);
        let Parsed { document, diagnostics, .. } = parse(&sources, file);
        (shown(&document.root), diagnostics.iter().map(|one| one.message.clone()).collect())
    }

    #[test]
    fn what_is_not_broken_is_understood() {
        for (text, expected) in [
            ("{ \"a\": 1 \"b\": 2 }", "{a:1 b:2}"),
            ("{ \"a\" 1, \"b\": }", "{a:1 b:_}"),
            ("{ \"a\": \"b\": 2, \"c\": [1 2,, 3] }", "{a:_ b:2 c:[1 2 3]}"),
            ("{ \"a\" \"b\": 2, c: what, \"d\": 3 }", "{a:_ b:2 c:_ d:3}"),
            ("{ \"a\": [1, { \"b\": 2 }", "{a:[1 {b:2}]}"),
            ("{ \"a\": [1, 2, \"b\": 3 }", "{a:[1 2] b:3}"),
            ("{ \"a\": { \"b\": [1, 2 }, \"c\": 3 }", "{a:{b:[1 2]} c:3}"),
            ("{ \"a\": [{ \"b\": 1 ], \"c\": 3 }", "{a:[{b:1}] c:3}"),
            ("{ \"a\": 1 } }, \"b\": 2 }", "{a:1 b:2}"),
            ("{ \"a\": \"x,\n  \"b\": \"y\" }", "{a:x b:y}"),
            ("{ \"a\": 1; \"b\": @, { \"c\": 1 }, \"d\": 2 }", "{a:1 b:_ d:2}"),
            ("{ \"a\": 1, \"b\": \"cut", "{a:1 b:cut}"),
            ("{ \"a\": 1, \"b", "{a:1 b:_}"),
            ("{ \"a\": 1, /* cut", "{a:1}"),
            ("{\n  \"a\": {\n    \"b\": 1,\n  \"c\": 2\n}\n", "{a:{b:1} c:2}"),
            ("// nothing", "_"),
        ] {
            let (tree, messages) = understood(text);
            assert_eq!(tree, expected, "{text}");
            assert!(!messages.is_empty(), "{text}");
        }
    }

    #[test]
    fn only_places_that_do_not_follow_from_the_first_are_told() {
        let two = "{\n  \"a\": 1\n  \"b\": [1, 2],\n  \"c\" 3,\n  \"d\": [4 5], \"e\": x\n}";
        let (_, messages) = understood(two);
        let expected = ["comma", "colon", "comma", "value"];
        assert_eq!(messages.len(), expected.len(), "{messages:?}");
        assert!(messages.iter().zip(expected).all(|(message, word)| message.contains(word)), "{messages:?}");
        for one in ["{ \"a\": \"b, \"c\": 1, \"d\": 2, \"e\": x y z }", "{ \"a\": [1 2, \"b\" 2, \"c\": "] {
            assert_eq!(understood(one).1.len(), 1, "{one}");
        }
    }

    #[test]
    fn a_text_is_read_exactly_if_the_reference_parser_reads_it() {
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
            let mut reader = Reader::new(sources.iter().next().unwrap().0, text, VecDeque::new());
            reader.document();
            let is_read = reader.holes.is_empty();
            let parsed = parse_to_ast(text, &CollectOptions::default(), &STRICT);
            assert_eq!(is_read, parsed.is_ok_and(|parsed| parsed.value.is_some()), "{text}");
            read += usize::from(is_read);
        }
        assert!(read > 100 && read < texts.len() / 2, "{read} of {}", texts.len());
    }
}
