//! Attributes of declarations that WGSL allows elsewhere only.
//!
//! naga reads the attributes before a declaration and forgets those that mean nothing there, such as `@id` before a
//! `const`; browsers refuse them. It also takes a workgroup size of an `i32` and a `u32`, of which WGSL wants one.
//!
//! Source: *WebGPU Shading Language*, "Attributes".

use std::ops::Range;

use naga::keywords::wgsl::RESERVED;
use naga::{Module, ScalarKind, Span, TypeInner};

use super::rejection::Rejection;
use super::tokens::Tokens;
use crate::codes;

/// Attributes, each with the keyword of the only declaration that allows the attribute.
const PLACES: [(&str, &str); 9] = [
    ("vertex", "fn"),
    ("fragment", "fn"),
    ("compute", "fn"),
    ("workgroup_size", "fn"),
    ("must_use", "fn"),
    ("diagnostic", "fn"),
    ("id", "override"),
    ("group", "var"),
    ("binding", "var"),
];

/// The largest allowed value of a number without a suffix in an attribute: the maximum of `i32`.
const MAX_NUMBER: u64 = i32::MAX.cast_unsigned() as u64;

/// Rejects the first attribute of a WGSL module that the declaration after it does not allow.
pub(crate) fn check(tokens: &Tokens<'_>, module: &Module) -> Result<(), Rejection> {
    (0..tokens.ranges.len()).filter(|at| tokens.word(*at) == "@").try_for_each(|at| numbers(tokens, at))?;
    let mut at = 0;
    while at < tokens.ranges.len() {
        let keyword = tokens.after_attributes(at);
        if keyword > at {
            placed(tokens, module, at..keyword)?;
        }
        if tokens.word(keyword) == "diagnostic" {
            diagnostic(tokens, keyword)?;
        }
        if tokens.word(keyword) == "struct" {
            members(tokens, keyword + 2)?;
        }
        // To the end of the declaration.
        at = keyword;
        while at < tokens.ranges.len() && ![";", "{"].contains(&tokens.word(at)) {
            at += 1;
        }
        at = if tokens.word(at) == "{" { tokens.closing(at) } else { at } + 1;
    }
    Ok(())
}

/// Rejects a number in an attribute that has no suffix and exceeds the range of `i32`. `at` is the token index of the
/// attribute's `@`.
fn numbers(tokens: &Tokens<'_>, at: usize) -> Result<(), Rejection> {
    let end = if tokens.word(at + 2) == "(" { tokens.closing(at + 2) } else { at };
    let is_large = |at: &usize| tokens.word(*at).parse::<u64>().is_ok_and(|value| value > MAX_NUMBER);
    let Some(number) = (at..end).find(is_large) else { return Ok(()) };
    let message = format!("{} is a number without a suffix, which does not fit an i32", tokens.word(number));
    let place = Span::from(tokens.ranges[number].clone());
    Err(Rejection::new(codes::WGSL_INVALID, message, place).help("write a smaller number"))
}

/// Rejects the first misplaced attribute of one declaration. `attributes` is a range of token indices, which ends at
/// the keyword of the declaration.
fn placed(tokens: &Tokens<'_>, module: &Module, attributes: Range<usize>) -> Result<(), Rejection> {
    let keyword = tokens.word(attributes.end);
    let is_attribute = |at: &usize| tokens.word(*at) == "@";
    let names: Vec<usize> = attributes.filter(is_attribute).map(|at| at + 1).collect();
    let has = |name: &str| names.iter().any(|at| tokens.word(*at) == name);
    for at in &names {
        let name = tokens.word(*at);
        let place = Span::from(tokens.ranges[*at].clone());
        let belongs = PLACES.iter().find(|(attribute, _)| *attribute == name);
        if let Some((_, belongs)) = belongs.filter(|(_, belongs)| *belongs != keyword) {
            let message = format!("\"@{name}\" does not belong before \"{keyword}\"");
            let help = format!("it stands before \"{belongs}\"; remove it here");
            return Err(Rejection::new(codes::WGSL_SYNTAX, message, place).help(help));
        }
        if name == "diagnostic" {
            diagnostic(tokens, *at)?;
        }
        if name == "workgroup_size" {
            if !has("compute") {
                let message = "\"@workgroup_size\" belongs to compute entry points alone";
                let help = "add \"@compute\", or remove it";
                return Err(Rejection::new(codes::WGSL_SYNTAX, message, place).help(help));
            }
            let end = tokens.closing(at + 1);
            let kind = |kind| (*at + 2..end).any(|at| kind_of(tokens.word(at), module) == Some(kind));
            if kind(ScalarKind::Sint) && kind(ScalarKind::Uint) {
                let message = "the sizes of a workgroup are of the types i32 and u32";
                let help = "write all of them with one suffix, or with none";
                return Err(Rejection::new(codes::WGSL_INVALID, message, place).help(help));
            }
        }
    }
    Ok(())
}

