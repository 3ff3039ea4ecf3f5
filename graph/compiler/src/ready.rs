//! The live passes that can run next.

use std::collections::BTreeSet;

use super::graph::Graph;
use crate::work::PassHandle;

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
