//! Rules about what a text spells and naga's form of it no longer tells.
//!
//! | text | in naga's form |
//! |---|---|
//! | `s[0]` of a structure | `s.first` |
//! | `bitcast<vec2<f32>>(x)` of one `u32` | a bit cast to `f32`, with as many components as `x` |
//! | `counter = 1u` of an atomic | `atomicStore(&counter, 1u)` |
//! | `textureGather(0, depth, …)` | `textureGather(depth, …)` |
//! | `let r = 3000000000` | `let r = 3000000000u` |
//!
//! For each of them, this pass finds the expression in naga's form and looks at the text that it was made from.

use std::collections::HashSet;
use std::ops::Range;

use naga::front::Typifier;
use naga::proc::ResolveContext;
use naga::{
    Expression, Function, Handle, ImageClass, Literal, MathFunction, Module, ScalarKind, Span, Statement,
    TypeInner,
};

use super::types::{self, Parts};
use super::untyped::{self, is_untyped};
use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;
use crate::written::tokens::{Tokens, is_name};

/// Rejects the first expression of a module that naga interprets differently from the WGSL specification.
pub(crate) fn check(tokens: &Tokens<'_>, module: &Module) -> Result<(), Rejection> {
    (0..tokens.ranges.len()).try_for_each(|at| shift(tokens, at))?;
    let constants = untyped::constants(tokens);
    let (untyped, parts) = (untyped::values(tokens, &constants), types::parts(module));
    for (handle, variable) in module.global_variables.iter() {
        let place = module.global_variables.get_span(handle);
        // Without a type, numbers are of the type i32; naga takes u32 for those that it does not hold.
        let is_unsigned = module.types[variable.ty].inner.scalar_kind() == Some(ScalarKind::Uint);
        let holds = |value: &Range<usize>| {
            place.to_range().is_some_and(|place| place.start <= value.start && value.start <= place.end + 3)
        };
        if is_unsigned && variable.init.is_some() && untyped.iter().any(holds) {
            return Err(reject(WITHOUT_SUFFIX.0, WITHOUT_SUFFIX.1, place));
        }
    }
    let names = untyped::names(tokens, &constants);
    ir::functions(module).try_for_each(|function| {
        if let Some(place) = untyped::beyond(&names, module, function) {
            return Err(reject(WITHOUT_SUFFIX.0, WITHOUT_SUFFIX.1, place));
        }
        Check { tokens, module, function, parts: &parts, constants: &constants }.check(&untyped)
    })
}

/// The message and the help text for a number without a suffix that exceeds the range of `i32`.
const WITHOUT_SUFFIX: (&str, &str) =
    ("a number without a suffix is an i32, which does not hold this", "add the suffix \"u\"");

/// Returns `true` if a span of the WGSL is inside one of several byte ranges.
fn is_within(ranges: &[Range<usize>], place: Span) -> bool {
    let is_in =
        |place: &Range<usize>, range: &Range<usize>| range.start <= place.start && place.end <= range.end;
    place.to_range().is_some_and(|place| ranges.iter().any(|range| is_in(&place, range)))
}

struct Check<'a> {
    tokens: &'a Tokens<'a>,
    module: &'a Module,
    function: &'a Function,
    parts: &'a [Parts],
    constants: &'a HashSet<&'a str>,
}

