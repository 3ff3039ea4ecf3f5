//! A document with expressions in place of the names of derived values.
//!
//! Analyses that ask on which settings a text depends read such a document: wherever a text has the name of a derived
//! value, it has an expression over parameters and features instead.
//!
//! Names are replaced in expressions, wherever they stand as words; so a derived value cannot share its name with a
//! parameter, a feature or a resource.
//!
//! Limits: a text that is longer than an expression can be once it is inlined is none any more, but still mentions the
//! settings.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::derived::order;
use crate::compose::is_path;
use crate::document::{Document, Kind, Value as Json, Written};

/// The longest text that is an expression.
const MAX_BYTES: usize = 4096;

/// A document in which the texts of passes, resources, groups and subgraphs, and those of derived values themselves, have
/// expressions over parameters and features in place of the names of derived values.
pub fn inlined(document: &Document) -> Cow<'_, Document> {
    let has_any = |owner: &Json| owner.get("derived").is_some();
    let subgraphs = document.root.entries_of("subgraphs");
    if !has_any(&document.root) && !subgraphs.iter().any(|subgraph| has_any(&subgraph.value)) {
        return Cow::Borrowed(document);
    }
    let mut root = document.root.clone();
    let texts = inline_owner(&mut root, &BTreeMap::new());
    if let Some(subgraphs) = root.entries_of_mut("subgraphs") {
        for subgraph in subgraphs {
            let mut seen = if is_path(&subgraph.key) { BTreeMap::new() } else { texts.clone() };
            for section in ["parameters", "inputs"] {
                for own in subgraph.value.entries_of(section) {
                    seen.remove(&own.key);
                }
            }
            inline_owner(&mut subgraph.value, &seen);
        }
    }
    Cow::Owned(Document { root })
}

/// Inlines what a pipeline or a subgraph derives into its own sections, together with what it sees of `around`. Returns
/// all of these.
fn inline_owner(owner: &mut Json, around: &BTreeMap<String, String>) -> BTreeMap<String, String> {
    let mut texts = around.clone();
    let declared = owner.entries_of("derived");
    let own: BTreeMap<String, String> =
        declared.iter().map(|entry| (entry.key.clone(), written(&entry.value))).collect();
    let needs: BTreeMap<&str, BTreeSet<&str>> = own
        .iter()
        .map(|(name, text)| {
            let known = words_of(text).filter_map(|range| Some(own.get_key_value(&text[range])?.0.as_str()));
            (name.as_str(), known.collect())
        })
        .collect();
    own.keys().for_each(|name| drop(texts.remove(name)));
    for name in order(&needs).0 {
        let text = inline_text(&own[name], &texts);
        texts.insert(name.to_owned(), text);
    }
    for section in ["derived", "resources", "passes"] {
        for member in owner.entries_of_mut(section).into_iter().flatten() {
            inline_value(&mut member.value, &texts);
        }
    }
    texts
}

/// The text of an expression.
fn written(value: &Json) -> String {
    match &value.kind {
        Kind::Text(text) => match Written::of(text) {
            Written::Expression(expression) => expression.to_owned(),
            _ => text.clone(),
        },
        Kind::Array(elements) => format!("[{}]", elements.iter().map(written).collect::<Vec<_>>().join(", ")),
        _ => value.to_json().to_string(),
    }
}

fn inline_value(value: &mut Json, texts: &BTreeMap<String, String>) {
    match &mut value.kind {
        Kind::Text(text) => {
            if let Written::Expression(_) = Written::of(text) {
                *text = inline_text(text, texts);
            }
        }
        Kind::Array(elements) => elements.iter_mut().for_each(|element| inline_value(element, texts)),
        Kind::Object(members) => members
            .iter_mut()
            .filter(|member| member.key != "description")
            .for_each(|member| inline_value(&mut member.value, texts)),
        Kind::Null | Kind::Bool(_) | Kind::Number(_) | Kind::Missing => {}
    }
}

/// A text with expressions in place of names.
fn inline_text(text: &str, texts: &BTreeMap<String, String>) -> String {
    let mut result = String::new();
    let mut mentioned = BTreeSet::new();
    let mut at = 0;
    for range in words_of(text) {
        let Some(expression) = texts.get(&text[range.clone()]) else { continue };
        mentioned.insert(&text[range.clone()]);
        if result.len() + expression.len() <= MAX_BYTES {
            result.extend([&text[at..range.start], "(", expression, ")"]);
        } else {
            result = " ".repeat(MAX_BYTES + 1);
        }
        at = range.end;
    }
    result.push_str(&text[at..]);
    if result.len() <= MAX_BYTES || mentioned.is_empty() {
        return result;
    }
    // No expression any more, but all that it mentions.
    let within = mentioned.iter().flat_map(|name| words_of(&texts[*name]).map(|range| &texts[*name][range]));
    let own = words_of(text).map(|range| &text[range]).filter(|name| !texts.contains_key(*name));
    let all: BTreeSet<&str> = within.chain(own).collect();
    format!("? {}", all.into_iter().collect::<Vec<_>>().join(" "))
}

/// The ranges of the names in a text, but for those in quotes.
fn words_of(text: &str) -> impl Iterator<Item = Range<usize>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        loop {
            let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let begin = at + text[at..].find(|c| is_word(c) || c == '\'')?;
            if text[begin..].starts_with('\'') {
                at = text[begin + 1..].find('\'').map_or(text.len(), |length| begin + length + 2);
                continue;
            }
            let length = text[begin..].find(|c| !is_word(c) && c != '.');
            at = length.map_or(text.len(), |length| begin + length);
            return Some(begin..at);
        }
    })
}
