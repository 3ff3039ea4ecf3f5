//! Operators that WGSL does not let stand beside each other without parentheses.
//!
//! naga reads expressions by precedence, as C does. WGSL's grammar is narrower, and browsers hold to it: `a & b | c`,
//! `1u << n + 1u`, `a < b < c` and `a && b || c` need parentheses. This pass reads the words of a text that naga has
//! parsed, finds the operators of each expression, and rejects the first that the grammar does not allow there.
//!
//! Between two brackets, commas or statements, the binary operators of an expression stand on one level:
//!
//! - `&`, `|` and `^` go with themselves alone;
//! - `&&` and `||` do not mix; between them stands at most one comparison each;
//! - on each side of a comparison stands arithmetic, or one shift and nothing else.
//!
//! Source: *WebGPU Shading Language*, "Expression Grammar Summary".

use std::ops::Range;

use naga::Span;

use super::rejection::Rejection;
use super::tokens::{KEYWORDS, Tokens, is_assignment};
use crate::codes;

/// The byte range of a binary operator in the WGSL.
type Operator = Range<usize>;

/// Rejects the first pair of operators in a WGSL module that WGSL does not allow together without parentheses.
pub(crate) fn check(tokens: &Tokens<'_>) -> Result<(), Rejection> {
    let Tokens { text, ranges: tokens, lists } = tokens;
    // The operators of each open expression, the outermost first.
    let mut open: Vec<Vec<Operator>> = vec![Vec::new()];
    let mut after_operand = false;
    let mut at = 0;
    while let Some(range) = tokens.get(at) {
        let mut range = range.clone();
        let mut word = &text[range.clone()];
        let bounds_list = lists.contains(&at);
        at += 1;
        if word == ">" && !bounds_list {
            // `>>` and `>=` are tokens only where no template list ends.
            let next = tokens.get(at).filter(|next| next.start == range.end && !lists.contains(&at));
            if let Some(next) = next.filter(|next| [">", "=", "=="].contains(&&text[(*next).clone()])) {
                range.end = next.end;
                word = &text[range.clone()];
                at += 1;
            }
        }
        let is_operand = word.starts_with(|first: char| first.is_alphanumeric() || first == '_');
        match word {
            "(" | "[" => {
                open.push(Vec::new());
                after_operand = false;
            }
            "<" if bounds_list => {
                open.push(Vec::new());
                after_operand = false;
            }
            ")" | "]" => {
                close(text, &mut open)?;
                after_operand = true;
            }
            ">" if bounds_list => {
                close(text, &mut open)?;
                after_operand = true;
            }
            "{" | "}" | "," | ";" | ":" | "@" | "->" | "++" | "--" => {
                end(text, &mut open)?;
                after_operand = false;
            }
            "." => {}
            _ if is_operand => after_operand = !KEYWORDS.contains(&word),
            _ if is_assignment(word) => {
                end(text, &mut open)?;
                after_operand = false;
            }
            _ if after_operand => {
                open.last_mut().into_iter().for_each(|operators| operators.push(range.clone()));
                after_operand = false;
            }
            // A sign of one operand.
            _ => {}
        }
    }
    open.iter().try_for_each(|operators| allowed(text, operators))
}

/// Checks and removes the operators of the innermost open expression, which ends at a separator such as `,` or `;`.
fn end(text: &str, open: &mut [Vec<Operator>]) -> Result<(), Rejection> {
    let Some(operators) = open.last_mut() else { return Ok(()) };
    allowed(text, &std::mem::take(operators))
}

/// Checks and removes the operators of the innermost open expression, which ends with its closing bracket.
fn close(text: &str, open: &mut Vec<Vec<Operator>>) -> Result<(), Rejection> {
    let operators = open.pop().unwrap_or_default();
    if open.is_empty() {
        open.push(Vec::new());
    }
    allowed(text, &operators)
}

/// Rejects the operators of one expression, without those in nested brackets, if two of them need parentheses.
fn allowed(text: &str, operators: &[Operator]) -> Result<(), Rejection> {
    let word = |at: usize| &text[operators[at].clone()];
    let is = |at: usize, of: &[&str]| of.contains(&word(at));
    let all = 0..operators.len();
    for at in 1..operators.len() {
        let before = at - 1;
        let is_bitwise = |at: usize| is(at, &["&", "|", "^"]);
        if (is_bitwise(at) || is_bitwise(before)) && word(at) != word(before) {
            return Err(rejection(text, &operators[before], &operators[at]));
        }
    }
    let logical = |at: &usize| is(*at, &["&&", "||"]);
    if let Some(first) = all.clone().find(logical)
        && let Some(other) = all.clone().skip(first + 1).filter(logical).find(|at| word(*at) != word(first))
    {
        return Err(rejection(text, &operators[first], &operators[other]));
    }
    let (mut comparison, mut shift, mut arithmetic): (Option<usize>, Option<usize>, Option<usize>) =
        (None, None, None);
    for at in all {
        if logical(&at) {
            (comparison, shift, arithmetic) = (None, None, None);
        } else if is(at, &["<", ">", "<=", ">=", "==", "!="]) {
            if let Some(before) = comparison {
                return Err(rejection(text, &operators[before], &operators[at]));
            }
            (comparison, shift, arithmetic) = (Some(at), None, None);
        } else if is(at, &["<<", ">>"]) {
            if let Some(before) = shift.or(arithmetic) {
                return Err(rejection(text, &operators[before], &operators[at]));
            }
            shift = Some(at);
        } else if is(at, &["+", "-", "*", "/", "%"]) {
            if let Some(before) = shift {
                return Err(rejection(text, &operators[before], &operators[at]));
            }
            arithmetic = Some(at);
        }
    }
    Ok(())
}

