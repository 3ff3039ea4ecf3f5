//! The tags and the literal text of a template, and the words in its tags.
//!
//! The template engine's own tokenizer finds them, so that this module reads the same tags as the engine. Four users
//! need them: the map from generated text to templates (which tag wrote this value?), the length limit of expressions,
//! syntax diagnostics (which block is open here?), and answers for editors. Comments and the tags of `raw` blocks are no tokens; the body of
//! a `raw` block is literal text.
//!
//! Limits: in a template that the engine rejects, text after the place at which the tokenizer stops is not scanned.

use std::ops::Range;

use minijinja::machinery::{Token, Tokenizer};
use minijinja::syntax::SyntaxConfig;

/// The kind of a template tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TagKind {
    /// An expression tag: `{{ .. }}`.
    Expression,
    /// A block tag: `{% .. %}`.
    Block,
}

/// A tag of a template, such as `{% if sscs %}` or `{{ taps }}`.
#[derive(Clone, Debug)]
pub struct Tag {
    /// The byte range of the tag, including its delimiters.
    pub range: Range<usize>,
    /// The kind of the tag.
    pub kind: TagKind,
    /// The tokens between the delimiters, in source order.
    pub words: Vec<Word>,
    /// Whether the tag has no closing delimiter before the end of the template.
    pub is_open: bool,
}

/// One token inside a tag.
#[derive(Clone, Debug)]
pub struct Word {
    /// The byte range of the token; a string literal includes its quotes.
    pub range: Range<usize>,
    /// The kind of the token.
    pub kind: WordKind,
}

/// The kind of a token inside a tag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordKind {
    /// A name or a keyword.
    Identifier,
    /// A string literal with its quotes.
    Text,
    /// A numeric literal.
    Number,
    /// An operator or bracket.
    Sign,
}

/// The tags and literal pieces of a template, each in source order.
#[derive(Clone, Debug, Default)]
pub struct Scan {
    /// The tags.
    pub tags: Vec<Tag>,
    /// The byte ranges of literal text, without white space that tags trim.
    pub literals: Vec<Range<usize>>,
}

/// A piece of a template: literal text or a tag.
#[derive(Clone, Copy)]
pub(crate) enum Piece<'s> {
    Literal(&'s Range<usize>),
    Tag(&'s Tag),
}

impl Scan {
    /// Iterates over literal pieces and tags in source order.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = Piece<'_>> {
        let (mut tags, mut literals) = (self.tags.iter().peekable(), self.literals.iter().peekable());
        std::iter::from_fn(move || match (tags.peek(), literals.peek()) {
            (Some(tag), Some(literal)) if literal.start < tag.range.start => {
                literals.next().map(Piece::Literal)
            }
            (Some(_), _) => tags.next().map(Piece::Tag),
            (None, _) => literals.next().map(Piece::Literal),
        })
    }
}

impl Tag {
    /// The first word of a block tag, such as `if`; `None` for an expression tag.
    pub(crate) fn keyword<'t>(&self, text: &'t str) -> Option<&'t str> {
        let first = self.words.first().filter(|word| word.kind == WordKind::Identifier)?;
        (self.kind == TagKind::Block).then(|| text.get(first.range.clone())).flatten()
    }

    /// The source of the token at index `at`; `None` if there is no such token.
    pub(crate) fn word<'t>(&self, text: &'t str, at: usize) -> Option<&'t str> {
        text.get(self.words.get(at)?.range.clone())
    }
}

