//! Numbers that nothing gives a type: `3000000000` and `vec2(1, 2) << vec2(4u)`, but not `u32(3000000000)`.
//!
//! WGSL takes them for `i32` where a `let` or `var` gets its type from them, and rejects those that no `i32` holds.
//! naga takes `u32` for these, or floats if that does not suffice. A value is followed through the text: numbers,
//! constants of numbers, vectors and a few built-in functions of them. What else a value may have is taken for
//! something with a type, and left alone.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use naga::front::Typifier;
use naga::proc::ResolveContext;
use naga::{Expression, Function, Module, ScalarKind, Span};

use crate::written::tokens::{Tokens, is_name};

/// WGSL built-in functions whose result has no concrete type if all of their arguments are numbers without a type.
const UNTYPED: [&str; 14] = [
    "abs", "array", "clamp", "cross", "dot", "max", "min", "select", "sign", "vec2", "vec3", "vec4", "all",
    "any",
];

/// The names of a vector's components in swizzles.
const COMPONENTS: [char; 8] = ['x', 'y', 'z', 'w', 'r', 'g', 'b', 'a'];

/// The names of the constants whose values consist only of numbers without a type, such as `1`.
pub(super) fn constants<'t>(tokens: &Tokens<'t>) -> HashSet<&'t str> {
    let is_declared = |at: &usize| tokens.word(*at) == "const" && tokens.word(at + 2) == "=";
    let declared: Vec<usize> = (0..tokens.ranges.len()).filter(is_declared).collect();
    let mut found = HashSet::new();
    // One may name another that stands behind it.
    for _ in 0..2 {
        for at in &declared {
            let is_within = |at: &usize| *at < tokens.ranges.len() && tokens.word(*at) != ";";
            if (at + 3..).take_while(is_within).all(|at| is_untyped(tokens, &found, at))
                && !tokens.is_declared_twice(tokens.word(at + 1))
            {
                found.insert(tokens.word(at + 1));
            }
        }
    }
    found
}

/// The byte ranges of the initial values of `let` and `var` that consist only of numbers without a type. `constants`
/// names the constants of such numbers.
pub(super) fn values(tokens: &Tokens<'_>, constants: &HashSet<&str>) -> Vec<Range<usize>> {
    let value = |at: usize| match (tokens.word(at), tokens.word(at + 1)) {
        ("var", "<") if tokens.word(at + 5) == "=" => Some(at + 6),
        ("let" | "var", _) if tokens.word(at + 2) == "=" => Some(at + 3),
        _ => None,
    };
    let values = (0..tokens.ranges.len()).filter_map(value);
    let bytes = |first: usize| {
        let value = value_of(tokens, constants, first)?;
        Some(tokens.ranges.get(value.start)?.start..tokens.ranges.get(value.end - 1)?.end)
    };
    values.filter_map(bytes).collect()
}

/// The range of token indices of the value that begins at token `first` and ends before a semicolon. `None` unless it
/// consists only of numbers without a type.
fn value_of(tokens: &Tokens<'_>, constants: &HashSet<&str>, first: usize) -> Option<Range<usize>> {
    let end = (first..tokens.ranges.len()).find(|at| tokens.word(*at) == ";").unwrap_or(tokens.ranges.len());
    let mut at = first;
    while at < end {
        // The number of bits of a shift has a type of its own.
        if ["<<", ">"].contains(&tokens.word(at)) && !tokens.lists.contains(&at) {
            at = end_of_operand(tokens, at + 1);
        } else if is_untyped(tokens, constants, at) {
            at += 1;
        } else {
            return None;
        }
    }
    Some(first..end)
}

/// The index of the token after the operand that begins at token `first`: a number, a name, a call or a parenthesized
/// expression.
fn end_of_operand(tokens: &Tokens<'_>, first: usize) -> usize {
    let open = if is_name(tokens.word(first)) { first + 1 } else { first };
    if tokens.word(open) == "(" { tokens.closing(open) + 1 } else { first + 1 }
}

/// The kind of numbers in a value without a concrete type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    /// Only integer literals, and vectors of them.
    Whole,
    /// Literals and names, which may stand for floats.
    Named,
}

