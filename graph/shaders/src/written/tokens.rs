//! The tokens of a WGSL text: names, numbers, and operators of one or two bytes.
//!
//! A `<` after a name begins a template list if a `>` ends it; the search is that of the specification. What begins
//! with `>` is one byte, since it may end a template list.
//!
//! Source: *WebGPU Shading Language*, "Template Lists".

use std::collections::HashSet;
use std::ops::Range;

use super::complexity;

/// WGSL keywords that cannot end an operand, so that a following operator sign is unary.
pub(super) const KEYWORDS: [&str; 9] =
    ["return", "if", "else", "while", "switch", "case", "let", "const", "const_assert"];

/// WGSL operators of two bytes. Operators that begin with `>` are left out, since `>` may end a template list.
const PAIRS: [&str; 17] =
    ["&&", "||", "<<", "<=", "==", "!=", "->", "++", "--", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^="];

/// The tokens of a WGSL module, as byte ranges in its source.
pub(crate) struct Tokens<'t> {
    pub(crate) text: &'t str,
    pub(crate) ranges: Vec<Range<usize>>,
    /// The indices of the `<` and `>` tokens that delimit template lists.
    pub(crate) lists: HashSet<usize>,
}

impl<'t> Tokens<'t> {
    pub(crate) fn new(text: &'t str) -> Self {
        let ranges = tokens(text);
        let lists = template_lists(text, &ranges);
        Self { text, ranges, lists }
    }

    /// Returns the token at an index, or an empty string after the last token.
    pub(crate) fn word(&self, at: usize) -> &'t str {
        self.ranges.get(at).map_or("", |range| &self.text[range.clone()])
    }

    /// The token index of the bracket that closes the bracket at token index `open`, or the number of tokens if it is
    /// not closed.
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

    /// Returns `true` if a name is declared at least twice in the module, as a value, parameter or member.
    pub(crate) fn is_declared_twice(&self, name: &str) -> bool {
        let is_declared = |at: &usize| {
            let before = at.checked_sub(1).map_or("", |before| self.word(before));
            self.word(*at) == name
                && (["const", "let", "override", "var"].contains(&before) || self.word(at + 1) == ":")
        };
        (0..self.ranges.len()).filter(is_declared).nth(1).is_some()
    }

    /// The token index of the comma after the type of a structure member, or `end` if there is none. `ty` is the token
    /// index of the type.
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

    /// The index of the first token after the attributes that begin at token index `at`.
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

/// Returns `true` if a token is a name or a keyword other than those in [`KEYWORDS`].
pub(crate) fn is_name(word: &str) -> bool {
    word.starts_with(|first: char| first.is_alphabetic() || "_℘℮".contains(first))
        && !KEYWORDS.contains(&word)
}

/// Returns `true` if a token is an assignment operator.
pub(super) fn is_assignment(word: &str) -> bool {
    word.ends_with('=') && !["==", "!=", "<=", ">="].contains(&word)
}

/// Returns the byte ranges of the tokens in WGSL: names, numbers, and operators of one or two bytes.
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

/// Returns `true` if `word` continues `number`, which ends inside an exponent, such as `1e` or `1e-`.
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

/// Returns the indices of the tokens that begin and end template lists.
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
