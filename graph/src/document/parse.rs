//! The parser: `jsonc-parser`'s syntax tree, turned into our own with spans and duplicate keys found.

use std::collections::HashMap;
use std::str::FromStr as _;

use jsonc_parser::ast;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

use super::{Document, Entry, Kind, Value};
use crate::diagnostic::{Diagnostic, Diagnostics, MAXIMUM_FINDINGS, codes};
use crate::source::{FileId, Sources, Span};

const STRICT: ParseOptions = ParseOptions {
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

/// The most values that a text may have. The largest pipelines have 65,536 passes of a dozen values each.
const MAXIMUM_VALUES: usize = 1_500_000;

/// Where a text has more values than are read, counted by what begins or parts them outside of strings: a scan of a
/// hundredth of a second, where the tree of such a text would take seconds and gigabytes.
fn beyond_the_values(text: &str) -> Option<usize> {
    let (mut count, mut in_string, mut is_escaped) = (0, false, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            _ if is_escaped => is_escaped = false,
            b'\\' if in_string => is_escaped = true,
            b'"' => in_string = !in_string,
            b'{' | b'[' | b',' if !in_string => {
                count += 1;
                if count > MAXIMUM_VALUES {
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
/// Every finding: one syntax error at most (the parser stops there), and otherwise all duplicate keys and all numbers
/// that cannot be represented.
pub fn parse(sources: &Sources, file: FileId) -> Result<Document, Diagnostics> {
    let text = sources.get(file).map(|file| file.text().clone()).unwrap_or_else(|| "".into());
    if let Some(at) = beyond_the_values(&text) {
        let message = format!("from here on there are more than {MAXIMUM_VALUES} values");
        return Err(Diagnostic::error(codes::FILE_TOO_LARGE, Span::new(file, at..at + 1), message)
            .help("a pipeline has at most 65,536 passes: draw more in one pass, or split the pipeline")
            .into());
    }
    let parsed = parse_to_ast(&text, &CollectOptions::default(), &STRICT).map_err(|error| {
        let range = error.range();
        let end = range.end.max(range.start + 1).min(text.len().max(range.start));
        let message = lower_first(&error.kind().to_string());
        Diagnostic::error(
            codes::SYNTAX,
            Span::new(file, range.start..end),
            format!("this is not JSON: {message}"),
        )
        .help("pipelines are strict JSON; only // and /* */ comments are allowed on top of it")
    })?;
    let Some(root) = parsed.value else {
        return Err(Diagnostic::error(
            codes::SYNTAX,
            Span::new(file, 0..text.len()),
            "the document is empty",
        )
        .help("the smallest pipeline has \"format\", \"name\", \"resources\" and \"passes\"")
        .into());
    };
    let mut reader = Reader { file, text: &text, diagnostics: Diagnostics::new() };
    let root = reader.value(&root);
    if reader.diagnostics.is_empty() { Ok(Document { root }) } else { Err(reader.diagnostics) }
}

fn lower_first(text: &str) -> String {
    let mut characters = text.chars();
    characters
        .next()
        .map_or_else(String::new, |first| first.to_lowercase().collect::<String>() + characters.as_str())
}

struct Reader<'t> {
    file: FileId,
    text: &'t str,
    diagnostics: Diagnostics,
}

impl Reader<'_> {
    fn value(&mut self, value: &ast::Value<'_>) -> Value {
        let span = self.span(value);
        let kind = match value {
            ast::Value::NullKeyword(_) => Kind::Null,
            ast::Value::BooleanLit(literal) => Kind::Bool(literal.value),
            ast::Value::StringLit(literal) => Kind::Text(literal.value.to_string()),
            ast::Value::NumberLit(literal) => match serde_json::Number::from_str(literal.value) {
                Ok(number) => Kind::Number(number),
                Err(_) if self.diagnostics.len() >= MAXIMUM_FINDINGS => Kind::Null,
                Err(_) => {
                    self.diagnostics.push(
                        Diagnostic::error(
                            codes::NUMBER_RANGE,
                            span,
                            format!("the number {} cannot be represented", shorten(literal.value)),
                        )
                        .help("numbers are 64-bit floating point or 64-bit integers, without leading zeros"),
                    );
                    Kind::Null
                }
            },
            ast::Value::Array(array) => {
                Kind::Array(array.elements.iter().map(|element| self.value(element)).collect())
            }
            ast::Value::Object(object) => Kind::Object(self.entries(object)),
        };
        Value { span, kind }
    }

    fn entries(&mut self, object: &ast::Object<'_>) -> Vec<Entry> {
        let mut entries: Vec<Entry> = Vec::with_capacity(object.properties.len());
        let mut seen = HashMap::with_capacity(object.properties.len());
        let mut end_before = 0;
        for property in &object.properties {
            let key_span = self.span(&property.name);
            let key = property.name.as_str();
            let value = self.value(&property.value);
            let end = std::mem::replace(&mut end_before, value.span.end);
            if let Some(first) = seen.get(key).and_then(|at: &usize| entries.get(*at)) {
                if self.diagnostics.len() >= MAXIMUM_FINDINGS {
                    continue;
                }
                let mut finding = Diagnostic::error(
                    codes::DUPLICATE_KEY,
                    key_span,
                    format!("the key \"{key}\" stands twice in one object"),
                )
                .related(first.key_span, "it stands here first")
                .help("remove one of the two, or rename it");
                // From the end of the entry before, unless a comment would be lost.
                let removed = Span { start: end, ..value.span };
                let between = self.text.get(end as usize..key_span.start as usize).unwrap_or_default();
                if between.trim() == "," && first.value.to_json() == value.to_json() {
                    finding = finding.fix(removed, "");
                }
                self.diagnostics.push(finding);
                continue;
            }
            seen.insert(key.to_owned(), entries.len());
            entries.push(Entry { key: key.to_owned(), key_span, value });
        }
        entries
    }

    fn span(&self, node: &impl jsonc_parser::common::Ranged) -> Span {
        let range = node.range();
        Span::new(self.file, range.start..range.end)
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
    fn leniencies_are_findings() {
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
            assert!(result.is_err(), "{text} must be refused");
        }
    }

    #[test]
    fn a_key_that_stands_twice_is_found_with_both_places() {
        let (_, result) = parse_text("{\"a\":1,\"b\":2,\"a\":3}");
        let findings = result.unwrap_err();
        let finding = findings.iter().next().unwrap();
        assert_eq!(finding.code, codes::DUPLICATE_KEY);
        assert_eq!(finding.related.len(), 1);
    }

    #[test]
    fn deep_nesting_is_a_finding_and_not_a_stack_overflow() {
        let (_, result) = parse_text(&"[".repeat(100_000));
        assert!(result.is_err());
    }
}
