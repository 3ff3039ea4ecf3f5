//! [`Draft`]: a text of a document that is edited step by step, as edits of the text that it began with.

use serde_json::Value as Json;

use super::error::{ChangeError, Changed};
use crate::graph::document::{Document, Kind, Value, parse};
use crate::graph::edit::{Edits, Item, insert, remove, reorder, set};
use crate::graph::source::{Sources, Span};

/// The text of a document while it is edited in several steps, with the edits made so far.
pub(super) struct Draft {
    text: String,
    edits: Edits,
}

impl Draft {
    /// Creates a draft of a file's text.
    ///
    /// # Errors
    /// Returns [`ChangeError::Broken`] if the text is not a valid document.
    pub(super) fn new(file: &str, text: &str) -> Result<Self, ChangeError> {
        let mut sources = Sources::new();
        let added = sources.add(file, text);
        if parse(&sources, added).valid().is_err() {
            return Err(ChangeError::Broken(file.to_owned()));
        }
        Ok(Self { text: text.to_owned(), edits: Edits::default() })
    }

    pub(super) fn root(&self) -> Value {
        let mut sources = Sources::new();
        let file = sources.add("draft", self.text.as_str());
        let Document { root } = parse(&sources, file).document;
        root
    }

    pub(super) fn into_edits(self) -> Edits {
        self.edits
    }

    pub(super) fn make(&mut self, edits: &Edits) -> Changed {
        self.text = edits.apply(&self.text)?;
        self.edits = self.edits.then(edits);
        Ok(())
    }

    /// Replaces the value at a path of object keys and array indices.
    pub(super) fn set(&mut self, keys: &[&str], json: &Json) -> Changed {
        let root = self.root();
        let value = at(&root, keys).ok_or(ChangeError::Gone)?;
        let edits = set(&self.text, value, json)?;
        self.make(&edits)
    }

    /// Replaces the value at a path of object keys and array indices. If it does not exist, inserts it, with the
    /// objects and arrays that are missing around it.
    pub(super) fn put(&mut self, keys: &[&str], json: &Json) -> Changed {
        let root = self.root();
        let known = (0..=keys.len()).rev().find(|count| at(&root, &keys[..*count]).is_some()).unwrap_or(0);
        let Some((first, rest)) = keys[known..].split_first() else { return self.set(keys, json) };
        let content = rest.iter().rev().fold(json.clone(), |inner, key| match *key {
            "0" => Json::Array(vec![inner]),
            key => Json::Object([(key.to_owned(), inner)].into_iter().collect()),
        });
        let container = at(&root, &keys[..known]).ok_or(ChangeError::Gone)?;
        let (count, item) = match &container.kind {
            Kind::Object(entries) => (entries.len(), Item::member(*first, content)),
            Kind::Array(elements) => (elements.len(), Item::element(content)),
            _ => return Err(ChangeError::Gone),
        };
        let edits = insert(&self.text, container, count, &item)?;
        self.make(&edits)
    }

    /// Inserts an object member or array element at an index of the container at the path `keys`.
    pub(super) fn insert(&mut self, keys: &[&str], position: usize, item: &Item) -> Changed {
        let root = self.root();
        let container = at(&root, keys).ok_or(ChangeError::Gone)?;
        let edits = insert(&self.text, container, position, item)?;
        self.make(&edits)
    }

    /// Removes the object member or array element at the path `keys`.
    pub(super) fn remove(&mut self, keys: &[&str]) -> Changed {
        let (root, (last, above)) = (self.root(), keys.split_last().ok_or(ChangeError::Gone)?);
        let container = at(&root, above).ok_or(ChangeError::Gone)?;
        let edits = remove(&self.text, container, position(container, last).ok_or(ChangeError::Gone)?)?;
        self.make(&edits)
    }

    /// Moves an object member or array element from one index to another within the container at the path `keys`.
    pub(super) fn reorder(&mut self, keys: &[&str], from: usize, to: usize) -> Changed {
        let root = self.root();
        let edits = reorder(&self.text, at(&root, keys).ok_or(ChangeError::Gone)?, from, to)?;
        self.make(&edits)
    }

    /// Returns a copy of the object member or array element at the path `keys`, with its comments.
    pub(super) fn copied(&self, keys: &[&str]) -> Result<Item, ChangeError> {
        let (root, (last, above)) = (self.root(), keys.split_last().ok_or(ChangeError::Gone)?);
        let container = at(&root, above).ok_or(ChangeError::Gone)?;
        let position = position(container, last).ok_or(ChangeError::Gone)?;
        Ok(Item::copied(&self.text, container, position)?)
    }
}

/// Returns the value at a path of object keys and array indices; `None` if there is none.
pub(super) fn at<'v>(root: &'v Value, keys: &[&str]) -> Option<&'v Value> {
    keys.iter().try_fold(root, |value, key| match &value.kind {
        Kind::Object(_) => value.get(key),
        Kind::Array(elements) => elements.get(key.parse::<usize>().ok()?),
        _ => None,
    })
}

/// Returns the index of an object member in its object. For an array, parses `key` as the index.
pub(super) fn position(container: &Value, key: &str) -> Option<usize> {
    match &container.kind {
        Kind::Object(entries) => entries.iter().position(|entry| entry.key == key),
        _ => key.parse().ok(),
    }
}

/// Returns the path of object keys and array indices to the value at a source range; `None` if no value is there.
pub(super) fn path_to(root: &Value, place: Span) -> Option<Vec<String>> {
    if root.span == place {
        return Some(Vec::new());
    }
    let members: Vec<(String, &Value)> = match &root.kind {
        Kind::Object(entries) => entries.iter().map(|entry| (entry.key.clone(), &entry.value)).collect(),
        Kind::Array(elements) => elements.iter().enumerate().map(|(at, one)| (at.to_string(), one)).collect(),
        _ => return None,
    };
    let is_around = |value: &Value| value.span.start <= place.start && place.end <= value.span.end;
    let (key, value) = members.into_iter().find(|(_, value)| is_around(value))?;
    let mut path = path_to(value, place)?;
    path.insert(0, key);
    Some(path)
}
