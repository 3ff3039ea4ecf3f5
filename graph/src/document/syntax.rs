//! What is wrong with a text that is no JSON, by `jsonc-parser`'s own parser, and the one way to mend it where there is one.
//!
//! A comma too many or too few, a key without quotes, a string in single quotes and a plus in front of a number each have
//! one correction. It is a fix where the text behind it is read further than before.
//!
//! Limits: one finding for each text, since the parser stops there; no fixes in texts over a mebibyte.

use jsonc_parser::errors::{ParseError, ParseErrorKind};
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

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

/// Longer texts are not read again to see whether a fix mends them.
const MAXIMUM_MENDED: usize = 1 << 20;

/// The finding for a text that is no JSON.
pub(super) fn syntax(file: FileId, text: &str) -> Diagnostic {
    let whole = Span::new(file, 0..text.len());
    let help = "pipelines are strict JSON; only // and /* */ comments are allowed on top of it";
    match parse_to_ast(text, &CollectOptions::default(), &STRICT) {
        Err(error) => {
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
            let finding = Diagnostic::error(codes::SYNTAX, Span::new(file, place), message);
            match correction(text, &error).filter(|correction| correction.mends(text)) {
                Some(Correction { range, replacement, help }) => {
                    finding.help(help).fix(Span::new(file, range), replacement)
                }
                None => finding.help(help),
            }
        }
        Ok(parsed) if parsed.value.is_none() => {
            Diagnostic::error(codes::SYNTAX, whole, "the document is empty")
                .help("the smallest pipeline has \"format\", \"name\", \"resources\" and \"passes\"")
        }
        Ok(_) => Diagnostic::error(codes::SYNTAX, whole, "this is not JSON").help(help),
    }
}

/// The finding for a string with a character that only an escape can write: most often its end is missing, and it goes
/// on to the quotes of the next line.
pub(super) fn control_character(file: FileId, text: &str, string: std::ops::Range<usize>) -> Diagnostic {
    let written = text.get(string.clone()).unwrap_or_default();
    let line = written.split(['\n', '\r']).next().unwrap_or_default();
    let (place, message, help) = if line.len() < written.len() {
        let message = "the string does not end on its line";
        (string.start..string.start + line.len(), message, "close it with \", or write \\n for a new line")
    } else {
        let message = "a control character stands in the string";
        (string, message, "write it as an escape: \\t is a tab, \\u001b the character 1B")
    };
    Diagnostic::error(codes::SYNTAX, Span::new(file, place), format!("this is not JSON: {message}"))
        .help(help)
}

/// The one way to mend an error.
struct Correction {
    range: std::ops::Range<usize>,
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
            (range, format!("\"{found}\""), "keys stand in double quotes")
        }
        ParseErrorKind::SingleQuotedStringsNotAllowed => {
            let inside = text.get(start..)?.strip_prefix('\'')?;
            let inside = &inside[..inside.find(['\'', '\n'])?];
            let is_plain =
                !inside.contains(['"', '\\']) && text[start + 1 + inside.len()..].starts_with('\'');
            let range = start..start + inside.len() + 2;
            (is_plain.then_some(range)?, format!("\"{inside}\""), "strings stand in double quotes")
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
    /// Whether the text is read further with it.
    fn mends(&self, text: &str) -> bool {
        if text.len() > MAXIMUM_MENDED {
            return false;
        }
        let (Some(before), Some(behind)) = (text.get(..self.range.start), text.get(self.range.end..)) else {
            return false;
        };
        let mended = [before, &self.replacement, behind].concat();
        match parse_to_ast(&mended, &CollectOptions::default(), &STRICT) {
            Ok(_) => true,
            Err(error) => error.range().start > self.range.start + self.replacement.len(),
        }
    }
}

fn lower_first(text: &str) -> String {
    let mut characters = text.chars();
    characters
        .next()
        .map_or_else(String::new, |first| first.to_lowercase().collect::<String>() + characters.as_str())
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use crate::diagnostic::fix;
    use crate::source::Sources;

    /// The text with its fixes made, one after the other.
    fn mend(text: &str) -> String {
        let mut text = text.to_owned();
        loop {
            let mut sources = Sources::new();
            let file = sources.add("a", text.as_str());
            let Err(findings) = parse(&sources, file) else { return text };
            let Some(fixed) = fix::apply(&findings, &sources, |_| true).pop() else { return text };
            text = fixed.text;
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
            let findings = parse(&sources, file).unwrap_err();
            let places: Vec<&str> =
                findings.iter().filter_map(|each| Some(sources.text(each.span()?))).collect();
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
