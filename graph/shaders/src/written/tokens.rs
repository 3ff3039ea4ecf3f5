//! The tokens of a WGSL text: names, numbers, and operators of one or two bytes.
//!
//! A `<` after a name begins a template list if a `>` ends it; the search is that of the specification. What begins
//! with `>` is one byte, since it may end a template list.
//!
//! Source: *WebGPU Shading Language*, "Template Lists".

use std::collections::HashSet;
use std::ops::Range;

use super::complexity;

/// Words that are no operand, so that a sign after them has one operand.
pub(super) const KEYWORDS: [&str; 10] =
    ["return", "if", "else", "while", "switch", "case", "let", "const", "const_assert", "in"];

/// Tokens of two bytes, but for those that begin with `>`, which may end a template list.
const PAIRS: [&str; 17] =
    ["&&", "||", "<<", "<=", "==", "!=", "->", "++", "--", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^="];

/// The tokens of a text that naga has parsed.
pub(crate) struct Tokens<'t> {
    pub(crate) text: &'t str,
    pub(crate) ranges: Vec<Range<usize>>,
    /// The tokens that begin and end template lists.
    pub(crate) lists: HashSet<usize>,
}

impl<'t> Tokens<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        let ranges = tokens(text);
        let lists = template_lists(text, &ranges);
        Self { text, ranges, lists }
    }

    /// A token by its index; nothing beyond the last.
    pub(crate) fn word(&self, at: usize) -> &'t str {
        self.ranges.get(at).map_or("", |range| &self.text[range.clone()])
    }

    /// The index of the bracket that closes the one at an index, or of the end.
    pub(crate) fn closing(&self, open: usize) -> usize {
        let mut depth = 0_usize;
        for at in open..self.ranges.len() {
            match self.word(at) {
                "(" | "[" | "{" => depth += 1,
                ")" | "]" | "}" => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 {
                return at;
            }
        }
        self.ranges.len()
    }

    /// Whether a name may be another thing in a function than in the module: a value or a parameter.
    pub(crate) fn is_declared_twice(&self, name: &str) -> bool {
        let is_declared = |at: &usize| {
            let before = at.checked_sub(1).map_or("", |before| self.word(before));
            self.word(*at) == name
                && (["const", "let", "override", "var"].contains(&before) || self.word(at + 1) == ":")
        };
        (0..self.ranges.len()).filter(is_declared).nth(1).is_some()
    }

    /// The index of the comma behind the type of a member, or of the end of the structure.
    pub(super) fn after_member(&self, ty: usize, end: usize) -> usize {
        let mut depth = 0_usize;
        for at in ty..end {
            match self.word(at) {
                "<" | "(" => depth += 1,
                ">" | ")" => depth = depth.saturating_sub(1),
                "," if depth == 0 => return at,
                _ => {}
            }
        }
        end
    }

    /// The index behind the attributes that begin at an index.
    pub(crate) fn after_attributes(&self, mut at: usize) -> usize {
        while self.word(at) == "@" {
            at += 2;
            if self.word(at) == "(" {
                at = self.closing(at) + 1;
            }
        }
        at
    }
}

/// Whether a token is a name, and none of the words that end an operand.
pub(crate) fn is_name(word: &str) -> bool {
    word.starts_with(|first: char| first.is_alphabetic() || first == '_') && !KEYWORDS.contains(&word)
}

/// Whether a token assigns.
pub(super) fn is_assignment(word: &str) -> bool {
    word.ends_with('=') && !["==", "!=", "<=", ">="].contains(&word)
}

/// Names, numbers, and operators of one or two bytes.
fn tokens(text: &str) -> Vec<Range<usize>> {
    let mut tokens: Vec<Range<usize>> = Vec::new();
    for range in complexity::words(text) {
        if let Some(last) = tokens.last_mut()
            && last.end == range.start
            && (PAIRS.contains(&&text[last.start..range.end])
                || is_exponent(&text[last.clone()], &text[range.clone()]))
        {
            last.end = range.end;
        } else {
            tokens.push(range);
        }
    }
    tokens
}

/// Whether a word goes on with a number such as `1e` or `1e-`.
fn is_exponent(number: &str, word: &str) -> bool {
    let is_number = number.starts_with(|first: char| first.is_ascii_digit());
    let is_hex = number.starts_with("0x") || number.starts_with("0X");
    let ends = if is_hex { ['p', 'P'] } else { ['e', 'E'] };
    let begun = number.strip_suffix(['+', '-']);
    is_number
        && match begun {
            Some(begun) => begun.ends_with(ends),
            None => number.ends_with(ends) && ["+", "-"].contains(&word),
        }
}

/// The tokens that begin and end the template lists of a text.
fn template_lists(text: &str, tokens: &[Range<usize>]) -> HashSet<usize> {
    let word = |at: usize| tokens.get(at).map_or("", |range| &text[range.clone()]);
    let mut lists = HashSet::new();
    // Where a list may have begun, and within how many brackets.
    let mut pending: Vec<(usize, usize)> = Vec::new();
    let mut depth = 0_usize;
    for at in 0..tokens.len() {
        match word(at) {
            "<" if at > 0 && is_name(word(at - 1)) => pending.push((at, depth)),
            ">" => {
                if let Some((begin, _)) = pending.pop_if(|(_, within)| *within == depth) {
                    lists.extend([begin, at]);
                }
            }
            "(" | "[" => depth += 1,
            ")" | "]" => {
                pending.retain(|(_, within)| *within < depth);
                depth = depth.saturating_sub(1);
            }
            "&&" | "||" => pending.retain(|(_, within)| *within < depth),
            ";" | "{" | ":" => {
                depth = 0;
                pending.clear();
            }
            other if is_assignment(other) => {
                depth = 0;
                pending.clear();
            }
            _ => {}
        }
    }
    lists
}
