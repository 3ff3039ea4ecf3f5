//! The order of writers.
//!
//! The writers of one subresource range of a resource have to be ordered by something that the
//! document says: data that flows from one to the other, `after`, or a version (`color@opaque`). One rule is added for
//! what that leaves open: a single writer that does not load, and that nothing says is later, runs before those that
//! do, and so do several of which no two write the same, and two with opposite toggles; without one, what need not find
//! anything counts as such. What is left unordered is an error that names both, because any choice would be a guess.
//! Since an order found for one resource can order the writers of another, resources are tried until nothing changes,
//! those that need the rule after the others. Writers with opposite toggles never run in one frame and need no order.
//!
//! Once the writers of a resource are in order, [`readers`] finds the versions that are read, and the edges.
//!
//! Cost: whether a way leads from one writer to the next is searched only between their positions, and mostly found at
//! the first step; each writer looks back only as far as orders do not [follow](crate::regions::implied) from others.

mod diagnostics;
mod readers;

use std::collections::{BTreeSet, HashMap};

use petgraph::graph::{DiGraph, NodeIndex};
use smallvec::SmallVec;

use crate::graph::access::{PassAccess, Writers, in_conflict};
use crate::graph::jagged_array::JaggedArray;
use crate::graph::later::Stated;
use crate::graph::ready::{positions, sorted};
use crate::graph::{Edge, Graph, GraphNode, Hazard};
use crate::regions::{PartialRead, Unmet};
use diagnostics::unordered_writers;
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::pipeline::{Condition, TypedPipeline, Version};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle};

/// The reason why one pass must run before another: it reads a resource that the other writes, or a hazard.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Via {
    Data(ResourceHandle),
    Order(Hazard),
}

/// A builder for a [`Graph`], which orders the writers of each resource and adds edges.
pub(crate) struct Builder<'a> {
    pipeline: &'a TypedPipeline,
    accesses: &'a [Vec<PassAccess<'a>>],
    /// The resources whose accesses have an error, from which diagnostics about contents and order would only follow.
    unclear: BTreeSet<ResourceHandle>,
    /// The resources of `unclear` about which a diagnostic was left out.
    pub(crate) untold: BTreeSet<ResourceHandle>,
    /// The successors of each pass, by pass index, each with the reason.
    next: Vec<SmallVec<[(PassHandle, Via); 4]>>,
    /// The reads of each pass, by pass index: a resource, and the rank of the writer whose version is read.
    reads: Vec<SmallVec<[(ResourceHandle, u32); 3]>>,
    /// The writers of each resource, by resource index; `None` until they are ordered.
    ordered: Vec<Option<Writers>>,
    /// The pairs of a reader and a resource whose edges are conservative: some may come from writers of other subresources.
    coarse: BTreeSet<(PassHandle, ResourceHandle)>,
    /// The reads that may find unwritten contents; this can be decided only once resource sizes are known.
    partial: Vec<PartialRead>,
    /// The order that the document states with `after` and with reads of named versions (`resource@pass`).
    stated: Stated,
    /// The position of each pass, by pass index, in an order that respects all edges that existed when it was computed.
    position: Vec<usize>,
    /// Whether `position` does not respect some edge, or was not computed yet.
    is_outdated: bool,
}

