//! The order of writers, and the versions that readers read.
//!
//! **Order of writers.** The writers of one subresource range of a resource have to be ordered by something that the
//! document says: data that flows from one to the other, `after`, or a version (`color@opaque`). One rule is added for
//! what that leaves open: a single writer that does not load, and that nothing says is later, runs before those that
//! do, and so do several of which no two write the same, and two with opposite toggles; without one, what need not find
//! anything counts as such. What is left
//! unordered is an error that names both, because any choice would be a guess. Since an order found for one resource
//! can order the writers of another, resources are tried until nothing changes, those that need the rule after the
//! others.
//!
//! **Versions read.** A plain reference reads the newest version, without the writers that `after` puts behind the
//! reader; a pass that loads what it writes reads the one before its own. A reference to the version of a pass reads
//! what that pass left of what it writes, and of the rest the newest writes that do not have to follow the pass, be it
//! by `after` or since they write over what it, or another such writer, wrote. `name@0` reads what was there before the
//! first write of the frame. Two accesses overlap if their mip and their layer can be the same; a subresource range
//! without a mip (layer) means all of them.
//!
//! **Toggles.** A pass that can be off never covers what is below it for a reader that can run without it: such a
//! reader is connected to the writers below too, as far as it [sees](super::visible) them in some state. Writers with
//! opposite toggles never run in one frame and need no order. What is left without one is an error, unless the contents
//! of the frame before are there.
//!
//! Cost: each writer looks back only as far as orders do not [follow](super::implied) from others, each reader only to
//! the first write that covers its subresource range. Whether a way leads from one writer to the next is searched only
//! between their positions, and mostly found at the first step. Up to [`SHOWN_EDGES`] writers before and behind each
//! access, and up to [`DIRECT_READS`] that it reads, have edges also if they could be left out. Writers of different
//! subresource ranges that can be off are looked through as `visible` describes: for many of them, reads can get
//! [coarse](Graph::is_coarse).

mod diagnostics;

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, HashMap, HashSet};

use petgraph::graph::{DiGraph, NodeIndex};
use smallvec::SmallVec;

use super::access::{PassAccess, Writers, in_conflict};
use super::conditions;
use super::conditions::Runs;
use super::extents::extents;
use super::graph::{Edge, Graph, GraphNode, Hazard};
use super::implied::Unmet;
use super::jagged_array::JaggedArray;
use super::later::{Later, Stated};
use super::partial_read::{Left, PartialRead};
use super::visible::{Effort, View, Write};
use crate::diagnostic::Diagnostics;
use crate::language::Lifetime;
use crate::pipeline::{Condition, Pipeline, ResourceKind, SubresourceRange, Version};
use crate::work::{PassHandle, ResourceHandle};
use diagnostics::{never_written, unordered_writers};

/// How many hazards of an access have edges though they may follow from others. Random tests come to it sooner.
const SHOWN_EDGES: usize = if cfg!(test) { 1 } else { 16 };
/// How many writers a reader reads itself before what they pass on is left to them. Random tests come to it sooner.
const DIRECT_READS: usize = if cfg!(test) { 2 } else { 16 };

/// The reason why one pass comes before another.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Via {
    Data(ResourceHandle),
    Order(Hazard),
}

/// A graph in the making.
pub(super) struct Builder<'a> {
    pipeline: &'a Pipeline,
    accesses: &'a [Vec<PassAccess<'a>>],
    /// Successors of each pass, and why.
    next: Vec<SmallVec<[(PassHandle, Via); 4]>>,
    /// The reads of each pass: a resource, and the rank of the writer.
    reads: Vec<SmallVec<[(ResourceHandle, u32); 3]>>,
    /// The writers of each resource that is ordered.
    ordered: Vec<Option<Writers>>,
    /// The reads that may have more edges than there is data.
    coarse: BTreeSet<(PassHandle, ResourceHandle)>,
    /// The reads of which something may not be written.
    partial: Vec<PartialRead>,
    /// What "after" says alone.
    stated: Stated,
    /// The position of each pass in an order that respects all edges when it was made.
    position: Vec<usize>,
    /// Whether an edge was added since that the positions do not respect.
    is_outdated: bool,
}

