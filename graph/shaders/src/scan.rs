//! Where the tags of a template are, and the words in them.
//!
//! minijinja keeps its lexer to itself, and three things need to know a template's tags: the map from generated text to
//! templates (which tag wrote this value?), the search for undeclared names (where does the name stand?), and the guard
//! against explosions (which names does a tag bind?). This scanner knows as much of the syntax as these need: comments,
//! `raw` blocks, strings, brackets, identifiers. It never fails; on a template that minijinja refuses, its answer is
//! merely useless.

use std::ops::Range;

/// What a tag is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TagKind {
    /// `{{ .. }}`
    Expression,
    /// `{% .. %}`, with `raw` and `endraw` each on their own.
    Block,
    /// `{# .. #}`
    Comment,
}

/// One tag.
#[derive(Clone, Debug)]
pub(crate) struct Tag {
    /// Its bytes, with the delimiters.
    pub(crate) range: Range<usize>,
    pub(crate) kind: TagKind,
    /// The words in it; none in a comment.
    pub(crate) words: Vec<Word>,
}

/// One word of a tag.
#[derive(Clone, Debug)]
pub(crate) struct Word {
    pub(crate) range: Range<usize>,
    pub(crate) kind: WordKind,
}

/// What a word is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WordKind {
    /// A name or a keyword.
    Identifier,
    /// A string with its quotes.
    Text,
    /// A number.
    Number,
    /// One character of punctuation.
    Sign(u8),
}

impl Tag {
    /// The keyword of a block tag.
    pub(crate) fn keyword<'t>(&self, text: &'t str) -> Option<&'t str> {
        let first = self.words.first().filter(|word| word.kind == WordKind::Identifier)?;
        (self.kind == TagKind::Block).then(|| text.get(first.range.clone())).flatten()
    }
}

/// Finds all tags in the order of the text.
pub(crate) fn scan(text: &str) -> Vec<Tag> {
    let bytes = text.as_bytes();
    let mut tags = Vec::new();
    let mut at = 0;
    while let Some((start, kind)) = next_start(bytes, at) {
        let tag = match kind {
            TagKind::Comment => {
                let end = find(bytes, start + 2, b"#}").map_or(bytes.len(), |end| end + 2);
                Tag { range: start..end, kind, words: Vec::new() }
            }
            TagKind::Expression => scan_tag(bytes, start, kind, b"}}"),
            TagKind::Block => scan_tag(bytes, start, kind, b"%}"),
        };
        at = tag.range.end;
        let raw = tag.keyword(text) == Some("raw");
        tags.push(tag);
        if raw {
            at = raw_end(text, at, &mut tags);
        }
    }
    tags
}

fn next_start(bytes: &[u8], from: usize) -> Option<(usize, TagKind)> {
    (from..bytes.len().saturating_sub(1)).filter(|at| bytes[*at] == b'{').find_map(|at| match bytes[at + 1] {
        b'{' => Some((at, TagKind::Expression)),
        b'%' => Some((at, TagKind::Block)),
        b'#' => Some((at, TagKind::Comment)),
        _ => None,
    })
}

fn find(bytes: &[u8], from: usize, needle: &[u8; 2]) -> Option<usize> {
    bytes.get(from..)?.windows(2).position(|pair| pair == needle).map(|at| at + from)
}

/// Skips the body of a `raw` block; its closing tag is added to `tags`.
fn raw_end(text: &str, from: usize, tags: &mut Vec<Tag>) -> usize {
    let bytes = text.as_bytes();
    let mut at = from;
    while let Some(start) = find(bytes, at, b"{%") {
        let tag = scan_tag(bytes, start, TagKind::Block, b"%}");
        if tag.keyword(text) == Some("endraw") {
            let end = tag.range.end;
            tags.push(tag);
            return end;
        }
        at = start + 2;
    }
    bytes.len()
}

fn scan_tag(bytes: &[u8], start: usize, kind: TagKind, close: &[u8; 2]) -> Tag {
    let mut words = Vec::new();
    let mut depth = 0_usize;
    let mut at = start + 2;
    if matches!(bytes.get(at), Some(b'-' | b'+')) {
        at += 1;
    }
    while at < bytes.len() {
        let rest = &bytes[at..];
        if depth == 0 {
            let trim = usize::from(matches!(rest[0], b'-' | b'+'));
            if rest[trim..].starts_with(close) {
                return Tag { range: start..at + trim + 2, kind, words };
            }
        }
        let (length, word) = match rest[0] {
            byte if byte.is_ascii_whitespace() => (1, None),
            quote @ (b'"' | b'\'') => (text_length(rest, quote), Some(WordKind::Text)),
            byte if byte == b'_' || byte.is_ascii_alphabetic() => {
                let tail = |byte: &&u8| **byte == b'_' || byte.is_ascii_alphanumeric();
                (rest.iter().take_while(tail).count(), Some(WordKind::Identifier))
            }
            byte if byte.is_ascii_digit() => {
                let tail = |byte: &&u8| **byte == b'_' || byte.is_ascii_alphanumeric();
                (rest.iter().take_while(tail).count(), Some(WordKind::Number))
            }
            byte => {
                match byte {
                    b'(' | b'[' | b'{' => depth += 1,
                    b')' | b']' | b'}' => depth = depth.saturating_sub(1),
                    _ => {}
                }
                (1, Some(WordKind::Sign(byte)))
            }
        };
        words.extend(word.map(|kind| Word { range: at..at + length, kind }));
        at += length;
    }
    Tag { range: start..bytes.len(), kind, words }
}

fn text_length(rest: &[u8], quote: u8) -> usize {
    let mut at = 1;
    while at < rest.len() {
        match rest[at] {
            b'\\' => at += 2,
            byte if byte == quote => return at + 1,
            _ => at += 1,
        }
    }
    rest.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(text: &str) -> Vec<&str> {
        scan(text).into_iter().map(|tag| &text[tag.range]).collect()
    }

    #[test]
    fn strings_brackets_raw_and_comments_do_not_end_a_tag() {
        assert_eq!(tags("a {{ '}}' }} b"), ["{{ '}}' }}"]);
        assert_eq!(tags("{{ {'a': {}} }}"), ["{{ {'a': {}} }}"]);
        assert_eq!(tags("{# {{ x }} #}{%- if a -%}"), ["{# {{ x }} #}", "{%- if a -%}"]);
        assert_eq!(tags("{% raw %}{{ x }}{% if %}{% endraw %}{{y}}"), ["{% raw %}", "{% endraw %}", "{{y}}"]);
        assert_eq!(tags("ä{{ 'ö' }}ü {{"), ["{{ 'ö' }}", "{{"]);
        assert_eq!(tags("{"), [""; 0]);
    }

    #[test]
    fn words_are_told_apart() {
        let text = "{% set a = b.c|f('x', 12) %}";
        let kinds: Vec<_> =
            scan(text)[0].words.iter().map(|word| (&text[word.range.clone()], word.kind)).collect();
        assert_eq!(kinds[0], ("set", WordKind::Identifier));
        assert_eq!(kinds[2], ("=", WordKind::Sign(b'=')));
        assert_eq!(kinds[9], ("'x'", WordKind::Text));
        assert_eq!(kinds[11], ("12", WordKind::Number));
        assert_eq!(scan(text)[0].keyword(text), Some("set"));
    }
}