impl<'a> Check<'a> {
    fn check(&self, untyped: &[Range<usize>]) -> Result<(), Rejection> {
        let expressions = &self.function.expressions;
        let mut types = Typifier::new();
        let locals = &self.function.local_variables;
        let context = ResolveContext::with_locals(self.module, locals, &self.function.arguments);
        let mut of = |handle: Handle<Expression>| {
            types.grow(handle, expressions, &context).ok()?;
            Some(types.get(handle, &self.module.types).clone())
        };
        for (handle, expression) in expressions.iter() {
            let found = match expression {
                Expression::AccessIndex { base, .. } if self.text(handle).ends_with(']') => {
                    let of_base = of(*base);
                    of_base
                        .is_some_and(|ty| self.is_structure(&ty))
                        .then_some(("a structure has members, and no elements", "write the member's name"))
                }
                Expression::As { expr, convert: None, .. } => {
                    let mut is_other = || self.bits_of_cast(handle).zip(of(*expr).and_then(|ty| bits(&ty)));
                    let is_large = || {
                        self.is_large(*expr)
                            && self.argument(handle).is_some_and(|first| {
                                (first..self.tokens.closing(first - 1))
                                    .all(|at| is_untyped(self.tokens, self.constants, at))
                            })
                    };
                    if !self.text(handle).starts_with("bitcast") {
                        None
                    } else if is_other().is_some_and(|(to, from)| to != from) {
                        Some(("a bit cast takes as many bits as it gives", "take a vector of the same size"))
                    } else if is_large() {
                        Some(WITHOUT_SUFFIX)
                    } else {
                        None
                    }
                }
                Expression::Math { fun: MathFunction::Sign, arg, .. } => {
                    let is_unsigned = of(*arg).and_then(|ty| ty.scalar_kind()) == Some(ScalarKind::Uint);
                    is_unsigned.then_some(("\"sign\" takes no unsigned numbers", "use \"min(value, 1u)\""))
                }
                Expression::ImageSample { image, gather: Some(_), .. } => {
                    let image = ir::image(self.module, self.function, *image);
                    let is_depth =
                        matches!(image, Some(TypeInner::Image { class: ImageClass::Depth { .. }, .. }));
                    let first = self.argument(handle).map_or("", |at| self.tokens.word(at));
                    (is_depth && first.starts_with(|first: char| first.is_ascii_digit())).then_some((
                        "depth has one component, so that none is chosen",
                        "leave the first argument out",
                    ))
                }
                Expression::Load { pointer } => {
                    let holds = of(*pointer).is_some_and(|ty| self.is_composite_with_atomics(&ty));
                    holds.then_some((
                        "what holds atomics is not read as a whole",
                        "use \"atomicLoad\" on each",
                    ))
                }
                Expression::ImageLoad { coordinate, array_index, sample, level, .. } => {
                    let used = [Some(*coordinate), *array_index, *sample, *level];
                    let is_large = used.into_iter().flatten().any(|used| self.is_large_without_suffix(used));
                    is_large.then_some((
                        "a number without a suffix is an i32, which does not hold this",
                        "no texture is so large",
                    ))
                }
                // naga chooses a float where no integer holds a number.
                Expression::Literal(Literal::F32(_)) => {
                    let is_integer = |range: &&Range<usize>| {
                        let text = self.tokens.text.get(range.start..range.end).unwrap_or_default();
                        !text.contains(|one: char| one == '.' || one.is_ascii_alphabetic())
                    };
                    let place = expressions.get_span(handle);
                    let mut ranges = untyped.iter().filter(is_integer);
                    ranges
                        .any(|range| is_within(std::slice::from_ref(range), place))
                        .then_some(WITHOUT_SUFFIX)
                }
                Expression::Literal(Literal::U32(value)) if *value > i32::MAX.cast_unsigned() => {
                    let place = expressions.get_span(handle).to_range();
                    let is_within = |range: &Range<usize>| {
                        place
                            .as_ref()
                            .is_some_and(|place| range.start <= place.start && place.end <= range.end)
                    };
                    untyped.iter().any(is_within).then_some(WITHOUT_SUFFIX)
                }
                _ => None,
            };
            if let Some((message, help)) = found {
                return Err(reject(message, help, expressions.get_span(handle)));
            }
        }
        self.stores(&mut of)
    }

    fn stores(&self, of: &mut impl FnMut(Handle<Expression>) -> Option<TypeInner>) -> Result<(), Rejection> {
        let mut blocks = vec![&self.function.body];
        while let Some(block) = blocks.pop() {
            for (statement, span) in block.span_iter() {
                blocks.extend(ir::blocks(statement));
                let Statement::Store { pointer, .. } = statement else { continue };
                let written =
                    span.to_range().and_then(|range| self.tokens.text.get(range)).unwrap_or_default();
                if !written.starts_with("atomicStore") && of(*pointer).is_some_and(|ty| self.is_atomic(&ty)) {
                    let help = "use \"atomicStore(&counter, value)\"";
                    return Err(reject("an atomic is not assigned to", help, *span));
                }
            }
        }
        Ok(())
    }

