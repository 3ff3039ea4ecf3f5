//! The order of the live passes, chosen for an objective.
//!
//! Every order respects all hazards, also those that lead over culled passes. Where the graph leaves a choice:
//!
//! - `declaration`: the order of the document. Stable: a pass added elsewhere changes no other pass's place.
//! - `memory`: few bytes of physical resources, see `order_memory`.
//! - `few-passes`: few render passes. List scheduling: a pass that joins the render pass so far goes next; otherwise
//!   the first of the document, or, as a second try, the first that draws nothing, so that draws gather. The best of
//!   the two and the order of the document is taken. Searching for the fewest is NP-hard; no claim is made.
//!
//! Cost: linear in passes and edges but for a logarithm.

use std::collections::{BTreeSet, HashMap};

use serde::Serialize;

use super::graph::Graph;
use super::merge::{self, Key, Merger};
use super::order_memory;
use super::resolved_resources::ResolvedResources;
use crate::pipeline::Pipeline;
use crate::work::PassHandle;

/// The objective of the order of the passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Objective {
    /// The order of the document where the graph leaves a choice.
    #[default]
    Declaration,
    /// Few bytes.
    Memory,
    /// Few render passes.
    FewPasses,
}

impl Objective {
    /// All objectives.
    pub const ALL: [Self; 3] = [Self::Declaration, Self::Memory, Self::FewPasses];

    /// `declaration`, `memory` or `few-passes`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Declaration => "declaration",
            Self::Memory => "memory",
            Self::FewPasses => "few-passes",
        }
    }

    /// An objective by its name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|objective| objective.name() == name)
    }
}

/// How the order was chosen, and its bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OrderReport {
    /// The objective.
    pub objective: Objective,
    /// How.
    pub method: OrderMethod,
    /// For `memory`: what was reached, and against what.
    pub memory: Option<MemoryOrder>,
    /// For `few-passes`: the render passes of the order of the document, and of the one chosen.
    pub render_passes: Option<[usize; 2]>,
}

/// The method by which an order was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OrderMethod {
    /// The order of the document.
    Declaration,
    /// No order is better.
    Exact,
    /// A good one.
    Heuristic,
}

/// The bytes of orders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct MemoryOrder {
    /// The order of the document.
    pub declaration: u64,
    /// The order chosen.
    pub chosen: u64,
    /// A bound that no order goes below: for each class what single passes need at once, summed.
    pub bound: u64,
}

/// Puts the live passes, which come in the order of the document, into the order of an objective.
pub(super) fn choose<'a>(
    pipeline: &'a Pipeline,
    graph: &Graph,
    resolved: &'a ResolvedResources<'a>,
    objective: Objective,
    live: &mut Vec<PassHandle>,
) -> OrderReport {
    let mut report =
        OrderReport { objective, method: OrderMethod::Declaration, memory: None, render_passes: None };
    match objective {
        Objective::Declaration => {}
        Objective::Memory => {
            let (order, method, memory) = order_memory::choose(pipeline, graph, resolved, live);
            (*live, report.method, report.memory) = (order, method, Some(memory));
        }
        Objective::FewPasses => {
            let declared = render_passes(pipeline, resolved, live);
            let tries = [false, true].map(|gather| gathered(pipeline, graph, resolved, live, gather));
            let best = tries
                .into_iter()
                .map(|order| (render_passes(pipeline, resolved, &order), order))
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

/// The number of render passes of an order.
fn render_passes<'a>(
    pipeline: &'a Pipeline,
    resolved: &'a ResolvedResources<'a>,
    order: &[PassHandle],
) -> usize {
    let mut merger = Merger::new(pipeline, resolved);
    let draws = |pass: &PassHandle| matches!(pipeline.pass(*pass).work(), crate::work::Work::Render(_));
    order.iter().filter(|pass| !merger.push(**pass) && draws(pass)).count()
}

fn gathered<'a>(
    pipeline: &'a Pipeline,
    graph: &Graph,
    resolved: &'a ResolvedResources<'a>,
    live: &[PassHandle],
    others_first: bool,
) -> Vec<PassHandle> {
    let mut ready = Ready::new(graph, live);
    let keys: HashMap<PassHandle, Key> =
        live.iter().filter_map(|pass| Some((*pass, merge::key(pipeline, resolved, *pass)?))).collect();
    let mut loading: HashMap<&Key, BTreeSet<PassHandle>> = HashMap::new();
    let mut quiet: BTreeSet<PassHandle> = BTreeSet::new();
    let mut merger = Merger::new(pipeline, resolved);
    let mut order = Vec::with_capacity(live.len());
    let mut arrived: Vec<PassHandle> = ready.passes.iter().copied().collect();
    loop {
        for pass in arrived.drain(..) {
            match keys.get(&pass) {
                Some(key) if merge::loads_all(pipeline, pass) => {
                    loading.entry(key).or_default().insert(pass);
                }
                Some(_) => {}
                None => {
                    quiet.insert(pass);
                }
            }
        }
        let joining = merger.key().and_then(|key| loading.get(key)).and_then(|set| {
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

/// The live passes that can run next.
pub(super) struct Ready<'a> {
    graph: &'a Graph,
    missing: Vec<u32>,
    live: Vec<bool>,
    /// In the order of the document.
    pub(super) passes: BTreeSet<PassHandle>,
}

impl<'a> Ready<'a> {
    /// Before the first pass.
    pub(super) fn new(graph: &'a Graph, live: &[PassHandle]) -> Self {
        let count = graph.successors.len();
        let mut ready =
            Self { graph, missing: vec![0; count], live: vec![false; count], passes: BTreeSet::new() };
        for pass in live {
            ready.live[pass.index()] = true;
        }
        for to in graph.successors.items() {
            ready.missing[to.index()] += 1;
        }
        let free: Vec<PassHandle> =
            graph.order.iter().copied().filter(|pass| ready.missing[pass.index()] == 0).collect();
        ready.arrive(free);
        ready
    }

    /// Runs a pass; those that can run now and could not before.
    pub(super) fn take(&mut self, pass: PassHandle) -> Vec<PassHandle> {
        self.passes.remove(&pass);
        let free = self.release(pass);
        self.arrive(free)
    }

    fn release(&mut self, pass: PassHandle) -> Vec<PassHandle> {
        let mut free = Vec::new();
        for to in &self.graph.successors[pass.index()] {
            self.missing[to.index()] -= 1;
            if self.missing[to.index()] == 0 {
                free.push(*to);
            }
        }
        free
    }

    /// Culled passes take no time: what waits for them waits no longer.
    fn arrive(&mut self, mut free: Vec<PassHandle>) -> Vec<PassHandle> {
        let mut new = Vec::new();
        while let Some(pass) = free.pop() {
            if self.live[pass.index()] {
                self.passes.insert(pass);
                new.push(pass);
            } else {
                free.extend(self.release(pass));
            }
        }
        new
    }
}
