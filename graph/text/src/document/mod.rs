//! Text to a tree in which every value knows where it stands.
//!
//! A [`Document`] is strict JSON with comments, parsed by `jsonc-parser` with all its leniencies switched off: no
//! trailing commas, no single quotes, no bare words, no hexadecimal, no NaN. Keys that stand twice in one object are
//! diagnostics. A text that is no JSON is understood as far as it goes ([`Parsed`]): what is missing is a [`Hole`], and
//! where it is a value, [`Kind::Missing`]. Numbers keep their exact value where JSON's does (64-bit integers, else
//! `f64`); a number beyond `f64` is a diagnostic, never infinity.
//!
//! Limits: nesting to 512 levels (the parser's own guard), texts to [`crate::source::MAX_FILE_BYTES`].

mod brackets;
mod decode;
pub mod format;
mod keys;
mod parse;
mod pointer;
mod read;
pub mod schema;
mod sign;
mod syntax;
mod tokens;

pub use decode::decode_entries;
pub(crate) use keys::Keys;
pub use parse::{Parsed, parse};
pub use pointer::{Pointer, pointer_join};
pub use sign::{Signs, Written};

use crate::source::Span;

/// A parsed text.
#[derive(Clone, Debug)]
pub struct Document {
    /// The one value that the text consists of.
    pub root: Value,
}

/// A JSON value and its place.
#[derive(Clone, Debug)]
pub struct Value {
    /// The place of the value.
    pub span: Span,
    /// The value itself: a number, a text, an array, ….
    pub kind: Kind,
}

/// The kind of a JSON value.
#[derive(Clone, Debug)]
pub enum Kind {
    /// `null`
    Null,
    /// `true` or `false`
    Bool(bool),
    /// A number.
    Number(serde_json::Number),
    /// A string, unescaped.
    Text(String),
    /// An array.
    Array(Vec<Value>),
    /// An object, in the order of the text.
    Object(Vec<Entry>),
    /// A missing or unreadable value: only in a document that is not valid JSON.
    Missing,
}

/// A place of a text where something else should stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hole {
    /// The place: empty, or what stands there instead.
    pub place: Span,
    /// The missing thing.
    pub expected: Expected,
    /// Whether the text was understood again between the hole before and this one.
    pub is_independent: bool,
}

/// A thing that is missing in a text that is no JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// A value.
    Value,
    /// A key in double quotes.
    Key,
    /// A colon behind a key.
    Colon,
    /// A comma between two members or elements.
    Comma,
    /// A closing bracket.
    Closer(char),
    /// The end of a string or comment, or an escape for a character.
    Escape,
    /// The end: of the text, or of an object or array behind its last comma.
    End,
}

/// One member of an object.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key, unescaped.
    pub key: String,
    /// The place of the key, quotes included.
    pub key_span: Span,
    /// The value.
    pub value: Value,
}

impl Value {
    /// The members, if this is an object.
    pub fn entries(&self) -> Option<&[Entry]> {
        match &self.kind {
            Kind::Object(entries) => Some(entries),
            _ => None,
        }
    }

    /// The elements, if this is an array.
    pub fn elements(&self) -> Option<&[Value]> {
        match &self.kind {
            Kind::Array(elements) => Some(elements),
            _ => None,
        }
    }

    /// The text, if this is a string.
    pub fn text(&self) -> Option<&str> {
        match &self.kind {
            Kind::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The place of a `range` of the text in the file; `None` if this is not a string, or one with escapes.
    pub fn span_within(&self, range: std::ops::Range<usize>) -> Option<Span> {
        self.span.of_quoted(self.text()?, range)
    }

    /// The member `key`, if this is an object that has one.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.entry(key).map(|entry| &entry.value)
    }

    /// The members of the object under `key`; none where there is no such object.
    pub fn entries_of(&self, key: &str) -> &[Entry] {
        self.get(key).and_then(Value::entries).unwrap_or_default()
    }

    /// The members of the object under `key`, mutable; `None` without such an object.
    pub fn entries_of_mut(&mut self, key: &str) -> Option<&mut Vec<Entry>> {
        let Kind::Object(entries) = &mut self.kind else { return None };
        match &mut entries.iter_mut().find(|entry| entry.key == key)?.value.kind {
            Kind::Object(members) => Some(members),
            _ => None,
        }
    }

    /// The elements of the array under `key`; none where there is no such array.
    pub fn elements_of(&self, key: &str) -> &[Value] {
        self.get(key).and_then(Value::elements).unwrap_or_default()
    }

    /// The member `key` with its key's place.
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries()?.iter().find(|entry| entry.key == key)
    }

    /// The kind of the value, as a JSON author would say it.
    pub fn kind_name(&self) -> &'static str {
        match &self.kind {
            Kind::Null => "null",
            Kind::Bool(_) => "a boolean",
            Kind::Number(_) => "a number",
            Kind::Text(_) => "a string",
            Kind::Array(_) => "an array",
            Kind::Object(_) => "an object",
            Kind::Missing => "nothing",
        }
    }

    /// The deepest value on the way of a JSON pointer that exists, starting here. A diagnostic about a value that is
    /// not there (a default, a missing key) so falls on the object that lacks it.
    pub fn nearest(&self, pointer: &str) -> &Value {
        let mut value = self;
        for token in pointer.split('/').skip(1) {
            let next = match &value.kind {
                Kind::Object(_) if token.contains('~') => {
                    value.get(&token.replace("~1", "/").replace("~0", "~"))
                }
                Kind::Object(_) => value.get(token),
                Kind::Array(elements) => token.parse::<usize>().ok().and_then(|at| elements.get(at)),
                _ => None,
            };
            match next {
                Some(next) => value = next,
                None => break,
            }
        }
        value
    }

    /// A value that all stands at one place.
    pub fn from_json(value: serde_json::Value, span: Span) -> Self {
        let kind = match value {
            serde_json::Value::Null => Kind::Null,
            serde_json::Value::Bool(value) => Kind::Bool(value),
            serde_json::Value::Number(number) => Kind::Number(number),
            serde_json::Value::String(text) => Kind::Text(text),
            serde_json::Value::Array(elements) => {
                Kind::Array(elements.into_iter().map(|element| Self::from_json(element, span)).collect())
            }
            serde_json::Value::Object(members) => Kind::Object(
                members
                    .into_iter()
                    .map(|(key, value)| Entry { key, key_span: span, value: Self::from_json(value, span) })
                    .collect(),
            ),
        };
        Self { span, kind }
    }

    /// The value without its places.
    pub fn to_json(&self) -> serde_json::Value {
        match &self.kind {
            Kind::Null | Kind::Missing => serde_json::Value::Null,
            Kind::Bool(value) => (*value).into(),
            Kind::Number(number) => number.clone().into(),
            Kind::Text(text) => text.as_str().into(),
            Kind::Array(elements) => elements.iter().map(Value::to_json).collect(),
            Kind::Object(entries) => serde_json::Value::Object(
                entries.iter().map(|entry| (entry.key.clone(), entry.value.to_json())).collect(),
            ),
        }
    }

    /// Calls `visit` with every string in this value, depth first.
    pub fn for_each_text<'a>(&'a self, visit: &mut impl FnMut(&'a str)) {
        match &self.kind {
            Kind::Text(text) => visit(text),
            Kind::Array(elements) => elements.iter().for_each(|element| element.for_each_text(visit)),
            Kind::Object(entries) => entries.iter().for_each(|entry| entry.value.for_each_text(visit)),
            _ => {}
        }
    }
}
