//! The values with which the overrides of a module are tried.
//!
//! A module with overrides becomes another one with every set of values, and each may fail: a size of zero, an
//! overflow. All sets cannot be tried; all defaults, all minimums and all maximums are. Most overrides only choose
//! between branches: they are compared, negated, and decide an `if`. Then no value can make a difference to the
//! compiler, which evaluates the comparison and keeps both branches, and the defaults stand for all sets.
//! [`values_matter`] says so only where it can see every use.

use std::collections::BTreeMap;

use naga::back::PipelineConstants;
use naga::{Arena, ArraySize, BinaryOperator, Expression, Module, TypeInner, UnaryOperator};

use crate::axes::{Axes, AxisKind, AxisMode};
use crate::variant::compile;
use crate::written::ir;
use crate::written::rejection::Rejection;
use umbragraph_text::diagnostic::{AxisValue, AxisValues};

/// One value for each override axis, and the same values as pipeline constants of the module.
pub(super) struct Set {
    pub(super) values: AxisValues,
    pub(super) constants: PipelineConstants,
}

/// Returns the distinct sets of constants to try, the defaults first. Only the defaults remain if values cannot affect
/// validity.
///
/// # Errors
/// A rejection if the type of an override does not fit its axis.
pub(super) fn sets(axes: &Axes, values: &[AxisValues], module: &Module) -> Result<Vec<Set>, Rejection> {
    let mut sets: Vec<Set> = Vec::new();
    for values in values {
        let constants = compile::constants(axes, values, module)?;
        if sets.iter().all(|set| set.constants != constants) {
            sets.push(Set { values: values.clone(), constants });
        }
    }
    if sets.len() > 1 && !values_matter(module) {
        sets.truncate(1);
    }
    Ok(sets)
}

/// Returns three sets of override values: all defaults, all minimums, all maximums. If there are no override axes,
/// returns one empty set.
pub(super) fn values(axes: &Axes) -> Vec<AxisValues> {
    let overrides: Vec<_> = axes.iter().filter(|axis| axis.mode == AxisMode::Override).collect();
    let defaults: AxisValues =
        overrides.iter().map(|axis| (axis.name.clone(), axis.default.clone())).collect();
    if overrides.is_empty() {
        return vec![defaults];
    }
    let ends = |is_max: bool| -> AxisValues {
        overrides
            .iter()
            .map(|axis| {
                let value = match axis.kind {
                    AxisKind::Integer { min, max } => AxisValue::Integer(if is_max { max } else { min }),
                    _ => AxisValue::Bool(is_max),
                };
                (axis.name.clone(), value)
            })
            .collect()
    };
    vec![defaults, ends(false), ends(true)]
}

/// For each override axis, a string that identifies its tried values; validation results for the override depend on it.
pub(super) fn by_name(axes: &Axes) -> BTreeMap<&str, String> {
    let overrides = axes.iter().filter(|axis| axis.mode == AxisMode::Override);
    overrides.map(|axis| (axis.name.as_str(), format!("{:?} {:?}", axis.kind, axis.default))).collect()
}

/// Returns `true` if the module may be valid with some override values and invalid with others.
fn values_matter(module: &Module) -> bool {
    let sized = module.types.iter().any(|(_, ty)| {
        matches!(
            ty.inner,
            TypeInner::Array { size: ArraySize::Pending(_), .. }
                | TypeInner::BindingArray { size: ArraySize::Pending(_), .. }
        )
    });
    let mut entry_points = module.entry_points.iter();
    let dispatched =
        entry_points.any(|entry| entry.workgroup_size_overrides.is_some() || entry.mesh_info.is_some());
    // Initial values of variables and of other overrides.
    let initial = module.global_expressions.iter().any(|(_, each)| matches!(each, Expression::Override(_)));
    sized || dispatched || initial || ir::functions(module).any(|each| evaluates(&each.expressions))
}

/// Returns `true` if an expression computed from overrides may fail.
fn evaluates(expressions: &Arena<Expression>) -> bool {
    if !expressions.iter().any(|(_, each)| matches!(each, Expression::Override(_))) {
        return false;
    }
    // Whether each expression is made of overrides; operands stand before what they are operands of.
    let mut made: Vec<bool> = Vec::with_capacity(expressions.len());
    for (_, expression) in expressions.iter() {
        let is_made = match expression {
            Expression::Override(_) => true,
            _ => match ir::operands(expression) {
                Some(mut all) => all.any(|one| made.get(one.index()).copied().unwrap_or(true)),
                None => return true,
            },
        };
        let harmless = match expression {
            Expression::Override(_) | Expression::Unary { op: UnaryOperator::LogicalNot, .. } => true,
            Expression::Binary { op, .. } => compares(*op),
            _ => false,
        };
        if is_made && !harmless {
            return true;
        }
        made.push(is_made);
    }
    false
}

fn compares(operator: BinaryOperator) -> bool {
    use BinaryOperator as B;
    matches!(
        operator,
        B::Equal
            | B::NotEqual
            | B::Less
            | B::LessEqual
            | B::Greater
            | B::GreaterEqual
            | B::LogicalAnd
            | B::LogicalOr
    )
}

#[cfg(test)]
mod tests {
    use super::values_matter;

    fn matter(body: &str) -> bool {
        let text = format!("override n: u32 = 1u;\noverride b: bool = true;\n{body}\n");
        values_matter(&naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{error}: {text}")))
    }

    #[test]
    fn what_only_chooses_a_branch_does_not_matter() {
        for body in [
            "fn f() -> u32 { return n; }",
            "fn f(x: u32) -> u32 { if n == 2u && !b { return x / 2u; } return x; }",
            "fn f() -> u32 { var sum = 0u; for (var i = 0u; i < n; i++) { sum += i; } return sum; }",
        ] {
            assert!(!matter(body), "{body}");
        }
    }

    #[test]
    fn what_is_computed_or_sized_matters() {
        for body in [
            "fn f() -> u32 { return n * n; }",
            "fn f(x: u32) -> u32 { return x / n; }",
            "fn f(x: u32) -> u32 { return x % n; }",
            "fn f(x: u32) -> u32 { return x << n; }",
            "fn f(x: array<f32, 4>) -> f32 { return x[n]; }",
            "fn f() -> f32 { return 1.0 / f32(n); }",
            "fn f() -> vec2<u32> { return vec2<u32>(n); }",
            "fn f() -> u32 { return select(1u, 2u, b); }",
            "override m: u32 = n - 1u;",
            "var<private> p: u32 = n;",
            "var<workgroup> shared_values: array<u32, n>;",
            "@compute @workgroup_size(n) fn main() {}",
        ] {
            assert!(matter(body), "{body}");
        }
    }
}
