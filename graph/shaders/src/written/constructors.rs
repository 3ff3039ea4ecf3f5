//! Values of structures and arrays with as many parts as their types have, and of their types.
//!
//! naga evaluates `array<f32, 2>(1)[0]` and `S(1).a` where they are constants, and forgets the constructor before it is
//! validated. This pass counts the arguments that a text gives to structures and arrays, and compares the suffixes of
//! numbers with the types of the parts; of vectors and matrices, too. It reads sizes of arrays that are numbers or
//! constants with a number. Vectors of which a part is taken have no [empty vector](EMPTY_VECTOR) in them.
//!
//! Source: *WebGPU Shading Language*, "Value Constructor Built-in Functions".

use std::ops::Range;

use naga::{Module, ScalarKind, Span, TypeInner};

use super::attributes;
use super::rejection::Rejection;
use super::tokens::{Tokens, is_name};
use crate::codes;

/// The maximum number of array elements: the size in bytes, at four bytes per element, must fit in 32 bits.
const MAX_WORDS: usize = (1 << 30) - 1;

/// Rejects the first value constructor in a module with a wrong number of arguments, or with numbers of a wrong type.
pub(crate) fn check(tokens: &Tokens<'_>, module: &Module) -> Result<(), Rejection> {
    (0..tokens.ranges.len()).try_for_each(|at| {
        let before = at.checked_sub(1).map_or("", |before| tokens.word(before));
        match tokens.word(at) {
            "array" => array(tokens, module, at),
            word if word.starts_with("vec") || word.starts_with("mat") => vector(tokens, module, at),
            _ if tokens.word(at + 1) == "(" && before != "." && before != "fn" && before != "@" => {
                structure(tokens, module, at)
            }
            _ => Ok(()),
        }
    })
}

fn structure(tokens: &Tokens<'_>, module: &Module, at: usize) -> Result<(), Rejection> {
    let name = tokens.word(at);
    let mut types = module.types.iter().filter(|(_, ty)| ty.name.as_deref() == Some(name));
    let Some(TypeInner::Struct { members, .. }) = types.next().map(|(_, ty)| &ty.inner) else {
        return Ok(());
    };
    let arguments = arguments(tokens, at + 1);
    if !arguments.is_empty() && arguments.len() != members.len() {
        let (given, wanted) = (arguments.len(), members.len());
        let message = format!("\"{name}\" has {wanted} members, but {given} are given");
        return Err(rejection(tokens, at, message, "give each member a value, or none"));
    }
    for (member, argument) in members.iter().zip(&arguments) {
        match module.types[member.ty].inner {
            TypeInner::Scalar(scalar) => number(tokens, module, argument, scalar.kind)?,
            _ if is_number(tokens, argument) => {
                let message =
                    format!("a number is given for \"{}\"", member.name.as_deref().unwrap_or_default());
                return Err(rejection(
                    tokens,
                    argument.start,
                    message,
                    "give it a value of the member's type",
                ));
            }
            _ => {}
        }
    }
    Ok(())
}

fn array(tokens: &Tokens<'_>, module: &Module, at: usize) -> Result<(), Rejection> {
    if tokens.word(at + 1) == "(" {
        let all = arguments(tokens, at + 1);
        let first = all.iter().find_map(|argument| kind_of(tokens, module, argument));
        return first.map_or(Ok(()), |kind| {
            all.iter().try_for_each(|argument| number(tokens, module, argument, kind))
        });
    }
    if !tokens.lists.contains(&(at + 1)) {
        return Ok(());
    }
    let mut depth = 0;
    let is_end = |at: &usize| {
        match tokens.word(*at) {
            "<" | "(" => depth += 1,
            ">" | ")" => depth -= 1,
            _ => {}
        }
        depth == 0
    };
    let Some(end) = (at + 1..tokens.ranges.len()).find(is_end) else { return Ok(()) };
    let arguments = arguments(tokens, end + 1);
    let size = if tokens.word(end - 2) == "," { size(tokens, tokens.word(end - 1)) } else { None };
    if let Some(size) = size.filter(|size| !arguments.is_empty() && *size != arguments.len()) {
        let message = format!("the array has {size} elements, but {} are given", arguments.len());
        return Err(rejection(tokens, at, message, "give each element a value, or none"));
    }
    if size.is_some_and(|size| size > MAX_WORDS && tokens.word(end + 1) == "(") {
        let message = "the array is larger than 4 GiB".to_owned();
        return Err(rejection(tokens, at, message, "keep so many elements in a storage buffer"));
    }
    let Some(kind) = kind_of_type(tokens.word(at + 2)) else { return Ok(()) };
    arguments.iter().try_for_each(|argument| number(tokens, module, argument, kind))
}

