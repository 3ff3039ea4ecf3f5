//! The order that needs the fewest bytes.
//!
//! The bytes of an order are at least the sum over the classes of the maximum that is alive at once, and just that
//! where no class has members of different sizes, which only classes of buffers have. There the orders that are
//! compared are given their places by `lifetime`. Searching for the best order is NP-hard (it contains
//! register-sufficiency).
//!
//! - Up to [`EXACT_PASSES`] passes: branch and bound over the sets of passes that have run. What is alive depends only
//!   on the set, so a way to a set is dropped if another way to it had no higher peak in any class. The peaks start
//!   from what single passes need, below which no order goes. With buffers of different sizes, the order found counts
//!   as exact only if no way that was gone has a lower sum of peaks than it has bytes.
//! - Beyond, or after [`MAX_STEPS`] steps: list scheduling. Among the first [`WINDOW`] passes that can run and the
//!   [`WINDOW`] that could run last (the consumers of what was just made), the one that raises the peaks least goes
//!   next, then the one that leaves the fewest bytes alive, then the first of the document. The order of the document
//!   is kept where it is as good.
//!
//! Cost: the heuristic is linear in accesses times the window.

use std::collections::{HashMap, VecDeque};

use crate::graph::Graph;
use crate::graph::ready::Ready;
use crate::memory::lifetime::{AllocationRequest, assign};
use crate::request::objective::{MemoryOrder, OrderMethod};
use crate::resources::resolved::ResolvedResources;
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::work::PassHandle;

/// The maximum number of live passes for which the exact search runs.
const EXACT_PASSES: usize = 20;
/// The number of steps after which the exact search stops and keeps the best order found so far.
const MAX_STEPS: usize = 2_000_000;
/// The number of ready passes that the heuristic weighs from each of two lists: the first in document order, and the
/// latest to become ready.
const WINDOW: usize = 16;
/// The maximum number of paths to one set of passes whose peaks are remembered for pruning.
const MAX_WAYS: usize = 8;