impl<'a> Builder<'a> {
    /// Starts a graph with only the edges that `after` declares.
    pub(crate) fn new(
        pipeline: &'a TypedPipeline,
        accesses: &'a [Vec<PassAccess<'a>>],
        unclear: BTreeSet<ResourceHandle>,
    ) -> Self {
        let count = pipeline.passes.len();
        let mut builder = Self {
            pipeline,
            accesses,
            unclear,
            untold: BTreeSet::new(),
            next: vec![SmallVec::new(); count],
            reads: vec![SmallVec::new(); count],
            ordered: accesses.iter().map(|_| None).collect(),
            coarse: BTreeSet::new(),
            partial: Vec::new(),
            stated: Stated::new(pipeline),
            position: Vec::new(),
            is_outdated: true,
        };
        for pass in pipeline.pass_handles() {
            for before in &pipeline.pass(pass).after {
                builder.add(*before, pass, Via::Order(Hazard::Explicit));
            }
        }
        builder
    }

    /// Orders the writers of every resource and adds all edges. Returns `true` if no cycle and no unordered writers
    /// remain.
    pub(crate) fn order_all(&mut self, diagnostics: &mut Diagnostics) -> bool {
        let mut waiting: Vec<ResourceHandle> = Vec::new();
        for resource in self.pipeline.resource_handles() {
            let list = &self.accesses[resource.index()];
            let writers: SmallVec<[usize; 2]> = (0..list.len()).filter(|at| list[*at].writes).collect();
            if writers.len() > 1 && in_conflict(list, &writers) {
                self.add_certain(resource);
                waiting.push(resource);
            } else if !list.is_empty() {
                self.connect(resource, writers, diagnostics);
            }
        }
        // What the document says goes before the rule.
        let mut rule = false;
        while !waiting.is_empty() && self.find_positions() {
            let before = waiting.len();
            waiting.retain(|resource| {
                if rule && self.is_outdated {
                    return true;
                }
                match self.order_writers(*resource, rule) {
                    Ok(writers) => {
                        self.connect(*resource, writers, diagnostics);
                        false
                    }
                    Err(_) => true,
                }
            });
            let is_stuck = waiting.len() == before;
            if rule && is_stuck {
                break;
            }
            rule = is_stuck;
        }
        if !self.find_positions() {
            self.report_cycles(diagnostics);
            return false;
        }
        for resource in &waiting {
            if self.leaves_out(*resource) {
                continue;
            }
            if let Err((first, second)) = self.order_writers(*resource, true) {
                let list = &self.accesses[resource.index()];
                let (first, second) = (&list[first], &list[second]);
                // Where a name in "after" is misspelt, that is the diagnostic.
                if ![first, second].iter().any(|one| self.pipeline.pass(one.pass).is_misplaced) {
                    diagnostics.push(unordered_writers(self.pipeline, *resource, first, second));
                }
            }
        }
        waiting.is_empty()
    }

    /// Returns `true` if a diagnostic about a resource would only follow from another one, and notes that.
    fn leaves_out(&mut self, resource: ResourceHandle) -> bool {
        let is_unclear = self.unclear.contains(&resource);
        if is_unclear {
            self.untold.insert(resource);
        }
        is_unclear
    }

    fn add(&mut self, from: PassHandle, to: PassHandle, via: Via) {
        if from != to {
            self.next[from.index()].push((to, via));
            self.is_outdated |= self.position.get(from.index()) >= self.position.get(to.index());
        }
    }

    /// Adds the edges that hold for every order of the writers. A named version precedes its reader. If some writers
    /// are stated to run after a reader of the newest version, all others precede that reader.
    fn add_certain(&mut self, resource: ResourceHandle) {
        let list = &self.accesses[resource.index()];
        let names = named_writers(self.pipeline, list, 0..list.len());
        for reader in list.iter().filter(|access| access.reads) {
            match reader.version {
                Version::WrittenBy(name) => {
                    if let Some(writer) = names.get(name.as_str()) {
                        self.add(list[*writer].pass, reader.pass, Via::Data(resource));
                    }
                }
                Version::Newest if !reader.writes => {
                    let overlaps = |one: &&PassAccess<'_>| one.writes && one.range.overlaps(reader.range);
                    let writers = list.iter().filter(overlaps).map(|writer| writer.pass);
                    let behind = self.stated.followers(reader.pass, writers.clone());
                    for writer in writers.filter(|writer| !behind.is_empty() && !behind.contains(writer)) {
                        self.add(writer, reader.pass, Via::Data(resource));
                    }
                }
                Version::Newest | Version::Before => {}
            }
        }
    }

    /// Computes the position of each pass in an order that respects all edges so far. Returns `false` if there is a
    /// cycle.
    fn find_positions(&mut self) -> bool {
        if !self.is_outdated {
            return true;
        }
        let sorted = self.sorted();
        self.position = positions(&sorted, self.next.len());
        self.is_outdated = sorted.len() < self.next.len();
        !self.is_outdated
    }

    fn sorted(&self) -> Vec<PassHandle> {
        sorted(self.next.len(), |pass| self.next[pass].iter().map(|(to, _)| *to))
    }

    /// Returns the writers of a resource in write order, or the first two that nothing orders. If `rule` is `true`,
    /// writers that load nothing may run before writers that load.
    fn order_writers(
        &self,
        resource: ResourceHandle,
        rule: bool,
    ) -> Result<SmallVec<[usize; 2]>, (usize, usize)> {
        let position = &self.position;
        let list = &self.accesses[resource.index()];
        let mut order: SmallVec<[usize; 2]> = (0..list.len()).filter(|at| list[*at].writes).collect();
        let condition = |access: &PassAccess<'_>| self.pipeline.pass(access.pass).condition;
        let mut fresh: Vec<usize> = Vec::new();
        if rule {
            fresh = order.iter().copied().filter(|at| !list[*at].reads).collect();
            if fresh.is_empty() {
                let keeps = |at: &usize| list[*at].one.usage.keeps_what_is_there();
                fresh = order.iter().copied().filter(keeps).collect();
            }
            let is_single = match fresh[..] {
                [a, b] if never_together(condition(&list[a]), condition(&list[b])) => true,
                _ => !in_conflict(list, &fresh),
            };
            if !is_single {
                fresh.clear();
            }
        }
        let all = Writers::new(list, order.clone());
        fresh.retain(|at| {
            let first = &list[*at];
            let leads = |other: &PassAccess<'_>| {
                other.pass != first.pass
                    && other.range.overlaps(first.range)
                    && position[other.pass.index()] < position[first.pass.index()]
                    && self.reaches(other.pass, first.pass, position)
            };
            !all.after(0, first.range).any(|rank| leads(&list[all.list[rank]]))
        });
        let is_fresh = |at: usize| fresh.binary_search(&at).is_ok();
        order.sort_by_key(|at| (!is_fresh(*at), position[list[*at].pass.index()]));
        let writers = Writers::new(list, order);
        for (rank, at) in writers.list.iter().enumerate() {
            let later = &list[*at];
            let after = condition(later);
            let mut unmet = Unmet::new(later.range, after);
            for earlier_rank in writers.before(rank, later.range) {
                let earlier_at = writers.list[earlier_rank];
                let earlier = &list[earlier_at];
                let before = condition(earlier);
                if never_together(before, after) || !unmet.has_to_meet(earlier.range, before) {
                    continue;
                }
                if !is_fresh(earlier_at) && !self.reaches(earlier.pass, later.pass, position) {
                    return Err((earlier_at, *at));
                }
                unmet.meet(earlier.range, before);
                if unmet.is_empty() {
                    break;
                }
            }
        }
        Ok(writers.list)
    }

    /// Returns `true` if a path of edges leads from one pass to another.
    fn reaches(&self, from: PassHandle, to: PassHandle, position: &[usize]) -> bool {
        if from == to || self.next[from.index()].iter().any(|(next, _)| *next == to) {
            return true;
        }
        let mut seen = BTreeSet::from([from]);
        let mut stack = vec![from];
        while let Some(pass) = stack.pop() {
            for (next, _) in &self.next[pass.index()] {
                if *next == to {
                    return true;
                }
                if position[next.index()] < position[to.index()] && seen.insert(*next) {
                    stack.push(*next);
                }
            }
        }
        false
    }

    /// Returns the finished graph: a node for each pass and version, and an edge for each write, read and ordering.
    pub(crate) fn finish(self) -> Graph {
        let order = self.sorted();
        let edges: usize = self.next.iter().map(SmallVec::len).sum();
        let mut graph = DiGraph::with_capacity(self.next.len() * 2, edges + self.next.len());
        let nodes: Vec<NodeIndex> =
            self.pipeline.pass_handles().map(|pass| graph.add_node(GraphNode::Pass(pass))).collect();
        let count = self.ordered.iter().flatten().map(|writers| writers.list.len()).sum();
        let mut versions = JaggedArray::with_capacity(self.ordered.len(), count);
        for resource in self.pipeline.resource_handles() {
            let list = self.ordered[resource.index()].as_ref().map_or(&[][..], |writers| &writers.list);
            versions.push(list.iter().enumerate().map(|(rank, at)| {
                let access = &self.accesses[resource.index()][*at];
                let (range, writer, number) = (access.range, access.pass, rank as u32 + 1);
                let node = graph.add_node(GraphNode::Version { resource, range, number, writer });
                graph.add_edge(nodes[writer.index()], node, Edge::Writes);
                node
            }));
        }
        for (reader, mut reads) in self.reads.into_iter().enumerate() {
            reads.sort_unstable();
            reads.dedup();
            for (resource, rank) in reads {
                graph.add_edge(versions[resource.index()][rank as usize], nodes[reader], Edge::Reads);
            }
        }
        let mut successors = JaggedArray::with_capacity(self.next.len(), edges);
        for (from, mut list) in self.next.into_iter().enumerate() {
            let key = |via: &Via| match via {
                Via::Data(resource) => (None, Some(*resource)),
                Via::Order(hazard) => (Some(*hazard), None),
            };
            list.sort_unstable_by_key(|(to, via)| (*to, key(via)));
            list.dedup();
            for (to, via) in &list {
                if let Via::Order(hazard) = via {
                    graph.add_edge(nodes[from], nodes[to.index()], Edge::Order(*hazard));
                }
            }
            successors.push(list.into_iter().map(|(to, _)| to));
        }
        Graph { graph, order, nodes, versions, successors, coarse: self.coarse, partial: self.partial }
    }
}

/// Returns `true` if two passes with these toggle conditions never run in one frame, so that they need no order.
fn never_together(a: Option<Condition>, b: Option<Condition>) -> bool {
    a.zip(b).is_some_and(|(a, b)| a == b.opposite())
}

/// Returns the writers of a resource as indices into `list`, by pass name. If a pass writes several times, its last
/// write in `order` counts.
fn named_writers<'a>(
    pipeline: &'a TypedPipeline,
    list: &[PassAccess<'_>],
    order: impl IntoIterator<Item = usize>,
) -> HashMap<&'a str, usize> {
    let writers = order.into_iter().filter(|at| list[*at].writes);
    writers.map(|at| (pipeline.pass(list[at].pass).name.as_str(), at)).collect()
}
