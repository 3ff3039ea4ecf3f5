//! The declarations at module scope of a WGSL text, and the names that each mentions.
//!
//! naga's front end reads whole modules. This splitter reads tokens: braces, semicolons and comments bound a
//! declaration, its keyword says what it is. A declaration mentions more than it refers to (a local variable can hide a
//! module's name), never less. Text that no declaration is, such as a stray brace, is a declaration without a name.
//!
//! Limits: a text with characters beyond ASCII outside of comments, or with the rarer line ends of WGSL anywhere, is
//! not split.

use std::ops::Range;

use super::complexity::{comment_end, is_of_word, words};

/// The kind of a WGSL declaration at module scope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// `enable`, `requires` or `diagnostic`: affects all declarations of the module.
    Directive,
    /// A function that is no entry point. Declarations that call the function depend on its signature and on its
    /// summary (see `rules::summary`).
    Function,
    EntryPoint,
    /// A variable at module scope.
    Variable,
    /// A pipeline-overridable constant.
    Override,
    /// A structure, alias, constant or anything else. Declarations that mention it depend on its complete source.
    Other,
}

/// A WGSL declaration at module scope, parsed without the rest of its module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Declaration {
    pub(crate) kind: Kind,
    pub(crate) name: Option<String>,
    /// The length of the header in bytes. The header of a function is everything before its body, that of other
    /// declarations the complete source.
    pub(crate) header: usize,
    /// The distinct names in the header, sorted. The declaration's own name and those of parameters and members are
    /// left out.
    pub(crate) in_header: Vec<String>,
    /// The distinct names in the complete declaration, sorted, with the same exceptions as in `in_header`.
    pub(crate) mentions: Vec<String>,
    /// Whether the declaration can only be validated with its whole module. It has pointers to module-scope memory, or
    /// is a workgroup variable, an immediate or a numbered override.
    pub(crate) is_of_whole: bool,
}

/// A WGSL module with the byte ranges of its declarations in order. White space and comments before a declaration are
/// not part of its range.
#[derive(Clone, Debug, Default)]
pub(crate) struct Split {
    pub(crate) text: String,
    pub(crate) ranges: Vec<Range<usize>>,
    /// Whether the last declaration is complete; `false` if the WGSL ends inside it.
    is_closed: bool,
}

/// The numbers of declarations at the start and at the end of a WGSL module that are the same as in the previous
/// module.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Common {
    pub(crate) first: usize,
    pub(crate) last: usize,
}

impl Split {
    /// Replaces the WGSL with `text`, splits it, and returns the numbers of declarations in common with the previous
    /// WGSL. If `text` cannot be split, returns `None` and clears the state.
    pub(crate) fn go_on(&mut self, text: String) -> Option<Common> {
        let before = std::mem::take(self);
        let (old, new) = (before.text.as_bytes(), text.as_bytes());
        let (prefix, suffix) = if before.is_closed { in_common(old, new) } else { (0, 0) };
        let first = before.ranges.partition_point(|range| range.end <= prefix);
        let mut ranges = before.ranges[..first].to_vec();
        let start = ranges.last().map_or(0, |range| range.end);
        // Where a declaration ends in bytes that both have at the end, those behind it are the same.
        let place = |end: usize| (end + old.len()).checked_sub(new.len());
        let known = |end: usize| {
            let end = place(end).filter(|_| new.len() - end <= suffix)?;
            before.ranges.binary_search_by_key(&end, |range| range.end).ok()
        };
        let (is_closed, same) = split_from(new, start, &mut ranges, known)?;
        let last = same.map_or(0, |at| before.ranges.len() - at - 1);
        let rest = &before.ranges[before.ranges.len() - last..];
        ranges.extend(
            rest.iter().map(|range| range.start + new.len() - old.len()..range.end + new.len() - old.len()),
        );
        *self = Self { ranges, is_closed, text };
        Some(Common { first, last })
    }
}