/// The names of `let` and `var` declarations whose values consist only of numbers without a type. A name is left out if
/// another declaration of it has another kind of value.
pub(super) fn names<'t>(tokens: &Tokens<'t>, constants: &HashSet<&str>) -> HashMap<&'t str, Numbers> {
    // No other text has a number that is so large, without a suffix: most are not searched.
    let is_long = |word: &str| word.len() >= 10 && word.starts_with(|first: char| first.is_ascii_digit());
    if !(0..tokens.ranges.len()).map(|at| tokens.word(at)).any(|word| word == "<<" || is_long(word)) {
        return HashMap::new();
    }
    let mut found: HashMap<&str, Option<Numbers>> = HashMap::new();
    let is_declared = |at: &usize| ["let", "var"].contains(&tokens.word(*at));
    for at in (0..tokens.ranges.len()).filter(is_declared) {
        let value = if tokens.word(at + 2) == "=" { value_of(tokens, constants, at + 3) } else { None };
        let numbers = value.and_then(|value| numbers(tokens, value));
        let merged = |other: Option<Numbers>| if other == numbers { other } else { None };
        let known = found.get(tokens.word(at + 1)).copied();
        found.insert(tokens.word(at + 1), known.map_or(numbers, merged));
    }
    found.into_iter().filter_map(|(name, numbers)| Some((name, numbers?))).collect()
}

/// The span of the first value that naga does not make an `i32` because its numbers exceed the range of `i32`. `None`
/// if there is none.
pub(super) fn beyond(names: &HashMap<&str, Numbers>, module: &Module, function: &Function) -> Option<Span> {
    if names.is_empty() {
        return None;
    }
    let (expressions, locals) = (&function.expressions, &function.local_variables);
    let mut types = Typifier::new();
    let context = ResolveContext::with_locals(module, locals, &function.arguments);
    let is_beyond = |name: &str, kind: Option<ScalarKind>| match names.get(name) {
        Some(Numbers::Whole) => matches!(kind, Some(ScalarKind::Uint | ScalarKind::Float)),
        Some(Numbers::Named) => kind == Some(ScalarKind::Uint),
        None => false,
    };
    let mut values = function.named_expressions.iter();
    let value = values.find(|(handle, name)| {
        !matches!(expressions[**handle], Expression::FunctionArgument(_))
            && types.grow(**handle, expressions, &context).is_ok()
            && is_beyond(name, types.get(**handle, &module.types).scalar_kind())
    });
    let mut variables = locals.iter();
    let variable = variables.find(|(_, variable)| {
        let kind = module.types[variable.ty].inner.scalar_kind();
        variable.name.as_ref().is_some_and(|name| is_beyond(name, kind))
    });
    let value = value.map(|(handle, _)| expressions.get_span(*handle));
    value.or_else(|| variable.map(|(handle, _)| locals.get_span(handle)))
}

/// The kind of numbers in a value; `None` if the value contains a float literal or a comparison.
fn numbers(tokens: &Tokens<'_>, value: Range<usize>) -> Option<Numbers> {
    let mut numbers = Numbers::Whole;
    for at in value {
        let word = tokens.word(at);
        if is_name(word) && !["vec2", "vec3", "vec4"].contains(&word) {
            numbers = Numbers::Named;
        }
        let is_number = word.starts_with(|first: char| first.is_ascii_digit());
        let exponent = if word.starts_with("0x") { ['p', 'P'] } else { ['e', 'E'] };
        let is_point = word == "." && !is_name(tokens.word(at + 1));
        let is_float = is_point || (is_number && word.contains(exponent));
        if is_float || ["==", "!=", "<", ">", "<=", ">="].contains(&word) {
            return None;
        }
    }
    Some(numbers)
}

pub(super) fn is_untyped(tokens: &Tokens<'_>, constants: &HashSet<&str>, at: usize) -> bool {
    let word = tokens.word(at);
    if word.starts_with(|first: char| first.is_ascii_digit()) {
        let suffixes: &[char] = if word.starts_with("0x") { &['u', 'i'] } else { &['u', 'i', 'f', 'h'] };
        return !word.ends_with(suffixes);
    }
    if word == "<" && tokens.lists.contains(&at) {
        return false;
    }
    let is_component = || at > 0 && tokens.word(at - 1) == "." && word.trim_matches(COMPONENTS).is_empty();
    !is_name(word) || UNTYPED.contains(&word) || constants.contains(word) || is_component()
}
