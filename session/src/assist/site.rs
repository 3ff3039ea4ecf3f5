//! The place of a cursor in a document, whose text may be broken.

use std::ops::Range;

use crate::graph::document::{Entry, Kind, Value, pointer_join};

/// The location of a cursor in a document.
#[derive(Clone, Debug)]
pub(super) struct Site<'d> {
    /// The object keys and array positions from the root to the value, or to the object that contains the key.
    pub(super) way: Vec<String>,
    pub(super) spot: Spot<'d>,
    /// The byte range that another key or value would replace.
    pub(super) replaced: Range<usize>,
}

/// The kinds of locations in a document: key or value.
#[derive(Clone, Copy, Debug)]
pub(super) enum Spot<'d> {
    /// An object key, or a gap where one can be inserted.
    Key {
        /// The object that contains the key.
        object: &'d Value,
        /// The member whose key is at the cursor; `None` in a gap.
        entry: Option<&'d Entry>,
    },
    /// A value, or a gap where one can be inserted.
    Value(Option<&'d Value>),
}

impl<'d> Site<'d> {
    /// Finds the location of a byte offset in `text`; `root` is the document parsed from `text`.
    pub(super) fn find(root: &'d Value, text: &str, offset: usize) -> Self {
        let (mut value, mut way) = (root, Vec::new());
        loop {
            match &value.kind {
                Kind::Object(entries) if is_inside(value, text, offset) => {
                    match member_at(entries, text, offset) {
                        Member::Key(entry) => {
                            let spot = Spot::Key { object: value, entry: Some(entry) };
                            return Self {
                                way,
                                spot,
                                replaced: written(entry.key_span.range(), text, offset),
                            };
                        }
                        Member::Value(entry) => {
                            way.push(entry.key.clone());
                            value = &entry.value;
                            if !is_at(value, text, offset) {
                                return Self {
                                    way,
                                    spot: Spot::Value(None),
                                    replaced: word_at(text, offset),
                                };
                            }
                        }
                        Member::None => {
                            let spot = Spot::Key { object: value, entry: None };
                            return Self { way, spot, replaced: word_at(text, offset) };
                        }
                    }
                }
                Kind::Array(elements) if is_inside(value, text, offset) => {
                    let before = elements.iter().take_while(|one| (one.span.end as usize) < offset).count();
                    way.push(before.to_string());
                    match elements.get(before).filter(|one| is_at(one, text, offset)) {
                        Some(element) => value = element,
                        None => {
                            return Self { way, spot: Spot::Value(None), replaced: word_at(text, offset) };
                        }
                    }
                }
                Kind::Object(_) | Kind::Array(_) | Kind::Missing => {
                    return Self { way, spot: Spot::Value(Some(value)), replaced: word_at(text, offset) };
                }
                _ => {
                    let replaced = written(value.span.range(), text, offset);
                    return Self { way, spot: Spot::Value(Some(value)), replaced };
                }
            }
        }
    }

    /// Returns the JSON pointer of the value at the cursor, or of the object that contains the key.
    pub(super) fn pointer(&self) -> String {
        self.way.iter().fold(String::new(), |pointer, key| pointer_join(&pointer, key))
    }

    /// Returns the string at the cursor, and the number of bytes between its opening quote and the cursor. Returns
    /// `None` outside of strings.
    pub(super) fn string(&self, text: &str, offset: usize) -> Option<(&'d Value, usize)> {
        let Spot::Value(Some(value)) = self.spot else { return None };
        value.text()?;
        let within = offset.checked_sub(value.span.start as usize + 1)?;
        (within <= text.get(value.span.range())?.len().saturating_sub(1)).then_some((value, within))
    }
}

/// Returns `true` if an offset is between the brackets of a container, or after a container that is never closed.
fn is_inside(value: &Value, text: &str, offset: usize) -> bool {
    let Range { start, end } = value.span.range();
    let is_closed = text.get(start..end).is_some_and(|text| text.len() > 1 && text.ends_with(['}', ']']));
    let behind = || text.get(end..offset).is_some_and(|rest| rest.trim().is_empty());
    start < offset && (offset < end || !is_closed && behind())
}