/// The lengths in bytes of the common prefix and suffix of two byte strings, without overlap.
fn in_common(one: &[u8], other: &[u8]) -> (usize, usize) {
    const PIECE: usize = 64;
    let pieces = one.chunks_exact(PIECE).zip(other.chunks_exact(PIECE));
    let whole = PIECE * pieces.take_while(|(one, other)| one == other).count();
    let bytes = one[whole..].iter().zip(&other[whole..]);
    let prefix = whole + bytes.take_while(|(one, other)| one == other).count();
    let (one, other) = (&one[prefix..], &other[prefix..]);
    let pieces = one.rchunks_exact(PIECE).zip(other.rchunks_exact(PIECE));
    let whole = PIECE * pieces.take_while(|(one, other)| one == other).count();
    let (one, other) = (&one[..one.len() - whole], &other[..other.len() - whole]);
    let bytes = one.iter().rev().zip(other.iter().rev());
    (prefix, whole + bytes.take_while(|(one, other)| one == other).count())
}

/// The byte ranges of the declarations of a WGSL module; `None` if it cannot be split.
pub(crate) fn split(text: &str) -> Option<Vec<Range<usize>>> {
    let mut found = Vec::new();
    split_from(text.as_bytes(), 0, &mut found, |_| None)?;
    Some(found)
}

/// Adds the byte ranges of the declarations from byte offset `at` to `found`. Stops after the first declaration for
/// whose end `known` returns an index.
///
/// Returns whether the last declaration is complete, and the index from `known`. Returns `None` if the module cannot be
/// split.
fn split_from(
    bytes: &[u8],
    mut at: usize,
    found: &mut Vec<Range<usize>>,
    known: impl Fn(usize) -> Option<usize>,
) -> Option<(bool, Option<usize>)> {
    let (mut start, mut depth) = (None, 0_usize);
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'/' if matches!(bytes.get(at + 1), Some(b'/' | b'*')) => {
                let end = comment(bytes, at)?;
                if has_other_line_end(&bytes[at..end]) {
                    return None;
                }
                at = end;
                continue;
            }
            b' ' | b'\t' | b'\n' => {}
            b'\r' if bytes.get(at + 1) == Some(&b'\n') => {}
            0 | b'\r' | 0x0b | 0x0c | 0x80.. => return None,
            b'{' => {
                start.get_or_insert(at);
                depth += 1;
            }
            b'}' | b';' => {
                let first = *start.get_or_insert(at);
                depth -= usize::from(*byte == b'}' && depth > 0);
                if depth == 0 {
                    start = None;
                    // A semicolon alone is nothing, but no directive may stand behind it.
                    let is_first = |last: &Range<usize>| is_directive(&bytes[last.clone()]);
                    if *byte == b';' && first == at && found.last().is_none_or(is_first) {
                        return None;
                    }
                    if *byte == b'}' || first < at {
                        found.push(first..at + 1);
                        if let Some(known) = known(at + 1) {
                            return Some((true, Some(known)));
                        }
                    }
                }
            }
            _ => drop(start.get_or_insert(at)),
        }
        at += 1;
    }
    found.extend(start.map(|start| start..bytes.len()));
    Some((start.is_none(), None))
}

fn is_directive(declaration: &[u8]) -> bool {
    ["enable", "requires", "diagnostic"].iter().any(|word| declaration.starts_with(word.as_bytes()))
}

/// The byte offset of the end of the comment at `start`; `None` if it is not closed.
fn comment(bytes: &[u8], start: usize) -> Option<usize> {
    if bytes.get(start + 1) != Some(&b'*') {
        let length = bytes[start..].iter().position(|byte| *byte == b'\n');
        return Some(length.map_or(bytes.len(), |length| start + length));
    }
    comment_end(bytes, start)
}

/// Returns `true` if a comment contains a null character, or a WGSL line break that is neither `\n` nor `\r\n`.
fn has_other_line_end(comment: &[u8]) -> bool {
    let ends = |window: &[u8]| matches!(window, [0xc2, 0x85] | [b'\r', 0..=9 | 11..]);
    comment.iter().any(|byte| matches!(byte, 0 | 0x0b | 0x0c))
        || comment.windows(2).any(ends)
        || comment.windows(3).any(|window| matches!(window, [0xe2, 0x80, 0xa8 | 0xa9]))
}