fn rejection(text: &str, first: &Operator, second: &Operator) -> Rejection {
    let (one, other) = (&text[first.clone()], &text[second.clone()]);
    let message = if one == other {
        format!("WGSL takes one \"{one}\" here, and a second only in parentheses")
    } else {
        format!("WGSL does not take \"{one}\" and \"{other}\" beside each other without parentheses")
    };
    // C and naga read the tighter operator first.
    let tighter = if tightness(one) >= tightness(other) { one } else { other };
    let help =
        format!("to keep the meaning that C gives it, write parentheses around the part with \"{tighter}\"");
    let mut rejection = Rejection::new(codes::WGSL_SYNTAX, message, Span::from(second.clone())).help(help);
    rejection.labels.push((first.clone(), format!("\"{one}\" stands here")));
    rejection
}

/// The precedence of an operator in C; operators with higher values bind tighter.
fn tightness(operator: &str) -> usize {
    const ORDER: [&[&str]; 9] = [
        &["||"],
        &["&&"],
        &["|"],
        &["^"],
        &["&"],
        &["==", "!="],
        &["<", ">", "<=", ">="],
        &["<<", ">>"],
        &["+", "-"],
    ];
    ORDER.iter().position(|level| level.contains(&operator)).unwrap_or(ORDER.len())
}

#[cfg(test)]
mod tests {
    use super::Tokens;
    use crate::written::rejection::Rejection;

    fn check(text: &str) -> Result<(), Rejection> {
        super::check(&Tokens::new(text))
    }

    fn accepts(expression: &str) -> bool {
        check(&format!("fn f() {{ let r = {expression}; }}")).is_ok()
    }

    #[test]
    fn mixed_operators_need_parentheses() {
        for mixed in [
            "a & b | c",
            "a | b & c",
            "a ^ b & c",
            "x & 7u | y << 3u",
            "a & b + c",
            "a + b & c",
            "a & b == c",
            "a == b | c",
            "a && b || c",
            "a || b && c",
            "a & b && c",
            "a << b << c",
            "a << b + c",
            "a + b << c",
            "a * b >> c",
            "a < b < c",
            "a == b == c",
            "a < b == c",
            "a >= b > c",
            "f(a & b | c)",
            "x[a << b + c]",
            "vec2<u32>(a & b | c, d)",
            "a & (b | c) | d",
            "1.5e-3 + a & b",
            "-a & b | c",
        ] {
            assert!(!accepts(mixed), "{mixed}");
        }
    }

    #[test]
    fn operators_that_go_together_are_accepted() {
        for sound in [
            "a & b & c",
            "a | b | c",
            "(a & b) | c",
            "a + b * c - d",
            "a && b && c",
            "a < b && c > d",
            "a + b < c * d",
            "a << b < c",
            "a << b == c >> d",
            "a << (b + c)",
            "-a & -b",
            "a - -b",
            "!a && !b",
            "(a < b) == (c < d)",
            "vec4<f32>(a < b)",
            "array<vec2<f32>, 4>(a, b)",
            "x[a + b] & y[c]",
            "1e-3 + 2.5e+4 * a",
            "0x1p-3 + a",
            "*p & *q",
            "select(a, b, c < d || e > g)",
            "a.x & b.y & c.z",
            "vec2<i32>(a) >= vec2<i32>(b)",
            "array<array<f32, 2>, 3>()[1][0] + a",
            "a >> b",
            "(a >> b) & c",
        ] {
            assert!(accepts(sound), "{sound}");
        }
    }

    #[test]
    fn names_may_hold_letters_of_any_script() {
        assert!(accepts("é & ß") && !accepts("é & ß | c") && accepts("a\u{200e} & 日本"));
    }

    #[test]
    fn help_names_the_operator_that_c_reads_first() {
        let rejection = check("const A = 1u << n + 1u;").unwrap_err();
        assert!(rejection.help.is_some_and(|help| help.ends_with("the part with \"+\"")));
    }

    #[test]
    fn statements_and_declarations_end_an_expression() {
        let text = "@group(0) @binding(1) var<storage, read_write> list: array<vec4<u32>>;
            const SIDE: u32 = 1u << 3u; const OTHER = SIDE & 7u; // a & b | c
            fn f(p: ptr<function, u32>, q: u32) -> u32 {
                *p = q & 1u; *p += q << 2u; *p |= q ^ 3u;
                for (var i = 0u; i < 4u && i != q; i++) { if (i & 1u) == 0u { continue; } *p >>= 1u; }
                switch q { case 1u: { return *p & q; } default: {} }
                let v: vec2<f32>= vec2<f32>(1.0, -2.0);
                return select(*p | q, q >> 1u, v.x < v.y);
            }";
        assert_eq!(check(text), Ok(()));
    }
}
