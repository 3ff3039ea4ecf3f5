//! Nesting that Chrome's compiler does not read.
//!
//! Its parser counts the brackets and unary operators that are open at a place, and its resolver the statements around
//! each other, of which each branch of an `else if` chain is one more. Both end at 127. It also ends at 512 operators
//! of one expression in a row. naga goes further, and takes any number of signs and branches.
//!
//! | text | counts |
//! |---|---|
//! | `(`, `[`, `{`, the `<` of a template list, `-`, `!`, `~`, `&`, `*` | one open part |
//! | `if`, `loop`, `for`, `while`, `switch`, `{`, a clause of `switch`, any other statement | one statement |

use naga::Span;

use super::rejection::Rejection;
use super::tokens::{KEYWORDS, Tokens, is_assignment};
use crate::codes;

/// The maximum number of open brackets and unary operators, and the maximum number of statements around each other.
const MAX_OPEN: usize = 127;
/// The maximum number of operators in a row.
const MAX_CHAIN: usize = 512;

/// Rejects the first place that is nested too deeply for Chrome's compiler.
pub(crate) fn check(tokens: &Tokens<'_>) -> Result<(), Rejection> {
    expressions(tokens)?;
    statements(tokens)
}

/// The operators of the innermost open bracket.
#[derive(Clone, Copy, Debug, Default)]
struct Level {
    /// The unary operators of the operand that is read.
    signs: usize,
    /// Operators in a row: `&&` and `||`, sums and bits, products.
    chains: [usize; 3],
}

fn expressions(tokens: &Tokens<'_>) -> Result<(), Rejection> {
    let mut open = vec![Level::default()];
    let mut signs = 0;
    let mut after_operand = false;
    // The left side of an assignment, whose signs do not count.
    let mut is_left = false;
    for at in 0..tokens.ranges.len() {
        let word = tokens.word(at);
        let is_list = tokens.lists.contains(&at);
        let is_operand = word.starts_with(|first: char| first.is_alphanumeric() || first == '_');
        match word {
            "(" | "[" | "{" => {
                if word == "{" {
                    open.last_mut().into_iter().for_each(|level| operator(level, &mut signs, word));
                }
                open.push(Level::default());
                after_operand = false;
            }
            "<" if is_list => {
                open.push(Level::default());
                after_operand = false;
            }
            ")" | "]" | "}" => {
                close(&mut open, &mut signs);
                after_operand = word != "}";
            }
            ">" if is_list => {
                close(&mut open, &mut signs);
                after_operand = true;
            }
            "." => {}
            _ if is_operand => after_operand = !KEYWORDS.contains(&word),
            "-" | "!" | "~" | "*" | "&" if !after_operand => {
                if !is_left {
                    signs += 1;
                    open.last_mut().into_iter().for_each(|level| level.signs += 1);
                }
            }
            "--" if !after_operand => {}
            _ => {
                let level = open.last_mut();
                level.into_iter().for_each(|level| operator(level, &mut signs, word));
                after_operand = false;
            }
        }
        is_left = match word {
            ";" | "{" | "}" => ["*", "&", "("].contains(&tokens.word(at + 1)),
            _ => is_left && !is_assignment(word),
        };
        let chain = open.last().is_some_and(|level| level.chains.iter().any(|chain| *chain > MAX_CHAIN));
        if open.len() - 1 + signs > MAX_OPEN {
            return Err(reject(tokens, at, "brackets and signs are open", MAX_OPEN));
        }
        if chain {
            return Err(reject(tokens, at, "operators stand in a row", MAX_CHAIN));
        }
    }
    Ok(())
}

fn close(open: &mut Vec<Level>, signs: &mut usize) {
    if let Some(level) = open.pop() {
        *signs -= level.signs;
    }
    if open.is_empty() {
        open.push(Level::default());
    }
}

/// Ends the operand before a binary operator or separator.
fn operator(level: &mut Level, signs: &mut usize, word: &str) {
    *signs -= level.signs;
    level.signs = 0;
    let [logical, sums, products] = level.chains;
    level.chains = match word {
        "&&" | "||" => [logical + 1, 0, 0],
        "+" | "-" | "&" | "|" | "^" => [logical, sums + 1, 0],
        "*" | "/" | "%" => [logical, sums, products + 1],
        "<" | ">" | "<=" | ">=" | "==" | "!=" | "<<" => [logical, 0, 0],
        _ => [0; 3],
    };
}

/// A brace that is open.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// The number of statements around what stands in the block, with the block itself.
    depth: usize,
    /// The number of statements around the branch of an `if`, with the `if` itself; `None` for other blocks.
    chain: Option<usize>,
}

fn statements(tokens: &Tokens<'_>) -> Result<(), Rejection> {
    let mut open: Vec<Block> = Vec::new();
    // What the next brace begins, if it is no plain block.
    let mut next: Option<Block> = None;
    let mut last_chain: Option<usize> = None;
    let mut brackets = 0_usize;
    for at in 0..tokens.ranges.len() {
        let depth = open.last().map_or(0, |block| block.depth);
        let word = tokens.word(at);
        match word {
            "(" => brackets += 1,
            ")" => brackets = brackets.saturating_sub(1),
            "if" => {
                let around = if at > 0 && tokens.word(at - 1) == "else" { last_chain } else { None };
                let chain = around.unwrap_or(depth) + 1;
                next = Some(Block { depth: chain + 1, chain: Some(chain) });
            }
            "else" => next = last_chain.map(|chain| Block { depth: chain + 1, chain: None }),
            "loop" | "for" | "while" => next = Some(Block { depth: depth + 2, chain: None }),
            "switch" => next = Some(Block { depth: depth + 1, chain: None }),
            "case" | "default" => next = Some(Block { depth: depth + 2, chain: None }),
            "{" => {
                let block = next.take().unwrap_or(Block { depth: depth + 1, chain: None });
                if block.depth > MAX_OPEN {
                    return Err(reject(tokens, at, "statements stand around each other", MAX_OPEN));
                }
                open.push(block);
            }
            "}" => {
                next = None;
                last_chain = open.pop().and_then(|block| block.chain);
            }
            ";" if brackets == 0 && !open.is_empty() && depth + 1 > MAX_OPEN => {
                return Err(reject(tokens, at, "statements stand around each other", MAX_OPEN));
            }
            // `break if …;` begins no block.
            ";" if brackets == 0 => next = None,
            _ => {}
        }
    }
    Ok(())
}

fn reject(tokens: &Tokens<'_>, at: usize, what: &str, max: usize) -> Rejection {
    let message = format!("more than {max} {what} here, which Chrome's compiler does not read");
    let help = "give a part a name, as a `let` or a function of its own, or use a `switch` or a loop";
    Rejection::new(codes::WGSL_TOO_LARGE, message, Span::from(tokens.ranges[at].clone())).help(help)
}
