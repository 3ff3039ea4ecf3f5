//! Passes that can run next, and the order of all passes that takes the first of them.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use crate::graph::Graph;
use umbragraph_pipeline::work::PassHandle;

/// Kahn's algorithm over the successors of each pass; among the passes that are ready the first of the document goes
/// first. Those in or behind a cycle are left out.
pub(crate) fn sorted<I: Iterator<Item = PassHandle>>(
    count: usize,
    next: impl Fn(usize) -> I,
) -> Vec<PassHandle> {
    let mut missing = vec![0usize; count];
    (0..count).flat_map(&next).for_each(|to| missing[to.index()] += 1);
    let free = (0..count).filter(|pass| missing[*pass] == 0);
    let mut ready: BinaryHeap<Reverse<usize>> = free.map(Reverse).collect();
    let mut order = Vec::with_capacity(count);
    while let Some(Reverse(pass)) = ready.pop() {
        order.push(PassHandle::at(pass));
        for to in next(pass) {
            missing[to.index()] -= 1;
            if missing[to.index()] == 0 {
                ready.push(Reverse(to.index()));
            }
        }
    }
    order
}

/// The position of each pass in an order; those that are left out come last.
pub(crate) fn positions(order: &[PassHandle], count: usize) -> Vec<usize> {
    let mut positions = vec![usize::MAX; count];
    for (at, pass) in order.iter().enumerate() {
        positions[pass.index()] = at;
    }
    positions
}

/// The live passes that can run next.
pub(crate) struct Ready<'a> {
    graph: &'a Graph,
    missing: Vec<u32>,
    live: Vec<bool>,
    /// The ready passes in the order of the document.
    pub(crate) passes: BTreeSet<PassHandle>,
}

impl<'a> Ready<'a> {
    /// The state before the first pass.
    pub(crate) fn new(graph: &'a Graph, live: &[PassHandle]) -> Self {
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
    pub(crate) fn take(&mut self, pass: PassHandle) -> Vec<PassHandle> {
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
