//! A text as a tree that keeps comments and line breaks.

use std::borrow::Cow;

use serde_json::Value;

use super::WIDTH;

/// The number of line ends between a thing and what stands before it.
#[derive(Clone, Copy, Default)]
pub(super) struct Gap(pub(super) usize);

impl Gap {
    pub(super) fn is_line_end(self) -> bool {
        self.0 > 0
    }

    pub(super) fn is_blank_line(self) -> bool {
        self.0 > 1
    }
}

/// A comment, with its signs.
pub(super) struct Comment {
    /// The comment without trailing spaces; lines end with `\n`.
    pub(super) text: String,
    /// The gap before it.
    pub(super) gap: Gap,
    /// The column that it begins at, from 0, if nothing else stands before it on its line.
    pub(super) column: Option<usize>,
}

impl Comment {
    pub(super) fn is_line(&self) -> bool {
        self.text.starts_with("//")
    }

    /// Whether other things can stand behind it on the line where it began.
    fn is_flat(&self) -> bool {
        !self.is_line() && !self.text.contains('\n')
    }
}

/// The whole text.
pub(super) struct Text<'a> {
    pub(super) leading: Vec<Comment>,
    /// The gap between the last of `leading` and the value.
    pub(super) gap: Gap,
    pub(super) root: Node<'a>,
    pub(super) trailing: Vec<Comment>,
}

/// A value.
pub(super) enum Node<'a> {
    Scalar(Cow<'a, str>),
    Container(Container<'a>),
}

/// An array or an object.
pub(super) struct Container<'a> {
    pub(super) is_object: bool,
    /// Comments behind the opening bracket on its line.
    pub(super) opening: Vec<Comment>,
    pub(super) items: Vec<Item<'a>>,
    /// Comments on lines of their own before the closing bracket.
    pub(super) closing: Vec<Comment>,
    /// Whether it has to take several lines, by the author's line breaks or by comments.
    pub(super) broken: bool,
    /// Its text on one line, if it can have one of at most [`WIDTH`] characters.
    pub(super) flat: Option<String>,
}

/// A member of an object or an element of an array.
pub(super) struct Item<'a> {
    pub(super) leading: Vec<Comment>,
    /// The gap before the key or the value, after the last of `leading`.
    pub(super) gap: Gap,
    pub(super) key: Option<Cow<'a, str>>,
    pub(super) value: Node<'a>,
    /// Block comments before the comma.
    pub(super) before_comma: Vec<Comment>,
    /// Comments behind the comma on its line.
    pub(super) trailing: Vec<Comment>,
}

impl Node<'_> {
    /// The text on one line, if it can have one of at most [`WIDTH`] characters.
    pub(super) fn flat(&self) -> Option<&str> {
        match self {
            Node::Scalar(text) if text.contains(['\n', '\r']) => None,
            Node::Scalar(text) => Some(text),
            Node::Container(container) => container.flat.as_deref(),
        }
    }

    fn is_broken(&self) -> bool {
        match self {
            Node::Scalar(text) => text.contains(['\n', '\r']),
            Node::Container(container) => container.broken,
        }
    }
}

impl Item<'_> {
    /// The gap before the item and its comments.
    pub(super) fn start(&self) -> Gap {
        self.leading.first().map_or(self.gap, |comment| comment.gap)
    }

    /// The text on one line up to the comma.
    pub(super) fn flat(&self) -> Option<String> {
        let value = self.value.flat().filter(|_| !self.is_broken())?;
        let mut text = String::new();
        self.leading.iter().for_each(|comment| text.extend([comment.text.as_str(), " "]));
        self.key.iter().for_each(|key| text.extend([key, ": "]));
        text.push_str(value);
        self.before_comma.iter().for_each(|comment| text.extend([" ", comment.text.as_str()]));
        Some(text)
    }

    /// Whether the item ends on another line than it begins on.
    fn is_broken(&self) -> bool {
        let inner = self.leading.iter().map(|comment| comment.gap).skip(1);
        let inner = inner.chain((!self.leading.is_empty()).then_some(self.gap));
        self.value.is_broken()
            || inner.into_iter().any(Gap::is_line_end)
            || self.leading.iter().chain(&self.before_comma).any(|comment| !comment.is_flat())
    }

    fn has_comments(&self) -> bool {
        !(self.leading.is_empty() && self.before_comma.is_empty() && self.trailing.is_empty())
    }
}

