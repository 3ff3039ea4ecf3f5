//! What a plan keeps of live settings: expressions in which nothing is left but live parameters.

use serde::Serialize;

use crate::expression::{self, BinaryOperator, Expression, ExpressionKind, Scope, UnaryOperator, Value};
use crate::pipeline::{LiveSetting, LiveTarget, Pipeline, with_names};
use crate::shader::{Member, TypeLayout};
use crate::size::Sizes;
use crate::source::Span;
use crate::work::{BlockValues, Deferred};

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

/// A live setting of a pass.
#[derive(Clone, Debug)]
pub struct PlannedSetting {
    /// What it sets.
    pub(super) target: PlannedTarget,
    /// Over live parameters and what follows from them alone.
    pub(super) expression: Expression,
    /// The same for each element of a list.
    pub(super) elements: Vec<Expression>,
    pub(super) place: Span,
    pub(super) pointer: String,
}

#[derive(Clone, Debug)]
pub(super) enum PlannedTarget {
    /// A member of the block at a position of the pass's blocks.
    Member(usize, Member),
    /// One of the three counts of a dispatch, which is at most so large.
    Workgroups(usize, u32),
    /// A setting of the CPU node.
    Node,
    /// A count of a draw from buffers, and how many of what is counted a buffer has, with its name.
    Drawn(LiveTarget, Option<(u64, String)>),
    /// Something else.
    Other(LiveTarget),
}

/// What a plan says of the parameters of a pipeline.
pub(in super::super) fn planned(pipeline: &Pipeline) -> std::collections::BTreeMap<String, PlannedParameter> {
    let of = |structural: &Option<crate::pipeline::Structural>| PlannedParameter {
        live: structural.is_none(),
        structural_at: structural.as_ref().map(|structural| structural.pointer.clone()),
    };
    pipeline.parameters.iter().map(|(name, one)| (name.clone(), of(&one.structural))).collect()
}

/// Adds the live settings among the members of a block.
pub(in super::super) fn of_block(
    sizes: &Sizes<'_>,
    position: usize,
    block: &BlockValues,
    settings: &mut Vec<PlannedSetting>,
) {
    let TypeLayout::Struct { members, .. } = &block.layout else { return };
    for (name, deferred) in &block.expressions {
        let Some(member) = members.iter().find(|member| member.name == *name) else { continue };
        settings.extend(live(sizes, deferred, || PlannedTarget::Member(position, member.clone())));
    }
}

/// Adds the live counts of a dispatch.
pub(in super::super) fn of_dispatch(
    sizes: &Sizes<'_>,
    counts: &[Deferred; 3],
    limit: u32,
    settings: &mut Vec<PlannedSetting>,
) {
    for (axis, deferred) in counts.iter().enumerate() {
        settings.extend(live(sizes, deferred, || PlannedTarget::Workgroups(axis, limit)));
    }
}

/// Adds what a pass says is live; `most` is how many of what a draw counts its buffers have.
pub(in super::super) fn of_pass(
    sizes: &Sizes<'_>,
    all: &[LiveSetting],
    most: impl Fn(LiveTarget) -> Option<(u64, String)>,
    settings: &mut Vec<PlannedSetting>,
) {
    for setting in all {
        settings.extend(match setting.target {
            LiveTarget::Node => Some(fold(sizes, &setting.value, PlannedTarget::Node)),
            target @ (LiveTarget::Count | LiveTarget::Instances) => {
                live(sizes, &setting.value, || PlannedTarget::Drawn(target, most(target)))
            }
            other => live(sizes, &setting.value, || PlannedTarget::Other(other)),
        });
    }
    // A node whose settings do not change needs none of them.
    let is_node = |setting: &PlannedSetting| matches!(setting.target, PlannedTarget::Node);
    if !settings.iter().any(|setting| is_node(setting) && !setting.expression.names().is_empty()) {
        settings.retain(|setting| !is_node(setting));
    }
}

fn live(
    sizes: &Sizes<'_>,
    deferred: &Deferred,
    target: impl FnOnce() -> PlannedTarget,
) -> Option<PlannedSetting> {
    let is_live = deferred.expression.names().iter().any(|name| sizes.is_live(name));
    is_live.then(|| fold(sizes, deferred, target()))
}

fn fold(sizes: &Sizes<'_>, deferred: &Deferred, target: PlannedTarget) -> PlannedSetting {
    let expression = folded(&deferred.expression, sizes);
    let elements = match expression::evaluate(&expression, sizes) {
        Ok(Value::List(list)) => (0..list.len()).map(|at| element(&expression, at, sizes)).collect(),
        _ => None,
    };
    let elements = elements.unwrap_or_default();
    PlannedSetting { target, expression, elements, place: deferred.place, pointer: deferred.pointer.clone() }
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