/// The message and the help text for a vector of constants with an empty vector in it.
pub(crate) const EMPTY_VECTOR: (&str, &str) = (
    "a vector of constants has a vector without arguments in it, which naga takes for one component",
    "WGSL allows this, but naga, which wgpu uses, gets it wrong: give the inner vector its zero, such as \"vec3f(0)\"",
);

/// Rejects arguments of a vector or matrix constructor that are not of its scalar type. `at` is the token index of the
/// type name.
fn vector(tokens: &Tokens<'_>, module: &Module, at: usize) -> Result<(), Rejection> {
    let word = tokens.word(at);
    let (kind, open) = if tokens.lists.contains(&(at + 1)) {
        (kind_of_type(tokens.word(at + 2)), at + 4)
    } else {
        (kind_of_type(word), at + 1)
    };
    let all = arguments(tokens, open);
    if all.len() < 2 {
        return Ok(());
    }
    let is_taken_apart = matches!(tokens.word(tokens.closing(open) + 1), "[" | ".");
    if is_taken_apart
        && all.iter().any(|argument| is_empty_vector(tokens, argument))
        && all.iter().all(|argument| is_constant(tokens, argument))
    {
        return Err(rejection(tokens, at, EMPTY_VECTOR.0.to_owned(), EMPTY_VECTOR.1));
    }
    let kind = kind.or_else(|| all.iter().find_map(|argument| kind_of(tokens, module, argument)));
    let Some(kind) = kind else { return Ok(()) };
    all.iter().try_for_each(|argument| number(tokens, module, argument, kind))
}

fn is_vector(word: &str) -> bool {
    let size = word.strip_prefix("vec").and_then(|rest| rest.strip_prefix(['2', '3', '4']));
    size.is_some_and(|kind| matches!(kind, "" | "f" | "h" | "i" | "u"))
}

fn is_empty_vector(tokens: &Tokens<'_>, argument: &Range<usize>) -> bool {
    let open = if tokens.lists.contains(&(argument.start + 1)) { 4 } else { 1 };
    is_vector(tokens.word(argument.start))
        && tokens.word(argument.start + open) == "("
        && argument.len() == open + 2
}

/// Returns `true` for an argument of numbers, and of vectors of them.
fn is_constant(tokens: &Tokens<'_>, argument: &Range<usize>) -> bool {
    argument.clone().all(|at| {
        let word = tokens.word(at);
        let is_type = matches!(word, "f16" | "f32" | "i32" | "u32" | "bool") || is_vector(word);
        is_type || matches!(word, "true" | "false") || !is_name(word)
    })
}

/// The value of an integer literal, or of the constant with this name if it is declared as a literal; `None` if
/// unknown.
fn size(tokens: &Tokens<'_>, word: &str) -> Option<usize> {
    let number = |word: &str| {
        let digits = word.trim_end_matches(['u', 'i']);
        let hexadecimal = digits.strip_prefix("0x").or_else(|| digits.strip_prefix("0X"));
        hexadecimal.map_or_else(|| digits.parse().ok(), |digits| usize::from_str_radix(digits, 16).ok())
    };
    let value = || {
        let is_it = |at: &usize| tokens.word(*at) == "const" && tokens.word(at + 1) == word;
        let mut declared = (0..tokens.ranges.len()).filter(is_it);
        let at = declared.next().filter(|_| declared.next().is_none())?;
        let equals = (at..tokens.ranges.len()).take(6).find(|at| tokens.word(*at) == "=")?;
        if tokens.word(equals + 2) == ";" { number(tokens.word(equals + 1)) } else { None }
    };
    number(word).or_else(value)
}

