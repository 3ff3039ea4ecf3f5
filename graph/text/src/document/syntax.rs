//! Syntax errors of a text, by `jsonc-parser`'s own parser, and their fix if there is exactly one.
//!
//! A comma too many or too few, a key without quotes, a string in single quotes and a plus in front of a number each
//! have one correction. It is a fix where the text behind it is read further than before. A bracket that is never
//! closed is looked for by the [layout](super::brackets); closing it is a fix where the text is whole with it.
//!
//! Limits: that parser stops at the first error, and what follows is told without a fix; no fixes in texts over a
//! mebibyte, and of their brackets that are never closed those only that the end of the text shows.

use std::ops::Range;

use jsonc_parser::errors::{ParseError, ParseErrorKind};
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

use super::brackets::{Found, Unclosed, unclosed};
use super::{Expected, Hole};
use crate::diagnostic::{Diagnostic, codes};
use crate::source::{FileId, Span};

pub(super) const STRICT: ParseOptions = ParseOptions {
    allow_comments: true,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// The maximum size, in bytes, of a text that is parsed again to check whether a fix removes the error.
const MAX_MENDED: usize = 1 << 20;

/// Creates the diagnostic for the first syntax error of a text that is not valid JSON.
pub(super) fn syntax(file: FileId, text: &str) -> Diagnostic {
    let whole = Span::new(file, 0..text.len());
    let help = "pipelines are strict JSON; only // and /* */ comments are allowed on top of it";
    match parse_to_ast(text, &CollectOptions::default(), &STRICT) {
        Err(error) => {
            if let Some(diagnostic) = open_bracket(file, text, error.kind()) {
                return diagnostic;
            }
            let range = error.range();
            let end = range.end.max(range.start + 1).min(text.len().max(range.start));
            let place = match error.kind() {
                // Behind the value may be the end of the line.
                ParseErrorKind::ExpectedComma => range.start.saturating_sub(1)..range.start,
                _ => range.start..end,
            };
            let message = format!("this is not JSON: {}", lower_first(&error.kind().to_string()));
            let help = match error.kind() {
                ParseErrorKind::MultipleRootJsonValues => {
                    "the first value has ended before: a } or ] closes too early, or what follows is too much"
                }
                _ => help,
            };
            let diagnostic = Diagnostic::error(codes::SYNTAX, Span::new(file, place), message);
            match correction(text, &error).filter(|correction| correction.mends(text)) {
                Some(Correction { range, replacement, help }) => {
                    diagnostic.help(help).fix(Span::new(file, range), replacement)
                }
                None => diagnostic.help(help),
            }
        }
        Ok(parsed) if parsed.value.is_none() => {
            Diagnostic::error(codes::SYNTAX, whole, "the document is empty")
                .help("the smallest pipeline has \"format\", \"name\", \"resources\" and \"passes\"")
        }
        Ok(_) => Diagnostic::error(codes::SYNTAX, whole, "this is not JSON").help(help),
    }
}

/// Creates the diagnostic for an unclosed bracket, at the bracket. `None` if `error` has another cause. An error before
/// the end of the text counts only if closing the bracket removes all errors.
fn open_bracket(file: FileId, text: &str, error: &ParseErrorKind) -> Option<Diagnostic> {
    use ParseErrorKind as Error;
    let is_at_the_end = matches!(error, Error::UnterminatedObject | Error::UnterminatedArray);
    let may_be = matches!(
        error,
        Error::ExpectedComma
            | Error::ExpectedColonAfterObjectKey
            | Error::ExpectedStringObjectProperty
            | Error::TrailingCommasNotAllowed
            | Error::UnexpectedCloseBrace
            | Error::UnexpectedCloseBracket
            | Error::UnexpectedColon
            | Error::UnexpectedTokenInObject
    );
    if !is_at_the_end && !may_be {
        return None;
    }
    let Found { by_layout, at_the_end, is_whole } = unclosed(text);
    let mended = by_layout.iter().find(|one| one.mends(text));
    let first = by_layout.first().filter(|_| is_at_the_end && is_whole);
    let found = mended.or(first).or(at_the_end.as_ref().filter(|_| is_at_the_end))?;
    let Unclosed { at, closer, before, correction } = found;
    let bracket = &text[*at..at + 1];
    let message = format!("this is not JSON: the {bracket} is never closed");
    let mut diagnostic = Diagnostic::error(codes::SYNTAX, Span::new(file, *at..at + 1), message);
    if before.is_empty() {
        diagnostic = diagnostic.help(format!("close it with {closer}"));
    } else {
        diagnostic = diagnostic
            .related(
                Span::new(file, before.clone()),
                format!("by its place, this stands behind the {closer}"),
            )
            .help(format!("close it with {closer} before that"));
    }
    if is_at_the_end {
        let end = text.trim_end().len();
        let last = (0..end).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
        if last != *at {
            diagnostic = diagnostic.related(Span::new(file, last..end), "the text ends here");
        }
    }
    Some(match mended {
        Some(_) => diagnostic.fix(Span::new(file, correction.0..correction.0), correction.1.as_str()),
        None => diagnostic,
    })
}

impl Unclosed {
    /// Returns `true` if closing this bracket makes the text valid JSON, and the text is short enough to check.
    fn mends(&self, text: &str) -> bool {
        let (at, written) = &self.correction;
        error_after(text, *at..*at, written) == Some(None)
    }
}

/// Creates the diagnostic for a string with an unescaped control character. Most often the closing quote is missing, so
/// that the string goes on to the next line.
pub(super) fn control_character(file: FileId, text: &str, string: Range<usize>) -> Diagnostic {
    let written = text.get(string.clone()).unwrap_or_default();
    let line = written.split(['\n', '\r']).next().unwrap_or_default();
    let (place, message, help) = if line.len() < written.len() {
        let message = "the string does not end on its line";
        (string.start..string.start + line.len(), message, "close it with \", or write \\n for a new line")
    } else {
        let message = "the string contains a control character";
        (string, message, "write it as an escape: \\t is a tab, \\u001b the character 1B")
    };
    Diagnostic::error(codes::SYNTAX, Span::new(file, place), format!("this is not JSON: {message}"))
        .help(help)
}

/// Creates the diagnostic for a syntax error after the first.
pub(super) fn further(hole: &Hole) -> Diagnostic {
    let (message, help) = match hole.expected {
        Expected::Comma => ("expected a comma", "put a comma in between"),
        Expected::Colon => ("expected a colon", "put a colon between the key and its value"),
        Expected::Key => ("expected a key", "keys are written in double quotes"),
        _ => ("expected a value", "a value is a string, a number, true, false, null, a list or an object"),
    };
    let place = if hole.place.start == hole.place.end {
        Span { start: hole.place.start.saturating_sub(1), ..hole.place }
    } else {
        hole.place
    };
    Diagnostic::error(codes::SYNTAX, place, format!("this is not JSON: {message}")).help(help)
}

/// The only sensible correction of a syntax error.
struct Correction {
    range: Range<usize>,
    replacement: String,
    help: &'static str,
}

fn correction(text: &str, error: &ParseError) -> Option<Correction> {
    let range = error.range();
    let (start, range) = (range.start, range.start..range.end);
    let found = text.get(range.clone())?;
    let is_word = |text: &str| text.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '$');
    let (range, replacement, help) = match error.kind() {
        ParseErrorKind::TrailingCommasNotAllowed => (range, String::new(), "remove the comma"),
        ParseErrorKind::ExpectedComma => (start..start, ",".to_owned(), "put a comma in between"),
        ParseErrorKind::ExpectedStringObjectProperty if is_word(found) => {
            (range, format!("\"{found}\""), "keys are written in double quotes")
        }
        ParseErrorKind::SingleQuotedStringsNotAllowed => {
            let inside = text.get(start..)?.strip_prefix('\'')?;
            let inside = &inside[..inside.find(['\'', '\n'])?];
            let is_plain =
                !inside.contains(['"', '\\']) && text[start + 1 + inside.len()..].starts_with('\'');
            let range = start..start + inside.len() + 2;
            (is_plain.then_some(range)?, format!("\"{inside}\""), "strings are written in double quotes")
        }
        ParseErrorKind::UnaryPlusNumbersNotAllowed => {
            let is_plus = text.get(start..)?.starts_with('+');
            (is_plus.then_some(start..start + 1)?, String::new(), "positive numbers have no sign")
        }
        ParseErrorKind::ExpectedColonAfterObjectKey => {
            let end = text.get(..start)?.trim_end().len();
            (end..end, ":".to_owned(), "put a colon between the key and its value")
        }
        ParseErrorKind::UnexpectedWord | ParseErrorKind::UnexpectedToken
            if matches!(found, "True" | "TRUE" | "False" | "FALSE") =>
        {
            (range, found.to_lowercase(), "true and false are written in small letters")
        }
        _ => return None,
    };
    Some(Correction { range, replacement, help })
}