fn is_at(value: &Value, text: &str, offset: usize) -> bool {
    let Range { start, end } = value.span.range();
    (start..=end).contains(&offset) || is_inside(value, text, offset)
}

enum Member<'d> {
    Key(&'d Entry),
    Value(&'d Entry),
    None,
}

/// Finds the object member whose key, or whose value or room for a value, contains an offset.
fn member_at<'d>(entries: &'d [Entry], text: &str, offset: usize) -> Member<'d> {
    let Some(entry) = entries.iter().rev().find(|entry| (entry.key_span.start as usize) < offset) else {
        return Member::None;
    };
    let key_end = entry.key_span.end as usize;
    if offset <= key_end {
        return Member::Key(entry);
    }
    if is_at(&entry.value, text, offset) && !matches!(entry.value.kind, Kind::Missing) {
        return Member::Value(entry);
    }
    // Behind the colon, and before the comma.
    let between = text.get(key_end..offset).unwrap_or_default();
    let is_behind = offset > entry.value.span.end as usize && !matches!(entry.value.kind, Kind::Missing);
    match between.split_once(':') {
        Some((_, rest)) if !is_behind && !rest.contains([',', '}']) => Member::Value(entry),
        _ => Member::None,
    }
}

/// Returns the byte range of a key or value. A string without a closing quote ends at the cursor.
fn written(range: Range<usize>, text: &str, offset: usize) -> Range<usize> {
    let token = text.get(range.clone()).unwrap_or_default();
    let is_open = token.starts_with('"') && (token.len() < 2 || !token.ends_with('"'));
    if is_open { range.start..offset.max(range.start) } else { range }
}

/// Returns the byte range of the unquoted word around an offset.
fn word_at(text: &str, offset: usize) -> Range<usize> {
    let is_of_word = |character: char| character.is_ascii_alphanumeric() || character == '_';
    let (before, behind) = text.split_at_checked(offset).unwrap_or((text, ""));
    let start = before.trim_end_matches(is_of_word).len();
    let length = behind.len() - behind.trim_start_matches(is_of_word).len();
    start..offset + length
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::document;
    use crate::graph::source::Sources;

    /// Returns the JSON pointer at `|`, whether a key is there, and the text that would be replaced.
    fn site(marked: &str) -> (String, bool, String) {
        let offset = marked.find('|').unwrap();
        let text = marked.replacen('|', "", 1);
        let mut sources = Sources::new();
        let file = sources.add("t", text.as_str());
        let document = document::parse(&sources, file).document;
        let site = Site::find(&document.root, &text, offset);
        let is_key = matches!(site.spot, Spot::Key { .. });
        (site.pointer(), is_key, text[site.replaced.clone()].to_owned())
    }

    #[test]
    fn keys_and_values_are_told_apart_in_whole_and_broken_texts() {
        for (text, pointer, is_key, replaced) in [
            ("{ |\"a\": 1 }", "", true, ""),
            ("{ \"|a\": 1 }", "", true, "\"a\""),
            ("{ \"a\": { | } }", "/a", true, ""),
            ("{ \"a\": { \"b\": 1, | } }", "/a", true, ""),
            ("{ \"a\": { \"b\": 1, na| } }", "/a", true, "na"),
            ("{ \"a\": { \"b\": 1, \"na|\" } }", "/a", true, "\"na\""),
            ("{ \"a\": { \"b\": | } }", "/a/b", false, ""),
            ("{ \"a\": { \"b\": |, \"c\": 1 } }", "/a/b", false, ""),
            ("{ \"a\": \"=b |+ c\" }", "/a", false, "\"=b + c\""),
            ("{ \"a\": [1, |] }", "/a/1", false, ""),
            ("{ \"a\": [{ \"b\": \"|\" }] }", "/a/0/b", false, "\"\""),
            ("{ \"a\": {\n  \"b\": \"x\",\n  |", "/a", true, ""),
            ("{ \"a\": {\n  \"b\": \"x|", "/a/b", false, "\"x"),
            ("|", "", false, ""),
        ] {
            assert_eq!(site(text), (pointer.to_owned(), is_key, replaced.to_owned()), "{text}");
        }
    }
}
