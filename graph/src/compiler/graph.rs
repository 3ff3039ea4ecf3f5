//! Passes and resource versions as a graph, with every hazard an edge.
//!
//! Each write makes a new version of the part of a resource that it covers. Edges run from a pass to the versions that
//! it writes, from a version to the passes that read it, and from pass to pass for what has no data of its own:
//!
//! - read after write: writer → version → reader;
//! - write after read: a reader of a version runs before the next writer of that part;
//! - write after write: writers of one part run in their order;
//! - explicit: `after`.
//!
//! **Order of writers.** The writers of one part of a resource have to be ordered by something that the document says:
//! data that flows from one to the other, `after`, or a version (`color@opaque`). One rule is added: a single writer
//! that does not load runs before those that do. What is left unordered is an error that names both, because any
//! choice would be a guess. Since an order found for one resource can order the writers of another, resources are
//! tried until nothing changes.
//!
//! **Versions read.** A plain reference reads the newest version; a pass that loads what it writes reads the one
//! before its own. Two uses overlap if their mip and their layer can be the same; a part without a mip (layer) means
//! all of them.
//!
//! Cost: linear in passes, uses and edges, for a bounded number of writers that touch one part out of order.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef as _;

use super::cycle;
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::language::Lifetime;
use crate::pipeline::{Part, Pipeline, ResourceKind, Use, Version};
use crate::work::{PassHandle, ResourceHandle};

/// A node of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphNode {
    /// A pass.
    Pass(PassHandle),
    /// What one write made of a part of a resource.
    Version {
        /// The resource.
        resource: ResourceHandle,
        /// The part.
        part: Part,
        /// Counts the writes of the resource in their order, from 1.
        number: u32,
        /// The pass that wrote it.
        writer: PassHandle,
    },
}

/// An edge of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// From a pass to a version that it writes.
    Writes,
    /// From a version to a pass that reads it.
    Reads,
    /// From a pass to one that has to run later.
    Order(Hazard),
}

/// Why a pass has to run before another, where no data flows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Hazard {
    /// The first reads what the second overwrites.
    WriteAfterRead(ResourceHandle),
    /// Both write the same part.
    WriteAfterWrite(ResourceHandle),
    /// The document says so.
    Explicit,
}

/// Passes, versions and hazards, and an order that respects them all.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The graph.
    pub graph: DiGraph<GraphNode, Edge>,
    /// All passes, culled ones too, in an order that respects every edge; by the document where there is a choice.
    pub order: Vec<PassHandle>,
    nodes: Vec<NodeIndex>,
}

impl Graph {
    /// The node of a pass.
    pub fn node(&self, pass: PassHandle) -> NodeIndex {
        self.nodes[pass.index()]
    }

    /// The passes whose writes a pass reads, with the resource, in the order of the edges.
    pub fn producers(&self, pass: PassHandle) -> impl Iterator<Item = (PassHandle, ResourceHandle)> + '_ {
        self.graph.edges_directed(self.node(pass), petgraph::Direction::Incoming).filter_map(|edge| {
            match self.graph[edge.source()] {
                GraphNode::Version { resource, writer, .. } => Some((writer, resource)),
                GraphNode::Pass(_) => None,
            }
        })
    }
}

/// One pass's access to a part of a resource, reads and writes of the part united.
#[derive(Clone, Copy, Debug)]
struct Access<'a> {
    pass: PassHandle,
    part: Part,
    reads: bool,
    writes: bool,
    version: &'a Version,
    one: &'a Use,
}

