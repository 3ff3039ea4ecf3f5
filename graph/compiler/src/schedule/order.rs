//! The order of the live passes, chosen for an objective.
//!
//! Every order respects all hazards, also those that lead over culled passes. Where the graph leaves a choice:
//!
//! - `declaration`: the order of the document. Stable: a pass added elsewhere changes no other pass's place.
//! - `memory`: few bytes of physical resources, see `memory_order`.
//! - `few-passes`: few render passes. List scheduling: a pass that joins the render pass so far goes next; otherwise
//!   the first of the document, or, as a second try, the first that draws nothing, so that draws gather. The best of
//!   the two and the order of the document is taken. Searching for the fewest is NP-hard; no claim is made.
//!
//! Cost: linear in passes and edges but for a logarithm.

use std::collections::{BTreeSet, HashMap};

use crate::graph::Graph;
use crate::graph::ready::Ready;
use crate::request::objective::{Objective, OrderMethod, OrderReport};
use crate::resources::resolved::ResolvedResources;
use crate::schedule::memory_order;
use crate::schedule::merge::{self, Key, Merger};
use umbragraph_pipeline::work::{PassHandle, Work};

/// Reorders the live passes, given in document order, for an objective.
pub(crate) fn choose(
    graph: &Graph,
    resolved: &ResolvedResources<'_>,
    objective: Objective,
    live: &mut Vec<PassHandle>,
) -> OrderReport {
    let mut report =
        OrderReport { objective, method: OrderMethod::Declaration, memory: None, render_passes: None };
    match objective {
        Objective::Declaration => {}
        Objective::Memory => {
            let (order, method, memory) = memory_order::choose(graph, resolved, live);
            (*live, report.method, report.memory) = (order, method, Some(memory));
        }
        Objective::FewPasses => {
            let declared = render_passes(resolved, live);
            let tries = [false, true].map(|gather| gathered(graph, resolved, live, gather));
            let best = tries
                .into_iter()
                .map(|order| (render_passes(resolved, &order), order))
                .min_by_key(|(count, _)| *count);
            report.render_passes = Some([declared, declared]);
            if let Some((count, order)) = best.filter(|(count, _)| *count < declared) {
                *live = order;
                report.render_passes = Some([declared, count]);
            }
            report.method = OrderMethod::Heuristic;
        }
    }
    report
}

/// Returns the number of render passes in an order after merging.
fn render_passes(resolved: &ResolvedResources<'_>, order: &[PassHandle]) -> usize {
    let mut merger = Merger::new(resolved);
    let draws = |pass: &PassHandle| matches!(resolved.pipeline.pass(*pass).work(), Work::Render(_));
    order.iter().filter(|pass| !merger.push(**pass) && draws(pass)).count()
}

fn gathered(
    graph: &Graph,
    resolved: &ResolvedResources<'_>,
    live: &[PassHandle],
    others_first: bool,
) -> Vec<PassHandle> {
    let mut ready = Ready::new(graph, live);
    let keys: HashMap<PassHandle, Key> =
        live.iter().filter_map(|pass| Some((*pass, merge::key(resolved, *pass)?))).collect();
    let mut loading: HashMap<&Key, BTreeSet<PassHandle>> = HashMap::new();
    let mut quiet: BTreeSet<PassHandle> = BTreeSet::new();
    let mut merger = Merger::new(resolved);
    let mut order = Vec::with_capacity(live.len());
    let mut arrived: Vec<PassHandle> = ready.passes.iter().copied().collect();
    loop {
        for pass in arrived.drain(..) {
            match keys.get(&pass) {
                Some(key) if merge::loads_all(resolved.pipeline, pass) => {
                    loading.entry(key).or_default().insert(pass);
                }
                Some(_) => {}
                None => {
                    quiet.insert(pass);
                }
            }
        }
        let joining = merger.key.as_ref().and_then(|key| loading.get(key)).and_then(|set| {
            // A conflict with what is drawn already is rare; a few candidates are enough.
            set.iter().take(8).copied().find(|pass| merger.joins(*pass))
        });
        let other = if others_first { quiet.first().copied() } else { None };
        let Some(next) = joining.or(other).or_else(|| ready.passes.first().copied()) else { break };
        if let Some(set) = keys.get(&next).and_then(|key| loading.get_mut(key)) {
            set.remove(&next);
        }
        quiet.remove(&next);
        merger.push(next);
        order.push(next);
        arrived = ready.take(next);
    }
    order
}
