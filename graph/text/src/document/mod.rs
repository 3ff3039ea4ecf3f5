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

/// A parsed JSON document.
#[derive(Clone, Debug)]
pub struct Document {
    /// The value at the root of the document.
    pub root: Value,
}

/// A JSON value with its span in the source.
#[derive(Clone, Debug)]
pub struct Value {
    /// The span of the value in the source.
    pub span: Span,
    /// The type of the value, with its contents.
    pub kind: Kind,
}

/// The contents of a JSON value, by kind.
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
    /// An array, with its elements.
    Array(Vec<Value>),
    /// An object, with its members in the order of the source.
    Object(Vec<Entry>),
    /// A missing or unreadable value: only in a document that is not valid JSON.
    Missing,
}

/// A position in invalid JSON at which something is missing or wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hole {
    /// The span of the unexpected source at the position; empty if nothing is there.
    pub place: Span,
    /// The expected syntax element.
    pub expected: Expected,
    /// Whether valid JSON was read between the previous hole and this one. If so, this error is probably not a
    /// consequence of the previous one.
    pub is_independent: bool,
}

/// A syntax element that is missing in invalid JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// A value.
    Value,
    /// A key in double quotes.
    Key,
    /// A colon after a key.
    Colon,
    /// A comma between two members or elements.
    Comma,
    /// A closing bracket.
    Closer(char),
    /// The end of a string or comment, or an escape sequence instead of a control character.
    Escape,
    /// The end of the text, or of an object or array without a trailing comma.
    End,
}

/// One member of an object.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key, unescaped.
    pub key: String,
    /// The span of the key in the source, quotes included.
    pub key_span: Span,
    /// The value of the member.
    pub value: Value,
}

impl Value {
    /// The members of an object; `None` if this is no object.
    pub fn entries(&self) -> Option<&[Entry]> {
        match &self.kind {
            Kind::Object(entries) => Some(entries),
            _ => None,
        }
    }

    /// The elements of an array; `None` if this is no array.
    pub fn elements(&self) -> Option<&[Value]> {
        match &self.kind {
            Kind::Array(elements) => Some(elements),
            _ => None,
        }
    }

    /// The unescaped contents of a string; `None` if this is no string.
    pub fn text(&self) -> Option<&str> {
        match &self.kind {
            Kind::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Converts a byte range of this string's contents to a span of the source. `None` if this is not a string, or has
    /// escapes.
    pub fn span_within(&self, range: std::ops::Range<usize>) -> Option<Span> {
        self.span.of_quoted(self.text()?, range)
    }

    /// The value of the member `key`; `None` if this is no object, or lacks the member.
    pub fn get(&self, key: &str) -> Option<&Value> {
        self.entry(key).map(|entry| &entry.value)
    }

    /// The members of the object that is the value of the member `key`; empty if the member is missing or not an
    /// object.
    pub fn entries_of(&self, key: &str) -> &[Entry] {
        self.get(key).and_then(Value::entries).unwrap_or_default()
    }

    /// The mutable members of the object that is the value of the member `key`; `None` if the member is missing or not
    /// an object.
    pub fn entries_of_mut(&mut self, key: &str) -> Option<&mut Vec<Entry>> {
        let Kind::Object(entries) = &mut self.kind else { return None };
        match &mut entries.iter_mut().find(|entry| entry.key == key)?.value.kind {
            Kind::Object(members) => Some(members),
            _ => None,
        }
    }

    /// The elements of the array that is the value of the member `key`; empty if the member is missing or not an array.
    pub fn elements_of(&self, key: &str) -> &[Value] {
        self.get(key).and_then(Value::elements).unwrap_or_default()
    }

    /// The member `key` with the span of its key; `None` if this is no object, or lacks the member.
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        self.entries()?.iter().find(|entry| entry.key == key)
    }

    /// The kind of the value with an article, such as `an array`.
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

    /// Returns the deepest existing value on the path of a JSON pointer relative to this value. A diagnostic about a
    /// missing member can thereby point to the object that lacks the member.
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

    /// Converts a JSON value; all values and keys in it get the same span.
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

    /// Converts to a JSON value without spans; missing values become null.
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