impl Correction {
    /// Returns `true` if the parser gets past the corrected position once the correction is applied.
    fn mends(&self, text: &str) -> bool {
        let error = error_after(text, self.range.clone(), &self.replacement);
        error.is_some_and(|error| error.is_none_or(|at| at > self.range.start + self.replacement.len()))
    }
}

/// Replaces a byte range of the text, parses the result, and returns the byte offset of the first syntax error.
/// `Some(None)` if there is no error; `None` if the text is longer than [`MAX_MENDED`] bytes.
fn error_after(text: &str, range: Range<usize>, replacement: &str) -> Option<Option<usize>> {
    let (before, behind) = (text.get(..range.start)?, text.get(range.end..)?);
    let mended = (text.len() <= MAX_MENDED).then(|| [before, replacement, behind].concat())?;
    let parsed = parse_to_ast(&mended, &CollectOptions::default(), &STRICT);
    Some(parsed.err().map(|error| error.range().start))
}

fn lower_first(text: &str) -> String {
    let mut characters = text.chars();
    characters
        .next()
        .map_or_else(String::new, |first| first.to_lowercase().collect::<String>() + characters.as_str())
}

#[cfg(test)]
mod tests {
    use jsonc_parser::parse_to_ast;

    use super::super::parse;
    use crate::diagnostic::{Diagnostic, Place};
    use crate::edit;
    use crate::source::Sources;

