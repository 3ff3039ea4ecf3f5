//! The number of times that a loop runs at most, where its bounds are known: a variable that starts at a constant, is
//! compared with one, and grows by one.
//!
//! Limits: a variable that the body writes or hands to a function is not followed, nor is one whose start depends on
//! control flow.

use std::collections::HashMap;

use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, MathFunction, Module,
    Statement,
};

use crate::written::ir;

/// The integer constant that each local variable currently holds; `None` for a variable with an unknown value.
pub(super) type Known = HashMap<Handle<LocalVariable>, Option<i64>>;

/// The integer constant with which a local variable is initialized; `None` if its initial value is not constant.
pub(super) fn initial(module: &Module, function: &Function, variable: Handle<LocalVariable>) -> Option<i64> {
    match function.local_variables[variable].init {
        Some(init) => constant(module, function, init),
        // A variable without a value is zero.
        None => Some(0),
    }
}

/// An upper bound of an integer expression: its constant value, or a constant argument of `min`. `None` if unknown.
fn at_most(module: &Module, function: &Function, at: Handle<Expression>) -> Option<i64> {
    match function.expressions[at] {
        Expression::Math { fun: MathFunction::Min, arg, arg1: Some(other), .. } => {
            let sides = [arg, other].map(|side| at_most(module, function, side));
            sides.into_iter().flatten().min()
        }
        _ => constant(module, function, at),
    }
}

/// The value of an integer expression; `None` if it is not constant. Overrides have their default values.
pub(super) fn constant(module: &Module, function: &Function, at: Handle<Expression>) -> Option<i64> {
    let global = |init| match module.global_expressions[init] {
        Expression::Literal(literal) => integer(literal),
        _ => None,
    };
    match &function.expressions[at] {
        Expression::Literal(literal) => integer(*literal),
        Expression::Constant(constant) => global(module.constants[*constant].init),
        Expression::Override(value) => global(module.overrides[*value].init?),
        Expression::ZeroValue(_) => Some(0),
        // A value that both types have; another one changes.
        Expression::As { expr, .. } => {
            constant(module, function, *expr).filter(|value| (0..=i64::from(i32::MAX)).contains(value))
        }
        _ => None,
    }
}

fn integer(literal: Literal) -> Option<i64> {
    match literal {
        Literal::U32(value) => Some(value.into()),
        Literal::I32(value) => Some(value.into()),
        Literal::I64(value) | Literal::AbstractInt(value) => Some(value),
        Literal::U64(value) => value.try_into().ok(),
        _ => None,
    }
}

/// Returns the maximum number of iterations of a loop; `None` if unknown.
pub(super) fn trips(
    module: &Module,
    function: &Function,
    (body, continuing): (&Block, &Block),
    known: &Known,
) -> Option<u64> {
    // `for` and `while` begin with a condition whose other side leaves.
    let leaves = |block: &Block| matches!(block.last(), Some(Statement::Break));
    let first = body.iter().find(|statement| !matches!(statement, Statement::Emit(_)))?;
    let condition = match first {
        Statement::If { condition, accept, reject } if accept.is_empty() && leaves(reject) => *condition,
        _ => return None,
    };
    let Expression::Binary { op, left, right } = function.expressions[condition] else { return None };
    let variable = |at: Handle<Expression>| match function.expressions[at] {
        Expression::Load { pointer } => match function.expressions[pointer] {
            Expression::LocalVariable(variable) => Some(variable),
            _ => None,
        },
        _ => None,
    };
    use BinaryOperator::{Greater, GreaterEqual, Less, LessEqual};
    let (counter, bound, op) = match (variable(left), variable(right)) {
        (Some(counter), None) => (counter, right, op),
        (None, Some(counter)) => {
            let turned = match op {
                Less => Greater,
                LessEqual => GreaterEqual,
                Greater => Less,
                GreaterEqual => LessEqual,
                other => other,
            };
            (counter, left, turned)
        }
        _ => return None,
    };
    let is_upward = matches!(op, Less | LessEqual);
    let bound = if is_upward { at_most(module, function, bound) } else { constant(module, function, bound) };
    let (start, bound) = (known.get(&counter).copied()??, bound?);
    let step = |statement: &Statement| {
        let Statement::Store { pointer, value } = *statement else { return None };
        let is_it = matches!(function.expressions[pointer], Expression::LocalVariable(own) if own == counter);
        let Expression::Binary { op, left, right } = function.expressions[value] else { return None };
        let by = constant(module, function, right).filter(|_| is_it && variable(left) == Some(counter))?;
        match op {
            BinaryOperator::Add => Some(by),
            BinaryOperator::Subtract => Some(-by),
            _ => None,
        }
    };
    let step = continuing.iter().find_map(step)?;
    if writes(function, body, counter) || count(function, continuing, counter) != 1 {
        return None;
    }
    let (distance, step) = match op {
        Less if step > 0 => (bound.checked_sub(start)?, step),
        LessEqual if step > 0 => (bound.checked_sub(start)?.checked_add(1)?, step),
        Greater if step < 0 => (start.checked_sub(bound)?, -step),
        GreaterEqual if step < 0 => (start.checked_sub(bound)?.checked_add(1)?, -step),
        _ => return None,
    };
    u64::try_from(distance.max(0)).ok().map(|distance| distance.div_ceil(step.unsigned_abs()))
}

/// Returns `true` if a block may write a local variable.
pub(super) fn writes(function: &Function, block: &Block, variable: Handle<LocalVariable>) -> bool {
    count(function, block, variable) > 0
}

/// Counts the statements in a block, including nested blocks, that may write a local variable.
fn count(function: &Function, block: &Block, variable: Handle<LocalVariable>) -> usize {
    let is_it = |at: &Handle<Expression>| matches!(function.expressions[ir::base(function, *at)], Expression::LocalVariable(own) if own == variable);
    let of = |statement: &Statement| {
        let own = match statement {
            Statement::Store { pointer, .. } => is_it(pointer),
            Statement::Call { arguments, .. } => arguments.iter().any(is_it),
            _ => false,
        };
        usize::from(own) + ir::blocks(statement).map(|inner| count(function, inner, variable)).sum::<usize>()
    };
    block.iter().map(of).sum()
}
