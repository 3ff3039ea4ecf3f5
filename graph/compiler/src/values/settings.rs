//! Live settings of a plan: expressions in which nothing is left but live parameters.

use serde::Serialize;

use crate::resources::size::Sizes;
use crate::values::packed::Packing;
use umbragraph_pipeline::expression::{Expression, ExpressionKind, Scope as _};
use umbragraph_pipeline::pipeline::{LiveSetting, TypedPipeline, with_names};

/// A parameter in a plan: live (can change per frame) or structural (needs a new plan).
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct PlannedParameter {
    /// Whether the parameter can change from frame to frame without a new plan.
    pub live: bool,
    /// The JSON pointer of the setting that makes the parameter structural; `None` if the parameter is live.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub structural_at: Option<String>,
}

/// A live setting of a pass in a plan: an expression of live parameters, and the value in the plan that it sets. Its
/// index in the list of the pass is that in [`umbragraph_pipeline::pipeline::Pass::live`].
#[derive(Clone, Debug)]
pub struct PlannedSetting {
    /// The expression, with all names replaced by values except live parameters and values that follow from them.
    pub(crate) expression: Expression,
    pub(crate) bound: Bound,
}

/// The destination and the limit that a plan gives to the value of a live setting.
#[derive(Clone, Debug)]
pub(crate) enum Bound {
    Free,
    /// The value fills a member of a block, given by the index of the block in its pass.
    Member(usize, Packing),
    /// A workgroup count, with its maximum.
    Workgroups(u32),
    /// An element or instance count of a draw, with the count that the smallest bound buffer holds and the buffer's
    /// name.
    Drawn(u64, String),
}

/// Returns for each parameter of a pipeline, by name, whether it is live or structural.
pub(crate) fn planned(pipeline: &TypedPipeline) -> std::collections::BTreeMap<String, PlannedParameter> {
    let of = |structural: &Option<umbragraph_pipeline::pipeline::Structural>| PlannedParameter {
        live: structural.is_none(),
        structural_at: structural.as_ref().map(|structural| structural.pointer.clone()),
    };
    pipeline.parameters.iter().map(|(name, one)| (name.clone(), of(&one.structural))).collect()
}

/// Returns the live settings of a pass in declaration order; empty if no live parameter affects any of them.
pub(crate) fn of_pass(sizes: &Sizes<'_>, all: &[LiveSetting]) -> Vec<PlannedSetting> {
    let is_live = |one: &LiveSetting| one.value.expression.names().iter().any(|name| sizes.is_live(name));
    let all = if all.iter().any(is_live) { all } else { &[] };
    let planned = |one: &LiveSetting| PlannedSetting {
        expression: folded(&one.value.expression, sizes),
        bound: Bound::Free,
    };
    all.iter().map(planned).collect()
}

/// Returns an expression in which each name that does not follow from a live parameter is replaced by its value.
fn folded(expression: &Expression, sizes: &Sizes<'_>) -> Expression {
    with_names(expression, &|name| {
        let value = if sizes.is_live(name) { None } else { sizes.lookup(name) };
        value.map_or_else(|| ExpressionKind::Name(name.to_owned()), ExpressionKind::Literal)
    })
}
