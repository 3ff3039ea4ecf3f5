//! Finds the override values that make a module fail, and the expression that fails.
//!
//! naga reports neither: an error that comes from override values has no place. Both are found by trial. Each value of
//! a failing set is replaced by a value that passes, if the module still fails then; the remaining values are an
//! inclusion-minimal cause. The expression is found by bisection: every arithmetic expression from some place on is
//! replaced by its first operand. The last place at which the module passes is the first expression that fails. The
//! number of trials is logarithmic in the number of expressions.
//!
//! Limit: a failure that is neither arithmetic nor an index nor a workgroup size is placed at the declaration of the
//! override that causes it.

use std::ops::Range;

use naga::back::PipelineConstants;
use naga::back::pipeline_constants::{PipelineConstantError, process_overrides};
use naga::valid::ModuleInfo;
use naga::{Arena, BinaryOperator, Expression, Handle, Module, ShaderStage, Span, UnaryOperator};

use super::overrides::Set;
use crate::axes::Axes;
use crate::module::wgsl;
use crate::variant::compile;
use crate::written::rejection::{Rejection, Scope};
use crate::written::stages;
use umbragraph_text::diagnostic::AxisValues;

/// Completes a rejection with the override values that cause it, and with the byte range of the failing WGSL. `at` is
/// the index in `sets` of the failing override values.
pub(super) fn blame(
    text: &str,
    (module, info): (&Module, &ModuleInfo),
    axes: &Axes,
    (sets, at): (&[Set], usize),
    rejection: Rejection,
) -> Rejection {
    let Some(set) = sets.get(at) else { return rejection };
    let fails = |values: &AxisValues| {
        let constants = compile::constants(axes, values, module);
        let resolved = constants.and_then(|set| wgsl::resolve_overrides(module, info, &set).map(drop));
        resolved.is_err_and(|other| other.message == rejection.message)
    };
    let overrides = provoking(sets, at, &fails);
    let found = || Ok(place(text, module, info, &set.constants));
    let range = rejection.range.clone().or_else(|| wgsl::guarded(found).ok().flatten());
    if range.is_some() {
        return Rejection { range, overrides, ..rejection };
    }
    let declared = || {
        let mut declared = module.overrides.iter();
        let first = overrides.keys().next()?;
        let (handle, _) = declared.find(|(_, each)| each.name.as_deref() == Some(first.as_str()))?;
        module.overrides.get_span(handle).to_range()
    };
    Rejection { range: declared(), overrides, scope: Scope::Text, ..rejection }
}

/// Returns a minimal subset of the override values of set `at` that makes `fails` return `true`, with all other
/// overrides as in a passing set. Empty if every set fails.
pub(super) fn provoking(sets: &[Set], at: usize, fails: &dyn Fn(&AxisValues) -> bool) -> AxisValues {
    let (Some(failing), Some(passing)) = (sets.get(at), sets.iter().find(|set| !fails(&set.values))) else {
        return AxisValues::new();
    };
    let mut values = failing.values.clone();
    let mut needed = AxisValues::new();
    for (name, other) in &passing.values {
        let Some(own) = values.insert(name.clone(), other.clone()).filter(|own| own != other) else {
            continue;
        };
        if !fails(&values) {
            values.insert(name.clone(), own.clone());
            needed.insert(name.clone(), own);
        }
    }
    needed
}

fn place(
    text: &str,
    module: &Module,
    info: &ModuleInfo,
    constants: &PipelineConstants,
) -> Option<Range<usize>> {
    let error = |module: &Module, entry_point: Option<(ShaderStage, &str)>| {
        process_overrides(module, info, entry_point, constants).err()
    };
    match error(module, None)? {
        PipelineConstantError::NegativeWorkgroupSize => {
            let mut sized =
                module.entry_points.iter().filter(|entry| entry.workgroup_size_overrides.is_some());
            let entry = sized.find(|entry| {
                let found = error(module, Some((entry.stage, &entry.name)));
                matches!(found, Some(PipelineConstantError::NegativeWorkgroupSize))
            })?;
            stages::workgroup_size(text, &entry.name)
        }
        PipelineConstantError::ConstantEvaluatorError(_) => {
            let fails = |module: &Module| {
                matches!(error(module, None), Some(PipelineConstantError::ConstantEvaluatorError(_)))
            };
            first_failing(module, &fails)?.to_range()
        }
        _ => None,
    }
}

/// Iterates over the expression arenas of a module: its global expressions, then its functions', then its entry
/// points'.
fn arenas(module: &mut Module) -> impl Iterator<Item = &mut Arena<Expression>> {
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let functions = functions.chain(module.entry_points.iter_mut().map(|entry| &mut entry.function));
    std::iter::once(&mut module.global_expressions).chain(functions.map(|each| &mut each.expressions))
}

fn first_failing(module: &Module, fails: &dyn Fn(&Module) -> bool) -> Option<Span> {
    // What each expression is replaced by, with its place among all of the module.
    let mut suspects: Vec<(usize, Handle<Expression>, Expression, Span)> = Vec::new();
    for (home, arena) in arenas(&mut module.clone()).enumerate() {
        suspects.extend(arena.iter().filter_map(|(handle, each)| {
            Some((home, handle, shorter(arena, each)?, arena.get_span(handle)))
        }));
    }
    let passes_from = |first: usize| {
        let mut cut = module.clone();
        for (home, arena) in arenas(&mut cut).enumerate() {
            let here = suspects.iter().skip(first).filter(|(known, ..)| *known == home);
            here.for_each(|(_, handle, shorter, _)| arena[*handle] = shorter.clone());
        }
        !fails(&cut)
    };
    if !passes_from(0) {
        return None;
    }
    // It passes with everything from `low` on cut short, and fails where the cut begins at `high`.
    let (mut low, mut high) = (0, suspects.len());
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if passes_from(middle) { low = middle } else { high = middle }
    }
    suspects.get(low).map(|(.., span)| *span)
}

/// Returns a simpler expression of the same type, such as the first operand, to find a failing expression by bisection.
/// `None` for expressions that are never replaced.
fn shorter(arena: &Arena<Expression>, expression: &Expression) -> Option<Expression> {
    use BinaryOperator as B;
    match expression {
        Expression::Binary {
            op: B::Add | B::Subtract | B::Multiply | B::Divide | B::Modulo | B::ShiftLeft | B::ShiftRight,
            left,
            ..
        } => Some(arena[*left].clone()),
        Expression::Unary { op: UnaryOperator::Negate, expr } => Some(arena[*expr].clone()),
        Expression::Math { arg, .. } => Some(arena[*arg].clone()),
        Expression::Access { base, .. } => Some(Expression::AccessIndex { base: *base, index: 0 }),
        _ => None,
    }
}