impl<'a> Container<'a> {
    /// A container; `end` separates the closing bracket from what stands before.
    pub(super) fn new(
        is_object: bool,
        opening: Vec<Comment>,
        items: Vec<Item<'a>>,
        closing: Vec<Comment>,
        end: Gap,
    ) -> Self {
        let mut container = Self { is_object, opening, items, closing, broken: false, flat: None };
        container.broken = container.has_to_break(end);
        container.flat = container.flat_text();
        container
    }

    fn has_to_break(&self, end: Gap) -> bool {
        match self.only_item() {
            Some(item) => item.value.is_broken(),
            None if self.items.is_empty() && self.opening.is_empty() && self.closing.is_empty() => false,
            None => {
                end.is_line_end()
                    || !self.closing.is_empty()
                    || self.opening.iter().any(|comment| !comment.is_flat())
                    || self.items.iter().any(|item| {
                        item.start().is_line_end()
                            || item.is_broken()
                            || item.trailing.iter().any(|comment| !comment.is_flat())
                    })
            }
        }
    }

    /// The one item that nothing separates from the opening bracket, if there is one without any comment.
    pub(super) fn only_item(&self) -> Option<&Item<'a>> {
        match self.items.as_slice() {
            [item] if self.opening.is_empty() && self.closing.is_empty() => {
                (!item.has_comments() && !item.gap.is_line_end()).then_some(item)
            }
            _ => None,
        }
    }

    /// Whether it is an array of nothing but scalars.
    pub(super) fn is_list(&self) -> bool {
        !self.is_object && self.items.iter().all(|item| matches!(item.value, Node::Scalar(_)))
    }

    pub(super) fn brackets(&self) -> [&'static str; 2] {
        if self.is_object { ["{", "}"] } else { ["[", "]"] }
    }

    fn flat_text(&self) -> Option<String> {
        if self.broken {
            return None;
        }
        let [open, close] = self.brackets();
        let space =
            if self.is_object && !self.items.is_empty() || !self.opening.is_empty() { " " } else { "" };
        let mut text = open.to_owned();
        self.opening.iter().for_each(|comment| text.extend([" ", comment.text.as_str()]));
        for (at, item) in self.items.iter().enumerate() {
            text.push_str(if at == 0 { space } else { ", " });
            text.push_str(&item.flat()?);
            item.trailing.iter().for_each(|comment| text.extend([" ", comment.text.as_str()]));
            // Each character takes four bytes at most: what is longer than that is too wide without counting.
            if text.len() > 4 * WIDTH {
                return None;
            }
        }
        if self.items.is_empty() || self.is_object {
            text.push_str(space);
        }
        text.push_str(close);
        (width(&text) <= WIDTH).then_some(text)
    }
}

impl<'a> Node<'a> {
    /// The tree of a value alone.
    pub(super) fn of(value: &'a Value) -> Self {
        let item = |key: Option<&String>, value| Item {
            leading: Vec::new(),
            gap: Gap::default(),
            key: key.map(|key| quoted(key)),
            value: Node::of(value),
            before_comma: Vec::new(),
            trailing: Vec::new(),
        };
        let items: Vec<Item<'a>> = match value {
            Value::Array(elements) => elements.iter().map(|element| item(None, element)).collect(),
            Value::Object(members) => members.iter().map(|(key, value)| item(Some(key), value)).collect(),
            scalar => return Node::Scalar(scalar.to_string().into()),
        };
        Node::Container(Container::new(value.is_object(), Vec::new(), items, Vec::new(), Gap::default()))
    }
}

pub(super) fn quoted(text: &str) -> Cow<'static, str> {
    serde_json::Value::from(text).to_string().into()
}

/// The number of characters.
pub(super) fn width(text: &str) -> usize {
    text.chars().count()
}
