//! Longest expressions and branches of templates: the template engine descends them on the stack.

use std::ops::Range;

use super::scan::{Tag, WordKind};

/// The maximum number of tokens in an expression, and of branches in one `if`, since minijinja recurses over them. In a
/// list, only the longest element counts.
const MAX_WORDS: usize = 1024;

/// Returns the byte range of the first token or tag beyond [`MAX_WORDS`], with a message; `None` if all are within the
/// limit.
pub(crate) fn too_long(text: &str, tags: &[Tag]) -> Option<(Range<usize>, &'static str)> {
    let mut branches: Vec<usize> = Vec::new();
    for tag in tags {
        // A comma begins a part of its own; the longest part counts on behind the bracket.
        let (mut words, mut open) = (0, Vec::<(usize, usize)>::new());
        for word in &tag.words {
            words += 1;
            let sign = if word.kind == WordKind::Sign { &text[word.range.clone()] } else { "" };
            match (sign, open.last_mut()) {
                ("(" | "[" | "{", _) => open.push((words, words)),
                (",", Some((start, longest))) => {
                    *longest = words.max(*longest);
                    words = *start;
                }
                (",", None) => words = 0,
                (")" | "]" | "}", Some((_, longest))) => {
                    words = words.max(*longest);
                    open.pop();
                }
                _ => {}
            }
            if words > MAX_WORDS {
                return Some((word.range.clone(), "an expression of more than 1024 words"));
            }
        }
        match tag.keyword(text) {
            Some("if") => branches.push(0),
            Some("endif") => drop(branches.pop()),
            Some("elif") => {
                if let Some(count) = branches.last_mut() {
                    *count += 1;
                    if *count > MAX_WORDS {
                        return Some((tag.range.clone(), "an \"if\" of more than 1024 branches"));
                    }
                }
            }
            _ => {}
        }
    }
    None
}
