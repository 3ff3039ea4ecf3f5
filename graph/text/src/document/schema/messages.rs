//! The diagnostics of schema checks, with their help texts and fixes.

use super::{Entry, Value};
use crate::diagnostic::{DID_YOU_MEAN, Diagnostic, codes, list_of};

/// Creates the diagnostic for a key that is not one of `known`; `beside` lists all members of the object that contains
/// the key.
pub fn unknown_key(entry: &Entry, known: &[&str], beside: &[Entry]) -> Diagnostic {
    let diagnostic =
        Diagnostic::error(codes::UNKNOWN_KEY, entry.key_span, format!("unknown key \"{}\"", entry.key));
    // A key that is there already would stand twice; one of a file below is laid over.
    let file = entry.key_span.file;
    let taken = |name: &str| beside.iter().any(|other| other.key == name && other.key_span.file == file);
    let known = known.iter().copied();
    diagnostic.suggest_unless(&entry.key, known, Some(entry.key_span), taken, |known| match known {
        [] => "no keys are known here".to_owned(),
        known => format!("the keys known here are {}", list_of(known)),
    })
}

/// Creates the diagnostic for a value of another type than `wanted`.
pub(super) fn wrong_type(value: &Value, wanted: &str) -> Diagnostic {
    let message = format!("{wanted} is wanted here, this is {}", value.kind_name());
    let diagnostic = Diagnostic::error(codes::WRONG_TYPE, value.span, message);
    let number = value.text().filter(|text| text.parse::<f64>().is_ok_and(f64::is_finite));
    match number.filter(|_| wanted.contains("number")) {
        Some(number) => diagnostic.help(format!("write it without quotes: {number}")),
        None => diagnostic,
    }
}

/// Adds the help and the fix that put a value between two texts.
pub(super) fn with_wrapper(
    diagnostic: Diagnostic,
    value: &Value,
    wrapper: Option<(String, &'static str)>,
) -> Diagnostic {
    let Some((before, after)) = wrapper else { return diagnostic };
    let written = match value.text() {
        Some(text) => format!("\"{text}\""),
        None => "…".to_owned(),
    };
    let end = value.span.range().len();
    diagnostic
        .help(format!("write {before}{written}{after}"))
        .fix(value.span.inside(0..0), before)
        .fix(value.span.inside(end..end), after)
}

/// The beginning of the help text that lists all known words.
pub(super) const KNOWN_ARE: &str = "known are";

/// Words of other languages, each with the words here that mean the same; the first that is known counts.
const ALIASES: &[(&str, &[&str])] = &[
    ("float", &["f32"]),
    ("int", &["integer", "i32"]),
    ("uint", &["u32"]),
    ("boolean", &["bool"]),
    ("r", &["red"]),
    ("g", &["green"]),
    ("b", &["blue"]),
    ("a", &["alpha"]),
];

/// Creates the diagnostic for a value that is not one of the allowed words.
pub fn unknown_word(value: &Value, words: &[&str]) -> Diagnostic {
    let found = value.text().map_or_else(|| value.kind_name().to_owned(), |text| format!("\"{text}\""));
    let diagnostic = Diagnostic::error(codes::UNKNOWN_WORD, value.span, format!("{found} is not known here"));
    let text = value.text().unwrap_or_default();
    let mut same = ALIASES.iter().filter(|(alias, _)| *alias == text).flat_map(|(_, same)| *same);
    if let Some(word) = same.find(|word| words.contains(word)) {
        let diagnostic = diagnostic.help(format!("{DID_YOU_MEAN} \"{word}\"?"));
        return diagnostic.fix(value.span, format!("\"{word}\""));
    }
    if text.starts_with("vec") && words.contains(&"f32[]") {
        let help = "a vector is an \"f32[]\" with a length: \"min_length\": 3, \"max_length\": 3";
        return diagnostic.help(help);
    }
    // "additive" means "add".
    let shorter = words.iter().filter(|word| word.len() >= 3 && text.starts_with(**word));
    let begins = shorter.max_by_key(|word| word.len());
    let begins = begins.filter(|begun| words.iter().filter(|word| word.starts_with(**begun)).count() == 1);
    diagnostic.suggest(text, words.iter().copied(), Some(value.span), |words| match (words, begins) {
        (words, Some(word)) if words.len() <= 24 => {
            format!("is \"{word}\" meant? {KNOWN_ARE} {}", list_of(words))
        }
        (words, None) if words.len() <= 24 => format!("{KNOWN_ARE} {}", list_of(words)),
        (_, Some(word)) => format!("is \"{word}\" meant?"),
        _ => "see the schema for the words known here".to_owned(),
    })
}
