//! Vectors of constants that have a vector without arguments in them, such as `vec4f(vec2f(), 3, 4)`.
//!
//! WGSL allows them. naga 30 does not take the empty vector apart: an index counts it as one component, so that
//! `vec4f(vec2f(), 3, 4)[1]` is 3 instead of 0, and the SPIR-V that it writes has too few components, which loses the
//! device on some drivers. Of a part that is taken at once, as here, naga keeps no trace: `written::constructors` rejects
//! it. Source: <https://github.com/gfx-rs/wgpu/pull/9940>.

use naga::{Arena, Expression, Handle, Module, TypeInner};

use crate::codes;
use crate::written::constructors::EMPTY_VECTOR;
use crate::written::ir;
use crate::written::rejection::Rejection;

/// Returns a rejection for each vector of constants with an empty vector in it.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    let functions = ir::functions(module).map(|function| &function.expressions);
    std::iter::once(&module.global_expressions)
        .chain(functions)
        .flat_map(|arena| in_arena(module, arena))
        .collect()
}

fn in_arena(module: &Module, arena: &Arena<Expression>) -> Vec<Rejection> {
    let is_mixed = |(handle, expression): (Handle<Expression>, &Expression)| {
        let Expression::Compose { ty, components } = expression else { return None };
        let is_vector = matches!(module.types[*ty].inner, TypeInner::Vector { .. });
        let has_empty = components.iter().any(|part| is_empty_vector(module, arena, *part));
        if !(is_vector && has_empty && is_constant(arena, handle)) {
            return None;
        }
        let (message, help) = EMPTY_VECTOR;
        Some(Rejection::new(codes::WGSL_INVALID, message.to_owned(), arena.get_span(handle)).help(help))
    };
    arena.iter().filter_map(is_mixed).collect()
}

fn is_empty_vector(module: &Module, arena: &Arena<Expression>, part: Handle<Expression>) -> bool {
    match arena[part] {
        Expression::ZeroValue(ty) => matches!(module.types[ty].inner, TypeInner::Vector { .. }),
        Expression::Constant(constant) => {
            is_empty_vector(module, &module.global_expressions, module.constants[constant].init)
        }
        _ => false,
    }
}

/// Returns `true` for literals and constants, and what is made of them alone.
fn is_constant(arena: &Arena<Expression>, handle: Handle<Expression>) -> bool {
    match &arena[handle] {
        Expression::Literal(_) | Expression::ZeroValue(_) | Expression::Constant(_) => true,
        Expression::Splat { value, .. } => is_constant(arena, *value),
        Expression::Compose { components, .. } => components.iter().all(|part| is_constant(arena, *part)),
        _ => false,
    }
}
