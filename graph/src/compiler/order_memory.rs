//! The order that needs the fewest bytes.
//!
//! The bytes of an order are the sum over the classes of the most that is alive at once, which aliasing meets exactly.
//! Finding the best order is NP-hard (it contains register-sufficiency).
//!
//! - Up to [`EXACT_PASSES`] passes: branch and bound over the sets of passes that have run. What is alive depends only
//!   on the set, so a way to a set is dropped if another way to it had no higher peak in any class. The peaks start
//!   from what single passes need, below which no order goes.
//! - Beyond, or after [`MAXIMUM_STEPS`] steps: list scheduling. Among the first [`WINDOW`] passes that can run and the
//!   [`WINDOW`] that could run last (the consumers of what was just made), the one that raises the peaks least goes
//!   next, then the one that leaves the fewest bytes alive, then the first of the document. The order of the document
//!   is kept where it is as good.
//!
//! Cost: the heuristic is linear in uses times the window.

use std::collections::{HashMap, VecDeque};

use super::facts::Facts;
use super::graph::Graph;
use super::order::{MemoryOrder, OrderMethod, Ready};
use crate::language::Lifetime;
use crate::pipeline::Pipeline;
use crate::work::PassHandle;

/// The most passes whose best order is searched for.
const EXACT_PASSES: usize = 20;
/// The most steps of that search.
const MAXIMUM_STEPS: usize = 2_000_000;
/// How many of the ready passes, the first and the latest, the heuristic weighs.
const WINDOW: usize = 16;
/// How many ways to one set of passes are remembered.
const MAXIMUM_WAYS: usize = 8;

/// The best order found, how, and its bytes.
pub(super) fn choose(
    pipeline: &Pipeline,
    graph: &Graph,
    facts: &Facts<'_>,
    live: &[PassHandle],
) -> (Vec<PassHandle>, OrderMethod, MemoryOrder) {
    let model = Model::new(pipeline, facts, live);
    let bound = model.total(&model.least);
    let declaration = model.bytes(live);
    let mut best = (declaration, live.to_vec());
    let heuristic = schedule(&model, graph, live);
    let bytes = model.bytes(&heuristic);
    if bytes < best.0 {
        best = (bytes, heuristic);
    }
    let mut method = OrderMethod::Heuristic;
    if best.0 == bound {
        method = OrderMethod::Exact;
    } else if live.len() <= EXACT_PASSES {
        let mut search = Search {
            model: &model,
            live,
            predecessors: predecessors(graph, live),
            best,
            known: HashMap::new(),
            steps: 0,
        };
        search.run(0, &mut model.start(), &mut Vec::new());
        if search.steps < MAXIMUM_STEPS {
            method = OrderMethod::Exact;
        }
        best = search.best;
    }
    let (chosen, order) = best;
    let fixed = model.fixed;
    let memory =
        MemoryOrder { declaration: declaration + fixed, chosen: chosen + fixed, bound: bound + fixed };
    (order, method, memory)
}

/// What counts for bytes.
struct Model {
    /// For each pass of the pipeline the transient resources that it uses, by an own number.
    uses: Vec<Vec<usize>>,
    /// For each of those resources its class and the number of live passes that use it.
    resources: Vec<(usize, u32)>,
    /// For each class the bytes of one.
    bytes: Vec<u64>,
    /// For each class the most that a single pass uses.
    least: Vec<u32>,
    /// Bytes that no order changes.
    fixed: u64,
}

/// What is alive, and what was at most, during an order.
#[derive(Clone)]
struct State {
    remaining: Vec<u32>,
    alive: Vec<u32>,
    peak: Vec<u32>,
}

impl Model {
    fn new(pipeline: &Pipeline, facts: &Facts<'_>, live: &[PassHandle]) -> Self {
        let mut model = Self {
            uses: vec![Vec::new(); pipeline.passes.len()],
            resources: Vec::new(),
            bytes: facts.class_bytes.clone(),
            least: vec![0; facts.class_bytes.len()],
            fixed: 0,
        };
        let mut numbers = vec![None; pipeline.resources.len()];
        for handle in pipeline.resource_handles() {
            let Some((class, bytes)) = facts.get(handle).and_then(|fact| Some((fact.class?, fact.bytes)))
            else {
                continue;
            };
            if pipeline.resource(handle).lifetime() == Lifetime::Transient {
                numbers[handle.index()] = Some(model.resources.len());
                model.resources.push((class, 0));
            } else {
                model.fixed += bytes;
            }
        }
        for pass in live {
            let mut used: Vec<usize> =
                pipeline.pass(*pass).uses.iter().filter_map(|one| numbers[one.resource.index()]).collect();
            used.sort_unstable();
            used.dedup();
            let mut counts: HashMap<usize, u32> = HashMap::new();
            for resource in &used {
                let (class, users) = &mut model.resources[*resource];
                *users += 1;
                *counts.entry(*class).or_default() += 1;
            }
            for (class, count) in counts {
                model.least[class] = model.least[class].max(count);
            }
            model.uses[pass.index()] = used;
        }
        model
    }