    /// Applies the fixes of a text's diagnostics one after the other, and returns the resulting text.
    fn mend(text: &str) -> String {
        let mut text = text.to_owned();
        loop {
            let mut sources = Sources::new();
            let file = sources.add("a", text.as_str());
            let Err(diagnostics) = parse(&sources, file).valid() else { return text };
            let Some((_, edits)) = edit::mend(&diagnostics, &sources, |_| true).pop_first() else {
                return text;
            };
            text = edits.apply(&text).unwrap();
        }
    }

    #[test]
    fn what_can_be_meant_in_one_way_is_mended() {
        for (text, mended) in [
            ("{ \"a\": [1, 2,], }", "{ \"a\": [1, 2] }"),
            ("{ \"a\": 1 // first\n  \"b\": [2 3] }", "{ \"a\": 1, // first\n  \"b\": [2, 3] }"),
            ("{ a: 'x', $b: +1 }", "{ \"a\": \"x\", \"$b\": 1 }"),
            ("{ \"a\" 1, \"b\": FALSE }", "{ \"a\": 1, \"b\": false }"),
        ] {
            assert_eq!(mend(text), mended);
        }
    }

    /// Returns the byte offset and source of each diagnostic's place, with the sources of its related places.
    fn marked(text: &str) -> Vec<(usize, String, Vec<String>)> {
        let mut sources = Sources::new();
        let file = sources.add("a", text);
        let diagnostics = parse(&sources, file).valid().unwrap_err();
        let text_of = |place: &Place| match place {
            Place::Span(span) => sources.text(*span).to_owned(),
            _ => String::new(),
        };
        let mark = |diagnostic: &Diagnostic| {
            let related = diagnostic.related.iter().map(|one| text_of(&one.place)).collect();
            (diagnostic.span().unwrap().start as usize, text_of(&diagnostic.place), related)
        };
        diagnostics.iter().map(mark).collect()
    }

    const LAID_OUT: &str = r#"// laid out
{
  "first": {
    "a": [1, 2],
    "b": { "c": { "d": 1 } },
    "e": [
      { "f": "}" },
      // ]
      3
    ]
  },
  "second": [4, { "g": 5 }],
  "third": {}
}
"#;