/// Rejects a reserved word as the name of a diagnostic rule. `at` is the token index of the word `diagnostic`.
fn diagnostic(tokens: &Tokens<'_>, at: usize) -> Result<(), Rejection> {
    let name = tokens.word(at + 4);
    if !RESERVED.contains(&name) {
        return Ok(());
    }
    let place = Span::from(tokens.ranges[at + 4].clone());
    let message = format!("\"{name}\" is no name of a diagnostic rule");
    let help = "name the rule, as \"derivative_uniformity\"";
    Err(Rejection::new(codes::WGSL_SYNTAX, message, place).help(help))
}

/// Rejects `@size` and `@align` values of structure members that are too small for booleans, which naga counts as one
/// byte. `open` is the token index of the opening brace.
fn members(tokens: &Tokens<'_>, open: usize) -> Result<(), Rejection> {
    let end = tokens.closing(open);
    let mut at = open + 1;
    while at < end {
        let name = tokens.after_attributes(at);
        let ty = name + 2;
        let next = tokens.after_member(ty, end);
        if let Some((size, alignment)) = layout_of_booleans(tokens, ty..next) {
            for attribute in (at..name).filter(|at| tokens.word(*at) == "@").map(|at| at + 1) {
                let Ok(given) = tokens.word(attribute + 2).trim_end_matches(['u', 'i']).parse::<u64>() else {
                    continue;
                };
                let least = match tokens.word(attribute) {
                    "size" => size,
                    "align" => alignment,
                    _ => continue,
                };
                if given < least {
                    let what = tokens.word(attribute);
                    let message = format!("\"@{what}({given})\" is less than the {least} bytes of the type");
                    let place = Span::from(tokens.ranges[attribute].clone());
                    let help = "a boolean takes as much as an \"u32\"";
                    return Err(Rejection::new(codes::WGSL_INVALID, message, place).help(help));
                }
            }
        }
        at = next + 1;
    }
    Ok(())
}

/// The size and the alignment in bytes of a boolean, or of a vector or array of booleans; `None` for other types.
fn layout_of_booleans(tokens: &Tokens<'_>, ty: Range<usize>) -> Option<(u64, u64)> {
    match tokens.word(ty.start) {
        "bool" => Some((4, 4)),
        "vec2" if tokens.word(ty.start + 2) == "bool" => Some((8, 8)),
        "vec3" if tokens.word(ty.start + 2) == "bool" => Some((12, 16)),
        "vec4" if tokens.word(ty.start + 2) == "bool" => Some((16, 16)),
        "array" if ty.len() > 5 => {
            let (size, alignment) = layout_of_booleans(tokens, ty.start + 2..ty.end)?;
            let count: u64 = tokens.word(ty.end - 2).trim_end_matches(['u', 'i']).parse().ok()?;
            Some((size.next_multiple_of(alignment).saturating_mul(count), alignment))
        }
        _ => None,
    }
}

/// The scalar kind of a literal, or of a module-scope constant or override with this name; `None` if unknown.
pub(super) fn kind_of(word: &str, module: &Module) -> Option<ScalarKind> {
    if word.starts_with(|first: char| first.is_ascii_digit()) {
        return match word.chars().next_back()? {
            'u' => Some(ScalarKind::Uint),
            'i' => Some(ScalarKind::Sint),
            'f' | 'h' if !word.starts_with("0x") => Some(ScalarKind::Float),
            _ if !word.starts_with("0x") && word.contains(['e', 'E']) => Some(ScalarKind::Float),
            _ => None,
        };
    }
    if word == "true" || word == "false" {
        return Some(ScalarKind::Bool);
    }
    let constants = module.constants.iter().map(|(_, constant)| (&constant.name, constant.ty));
    let overrides = module.overrides.iter().map(|(_, constant)| (&constant.name, constant.ty));
    let (_, ty) = constants.chain(overrides).find(|(name, _)| name.as_deref() == Some(word))?;
    match module.types[ty].inner {
        TypeInner::Scalar(scalar) => Some(scalar.kind),
        _ => None,
    }
}