impl<'a> Builder<'a> {
    /// A graph with the explicit edges only.
    pub(super) fn new(pipeline: &'a Pipeline, accesses: &'a [Vec<PassAccess<'a>>]) -> Self {
        let count = pipeline.passes.len();
        let mut builder = Self {
            pipeline,
            accesses,
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

    /// Orders the writers of every resource and connects what they feed; whether an order is left.
    pub(super) fn order_all(&mut self, diagnostics: &mut Diagnostics) -> bool {
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

    fn add(&mut self, from: PassHandle, to: PassHandle, via: Via) {
        if from != to {
            self.next[from.index()].push((to, via));
            self.is_outdated |= self.position.get(from.index()) >= self.position.get(to.index());
        }
    }

    /// The edges that hold whatever the order of the writers is: from a named version to its reader, and from the writers
    /// to who reads the newest version where others are stated to be behind it.
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

    /// Finds the position of each pass in an order that respects all edges so far; false if there is a cycle.
    fn find_positions(&mut self) -> bool {
        if !self.is_outdated {
            return true;
        }
        let sorted = self.sorted();
        self.position = vec![usize::MAX; self.next.len()];
        for (at, pass) in sorted.iter().enumerate() {
            self.position[pass.index()] = at;
        }
        self.is_outdated = sorted.len() < self.next.len();
        !self.is_outdated
    }

    /// Kahn's algorithm; among the passes that are ready the first of the document goes first.
    fn sorted(&self) -> Vec<PassHandle> {
        let mut missing = vec![0usize; self.next.len()];
        for (to, _) in self.next.iter().flatten() {
            missing[to.index()] += 1;
        }
        let mut ready: BinaryHeap<Reverse<PassHandle>> =
            self.pipeline.pass_handles().filter(|pass| missing[pass.index()] == 0).map(Reverse).collect();
        let mut order = Vec::with_capacity(self.next.len());
        while let Some(Reverse(pass)) = ready.pop() {
            order.push(pass);
            for (to, _) in &self.next[pass.index()] {
                missing[to.index()] -= 1;
                if missing[to.index()] == 0 {
                    ready.push(Reverse(*to));
                }
            }
        }
        order
    }

    /// The writers of a resource in their order, or the first two that nothing orders; with the rule about a first
    /// writer, or without.
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

    /// Whether a way leads from one pass to another.
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

    /// Adds the edges of a resource whose writers are in order.
    fn connect(
        &mut self,
        resource: ResourceHandle,
        order: SmallVec<[usize; 2]>,
        diagnostics: &mut Diagnostics,
    ) {
        let list = &self.accesses[resource.index()];
        let writers = Writers::new(list, order);
        for (rank, at) in writers.list.iter().enumerate() {
            let current = list[*at];
            let condition = |access: &PassAccess<'_>| self.pipeline.pass(access.pass).condition;
            let after = condition(&current);
            let mut hazards = Hazards::new(current.range, after);
            for earlier in writers.before(rank, current.range) {
                let earlier = list[writers.list[earlier]];
                let before = condition(&earlier);
                if never_together(before, after) {
                    continue;
                }
                if hazards.shows(earlier.range, before) {
                    self.add(earlier.pass, current.pass, Via::Order(Hazard::WriteAfterWrite(resource)));
                    let covers =
                        earlier.range.contains(current.range) && (before.is_none() || before == after);
                    if covers || hazards.are_done() {
                        break;
                    }
                }
            }
        }
        let names = if list.iter().any(|access| matches!(access.version, Version::WrittenBy(_))) {
            named_writers(self.pipeline, list, writers.list.iter().copied())
        } else {
            HashMap::new()
        };
        let is_toggled = |at: &usize| self.pipeline.pass(list[*at].pass).condition.is_some();
        let simple = writers.are_plain() && !writers.list.iter().any(is_toggled);
        let mut in_view =
            WritersInView { writers: &writers, simple, covers: HashMap::new(), effort: Effort::default() };
        for (rank, at) in writers.list.iter().enumerate().rev().filter(|_| !simple) {
            let access = &list[*at];
            if let Some(condition) = self.pipeline.pass(access.pass).condition.filter(|_| !access.reads) {
                in_view.covers.insert(condition, rank);
            }
        }
        for reader in list.iter().filter(|access| access.reads) {
            let later = match reader.version {
                Version::WrittenBy(name) => {
                    let Some(named) = names.get(name.as_str()).map(|at| &list[*at]) else { continue };
                    match writers.rank(list, named.pass, named.range) {
                        Some(rank) if named.range.contains(reader.range) => Later::From(rank + 1),
                        _ => self.stated.behind_version(list, &writers, named.pass),
                    }
                }
                Version::Newest => match writers.rank(list, reader.pass, reader.range) {
                    Some(rank) if reader.writes => Later::From(rank),
                    _ => self.stated.behind(list, &writers, reader.pass),
                },
                Version::Before => Later::From(0),
            };
            self.connect_reader(resource, reader, &mut in_view, &later, diagnostics);
        }
        self.ordered[resource.index()] = Some(writers);
    }

    /// A write that a reader reads.
    fn feed(&mut self, resource: ResourceHandle, rank: usize, writer: PassHandle, reader: PassHandle) {
        self.add(writer, reader, Via::Data(resource));
        self.reads[reader.index()].push((resource, rank as u32));
    }

    /// Connects one reader to the writers that feed it, and to the later ones, which overwrite it.
    fn connect_reader(
        &mut self,
        resource: ResourceHandle,
        reader: &PassAccess<'_>,
        in_view: &mut WritersInView<'_>,
        later: &Later,
        diagnostics: &mut Diagnostics,
    ) {
        let pipeline = self.pipeline;
        let writers = in_view.writers;
        let list = &self.accesses[resource.index()];
        let Some(known) = conditions::known(pipeline.pass(reader.pass), reader.one) else {
            // It never happens: the pass runs only in frames in which the fallback is seen.
            return;
        };
        let mut written = false;
        let mut missing: Option<(usize, Condition)> = None;
        let (mut left, mut toggled, mut open) = (None, Vec::new(), Vec::new());
        // Pieces of one subresource or of everything hide one another one by one, those of a range only together.
        if in_view.simple && reader.range.is_plain() {
            // What was written since of what is read: an older write of it is not there any more.
            let mut newer: HashSet<SubresourceRange> = HashSet::new();
            let mut covered = false;
            for rank in writers.before(later.end(writers), reader.range).filter(|rank| !later.has(*rank)) {
                let writer = &list[writers.list[rank]];
                if writer.pass == reader.pass || !writer.range.overlaps(reader.range) {
                    continue;
                }
                let read = common_of_plain(writer.range, reader.range);
                if !newer.is_empty() && within(&newer, read) {
                    continue;
                }
                self.feed(resource, rank, writer.pass, reader.pass);
                written = true;
                // Most reads end at the first write, which covers them, and need no set.
                covered = writer.range.contains(reader.range);
                if covered {
                    break;
                }
                newer.insert(read);
            }
            if !covered && !newer.is_empty() {
                left = Some(Left::AllBut(newer.into_iter().collect()));
            }
        } else {
            let mut view = View::new(reader.range, &known, &mut in_view.effort);
            let mut count = 0;
            for rank in writers.before(later.end(writers), reader.range).filter(|rank| !later.has(*rank)) {
                let writer = &list[writers.list[rank]];
                let (range, condition) = (writer.range, pipeline.pass(writer.pass).condition);
                if writer.pass == reader.pass || !writer.range.overlaps(reader.range) {
                    continue;
                }
                if view.sees(range, condition) {
                    self.feed(resource, rank, writer.pass, reader.pass);
                    written = true;
                    count += 1;
                }
                let loads = writer.reads && writer.one.when.is_empty() && *writer.version == Version::Newest;
                let covered = |condition| in_view.covers.get(&condition).is_some_and(|oldest| *oldest < rank);
                let passes_on = loads && condition.is_some_and(|condition| !covered(condition));
                view.cover(Write { range, condition, writer: rank, passes_on });
                if count == DIRECT_READS {
                    view.pass_on();
                }
                if view.is_covered() {
                    break;
                }
            }
            missing = view.missing();
            toggled = view.toggled();
            open = view.open();
            let unwritten = view.unwritten();
            left = (!unwritten.is_empty()).then_some(Left::Boxes(unwritten));
            if view.is_coarse() {
                self.coarse.insert((reader.pass, resource));
            }
        }
        let declared = pipeline.resource(resource);
        let at =
            || pipeline.pass(reader.pass).accesses().iter().position(|one| std::ptr::eq(one, reader.one));
        let own_memory = match declared.declared_lifetime() {
            Lifetime::Transient => true,
            // Before this frame writes it, it holds what was left so long ago that it has no name any more.
            Lifetime::History => !declared.is_earlier_frame(),
            Lifetime::Persistent | Lifetime::Imported => false,
        };
        let needs = !reader.one.usage.keeps_what_is_there();
        if !own_memory || pipeline.uncertain.contains(&resource) {
        } else if !needs {
            // What is between rows of texels is only told to who reads it.
            let unfilled = if written { open } else { vec![extents(reader.range)] };
            if let Some(at) = at().filter(|_| !unfilled.is_empty()) {
                self.partial.push(PartialRead { reader: reader.pass, at, left: Left::BetweenRows(unfilled) });
            }
        } else {
            if !written {
                // Data that nobody publishes has its diagnostic from the load.
                if !matches!(pipeline.resource(resource).kind, ResourceKind::Data(None)) {
                    diagnostics.push(never_written(pipeline, resource, reader, list));
                }
            } else if let Some((rank, condition)) = missing {
                let writer = &list[writers.list[rank]];
                let (reader, writer) = ((reader.pass, reader.one), (writer.pass, writer.one.place));
                diagnostics.push(conditions::taken_away(pipeline, reader, writer, condition, ""));
            } else if let Some(at) = at() {
                toggled.sort_by_key(|(_, rank, _)| Reverse(*rank));
                let toggled = toggled.into_iter().map(|(extents, rank, condition)| {
                    let writer = &list[writers.list[rank]];
                    (extents, writer.pass, writer.one.place, condition)
                });
                let toggled: Vec<_> = toggled.collect();
                let toggled = (!toggled.is_empty()).then_some(Left::Toggled(toggled));
                let left = left.into_iter().chain(toggled);
                self.partial.extend(left.map(|left| PartialRead { reader: reader.pass, at, left }));
            }
        }
        let mut hazards = Hazards::new(reader.range, None);
        for rank in writers.after(later.start(), reader.range).filter(|rank| later.has(*rank)) {
            let writer = &list[writers.list[rank]];
            let condition = match conditions::runs(pipeline.pass(writer.pass), &known) {
                Runs::Never => continue,
                Runs::Always => None,
                Runs::Sometimes(condition) => Some(condition),
            };
            if writer.pass != reader.pass && hazards.shows(writer.range, condition) {
                self.add(reader.pass, writer.pass, Via::Order(Hazard::WriteAfterRead(resource)));
                if writer.range.contains(reader.range) && condition.is_none() || hazards.are_done() {
                    break;
                }
            }
        }
    }

    /// The graph of what was connected.
    pub(super) fn finish(self) -> Graph {
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

/// The writers of a resource as its readers look through them.
struct WritersInView<'a> {
    writers: &'a Writers,
    /// Whether the writers are always there and write one subresource or everything.
    simple: bool,
    /// The oldest writer with each condition that does not load.
    covers: HashMap<Condition, usize>,
    effort: Effort,
}

/// The writers that have to run before, or after, one access.
struct Hazards {
    range: SubresourceRange,
    unmet: Unmet,
    shown: usize,
}

impl Hazards {
    fn new(range: SubresourceRange, condition: Option<Condition>) -> Self {
        Self { range, unmet: Unmet::new(range, condition), shown: 0 }
    }

    /// Whether the next writer has an edge.
    fn shows(&mut self, range: SubresourceRange, condition: Option<Condition>) -> bool {
        let shows = range.overlaps(self.range)
            && (self.shown < SHOWN_EDGES || self.unmet.has_to_meet(range, condition));
        if shows {
            self.unmet.meet(range, condition);
            self.shown += 1;
        }
        shows
    }

    /// Whether all others follow.
    fn are_done(&self) -> bool {
        self.shown >= SHOWN_EDGES && self.unmet.is_empty()
    }
}

/// Whether two passes never run in one frame, so that no order between them matters.
fn never_together(a: Option<Condition>, b: Option<Condition>) -> bool {
    a.zip(b).is_some_and(|(a, b)| a == b.opposite())
}

/// Whether one of the plain parts has everything of another.
fn within(ranges: &HashSet<SubresourceRange>, range: SubresourceRange) -> bool {
    let wider = [
        range,
        SubresourceRange { mip: None, ..range },
        SubresourceRange { layer: None, ..range },
        SubresourceRange::WHOLE,
    ];
    wider.iter().any(|wider| ranges.contains(wider))
}

/// What two plain parts that overlap have in common.
fn common_of_plain(a: SubresourceRange, b: SubresourceRange) -> SubresourceRange {
    SubresourceRange { mip: a.mip.or(b.mip), layer: a.layer.or(b.layer), ..SubresourceRange::WHOLE }
}

/// The writers of a resource by the name of their pass; of several writes of one pass the last in the given order.
fn named_writers<'a>(
    pipeline: &'a Pipeline,
    list: &[PassAccess<'_>],
    order: impl IntoIterator<Item = usize>,
) -> HashMap<&'a str, usize> {
    let writers = order.into_iter().filter(|at| list[*at].writes);
    writers.map(|at| (pipeline.pass(list[at].pass).name.as_str(), at)).collect()
}