/// Builds the graph of a pipeline.
///
/// Findings: reads of what nothing writes, unordered writers, cycles, a pass that reads and writes one part in a way
/// that no device allows. The result is `None` after errors that leave no order.
pub fn build(pipeline: &Pipeline, diagnostics: &mut Diagnostics) -> Option<Graph> {
    let mut builder = Builder::new(pipeline);
    for pass in pipeline.pass_handles() {
        for before in &pipeline.pass(pass).after {
            builder.add(*before, pass, Via::Order(Hazard::Explicit));
        }
    }
    let accesses = accesses(pipeline, diagnostics);
    let mut waiting: Vec<ResourceHandle> = Vec::new();
    let mut ordered: BTreeMap<ResourceHandle, Vec<usize>> = BTreeMap::new();
    for (resource, list) in &accesses {
        let writers: Vec<usize> = (0..list.len()).filter(|at| list[*at].writes).collect();
        if in_conflict(list, &writers) {
            builder.add_certain(*resource, list);
            waiting.push(*resource);
        } else {
            builder.connect(*resource, list, &writers, diagnostics);
            ordered.insert(*resource, writers);
        }
    }
    // Orders of writers, until nothing changes.
    loop {
        if builder.report_cycle(diagnostics) {
            return None;
        }
        let position = builder.positions();
        let (mut progress, mut next) = (false, Vec::new());
        for resource in waiting {
            let list = &accesses[&resource];
            match builder.order_writers(list, &position) {
                Ok(writers) => {
                    builder.connect(resource, list, &writers, diagnostics);
                    ordered.insert(resource, writers);
                    progress = true;
                }
                Err(_) => next.push(resource),
            }
        }
        waiting = next;
        if !progress || waiting.is_empty() {
            break;
        }
    }
    let position = builder.positions();
    let mut unordered = false;
    for resource in waiting {
        let list = &accesses[&resource];
        if let Err((first, second)) = builder.order_writers(list, &position) {
            unordered = true;
            diagnostics.push(unordered_writers(pipeline, resource, &list[first], &list[second]));
        }
    }
    if builder.report_cycle(diagnostics) || unordered {
        return None;
    }
    Some(builder.finish(&accesses, &ordered))
}

/// The accesses of each resource, in the order of the passes.
fn accesses<'a>(pipeline: &'a Pipeline, diagnostics: &mut Diagnostics) -> BTreeMap<ResourceHandle, Vec<Access<'a>>> {
    let mut accesses: BTreeMap<ResourceHandle, Vec<Access<'a>>> = BTreeMap::new();
    for handle in pipeline.pass_handles() {
        let pass = pipeline.pass(handle);
        for (at, one) in pass.uses.iter().enumerate() {
            for other in pass.uses[..at].iter().filter(|other| other.resource == one.resource && other.part.overlaps(one.part)) {
                if other.usage.writes() || one.usage.writes() {
                    diagnostics.push(feedback(pipeline, handle, other, one));
                }
            }
            let list = accesses.entry(one.resource).or_default();
            let same = list.iter_mut().rev().take_while(|access| access.pass == handle).find(|access| {
                access.part == one.part && access.version == &one.version && !access.writes && !one.usage.writes()
            });
            match same {
                Some(_) => {}
                None => list.push(Access {
                    pass: handle,
                    part: one.part,
                    reads: one.usage.reads(),
                    writes: one.usage.writes(),
                    version: &one.version,
                    one,
                }),
            }
        }
    }
    accesses
}

/// Whether two writers touch the same part, so that their order has to be found.
fn in_conflict(list: &[Access<'_>], writers: &[usize]) -> bool {
    if writers.len() < 2 {
        return false;
    }
    // Writers that each name one subresource are told apart by a set; the general test is only for the rest.
    let mut exact = BTreeSet::new();
    let (mut wide, mut wide_count) = (None, 0);
    for at in writers {
        let part = list[*at].part;
        if part.mip.is_some() && part.layer.is_some() {
            if !exact.insert(part) {
                return true;
            }
        } else {
            wide = Some(part);
            wide_count += 1;
        }
    }
    match (wide, wide_count) {
        (None, _) => false,
        (Some(part), 1) => exact.iter().any(|other| part.overlaps(*other)),
        _ => writers.iter().enumerate().any(|(at, a)| writers[..at].iter().any(|b| list[*a].part.overlaps(list[*b].part))),
    }
}

/// How one pass comes before another.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Via {
    Data(ResourceHandle),
    Order(Hazard),
}

