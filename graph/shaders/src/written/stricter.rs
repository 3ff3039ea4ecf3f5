//! WGSL that naga rejects although the text is valid: the reason, and a way to write it.
//!
//! | text | WGSL | naga |
//! |---|---|---|
//! | `false && (1 / 0 == 1)` | does not evaluate the right side | evaluates it |
//! | `let k = 4u; v[k]` | a `let` is no constant | knows its value |
//! | `loop { var q; continuing { var q; } }` | two scopes | one scope |

use std::ops::Range;

use naga::{Expression, Handle, Module};

use super::ir;
use super::rejection::Rejection;

/// Adds the reason to a parse error of naga for a text that WGSL allows.
pub(crate) fn explain(text: &str, rejection: Rejection) -> Rejection {
    let way = if is_in_skipped_side(text, &rejection) {
        "the right side of \"false &&\" and \"true ||\" is not evaluated, but naga, which wgpu uses, evaluates it: \
         leave that side out"
    } else if is_of_continuing(text, &rejection) {
        "\"continuing\" is a scope of its own, but naga, which wgpu uses, takes it for that of the loop: give one of \
         the two another name"
    } else {
        return rejection;
    };
    allowed(rejection, way)
}

/// Adds the reason to a validation error of naga for a module that WGSL allows.
pub(crate) fn explain_module(module: &Module, rejection: Rejection) -> Rejection {
    let is_of_value = ["Accessing index", "Division by zero", "Shift amount exceeds"];
    if !is_of_value.iter().any(|part| rejection.message.contains(part)) {
        return rejection;
    }
    let Some(name) = rejection.range.as_ref().and_then(|range| let_operand(module, range)) else {
        return rejection;
    };
    let way = format!(
        "the \"let\" {name} is no constant, but naga, which wgpu uses, takes it for one: declare {name} as a \"var\", \
         or give it a value that is allowed"
    );
    allowed(rejection, &way)
}

fn allowed(rejection: Rejection, way: &str) -> Rejection {
    Rejection { help: Some(format!("WGSL allows this: {way}")), ..rejection }
}

/// The name of the `let` that is the index or the right operand of the expression of a byte range; `None` if none is.
fn let_operand(module: &Module, range: &Range<usize>) -> Option<String> {
    ir::functions(module).find_map(|function| {
        let is_named = |handle: Handle<Expression>| function.named_expressions.get(&handle).cloned();
        function.expressions.iter().find_map(|(handle, expression)| {
            let place = function.expressions.get_span(handle).to_range()?;
            let is_it = place == *range;
            match *expression {
                Expression::Access { index, .. } if is_it => {
                    is_literal(function, index).then(|| is_named(index))?
                }
                Expression::Binary { right, .. } if is_it => {
                    is_literal(function, right).then(|| is_named(right))?
                }
                _ => None,
            }
        })
    })
}

fn is_literal(function: &naga::Function, handle: Handle<Expression>) -> bool {
    matches!(
        function.expressions[handle],
        Expression::Literal(_)
            | Expression::Splat { .. }
            | Expression::Compose { .. }
            | Expression::ZeroValue(_)
    )
}

/// The maximum number of bytes of a statement in which a skipped side is looked for.
const LONGEST: usize = 4096;

/// Returns `true` if the place is in the right side of `false &&` or `true ||`.
fn is_in_skipped_side(text: &str, rejection: &Rejection) -> bool {
    let Some(before) = rejection.range.as_ref().and_then(|range| text.get(..range.start)) else {
        return false;
    };
    let begin = before.rfind([';', '{', '}']).map_or(0, |at| at + 1);
    if before.len() - begin > LONGEST {
        return false;
    }
    let statement: String = before[begin..].split_whitespace().collect();
    ["false&&", "true||"].iter().any(|left| {
        statement.match_indices(left).any(|(at, _)| {
            let is_whole =
                !statement[..at].ends_with(|last: char| last.is_alphanumeric() || "_!".contains(last));
            let mut depth = 0_i32;
            let is_inside = |one: char| {
                match one {
                    '(' | '[' => depth += 1,
                    ')' | ']' => depth -= 1,
                    _ => {}
                }
                depth >= 0 && (one != ',' || depth > 0)
            };
            is_whole && statement[at..].chars().all(is_inside)
        })
    })
}

/// Returns `true` if a name is declared in the body of a loop, and again in its `continuing` block.
fn is_of_continuing(text: &str, rejection: &Rejection) -> bool {
    if !rejection.message.starts_with("redefinition of") {
        return false;
    }
    let places = rejection.range.iter().chain(rejection.labels.iter().map(|(range, _)| range));
    let places: Vec<usize> = places.map(|range| range.start).collect();
    let (Some(first), Some(last)) = (places.iter().min(), places.iter().max()) else { return false };
    let Some(between) = text.get(*first..*last) else { return false };
    let mut open = Vec::new();
    for (at, one) in between.char_indices() {
        match one {
            '{' => open.push(at),
            '}' if open.pop().is_none() => return false,
            _ => {}
        }
    }
    matches!(open[..], [only] if between[..only].trim_end().ends_with("continuing"))
}
