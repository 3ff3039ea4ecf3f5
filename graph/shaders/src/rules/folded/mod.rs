//! Values that naga computes in place, without the errors that WGSL has on the way.
//!
//! naga replaces `fma(3e38f, 2.0, -3e38f)` by its result while it parses, so that its form no longer tells what was
//! computed. This pass reads the expressions of the text again, as far as they are constant:
//!
//! | text | rejected |
//! |---|---|
//! | `fma`, `dot`, operators of floats | a step beyond the range of the type |
//! | `inverseSqrt` | a value of 0 or below, in a vector, too |
//! | `let r = abs(4611686018427387904)` | an integer without a type that no `i32` holds |
//! | `bitcast<u32>(4611686018427387904)` | an integer without a type that the cast cannot take |
//!
//! WGSL does not evaluate the right side of `false && …` and `true || …`, and neither does this pass.
//!
//! Limits: matrices, structures, `f16` and most functions are not followed, nor are constants whose name is declared
//! twice. Source: *WebGPU Shading Language*, "Abstract Numeric Types" and "Floating Point Evaluation".

mod functions;
mod reader;
mod value;

use std::collections::HashMap;

use naga::Span;

use crate::codes;
use crate::written::rejection::Rejection;
use crate::written::tokens::{Tokens, is_name};
use reader::Reader;
use value::{Kind, Number, Value};

/// Rejects the first constant expression with a step that WGSL does not allow.
pub(crate) fn check(tokens: &Tokens<'_>) -> Result<(), Rejection> {
    let declared = declared(tokens);
    let mut constants = HashMap::new();
    // One may name another that stands behind it.
    for _ in 0..2 {
        for at in 0..tokens.ranges.len() {
            if tokens.word(at) == "const"
                && declared.get(tokens.word(at + 1)) == Some(&1)
                && let Some(value) = constant(tokens, &declared, &constants, at)
            {
                constants.insert(tokens.word(at + 1), value);
            }
        }
    }
    let mut reader = Reader::new(tokens, &declared, &constants);
    while reader.at < tokens.ranges.len() {
        let begun = reader.at;
        let is_initial = initial(tokens, begun);
        if let Some(first) = is_initial {
            reader.at = first;
        }
        let value = reader.expression();
        if let Some(rejection) = reader.rejection.take() {
            return Err(rejection);
        }
        if let (Some(first), Some(value)) = (is_initial, value)
            && tokens.word(reader.at) == ";"
            && let Some(whole) = beyond_i32(&value)
        {
            let (message, help) = without_type(whole);
            let end = tokens.ranges[reader.at - 1].end;
            let place = Span::from(tokens.ranges[first].start..end);
            return Err(Rejection::new(codes::WGSL_INVALID, message, place).help(help));
        }
        reader.at = reader.at.max(begun + 1);
    }
    Ok(())
}

/// The token index of the initial value of a `let` or `var` without a type; `None` if no such declaration begins here.
fn initial(tokens: &Tokens<'_>, at: usize) -> Option<usize> {
    match (tokens.word(at), tokens.word(at + 1)) {
        ("var", "<") => {
            let end = (at..tokens.ranges.len()).find(|at| tokens.word(*at) == ">")?;
            (tokens.word(end + 2) == "=").then_some(end + 3)
        }
        ("let" | "var", _) => (tokens.word(at + 2) == "=").then_some(at + 3),
        _ => None,
    }
}

/// The value of the constant that is declared at token `at`; `None` if it cannot be followed.
fn constant(
    tokens: &Tokens<'_>,
    declared: &HashMap<&str, usize>,
    constants: &HashMap<&str, Value>,
    at: usize,
) -> Option<Value> {
    let (first, kind) = match (tokens.word(at + 2), tokens.word(at + 3), tokens.word(at + 4)) {
        ("=", ..) => (at + 3, None),
        (":", ty, "=") => {
            let kind = match ty {
                "f32" => Kind::F32,
                "i32" => Kind::I32,
                "u32" => Kind::U32,
                "bool" => Kind::Bool,
                _ => return None,
            };
            (at + 5, Some(kind))
        }
        _ => return None,
    };
    let mut reader = Reader::new(tokens, declared, constants);
    reader.at = first;
    let value = reader.expression()?;
    if reader.rejection.is_some() || tokens.word(reader.at) != ";" {
        return None;
    }
    kind.map_or(Some(value.clone()), |kind| value.converted(kind))
}

/// The number of declarations of each name in the module, in any scope.
fn declared<'t>(tokens: &Tokens<'t>) -> HashMap<&'t str, usize> {
    let mut declared: HashMap<&str, usize> = HashMap::new();
    let mut is_after_space = false;
    for at in 0..tokens.ranges.len() {
        let (word, before) = (tokens.word(at), at.checked_sub(1).map_or("", |before| tokens.word(before)));
        let is_declared = is_after_space
            || ["const", "let", "override", "var", "fn", "struct", "alias"].contains(&before)
            || tokens.word(at + 1) == ":";
        if is_declared && is_name(word) {
            *declared.entry(word).or_default() += 1;
        }
        // `var<private> name`, or `var<storage, read_write> name`.
        is_after_space = word == ">" && {
            let last = (at.saturating_sub(4)..at).rev().find(|at| tokens.word(*at) == "<");
            last.is_some_and(|list| list > 0 && tokens.word(list - 1) == "var")
        };
    }
    declared
}

/// The first component of a value without a type that no `i32` holds; `None` if there is none.
fn beyond_i32(value: &Value) -> Option<i64> {
    if value.kind != Kind::Int {
        return None;
    }
    value.parts.iter().find_map(|part| match part {
        Number::Whole(whole) if i32::try_from(*whole).is_err() => Some(*whole),
        _ => None,
    })
}

/// The message and the help text for an integer without a type that no `i32` holds.
fn without_type(whole: i64) -> (String, &'static str) {
    let message = format!("a number without a suffix is an i32, which does not hold {whole}");
    let help = match u32::try_from(whole) {
        Ok(_) => "add the suffix \"u\"",
        Err(_) => "no integer of WGSL holds it: take a smaller number, or a float as 1e10",
    };
    (message, help)
}