    fn start(&self) -> State {
        let remaining = self.resources.iter().map(|(_, users)| *users).collect();
        State { remaining, alive: vec![0; self.bytes.len()], peak: self.least.clone() }
    }

    fn total(&self, peak: &[u32]) -> u64 {
        peak.iter().zip(&self.bytes).map(|(count, bytes)| u64::from(*count) * bytes).sum()
    }

    /// Runs a pass; by how many bytes the peaks rise, and how many more bytes are alive afterwards.
    fn run(&self, state: &mut State, pass: PassHandle) -> (u64, i64) {
        let (mut rise, mut change) = (0, 0i64);
        for resource in &self.uses[pass.index()] {
            let (class, users) = self.resources[*resource];
            if state.remaining[*resource] == users {
                state.alive[class] += 1;
                change += self.bytes[class] as i64;
                if state.alive[class] > state.peak[class] {
                    state.peak[class] = state.alive[class];
                    rise += self.bytes[class];
                }
            }
        }
        for resource in &self.uses[pass.index()] {
            state.remaining[*resource] -= 1;
            if state.remaining[*resource] == 0 {
                let (class, _) = self.resources[*resource];
                state.alive[class] -= 1;
                change -= self.bytes[class] as i64;
            }
        }
        (rise, change)
    }

    /// What running a pass would do, without running it.
    fn weigh(&self, state: &State, pass: PassHandle) -> (u64, i64) {
        let mut begun: Vec<(usize, u32)> = Vec::new();
        let (mut rise, mut change) = (0, 0i64);
        for resource in &self.uses[pass.index()] {
            let (class, users) = self.resources[*resource];
            let bytes = self.bytes[class];
            if state.remaining[*resource] == users {
                let known = begun.iter().position(|(known, _)| *known == class);
                let at = known.unwrap_or_else(|| {
                    begun.push((class, 0));
                    begun.len() - 1
                });
                begun[at].1 += 1;
                change += bytes as i64;
                if state.alive[class] + begun[at].1 > state.peak[class] {
                    rise += bytes;
                }
            }
            if state.remaining[*resource] == 1 {
                change -= bytes as i64;
            }
        }
        (rise, change)
    }

    fn bytes(&self, order: &[PassHandle]) -> u64 {
        let mut state = self.start();
        for pass in order {
            self.run(&mut state, *pass);
        }
        self.total(&state.peak)
    }
}

fn schedule(model: &Model, graph: &Graph, live: &[PassHandle]) -> Vec<PassHandle> {
    let mut ready = Ready::new(graph, live);
    let mut state = model.start();
    let mut order = Vec::with_capacity(live.len());
    let mut latest: VecDeque<PassHandle> = VecDeque::new();
    loop {
        latest.retain(|pass| ready.passes.contains(pass));
        let candidates = ready.passes.iter().take(WINDOW).chain(&latest).copied();
        let Some(next) = candidates.min_by_key(|pass| (model.weigh(&state, *pass), *pass)) else { break };
        model.run(&mut state, next);
        order.push(next);
        latest.extend(ready.take(next));
        while latest.len() > WINDOW {
            latest.pop_front();
        }
    }
    order
}

/// For each live pass the set of the live passes that have to run before it, also over culled ones.
fn predecessors(graph: &Graph, live: &[PassHandle]) -> Vec<u32> {
    let mut before = vec![0u32; graph.successors.len()];
    let mut own = vec![0u32; graph.successors.len()];
    for (at, pass) in live.iter().enumerate() {
        own[pass.index()] = 1 << at;
    }
    for pass in &graph.order {
        let all = before[pass.index()] | own[pass.index()];
        for to in &graph.successors[pass.index()] {
            before[to.index()] |= all;
        }
    }
    live.iter().map(|pass| before[pass.index()]).collect()
}

struct Search<'a> {
    model: &'a Model,
    live: &'a [PassHandle],
    predecessors: Vec<u32>,
    best: (u64, Vec<PassHandle>),
    /// The peaks with which each set of passes was reached.
    known: HashMap<u32, Vec<Vec<u32>>>,
    steps: usize,
}

impl Search<'_> {
    fn run(&mut self, done: u32, state: &mut State, order: &mut Vec<PassHandle>) {
        self.steps += 1;
        if self.steps >= MAXIMUM_STEPS || self.model.total(&state.peak) >= self.best.0 {
            return;
        }
        if order.len() == self.live.len() {
            self.best = (self.model.total(&state.peak), order.clone());
            return;
        }
        let ways = self.known.entry(done).or_default();
        if ways.iter().any(|way| way.iter().zip(&state.peak).all(|(known, new)| known <= new)) {
            return;
        }
        if ways.len() < MAXIMUM_WAYS {
            ways.push(state.peak.clone());
        }
        for at in 0..self.live.len() {
            let bit = 1u32 << at;
            if done & bit == 0 && self.predecessors[at] & !done == 0 {
                let mut next = state.clone();
                self.model.run(&mut next, self.live[at]);
                order.push(self.live[at]);
                self.run(done | bit, &mut next, order);
                order.pop();
            }
        }
    }
}
