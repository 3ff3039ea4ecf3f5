//! Passes that can run next, and the order of all passes that takes the first of them.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use crate::graph::Graph;
use umbragraph_pipeline::work::PassHandle;

/// Sorts passes topologically by Kahn's algorithm. `next` returns the successors of a pass; among ready passes the
/// first in the document goes first. Passes in or after a cycle are left out.
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

/// Returns the position of each pass in `order`, by pass index; `usize::MAX` for passes that `order` leaves out.
pub(crate) fn positions(order: &[PassHandle], count: usize) -> Vec<usize> {
    let mut positions = vec![usize::MAX; count];
    for (at, pass) in order.iter().enumerate() {
        positions[pass.index()] = at;
    }
    positions
}

/// The live (not culled) passes that can run next: all of their predecessors have run.
pub(crate) struct Ready<'a> {
    graph: &'a Graph,
    missing: Vec<u32>,
    live: Vec<bool>,
    /// The passes that can run next, in document order.
    pub(crate) passes: BTreeSet<PassHandle>,
}

impl<'a> Ready<'a> {
    /// Creates the state before the first pass runs.
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

    /// Marks a pass as run, and returns the live passes that became ready.
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

    /// Adds passes that wait for no other pass, and returns the live passes that became ready. Culled passes count as
    /// run at once.
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
