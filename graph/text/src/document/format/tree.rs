//! A text as a tree that keeps comments and line breaks.

use std::borrow::Cow;

use serde_json::Value;

use super::WIDTH;

/// The number of line ends before a comment, member or value.
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

/// A comment with its `//` or `/* */`.
pub(super) struct Comment {
    /// The comment without trailing spaces, with `\n` as line ends.
    pub(super) text: String,
    /// The number of line ends before the comment.
    pub(super) gap: Gap,
    /// The column of the comment's first character, from 0, if the comment begins a line; otherwise `None`.
    pub(super) column: Option<usize>,
}

impl Comment {
    pub(super) fn is_line(&self) -> bool {
        self.text.starts_with("//")
    }

    /// Returns `true` if this is a block comment on one line, so that other tokens can follow on the line.
    fn is_flat(&self) -> bool {
        !self.is_line() && !self.text.contains('\n')
    }
}

/// A document with the comments around its root value.
pub(super) struct Text<'a> {
    pub(super) leading: Vec<Comment>,
    /// The number of line ends between the last of the `leading` comments and the root value.
    pub(super) gap: Gap,
    pub(super) root: Node<'a>,
    pub(super) trailing: Vec<Comment>,
}

/// A JSON value with the comments inside it.
pub(super) enum Node<'a> {
    Scalar(Cow<'a, str>),
    Container(Container<'a>),
}

/// An array or an object.
pub(super) struct Container<'a> {
    pub(super) is_object: bool,
    /// Comments after the opening bracket on its line.
    pub(super) opening: Vec<Comment>,
    pub(super) items: Vec<Item<'a>>,
    /// Comments on lines of their own before the closing bracket.
    pub(super) closing: Vec<Comment>,
    /// Whether the container takes several lines, because of the author's line breaks or of comments.
    pub(super) broken: bool,
    /// The container printed on one line; `None` if it must be broken or is wider than [`WIDTH`] characters.
    pub(super) flat: Option<String>,
}

/// A member of an object or an element of an array.
pub(super) struct Item<'a> {
    pub(super) leading: Vec<Comment>,
    /// The number of line ends before the key or the value, after the `leading` comments.
    pub(super) gap: Gap,
    pub(super) key: Option<Cow<'a, str>>,
    pub(super) value: Node<'a>,
    /// Block comments before the comma.
    pub(super) before_comma: Vec<Comment>,
    /// Comments after the comma on its line.
    pub(super) trailing: Vec<Comment>,
}

impl Node<'_> {
    /// The value printed on one line; `None` if a container must be broken or is wider than [`WIDTH`] characters.
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
    /// The number of line ends before the item and its comments.
    pub(super) fn start(&self) -> Gap {
        self.leading.first().map_or(self.gap, |comment| comment.gap)
    }

    /// The item printed on one line, up to the comma; `None` if it must be broken.
    pub(super) fn flat(&self) -> Option<String> {
        let value = self.value.flat().filter(|_| !self.is_broken())?;
        let mut text = String::new();
        self.leading.iter().for_each(|comment| text.extend([comment.text.as_str(), " "]));
        self.key.iter().for_each(|key| text.extend([key, ": "]));
        text.push_str(value);
        self.before_comma.iter().for_each(|comment| text.extend([" ", comment.text.as_str()]));
        Some(text)
    }

    /// Returns `true` if the item takes several lines.
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
    /// Creates an array or an object; `end` is the number of line ends before its closing bracket.
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

    /// The only item of the container, if it has no comments and is on the line of the opening bracket. `None`
    /// otherwise.
    pub(super) fn only_item(&self) -> Option<&Item<'a>> {
        match self.items.as_slice() {
            [item] if self.opening.is_empty() && self.closing.is_empty() => {
                (!item.has_comments() && !item.gap.is_line_end()).then_some(item)
            }
            _ => None,
        }
    }

    /// Returns `true` if the container is an array of scalars only.
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
    /// Creates the tree of a JSON value, which has no comments.
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

/// The width of a text in characters.
pub(super) fn width(text: &str) -> usize {
    text.chars().count()
}