/// Chooses the pass order that needs the fewest bytes; returns the order, the method that found it, and its bytes.
pub(crate) fn choose(
    graph: &Graph,
    resolved: &ResolvedResources<'_>,
    live: &[PassHandle],
) -> (Vec<PassHandle>, OrderMethod, MemoryOrder) {
    let model = Model::new(resolved, live);
    let bound: u64 = model.min.iter().sum();
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
            lowest: u64::MAX,
            known: HashMap::new(),
            steps: 0,
        };
        search.run(0, &mut model.start(), &mut Vec::new());
        if search.steps < MAX_STEPS && search.best.0 <= search.lowest {
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

/// The input of the search: the transient resources with their bytes, and the resources that each pass uses.
struct Model {
    /// The transient resources that each pass uses, indexed by pass handle, as indices into `resources`.
    uses: Vec<Vec<usize>>,
    resources: Vec<Needed>,
    /// The maximum number of bytes that a single pass uses, for each compatibility class.
    min: Vec<u64>,
    /// Whether all transient resources of each compatibility class have the same size in bytes.
    even: bool,
    /// The bytes of resources that outlive the frame, which no order changes.
    fixed: u64,
}

/// A transient resource that live passes use.
struct Needed {
    class: usize,
    bytes: u64,
    /// The number of live passes that use the resource.
    users: u32,
}

/// The bytes alive and their peak so far, for each compatibility class, after some passes of an order.
#[derive(Clone)]
struct State {
    remaining: Vec<u32>,
    alive: Vec<u64>,
    peak: Vec<u64>,
}

impl Model {
    fn new(resolved: &ResolvedResources<'_>, live: &[PassHandle]) -> Self {
        let pipeline = resolved.pipeline;
        let mut model = Self {
            uses: vec![Vec::new(); pipeline.passes.len()],
            resources: Vec::new(),
            min: vec![0; resolved.classes],
            even: true,
            fixed: 0,
        };
        let mut numbers = vec![None; pipeline.resources.len()];
        let mut sizes: Vec<Option<u64>> = vec![None; resolved.classes];
        for handle in pipeline.resource_handles() {
            let Some((class, bytes)) =
                resolved.get(handle).and_then(|properties| Some((properties.class?, properties.bytes)))
            else {
                continue;
            };
            if pipeline.resource(handle).lifetime() == Lifetime::Transient {
                numbers[handle.index()] = Some(model.resources.len());
                model.resources.push(Needed { class, bytes, users: 0 });
                model.even &= *sizes[class].get_or_insert(bytes) == bytes;
            } else {
                model.fixed += bytes;
            }
        }
        for pass in live {
            let mut used: Vec<usize> = pipeline
                .pass(*pass)
                .accesses()
                .iter()
                .filter_map(|one| numbers[one.resource.index()])
                .collect();
            used.sort_unstable();
            used.dedup();
            let mut needed: HashMap<usize, u64> = HashMap::new();
            for resource in &used {
                let Needed { class, bytes, users } = &mut model.resources[*resource];
                *users += 1;
                *needed.entry(*class).or_default() += *bytes;
            }
            for (class, bytes) in needed {
                model.min[class] = model.min[class].max(bytes);
            }
            model.uses[pass.index()] = used;
        }
        model
    }

    fn start(&self) -> State {
        let remaining = self.resources.iter().map(|resource| resource.users).collect();
        State { remaining, alive: vec![0; self.min.len()], peak: self.min.clone() }
    }

    /// Updates the state as if the pass ran next.
    fn run(&self, state: &mut State, pass: PassHandle) {
        for resource in &self.uses[pass.index()] {
            let Needed { class, bytes, users } = self.resources[*resource];
            if state.remaining[*resource] == users {
                state.alive[class] += bytes;
                state.peak[class] = state.peak[class].max(state.alive[class]);
            }
        }
        for resource in &self.uses[pass.index()] {
            state.remaining[*resource] -= 1;
            if state.remaining[*resource] == 0 {
                let Needed { class, bytes, .. } = self.resources[*resource];
                state.alive[class] -= bytes;
            }
        }
    }

    /// Returns the bytes by which the sum of peaks rises if the pass runs next, and the change of the bytes alive after
    /// the pass.
    fn weigh(&self, state: &State, pass: PassHandle) -> (u64, i64) {
        let mut begun: Vec<(usize, u64)> = Vec::new();
        let mut change = 0i64;
        for resource in &self.uses[pass.index()] {
            let Needed { class, bytes, users } = self.resources[*resource];
            if state.remaining[*resource] == users {
                match begun.iter_mut().find(|(known, _)| *known == class) {
                    Some((_, begun)) => *begun += bytes,
                    None => begun.push((class, bytes)),
                }
                change += bytes as i64;
            }
            if state.remaining[*resource] == 1 {
                change -= bytes as i64;
            }
        }
        let above =
            |(class, bytes): &(usize, u64)| (state.alive[*class] + bytes).saturating_sub(state.peak[*class]);
        (begun.iter().map(above).sum(), change)
    }

    /// Returns the bytes of memory that transient resources need in an order.
    fn bytes(&self, order: &[PassHandle]) -> u64 {
        if !self.even {
            return self.created(order);
        }
        let mut state = self.start();
        for pass in order {
            self.run(&mut state, *pass);
        }
        state.peak.iter().sum()
    }

    /// Returns the bytes of the textures and buffers that are created for transient resources in an order.
    fn created(&self, order: &[PassHandle]) -> u64 {
        let mut spans: Vec<Option<(usize, usize)>> = vec![None; self.resources.len()];
        for (at, pass) in order.iter().enumerate() {
            for resource in &self.uses[pass.index()] {
                spans[*resource].get_or_insert((at, at)).1 = at;
            }
        }
        let requests = self.resources.iter().zip(spans);
        let requests = requests.filter_map(|(Needed { class, bytes, .. }, span)| {
            let (first, last) = span?;
            Some(AllocationRequest { class: *class, bytes: *bytes, first, last })
        });
        assign(&requests.collect::<Vec<_>>()).bytes.iter().sum()
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

/// Returns a bit set for each live pass: the live passes that must run before it, also due to culled passes between.
/// Bit `i` is the pass `live[i]`.
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
    /// The lowest sum of peaks in bytes of all complete orders visited.
    lowest: u64,
    /// The peaks in bytes for each compatibility class with which each set of passes (a bit set) was reached.
    known: HashMap<u32, Vec<Vec<u64>>>,
    steps: usize,
}

impl Search<'_> {
    fn run(&mut self, done: u32, state: &mut State, order: &mut Vec<PassHandle>) {
        self.steps += 1;
        let peaks: u64 = state.peak.iter().sum();
        if self.steps >= MAX_STEPS || peaks >= self.best.0 {
            return;
        }
        if order.len() == self.live.len() {
            self.lowest = self.lowest.min(peaks);
            let bytes = if self.model.even {
                peaks
            } else {
                // Places cost about as much as going the way.
                self.steps += order.len();
                self.model.created(order)
            };
            if bytes < self.best.0 {
                self.best = (bytes, order.clone());
            }
            return;
        }
        let ways = self.known.entry(done).or_default();
        if ways.iter().any(|way| way.iter().zip(&state.peak).all(|(known, new)| known <= new)) {
            return;
        }
        if ways.len() < MAX_WAYS {
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