struct Builder<'a> {
    pipeline: &'a Pipeline,
    /// Successors of each pass, and why.
    next: Vec<Vec<(PassHandle, Via)>>,
    /// What each reading access reads: (resource, writer) by reader.
    reads: Vec<Vec<(ResourceHandle, Part, PassHandle)>>,
}

impl<'a> Builder<'a> {
    fn new(pipeline: &'a Pipeline) -> Self {
        let count = pipeline.passes.len();
        Self { pipeline, next: vec![Vec::new(); count], reads: vec![Vec::new(); count] }
    }

    fn add(&mut self, from: PassHandle, to: PassHandle, via: Via) {
        if from != to && !self.next[from.index()].contains(&(to, via)) {
            self.next[from.index()].push((to, via));
        }
    }

    /// The edges that hold whatever the order of the writers is: from a named version to its reader.
    fn add_certain(&mut self, resource: ResourceHandle, list: &[Access<'_>]) {
        for reader in list.iter().filter(|access| access.reads) {
            if let Version::WrittenBy(name) = reader.version
                && let Some(writer) = list.iter().find(|access| access.writes && self.pipeline.pass(access.pass).name == *name)
            {
                self.add(writer.pass, reader.pass, Via::Data(resource));
            }
        }
    }

    /// The position of each pass in an order that respects all edges so far.
    fn positions(&self) -> Vec<usize> {
        let mut position = vec![usize::MAX; self.next.len()];
        for (at, pass) in self.sorted().into_iter().enumerate() {
            position[pass.index()] = at;
        }
        position
    }

    /// Kahn's algorithm; among the passes that are ready the first of the document goes first.
    fn sorted(&self) -> Vec<PassHandle> {
        let mut missing = vec![0usize; self.next.len()];
        for (to, _) in self.next.iter().flatten() {
            missing[to.index()] += 1;
        }
        let mut ready: std::collections::BinaryHeap<std::cmp::Reverse<PassHandle>> =
            self.pipeline.pass_handles().filter(|pass| missing[pass.index()] == 0).map(std::cmp::Reverse).collect();
        let mut order = Vec::with_capacity(self.next.len());
        while let Some(std::cmp::Reverse(pass)) = ready.pop() {
            order.push(pass);
            for (to, _) in &self.next[pass.index()] {
                missing[to.index()] -= 1;
                if missing[to.index()] == 0 {
                    ready.push(std::cmp::Reverse(*to));
                }
            }
        }
        order
    }

    /// The writers of a resource in their order, or the first two that nothing orders.
    fn order_writers(&self, list: &[Access<'_>], position: &[usize]) -> Result<Vec<usize>, (usize, usize)> {
        let mut writers: Vec<usize> = (0..list.len()).filter(|at| list[*at].writes).collect();
        let fresh: Vec<usize> = writers.iter().copied().filter(|at| !list[*at].reads).collect();
        let single_fresh = match fresh.as_slice() {
            [one] => Some(*one),
            _ => None,
        };
        writers.sort_by_key(|at| (Some(*at) != single_fresh, position[list[*at].pass.index()]));
        for (index, b) in writers.iter().enumerate() {
            for a in writers[..index].iter().rev() {
                if !list[*a].part.overlaps(list[*b].part) {
                    continue;
                }
                if Some(*a) != single_fresh && !self.reaches(list[*a].pass, list[*b].pass, position) {
                    return Err((*a, *b));
                }
                if list[*a].part.contains(list[*b].part) {
                    break;
                }
            }
        }
        Ok(writers)
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
    fn connect(&mut self, resource: ResourceHandle, list: &[Access<'_>], writers: &[usize], diagnostics: &mut Diagnostics) {
        let pipeline = self.pipeline;
        for (index, b) in writers.iter().enumerate() {
            let current = list[*b];
            for a in writers[..index].iter().rev() {
                if list[*a].part.overlaps(current.part) {
                    self.add(list[*a].pass, current.pass, Via::Order(Hazard::WriteAfterWrite(resource)));
                    if list[*a].part.contains(current.part) {
                        break;
                    }
                }
            }
        }
        let rank: HashMap<PassHandle, usize> =
            writers.iter().enumerate().map(|(index, at)| (list[*at].pass, index)).collect();
        for reader in list.iter().filter(|access| access.reads) {
            let limit = match reader.version {
                Version::WrittenBy(name) => {
                    let Some(at) = writers.iter().position(|at| pipeline.pass(list[*at].pass).name == *name) else { continue };
                    at + 1
                }
                Version::Newest if reader.writes => rank.get(&reader.pass).copied().unwrap_or(0),
                Version::Newest => writers.len(),
            };
            let mut fed = false;
            for at in writers[..limit].iter().rev() {
                let writer = list[*at];
                if writer.pass == reader.pass || !writer.part.overlaps(reader.part) {
                    continue;
                }
                fed = true;
                self.add(writer.pass, reader.pass, Via::Data(resource));
                self.reads[reader.pass.index()].push((resource, writer.part, writer.pass));
                if writer.part.contains(reader.part) {
                    break;
                }
            }
            let own_memory = pipeline.resource(resource).lifetime() == Lifetime::Transient;
            if !fed && own_memory && !pipeline.uncertain.contains(&resource) {
                diagnostics.push(never_written(pipeline, resource, reader, list));
            }
            for at in &writers[limit..] {
                let writer = list[*at];
                if writer.pass != reader.pass && writer.part.overlaps(reader.part) {
                    self.add(reader.pass, writer.pass, Via::Order(Hazard::WriteAfterRead(resource)));
                    if writer.part.contains(reader.part) {
                        break;
                    }
                }
            }
        }
    }

    fn report_cycle(&self, diagnostics: &mut Diagnostics) -> bool {
        let edges: Vec<Vec<usize>> = self.next.iter().map(|list| list.iter().map(|(to, _)| to.index()).collect()).collect();
        let cycles = cycle::shortest(&edges);
        for members in &cycles {
            let describe = |at: usize| {
                let (from, to) = (members[at], members[(at + 1) % members.len()]);
                let via = self.next[from].iter().find(|(next, _)| next.index() == to).map(|(_, via)| *via);
                let name = |pass: usize| &self.pipeline.passes[pass].name;
                let resource = |handle: ResourceHandle| &self.pipeline.resource(handle).name;
                match via {
                    Some(Via::Data(handle)) => format!("\"{}\" reads \"{}\" of \"{}\"", name(to), resource(handle), name(from)),
                    Some(Via::Order(Hazard::WriteAfterRead(handle))) => {
                        format!("\"{}\" overwrites \"{}\", which \"{}\" reads", name(to), resource(handle), name(from))
                    }
                    Some(Via::Order(Hazard::WriteAfterWrite(handle))) => {
                        format!("\"{}\" overwrites \"{}\" of \"{}\"", name(to), resource(handle), name(from))
                    }
                    _ => format!("\"{}\" is after \"{}\"", name(to), name(from)),
                }
            };
            let first = &self.pipeline.passes[members[0]];
            let names: Vec<String> = members.iter().map(|pass| format!("\"{}\"", self.pipeline.passes[*pass].name)).collect();
            let mut finding = Diagnostic::error(
                codes::CYCLE,
                first.place,
                format!("the passes {} wait for one another", names.join(", ")),
            )
            .pointer(&first.pointer)
            .help("break the circle: read an older version (name@pass), or write to another resource");
            for (at, pass) in members.iter().enumerate() {
                finding = finding.related(self.pipeline.passes[*pass].place, describe(at));
            }
            diagnostics.push(finding);
        }
        !cycles.is_empty()
    }

    fn finish(self, accesses: &BTreeMap<ResourceHandle, Vec<Access<'_>>>, ordered: &BTreeMap<ResourceHandle, Vec<usize>>) -> Graph {
        let order = self.sorted();
        let mut graph = DiGraph::new();
        let nodes: Vec<NodeIndex> = self.pipeline.pass_handles().map(|pass| graph.add_node(GraphNode::Pass(pass))).collect();
        let mut versions: HashMap<(ResourceHandle, PassHandle, Part), NodeIndex> = HashMap::new();
        for (resource, writers) in ordered {
            for (number, at) in writers.iter().enumerate() {
                let access = accesses[resource][*at];
                let node = graph.add_node(GraphNode::Version {
                    resource: *resource,
                    part: access.part,
                    number: number as u32 + 1,
                    writer: access.pass,
                });
                graph.add_edge(nodes[access.pass.index()], node, Edge::Writes);
                versions.insert((*resource, access.pass, access.part), node);
            }
        }
        for (reader, reads) in self.reads.iter().enumerate() {
            let mut seen = BTreeSet::new();
            for (resource, part, writer) in reads {
                if let Some(version) = versions.get(&(*resource, *writer, *part))
                    && seen.insert(*version)
                {
                    graph.add_edge(*version, nodes[reader], Edge::Reads);
                }
            }
        }
        for (from, list) in self.next.iter().enumerate() {
            for (to, via) in list {
                if let Via::Order(hazard) = via {
                    graph.add_edge(nodes[from], nodes[to.index()], Edge::Order(*hazard));
                }
            }
        }
        Graph { graph, order, nodes }
    }
}

fn feedback(pipeline: &Pipeline, pass: PassHandle, first: &Use, second: &Use) -> Diagnostic {
    let name = &pipeline.resource(second.resource).name;
    Diagnostic::error(
        codes::FEEDBACK,
        second.place,
        format!(
            "the pass \"{}\" uses \"{name}\" as {} and as {} at once",
            pipeline.pass(pass).name,
            first.usage.name(),
            second.usage.name()
        ),
    )
    .pointer(&second.pointer)
    .related(first.place, "the other use")
    .help("no device can read what the same pass writes: use another mip or layer, or a second texture")
}

fn never_written(pipeline: &Pipeline, resource: ResourceHandle, reader: &Access<'_>, list: &[Access<'_>]) -> Diagnostic {
    let known = pipeline.resource(resource);
    let verb = if reader.writes { "loads" } else { "reads" };
    let mut finding = Diagnostic::error(
        codes::NEVER_WRITTEN,
        reader.one.place,
        format!("\"{}\" {verb} \"{}\", which nothing writes before", pipeline.pass(reader.pass).name, known.name),
    )
    .pointer(&reader.one.pointer)
    .related(known.place, "declared here");
    let others = list.iter().any(|access| access.writes && access.pass != reader.pass);
    finding.help = Some(match (&known.kind, others, reader.writes) {
        (ResourceKind::Data(_), ..) => "let a host pass publish it".to_owned(),
        (_, true, _) => "the passes that write it write other mips or layers, or run later".to_owned(),
        (_, false, true) => "give the attachment a \"clear\" value".to_owned(),
        (_, false, false) => "let a pass write it, or make it \"lifetime\": \"imported\" if the host fills it".to_owned(),
    });
    finding
}

fn unordered_writers(pipeline: &Pipeline, resource: ResourceHandle, a: &Access<'_>, b: &Access<'_>) -> Diagnostic {
    let (first, second) = if a.pass < b.pass { (a, b) } else { (b, a) };
    let name = |access: &Access<'_>| &pipeline.pass(access.pass).name;
    let resource = &pipeline.resource(resource).name;
    Diagnostic::error(
        codes::UNORDERED_WRITERS,
        second.one.place,
        format!("\"{}\" and \"{}\" both write \"{resource}\", and nothing says which goes first", name(first), name(second)),
    )
    .pointer(&second.one.pointer)
    .related(first.one.place, format!("\"{}\" writes it here", name(first)))
    .help(format!("add \"after\": [\"{}\"] to \"{}\", or the other way round", name(first), name(second)))
}
