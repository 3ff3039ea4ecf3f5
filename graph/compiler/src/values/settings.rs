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
    /// Whether it can change from frame to frame.
    pub live: bool,
    /// The JSON pointer of the setting that makes the parameter structural; `None` if the parameter is live.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub structural_at: Option<String>,
}

/// A live setting in a plan: the expression and the value that it sets. Positions are those of
/// [`umbragraph_pipeline::pipeline::Pass::live`].
#[derive(Clone, Debug)]
pub struct PlannedSetting {
    /// An expression of live parameters, and of values derived from them alone.
    pub(crate) expression: Expression,
    pub(crate) bound: Bound,
}

/// Bound that a plan sets to the value of a live setting.
#[derive(Clone, Debug)]
pub(crate) enum Bound {
    Free,
    /// A member of the block at a position of the pass's blocks.
    Member(usize, Packing),
    /// A count of workgroups, which is at most so large.
    Workgroups(u32),
    /// A count of a draw, and how many of what is counted a buffer has, with its name.
    Drawn(u64, String),
}

/// The parameters of a pipeline, as its plan has them.
pub(crate) fn planned(pipeline: &TypedPipeline) -> std::collections::BTreeMap<String, PlannedParameter> {
    let of = |structural: &Option<umbragraph_pipeline::pipeline::Structural>| PlannedParameter {
        live: structural.is_none(),
        structural_at: structural.as_ref().map(|structural| structural.pointer.clone()),
    };
    pipeline.parameters.iter().map(|(name, one)| (name.clone(), of(&one.structural))).collect()
}

/// The live settings of a pass, in their order; none where no live parameter reaches one.
pub(crate) fn of_pass(sizes: &Sizes<'_>, all: &[LiveSetting]) -> Vec<PlannedSetting> {
    let is_live = |one: &LiveSetting| one.value.expression.names().iter().any(|name| sizes.is_live(name));
    let all = if all.iter().any(is_live) { all } else { &[] };
    let planned = |one: &LiveSetting| PlannedSetting {
        expression: folded(&one.value.expression, sizes),
        bound: Bound::Free,
    };
    all.iter().map(planned).collect()
}

/// An expression in which values stand for the names of what does not change.
fn folded(expression: &Expression, sizes: &Sizes<'_>) -> Expression {
    with_names(expression, &|name| {
        let value = if sizes.is_live(name) { None } else { sizes.lookup(name) };
        value.map_or_else(|| ExpressionKind::Name(name.to_owned()), ExpressionKind::Literal)
    })
}
