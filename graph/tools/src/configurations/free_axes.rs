//! Shader axes whose values the enumerated configurations do not give in full.
//!
//! An axis is free if its value depends on a setting of which not all values are tried, or on several settings while the
//! states of passes are sampled. Its expression is evaluated for all values of these settings, up to [`MAX_STATES`]
//! combinations. Beyond that limit, every value that the axis declares counts as reachable.

use std::collections::BTreeSet;

use umbragraph_pipeline::diagnostic::AxisValue;
use umbragraph_pipeline::expression::{self, Expression};
use umbragraph_pipeline::pipeline::axis_value;

use super::varied::Mentions;
use super::varied_setting::Varied;
use super::witness::Settings;
use super::{MAX_STATES, combination, product};

/// A shader axis that can have values beyond those that the tried configurations give it.
#[derive(Clone, Debug)]
pub(super) struct FreeAxis {
    pub(super) name: String,
    /// The name of the pass whose axis it is, as the document names the pass. `None` for all passes, where a subgraph
    /// or a setting with the axis's name gives the value.
    pub(super) pass: Option<String>,
    /// All values that the axis's expression can yield; `None` if they are unknown, so that every value of the axis
    /// counts.
    pub(super) values: Option<BTreeSet<AxisValue>>,
    /// The expression or setting that gives the axis its value, in quotation marks.
    pub(super) reason: String,
}

/// Finds the shader axes that can have values beyond those that the enumerated configurations give them. `sampled` says
/// whether states of passes were sampled.
pub(super) fn free_axes(mentions: &Mentions<'_>, settings: &Settings<'_>, sampled: bool) -> Vec<FreeAxis> {
    let varied = mentions.varied(MAX_STATES);
    // The same settings, with all whole numbers of larger ranges.
    let wide = &Settings::new(&varied, &mentions.defaults);
    let open = |at: &usize| !settings.varied[*at].exhaustive;
    let mut free = Vec::new();
    for mention in &mentions.list {
        let Some(axis) = mention.axis else { continue };
        let expression = mention.expression.as_ref();
        let named = expression.map(|each| settings.named(each)).unwrap_or_default();
        let is_tried = !sampled || named.len() <= 1;
        let behind = mentions.behind_locals(mention);
        let is_open = |each: &Varied| !each.exhaustive && behind.contains(each.name.as_str());
        let follows_open = settings.varied.iter().any(is_open);
        if is_tried && !follows_open && !named.iter().any(open) {
            continue;
        }
        // Through parameters of subgraphs and variables of loops no value is followed.
        let expression = expression.filter(|_| !follows_open);
        // A value by name alone reaches the passes that say nothing of the axis themselves.
        let passes: Vec<Option<&str>> = match mention.is_derived {
            true => mentions.passes_without(axis).map(Some).collect(),
            false => vec![mention.pass],
        };
        free.extend(passes.into_iter().map(|pass| {
            let condition = pass.and_then(|pass| mentions.condition_of(pass));
            FreeAxis {
                name: axis.to_owned(),
                pass: pass.map(str::to_owned),
                values: expression.and_then(|each| values_yielded(wide, each, condition.as_ref())),
                reason: format!("\"{}\"", mention.text),
            }
        }));
    }
    let is_open = |each: &&Varied| !each.exhaustive && mentions.axes.contains(each.name.as_str());
    for each in settings.varied.iter().filter(is_open) {
        free.push(FreeAxis {
            name: each.name.clone(),
            pass: None,
            values: expression::parse(&each.name).ok().and_then(|name| values_yielded(wide, &name, None)),
            reason: format!("\"{}\"", each.name),
        });
    }
    free
}

/// Evaluates an expression for all values of its settings with which `condition` may hold, and returns the results.
/// `None` if the settings have too many values to try all, or if no evaluation succeeds.
fn values_yielded(
    settings: &Settings<'_>,
    expression: &Expression,
    condition: Option<&Expression>,
) -> Option<BTreeSet<AxisValue>> {
    let named = settings.named(expression);
    if named.is_empty() || !named.iter().all(|at| settings.varied[*at].exhaustive) {
        return None;
    }
    let total = product(settings.varied, &named)?;
    let mut found = BTreeSet::new();
    for number in 0..total {
        let pick = combination(settings.varied, &named, number);
        if condition.is_none_or(|condition| settings.holds(condition, &pick) != Some(false)) {
            found.extend(settings.value(expression, &pick).as_ref().and_then(axis_value));
        }
    }
    // An expression over names of a subgraph yields nothing here.
    (!found.is_empty()).then_some(found)
}