/// Splits a template into tags and literal text.
pub fn scan(text: &str) -> Scan {
    let mut found = Scan::default();
    let mut tokenizer = Tokenizer::new(text, "", false, syntax());
    loop {
        let (token, span) = match tokenizer.next_token() {
            Ok(Some(token)) => token,
            Ok(None) => return found,
            Err(error) => {
                let is_at_the_end = error.detail().is_some_and(|detail| detail.starts_with("unexpected end"));
                if let Some(tag) = found.tags.last_mut() {
                    let closer = if tag.kind == TagKind::Block { "%}" } else { "}}" };
                    tag.is_open &= is_at_the_end || !text[tag.range.start..].contains(closer);
                }
                return found;
            }
        };
        let range = span.start_offset as usize..span.end_offset as usize;
        let kind = match token {
            Token::TemplateData(_) => {
                found.literals.push(range);
                continue;
            }
            Token::VariableStart | Token::BlockStart => {
                let is_block = matches!(token, Token::BlockStart);
                let kind = if is_block { TagKind::Block } else { TagKind::Expression };
                let range = range.start..text.len();
                found.tags.push(Tag { range, kind, words: Vec::new(), is_open: true });
                continue;
            }
            Token::Ident(_) => WordKind::Identifier,
            Token::Str(_) | Token::String(_) => WordKind::Text,
            Token::Int(_) | Token::Int128(_) | Token::Float(_) => WordKind::Number,
            _ => WordKind::Sign,
        };
        let Some(tag) = found.tags.last_mut() else { continue };
        match token {
            Token::VariableEnd | Token::BlockEnd => (tag.range.end, tag.is_open) = (range.end, false),
            _ => tag.words.push(Word { range, kind }),
        }
    }
}

/// The tag syntax: a block tag trims the newline after it and the indentation before it.
pub(crate) fn syntax() -> SyntaxConfig {
    let mut builder = SyntaxConfig::builder();
    // The default delimiters, so building cannot fail.
    builder.trim_blocks(true).lstrip_blocks(true).keep_trailing_newline(true).build().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(text: &str) -> Vec<&str> {
        scan(text).tags.into_iter().map(|tag| &text[tag.range]).collect()
    }

    #[test]
    fn strings_brackets_raw_and_comments_do_not_end_a_tag() {
        assert_eq!(tags("a {{ '}}' }} b"), ["{{ '}}' }}"]);
        assert_eq!(tags("{{ {'a': {}} }}"), ["{{ {'a': {}} }}"]);
        assert_eq!(tags("{# {{ x }} #}{%- if a -%}"), ["{%- if a -%}"]);
        assert_eq!(tags("{% raw %}{{ x }}{% if %}{% endraw %}{{y}}"), ["{{y}}"]);
        assert_eq!(tags("ä{{ 'ö' }}ü {{"), ["{{ 'ö' }}", "{{"]);
        assert_eq!(tags("{"), [""; 0]);
    }

    #[test]
    fn literal_text_is_what_stands_between_tags_and_comments() {
        let text = "a {# b #}c\n{% if d %}{% raw %}{{ e }}{% endraw %} {{- f }}g";
        let literals: Vec<&str> = scan(text).literals.into_iter().map(|range| &text[range]).collect();
        assert_eq!(literals, ["a ", "c\n", "{{ e }}", "g"]);
    }

    #[test]
    fn words_are_told_apart() {
        let text = "{% set a = b.c|f('x', 12) == 1 %}";
        let tag = &scan(text).tags[0];
        let word = |at: usize| (tag.word(text, at).unwrap(), tag.words[at].kind);
        assert_eq!(word(0), ("set", WordKind::Identifier));
        assert_eq!(word(2), ("=", WordKind::Sign));
        assert_eq!(word(9), ("'x'", WordKind::Text));
        assert_eq!(word(11), ("12", WordKind::Number));
        assert_eq!(word(13), ("==", WordKind::Sign));
        assert_eq!(tag.keyword(text), Some("set"));
    }

    #[test]
    fn a_tag_without_an_end_is_told_from_one_with_a_fault() {
        let is_open = |text: &str| scan(text).tags.last().unwrap().is_open;
        assert!(is_open("{{ a") && is_open("{{ 'a }}") && is_open("{{ a; b"));
        assert!(!is_open("{{ a }}") && !is_open("{{ a ? b }}"));
    }
}
