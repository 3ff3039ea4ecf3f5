//! What a plan keeps of live settings: expressions in which nothing is left but live parameters.

use serde::Serialize;

use crate::expression::{self, BinaryOperator, Expression, ExpressionKind, Scope, UnaryOperator, Value};
use crate::pipeline::{LiveSetting, Pipeline, with_names};
use crate::size::Sizes;
use crate::values::Packing;

/// What a plan says of a parameter.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct PlannedParameter {
    /// Whether it can change from frame to frame.
    pub live: bool,
    /// The setting that makes it structural, by its JSON pointer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub structural_at: Option<String>,
}

/// A live setting of a pass, as [`crate::pipeline::Pass::live`] has it at the same position.
#[derive(Clone, Debug)]
pub struct PlannedSetting {
    /// Over live parameters and what follows from them alone.
    pub(super) expression: Expression,
    /// The same for each element of a list.
    pub(super) elements: Vec<Expression>,
    pub(in super::super) bound: Bound,
}

/// What a plan holds the value of a live setting to.
#[derive(Clone, Debug)]
pub(in super::super) enum Bound {
    Free,
    /// A member of the block at a position of the pass's blocks.
    Member(usize, Packing),
    /// A count of workgroups, which is at most so large.
    Workgroups(u32),
    /// A count of a draw, and how many of what is counted a buffer has, with its name.
    Drawn(u64, String),
}

/// What a plan says of the parameters of a pipeline.
pub(in super::super) fn planned(pipeline: &Pipeline) -> std::collections::BTreeMap<String, PlannedParameter> {
    let of = |structural: &Option<crate::pipeline::Structural>| PlannedParameter {
        live: structural.is_none(),
        structural_at: structural.as_ref().map(|structural| structural.pointer.clone()),
    };
    pipeline.parameters.iter().map(|(name, one)| (name.clone(), of(&one.structural))).collect()
}

/// The live settings of a pass, in their order; none where no live parameter reaches one.
pub(in super::super) fn of_pass(sizes: &Sizes<'_>, all: &[LiveSetting]) -> Vec<PlannedSetting> {
    let is_live = |one: &LiveSetting| one.value.expression.names().iter().any(|name| sizes.is_live(name));
    let all = if all.iter().any(is_live) { all } else { &[] };
    all.iter().map(|setting| fold(sizes, setting)).collect()
}

fn fold(sizes: &Sizes<'_>, setting: &LiveSetting) -> PlannedSetting {
    let expression = folded(&setting.value.expression, sizes);
    let elements = match expression::evaluate(&expression, sizes) {
        Ok(Value::List(list)) => (0..list.len()).map(|at| element(&expression, at, sizes)).collect(),
        _ => None,
    };
    PlannedSetting { expression, elements: elements.unwrap_or_default(), bound: Bound::Free }
}

/// One element of what an expression yields, as an expression that computes no list; `None` where lists are nested. Of a
/// number, which stands for all elements, itself.
fn element(expression: &Expression, at: usize, scope: &dyn Scope) -> Option<Expression> {
    let inner = |one: &Expression| element(one, at, scope).map(Box::new);
    let range = expression.range.clone();
    let kind = match &expression.kind {
        ExpressionKind::Literal(Value::List(list)) => ExpressionKind::Literal(list.get(at)?.clone()),
        ExpressionKind::List(items) => {
            let item = items.get(at)?;
            if matches!(expression::evaluate(item, scope), Ok(Value::List(_)) | Err(_)) {
                return None;
            }
            return Some(item.clone());
        }
        ExpressionKind::Name(name) if matches!(scope.lookup(name), Some(Value::List(_))) => {
            let position = ExpressionKind::Literal(Value::Number(at as f64));
            let position = Expression { range: range.clone(), kind: position };
            ExpressionKind::Index(Box::new(expression.clone()), Box::new(position))
        }
        ExpressionKind::Unary(UnaryOperator::Negate, a) => {
            ExpressionKind::Unary(UnaryOperator::Negate, inner(a)?)
        }
        ExpressionKind::Binary(
            operator @ (BinaryOperator::Add
            | BinaryOperator::Subtract
            | BinaryOperator::Multiply
            | BinaryOperator::Divide
            | BinaryOperator::Remainder),
            a,
            b,
        ) => ExpressionKind::Binary(*operator, inner(a)?, inner(b)?),
        ExpressionKind::Conditional(condition, a, b) => {
            let length = |one: &Expression| match expression::evaluate(one, scope) {
                Ok(Value::List(list)) => Some(list.len()),
                _ => None,
            };
            if length(a) != length(b) {
                return None;
            }
            ExpressionKind::Conditional(condition.clone(), inner(a)?, inner(b)?)
        }
        ExpressionKind::Index(..)
            if matches!(expression::evaluate(expression, scope), Ok(Value::List(_)) | Err(_)) =>
        {
            return None;
        }
        ExpressionKind::Call(name, list) if !matches!(&**name, "min" | "max" | "len" | "mip_count") => {
            let list = list.iter().map(|one| element(one, at, scope)).collect::<Option<_>>()?;
            ExpressionKind::Call(name.clone(), list)
        }
        other => other.clone(),
    };
    Some(Expression { range, kind })
}

/// An expression in which values stand for the names of what does not change.
fn folded(expression: &Expression, sizes: &Sizes<'_>) -> Expression {
    with_names(expression, &|name| {
        let value = if sizes.is_live(name) { None } else { sizes.lookup(name) };
        value.map_or_else(|| ExpressionKind::Name(name.to_owned()), ExpressionKind::Literal)
    })
}
