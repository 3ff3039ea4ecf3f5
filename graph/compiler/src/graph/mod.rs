//! Passes and resource versions as a graph, with every hazard an edge.
//!
//! Each write makes a new version of the subresource range of a resource that it covers. Edges run from a pass to the
//! versions that it writes, from a version to the passes that read it, and from pass to pass for what has no data of
//! its own:
//!
//! - read after write: writer → version → reader;
//! - write after read: a reader of a version runs before the next writer of that subresource range;
//! - write after write: writers of one subresource range run in their order;
//! - explicit: `after`.
//!
//! Module `writers` orders writers and gives readers their versions; this file has the result.
//!
//! Cost: linear in passes, accesses and edges, for a bounded number of writers that touch one subresource range out of
//! order.

pub(crate) mod access;
pub(crate) mod build;
pub(crate) mod conditions;
pub(crate) mod cycle;
pub(crate) mod discards;
pub(crate) mod jagged_array;
pub(crate) mod later;
pub(crate) mod ready;
pub(crate) mod writers;

use std::collections::BTreeSet;

use petgraph::Direction;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef as _;

use crate::graph::jagged_array::JaggedArray;
use crate::regions::partial_read::PartialRead;
use umbragraph_pipeline::pipeline::SubresourceRange;
use umbragraph_pipeline::work::{PassHandle, ResourceHandle};

/// A node of the dependency graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GraphNode {
    /// A pass of the pipeline.
    Pass(PassHandle),
    /// The version of a subresource range that one write made.
    Version {
        /// The resource.
        resource: ResourceHandle,
        /// The subresource range.
        range: SubresourceRange,
        /// The version number: counts the writes of the resource in order, from 1.
        number: u32,
        /// The pass that writes this version.
        writer: PassHandle,
    },
}

/// An edge of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edge {
    /// An edge from a pass to a version that it writes.
    Writes,
    /// An edge from a version to a pass that reads it.
    Reads,
    /// An edge from a pass to another that must run later.
    Order(Hazard),
}

/// The reason why one pass must run before another although no data flows between them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Hazard {
    /// The first reads what the second overwrites.
    WriteAfterRead(ResourceHandle),
    /// Both write the same subresource range.
    WriteAfterWrite(ResourceHandle),
    /// The pipeline document declares the order with `after`.
    Explicit,
}

/// The dependency graph of passes and resource versions, with an order that respects all edges.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The graph.
    pub graph: DiGraph<GraphNode, Edge>,
    /// All passes, including culled ones, in an order that respects every edge; document order where there is a choice.
    pub order: Vec<PassHandle>,
    pub(crate) nodes: Vec<NodeIndex>,
    /// The nodes of the versions of each resource, in their order.
    pub(crate) versions: JaggedArray<NodeIndex>,
    /// The passes that have to run after each pass, for whatever reason; repetitions are possible.
    pub(crate) successors: JaggedArray<PassHandle>,
    /// The reads that may have more edges than there is data.
    pub(crate) coarse: BTreeSet<(PassHandle, ResourceHandle)>,
    /// The reads of which something may not be written, as sizes decide.
    pub(crate) partial: Vec<PartialRead>,
}

impl Graph {
    /// Returns the graph node of a pass.
    pub fn node(&self, pass: PassHandle) -> NodeIndex {
        self.nodes[pass.index()]
    }

    /// Returns the passes whose writes a pass reads, each with the resource.
    pub fn producers(&self, pass: PassHandle) -> impl Iterator<Item = (PassHandle, ResourceHandle)> + '_ {
        self.graph.edges_directed(self.node(pass), Direction::Incoming).filter_map(|edge| {
            match self.graph[edge.source()] {
                GraphNode::Version { resource, writer, .. } => Some((writer, resource)),
                GraphNode::Pass(_) => None,
            }
        })
    }

    /// Returns the passes that read a pass's writes, each with the resource.
    pub fn consumers(&self, pass: PassHandle) -> impl Iterator<Item = (PassHandle, ResourceHandle)> + '_ {
        self.versions(pass).flat_map(move |(node, resource)| {
            self.graph.neighbors(node).filter_map(move |reader| match self.graph[reader] {
                GraphNode::Pass(reader) => Some((reader, resource)),
                GraphNode::Version { .. } => None,
            })
        })
    }

    /// The passes that read what a pass writes of a resource, sorted.
    pub(crate) fn readers(&self, pass: PassHandle, resource: ResourceHandle) -> BTreeSet<PassHandle> {
        self.consumers(pass).filter(|(_, of)| *of == resource).map(|(reader, _)| reader).collect()
    }

    /// Whether a pass reads a resource with more writers of different ranges or toggles than are distinguished. The
    /// pass may then be connected to writers of which it reads nothing.
    pub fn is_coarse(&self, reader: PassHandle, resource: ResourceHandle) -> bool {
        self.coarse.contains(&(reader, resource))
    }

    /// The versions of a resource in their order: the subresource range, and the pass that wrote it.
    pub fn versions_of(
        &self,
        resource: ResourceHandle,
    ) -> impl DoubleEndedIterator<Item = (SubresourceRange, PassHandle)> + '_ {
        self.versions[resource.index()].iter().filter_map(|node| match self.graph[*node] {
            GraphNode::Version { range, writer, .. } => Some((range, writer)),
            GraphNode::Pass(_) => None,
        })
    }

    /// The versions that a pass writes, each with its resource.
    fn versions(&self, pass: PassHandle) -> impl Iterator<Item = (NodeIndex, ResourceHandle)> + '_ {
        self.graph.neighbors(self.node(pass)).filter_map(|node| match self.graph[node] {
            GraphNode::Version { resource, .. } => Some((node, resource)),
            GraphNode::Pass(_) => None,
        })
    }
}