impl Declaration {
    /// Parses the source of one WGSL declaration.
    pub(crate) fn new(text: &str) -> Self {
        let tokens: Vec<&str> = words(text).map(|range| &text[range]).collect();
        let keyword = after_attributes(&tokens);
        let is_entry = tokens[..keyword].windows(2).any(|pair| {
            pair[0] == "@" && matches!(pair[1], "vertex" | "fragment" | "compute" | "task" | "mesh")
        });
        let kind = match tokens.get(keyword).copied().unwrap_or_default() {
            "enable" | "requires" | "diagnostic" => Kind::Directive,
            "fn" if is_entry => Kind::EntryPoint,
            "fn" => Kind::Function,
            "var" => Kind::Variable,
            "override" => Kind::Override,
            _ => Kind::Other,
        };
        let is_named = matches!(
            tokens.get(keyword).copied(),
            Some("fn" | "struct" | "alias" | "const" | "override" | "var")
        );
        let mut named_at = keyword + 1;
        if tokens.get(keyword) == Some(&"var") && tokens.get(named_at) == Some(&"<") {
            let rest = &tokens[named_at..];
            named_at += rest.iter().position(|token| *token == ">").map_or(rest.len(), |end| end + 1);
        }
        let name =
            tokens.get(named_at).filter(|token| is_named && is_name(token)).map(|name| (*name).to_owned());
        let is_function = matches!(kind, Kind::Function | Kind::EntryPoint);
        let body = tokens.iter().position(|token| *token == "{").unwrap_or(tokens.len());
        // Names before a colon are those of members and parameters.
        let named = if is_function { ..body } else { ..tokens.len() };
        let has_members = is_function || tokens.get(keyword) == Some(&"struct");
        let mentioned = |range: Range<usize>| {
            let mut names: Vec<String> = range
                .filter(|at| {
                    let before = at.checked_sub(1).map(|before| tokens[before]);
                    let is_member = has_members && *at < named.end && tokens.get(at + 1) == Some(&":");
                    is_name(tokens[*at])
                        && (!is_named || *at != named_at)
                        && *at != keyword
                        && !matches!(before, Some("." | "@"))
                        && !is_member
                })
                .map(|at| tokens[at].to_owned())
                .collect();
            names.sort_unstable();
            names.dedup();
            names
        };
        let mut spaces = tokens.windows(3).filter(|three| three[1] == "<");
        let is_numbered =
            kind == Kind::Override && tokens[..keyword].windows(2).any(|pair| pair == ["@", "id"]);
        let is_of_whole = is_numbered
            || spaces.any(|three| match three[0] {
                "ptr" => three[2] != "function",
                "var" => !matches!(three[2], "private" | "uniform" | "storage"),
                _ => false,
            });
        let start = words(text).nth(body).map_or(text.len(), |brace| brace.start);
        Self {
            kind,
            name,
            header: if is_function { start } else { text.len() },
            in_header: mentioned(0..if is_function { body } else { tokens.len() }),
            mentions: mentioned(0..tokens.len()),
            is_of_whole,
        }
    }
}

fn is_name(token: &str) -> bool {
    token.bytes().next().is_some_and(|first| is_of_word(&first) && !first.is_ascii_digit())
}

/// The index of the first token after the attributes at the start of a declaration.
fn after_attributes(tokens: &[&str]) -> usize {
    let mut at = 0;
    while tokens.get(at) == Some(&"@") {
        at += 2;
        let mut depth = usize::from(tokens.get(at) == Some(&"("));
        at += depth;
        while depth > 0 && at < tokens.len() {
            match tokens[at] {
                "(" => depth += 1,
                ")" => depth -= 1,
                _ => {}
            }
            at += 1;
        }
    }
    at.min(tokens.len())
}