    fn text(&self, handle: Handle<Expression>) -> &'a str {
        let range = self.function.expressions.get_span(handle).to_range();
        range.and_then(|range| self.tokens.text.get(range)).unwrap_or_default()
    }

    /// Returns `true` if a literal, or a component of a vector of literals, exceeds the range of `i32`.
    fn is_large(&self, handle: Handle<Expression>) -> bool {
        match &self.function.expressions[handle] {
            Expression::Literal(Literal::U32(value)) => *value > i32::MAX.cast_unsigned(),
            Expression::Splat { value, .. } => self.is_large(*value),
            Expression::Compose { components, .. } => components.iter().any(|one| self.is_large(*one)),
            _ => false,
        }
    }

    /// Returns `true` if a literal without a suffix, or a component of a vector of such literals, exceeds the range of
    /// `i32`.
    fn is_large_without_suffix(&self, handle: Handle<Expression>) -> bool {
        match &self.function.expressions[handle] {
            Expression::Literal(Literal::U32(value)) => {
                *value > i32::MAX.cast_unsigned()
                    && self.text(handle).ends_with(|last: char| last.is_ascii_digit())
            }
            Expression::Compose { components, .. } => {
                components.iter().any(|component| self.is_large_without_suffix(*component))
            }
            _ => false,
        }
    }

    /// The index of the first token in a call's argument list; `None` if the expression is no call.
    fn argument(&self, handle: Handle<Expression>) -> Option<usize> {
        let range = self.function.expressions.get_span(handle).to_range()?;
        let call = self.tokens.ranges.partition_point(|token| token.start < range.start);
        let next = self.tokens.word(call + 1);
        let open = if next == "<" {
            (call..self.tokens.ranges.len()).find(|at| self.tokens.word(*at) == "(")?
        } else {
            call + 1
        };
        (self.tokens.word(open) == "(").then_some(open + 1)
    }

    fn is_structure(&self, ty: &TypeInner) -> bool {
        match ty {
            TypeInner::Struct { .. } => true,
            TypeInner::Pointer { base, .. } => {
                matches!(self.module.types[*base].inner, TypeInner::Struct { .. })
            }
            _ => false,
        }
    }

    fn is_atomic(&self, pointer: &TypeInner) -> bool {
        matches!(pointer, TypeInner::Pointer { base, .. } if matches!(self.module.types[*base].inner, TypeInner::Atomic(_)))
    }

    fn is_composite_with_atomics(&self, pointer: &TypeInner) -> bool {
        let TypeInner::Pointer { base, .. } = pointer else { return false };
        let has_atomics = self.parts.get(base.index()).is_some_and(|parts| parts.has_atomics);
        has_atomics && !self.is_atomic(pointer)
    }

    /// The size in bits of the target type of a bit cast; `None` if the type is not recognized.
    fn bits_of_cast(&self, handle: Handle<Expression>) -> Option<u32> {
        let range = self.function.expressions.get_span(handle).to_range()?;
        let first = self.tokens.ranges.partition_point(|token| token.start < range.start);
        let mut at = first + 2;
        // An alias stands for another name, at most for so many others.
        for _ in 0..64 {
            let (name, next) = (self.tokens.word(at), self.tokens.word(at + 1));
            let scalar = if next == "<" { self.tokens.word(at + 2) } else { name };
            let width = if scalar.ends_with("16") || scalar.ends_with('h') { 16 } else { 32 };
            if let Some(size) = name.strip_prefix("vec").and_then(|rest| rest.get(..1)?.parse::<u32>().ok()) {
                return Some(size * width);
            }
            if ["f32", "i32", "u32", "f16"].contains(&name) {
                return Some(width);
            }
            let is_alias = |at: &usize| self.tokens.word(*at) == "alias" && self.tokens.word(at + 1) == name;
            at = (0..self.tokens.ranges.len()).find(is_alias)? + 3;
        }
        None
    }
}

fn bits(ty: &TypeInner) -> Option<u32> {
    match ty {
        TypeInner::Scalar(scalar) => Some(u32::from(scalar.width) * 8),
        TypeInner::Vector { size, scalar } => Some(*size as u32 * u32::from(scalar.width) * 8),
        _ => None,
    }
}

fn reject(message: &str, help: &str, place: Span) -> Rejection {
    Rejection::new(codes::WGSL_INVALID, message, place).help(help)
}

/// Rejects a left shift of two numbers without suffixes whose result exceeds all integer types; naga drops the excess
/// bits. `at` is the token index of the operator.
fn shift(tokens: &Tokens<'_>, at: usize) -> Result<(), Rejection> {
    if tokens.word(at) != "<<" || at < 3 {
        return Ok(());
    }
    let is_whole = match (tokens.word(at - 2), tokens.word(at + 2)) {
        ("=", ";") => tokens.word(at.saturating_sub(4)) != "const",
        (",", ",") => true,
        ("(", ")") => is_name(tokens.word(at - 3)) || tokens.word(at - 3) == ">",
        _ => false,
    };
    let number = |at: usize| tokens.word(at).parse::<u64>().ok();
    let value = number(at - 1).zip(number(at + 1)).filter(|(_, by)| *by < 64);
    let is_large = value.is_some_and(|(value, by)| u128::from(value) << by > u128::from(u32::MAX));
    if is_whole && is_large {
        let place = Span::from(tokens.ranges[at].clone());
        return Err(reject("the shift gives a number that no integer holds", "shift by less", place));
    }
    Ok(())
}