    #[test]
    fn an_unclosed_bracket_is_marked_and_closed_at_its_line_end() {
        assert!(parse_to_ast(LAID_OUT, &Default::default(), &super::STRICT).is_ok());
        // The closer that is missing, the line that opens it with the bracket, and the line that is too far out.
        for (missing, bracket, follows) in [
            ("\n  },\n  \"second\"", "{\n    \"a\"", "\"second\""),
            ("\n    ]\n", "[\n      {", "},"),
            (" },\n    \"e\"", "{ \"c\"", "\"e\""),
            (" } },\n    \"e\"", "{ \"c\"", "\"e\""),
            ("],\n  \"third\"", "[4", "\"third\""),
            ("],\n    \"b\"", "[1", "\"b\""),
        ] {
            let at = LAID_OUT.find(missing).unwrap();
            let closer = at + missing.find(['}', ']']).unwrap();
            for comma in [0, 1] {
                // With the comma behind it, or without.
                let removed =
                    closer..closer + 1 + comma * usize::from(missing[closer - at + 1..].starts_with(','));
                let text = [&LAID_OUT[..removed.start], &LAID_OUT[removed.end..]].concat();
                let found = marked(&text);
                assert_eq!(found.len(), 1);
                let (start, marked, related) = &found[0];
                assert_eq!(*start, LAID_OUT.find(bracket).unwrap(), "{text}\n{found:?}");
                assert_eq!(marked.len(), 1);
                assert!(related[0].starts_with(follows) || related[0] == ",", "{text}\n{found:?}");
                assert!(parse_to_ast(&mend(&text), &Default::default(), &super::STRICT).is_ok(), "{text}");
                assert_eq!(
                    mend(&text).split_whitespace().collect::<String>(),
                    LAID_OUT.split_whitespace().collect::<String>()
                );
            }
        }
    }

    #[test]
    fn what_is_open_at_the_end_is_the_innermost_bracket() {
        for (text, at) in [
            (LAID_OUT.trim_end().strip_suffix('}').unwrap(), LAID_OUT.find('{').unwrap()),
            ("{ \"a\": [1, { \"b\": 2 }", 7),
            ("{\n\"a\": [\n1\n],\n\"b\": {\n\"c\": 1\n", 19),
        ] {
            let found = marked(text);
            let (start, marked, related) = &found[0];
            assert_eq!((*start, marked.len(), related.len()), (at, 1, 1), "{text}");
            assert_eq!(mend(text), text);
        }
        // Cut off, the indentation of what is there is no evidence.
        let cut = &LAID_OUT[..LAID_OUT.find("// ]").unwrap()];
        assert_eq!(marked(cut)[0].0, LAID_OUT.find("[\n").unwrap());
    }

    #[test]
    fn two_unclosed_brackets_are_found_one_after_the_other() {
        let text = LAID_OUT.replace("\n  },\n", ",\n").replace("\"g\": 5 }],", "\"g\": 5,");
        assert_eq!(marked(&text)[0].0, LAID_OUT.find("{\n    \"a\"").unwrap());
    }

    #[test]
    fn indentation_that_says_nothing_misleads_nobody() {
        // Neither is a bracket open, nor is the layout at fault.
        for text in [
            "{\n\"a\": {\n\"b\": 1\n},\n\"c\": 2,\n}",
            "{\n  \"a\": {\n\"b\": 1\n  },\n  \"c\" 2\n}",
            "{\n  \"a\": [1,\n2],\n  \"c\": 2\n  \"d\": 3\n}",
        ] {
            let (_, _, related) = &marked(text)[0];
            assert!(related.is_empty(), "{text}");
            assert!(parse_to_ast(&mend(text), &Default::default(), &super::STRICT).is_ok(), "{text}");
        }
    }

    #[test]
    fn a_string_ends_on_its_line() {
        for (text, place) in [
            ("{ \"a\": \"x,\n  \"b\": \"y\" }", "\"x,"),
            ("{ \"a\": \"x\r\n y\" }", "\"x"),
            ("{ \"a\n\": 1 }", "\"a"),
            ("{ \"a\": \"\tx\" }", "\"\tx\""),
        ] {
            let mut sources = Sources::new();
            let file = sources.add("a", text);
            let diagnostics = parse(&sources, file).valid().unwrap_err();
            let places: Vec<&str> =
                diagnostics.iter().filter_map(|each| Some(sources.text(each.span()?))).collect();
            assert_eq!(places, [place], "{text:?}");
        }
    }

    #[test]
    fn what_is_not_read_further_for_it_is_left_as_it_is() {
        for text in
            ["{ \"a\": 'it\"s' }", "{ \"a\": 'x\n }", "{ \"a\": 1; }", "{ \"a\": 1 } }", "[1,, 2]", "{", "'"]
        {
            assert_eq!(mend(text), text);
        }
    }
}
