//! Names of a function that WGSL does not let be used where they are.
//!
//! naga gives a `let` the place of its value, so two rules about names are lost in its form of a module:
//!
//! - a `case` takes constants, no `let`, whatever its value;
//! - a `continue` must not jump over a declaration whose name stands in the `continuing` block of its loop.
//!
//! This pass walks the blocks of each function with the names that they declare. As in Chrome's compiler, a name in
//! `continuing` counts although a declaration there hides it.
//!
//! Source: *WebGPU Shading Language*, "Switch Statement" and "Continue Statement".

use naga::Span;

use super::rejection::Rejection;
use super::tokens::{Tokens, is_name};
use crate::codes;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The body of a `loop`.
    Loop,
    /// The body of a `for` or `while`, which has no `continuing` block.
    Other,
    Continuing,
    /// The body of an `if`, a `switch` or a function.
    Plain,
}

struct Block {
    kind: Kind,
    /// The names declared in the block: the index of the name's token, and whether it is a `const`.
    names: Vec<(usize, bool)>,
    /// The token index of the first `continue` so far that belongs to this loop; `None` if there is none.
    left_at: Option<usize>,
}

/// Rejects the first `case` selector that is no constant, or `continue` that skips a declaration which `continuing`
/// uses.
pub(crate) fn check(tokens: &Tokens<'_>) -> Result<(), Rejection> {
    let is_needed = |word: &str| word == "case" || word == "continuing";
    if !(0..tokens.ranges.len()).any(|at| is_needed(tokens.word(at))) {
        return Ok(());
    }
    let mut blocks: Vec<Block> = Vec::new();
    let mut kind = Kind::Plain;
    let mut at = 0;
    while at < tokens.ranges.len() {
        let before = at.checked_sub(1).map_or("", |before| tokens.word(before));
        match tokens.word(at) {
            "loop" => kind = Kind::Loop,
            "for" | "while" => kind = Kind::Other,
            "continuing" => kind = Kind::Continuing,
            "{" => {
                blocks.push(Block { kind, names: Vec::new(), left_at: None });
                kind = Kind::Plain;
            }
            "}" => drop(blocks.pop()),
            word @ ("let" | "const" | "var") if !blocks.is_empty() => {
                let mut name = at + 1;
                if tokens.word(name) == "<" {
                    name += (name..tokens.ranges.len()).take_while(|at| tokens.word(*at) != ">").count() + 1;
                }
                blocks.last_mut().into_iter().for_each(|block| block.names.push((name, word == "const")));
                at = name;
            }
            "continue" => {
                let left = blocks.iter_mut().rev().find(|block| block.kind != Kind::Plain);
                left.into_iter().for_each(|block| block.left_at = block.left_at.or(Some(at)));
            }
            "case" => case(tokens, &blocks, at)?,
            word if is_name(word) && before != "." => bypassed(tokens, &blocks, at)?,
            _ => {}
        }
        at += 1;
    }
    Ok(())
}

/// Rejects names of variables or `let` values among the selectors of a `case`. `case` is the index of the keyword's
/// token.
fn case(tokens: &Tokens<'_>, blocks: &[Block], case: usize) -> Result<(), Rejection> {
    for at in case + 1..tokens.ranges.len() {
        let word = tokens.word(at);
        if word == ":" || word == "{" {
            break;
        }
        if !is_name(word) || tokens.word(at - 1) == "." {
            continue;
        }
        let mut names = blocks.iter().rev().flat_map(|block| block.names.iter().rev());
        if let Some((declared, false)) = names.find(|(name, _)| tokens.word(*name) == word) {
            let message = format!("a case takes constants, but \"{word}\" is none");
            let place = Span::from(tokens.ranges[at].clone());
            let help = format!("declare \"{word}\" with \"const\"");
            let mut rejection = Rejection::new(codes::WGSL_INVALID, message, place).help(help);
            rejection.labels.push((tokens.ranges[*declared].clone(), "declared here".to_owned()));
            return Err(rejection);
        }
    }
    Ok(())
}

/// Rejects a name in a `continuing` block if an earlier `continue` of the loop skips its declaration. `at` is the index
/// of the name's token.
fn bypassed(tokens: &Tokens<'_>, blocks: &[Block], at: usize) -> Result<(), Rejection> {
    let word = tokens.word(at);
    for pair in blocks.windows(2).filter(|pair| pair[1].kind == Kind::Continuing) {
        let Some(left_at) = pair[0].left_at else { continue };
        let mut names = pair[0].names.iter().filter(|(name, _)| *name > left_at);
        if let Some((declared, _)) = names.find(|(name, _)| tokens.word(*name) == word) {
            let message =
                format!("\"continue\" jumps over the declaration of \"{word}\", which \"continuing\" uses");
            let place = Span::from(tokens.ranges[left_at].clone());
            let help = format!("declare \"{word}\" before the \"continue\"");
            let mut rejection = Rejection::new(codes::WGSL_INVALID, message, place).help(help);
            rejection.labels.push((tokens.ranges[*declared].clone(), "declared here".to_owned()));
            rejection.labels.push((tokens.ranges[at].clone(), "used here".to_owned()));
            return Err(rejection);
        }
    }
    Ok(())
}