/// The token indices of each argument in the parentheses at `open`; empty if no parenthesis opens there.
fn arguments(tokens: &Tokens<'_>, open: usize) -> Vec<Range<usize>> {
    if tokens.word(open) != "(" {
        return Vec::new();
    }
    let end = tokens.closing(open);
    let (mut found, mut first, mut depth) = (Vec::new(), open + 1, 0_usize);
    for at in open + 1..end {
        let bounds_list = tokens.lists.contains(&at);
        match tokens.word(at) {
            "(" | "[" => depth += 1,
            ")" | "]" => depth = depth.saturating_sub(1),
            "<" if bounds_list => depth += 1,
            ">" if bounds_list => depth = depth.saturating_sub(1),
            "," if depth == 0 => {
                found.push(first..at);
                first = at + 1;
            }
            _ => {}
        }
    }
    if first < end {
        found.push(first..end);
    }
    found
}

/// Rejects a constructor argument whose scalar type is known and differs from `wanted`.
fn number(
    tokens: &Tokens<'_>,
    module: &Module,
    argument: &Range<usize>,
    wanted: ScalarKind,
) -> Result<(), Rejection> {
    let is_of_bool = wanted == ScalarKind::Bool && is_number(tokens, argument);
    if !is_of_bool && kind_of(tokens, module, argument).is_none_or(|kind| kind == wanted) {
        return Ok(());
    }
    let message = format!("\"{}\" is of another type than the value it is for", tokens.word(argument.start));
    Err(rejection(tokens, argument.start, message, "write it without a suffix, or convert it"))
}

fn is_number(tokens: &Tokens<'_>, argument: &Range<usize>) -> bool {
    argument.len() == 1 && tokens.word(argument.start).starts_with(|first: char| first.is_ascii_digit())
}

/// The scalar kind of an argument that is a literal, a constant of the module or a constructor call; `None` if
/// unknown.
fn kind_of(tokens: &Tokens<'_>, module: &Module, argument: &Range<usize>) -> Option<ScalarKind> {
    let first = argument.start + usize::from(tokens.word(argument.start) == "-");
    let word = tokens.word(first);
    if first + 1 == argument.end {
        return attributes::kind_of(word, module)
            .filter(|_| !is_name(word) || !tokens.is_declared_twice(word));
    }
    let is_digit = |first: char| first.is_ascii_digit();
    if first + 3 == argument.end && tokens.word(first + 1) == "." && word.starts_with(is_digit) {
        return Some(ScalarKind::Float);
    }
    let is_list = tokens.lists.contains(&(first + 1));
    let open = if is_list { first + 4 } else { first + 1 };
    if tokens.word(open) != "(" || tokens.closing(open) + 1 != argument.end || word == "array" {
        return None;
    }
    kind_of_type(if is_list && word.starts_with("vec") { tokens.word(first + 2) } else { word })
}

/// The scalar kind of a scalar, vector or matrix type with this name; `None` if unknown.
fn kind_of_type(word: &str) -> Option<ScalarKind> {
    let suffix = word.strip_prefix("vec").or_else(|| word.strip_prefix("mat"));
    match (word, suffix.and_then(|suffix| suffix.chars().next_back())) {
        ("f32" | "f16", _) | (_, Some('f' | 'h')) => Some(ScalarKind::Float),
        ("u32", _) | (_, Some('u')) => Some(ScalarKind::Uint),
        ("i32", _) | (_, Some('i')) => Some(ScalarKind::Sint),
        ("bool", _) => Some(ScalarKind::Bool),
        _ => None,
    }
}

fn rejection(tokens: &Tokens<'_>, at: usize, message: String, help: &str) -> Rejection {
    let place = tokens.ranges.get(at).cloned().map_or(Span::UNDEFINED, Span::from);
    Rejection::new(codes::WGSL_INVALID, message, place).help(help)
}
