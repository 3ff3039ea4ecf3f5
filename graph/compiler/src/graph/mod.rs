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
pub(crate) mod misfits;
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
    /// The version (contents) of a subresource range that one write makes.
    Version {
        /// The resource that is written.
        resource: ResourceHandle,
        /// The subresource range that is written.
        range: SubresourceRange,
        /// The version number: the writes of the resource are counted in order, from 1.
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
    /// The first pass reads contents of this resource that the second pass overwrites.
    WriteAfterRead(ResourceHandle),
    /// Both passes write overlapping subresource ranges of this resource.
    WriteAfterWrite(ResourceHandle),
    /// The pipeline document declares the order with `after`.
    Explicit,
}

/// The dependency graph of passes and resource versions, with an order that respects all edges.
#[derive(Clone, Debug)]
pub struct Graph {
    /// The nodes and edges of the graph.
    pub graph: DiGraph<GraphNode, Edge>,
    /// All passes, including passes that will be culled, in an order that respects every edge. Where edges leave a
    /// choice, document order decides.
    pub order: Vec<PassHandle>,
    pub(crate) nodes: Vec<NodeIndex>,
    /// The version nodes of each resource in write order, by resource index.
    pub(crate) versions: JaggedArray<NodeIndex>,
    /// The passes that must run after each pass, by pass index; may contain duplicates.
    pub(crate) successors: JaggedArray<PassHandle>,
    /// The reads for which [`Self::is_coarse`] returns `true`, as reader and resource.
    pub(crate) coarse: BTreeSet<(PassHandle, ResourceHandle)>,
    /// The reads that may find unwritten contents; this can be decided only once resource sizes are known.
    pub(crate) partial: Vec<PartialRead>,
}

impl Graph {
    /// Returns the graph node of a pass.
    pub fn node(&self, pass: PassHandle) -> NodeIndex {
        self.nodes[pass.index()]
    }

    /// Returns the passes whose writes a pass reads, each with the resource that is read.
    pub fn producers(&self, pass: PassHandle) -> impl Iterator<Item = (PassHandle, ResourceHandle)> + '_ {
        self.graph.edges_directed(self.node(pass), Direction::Incoming).filter_map(|edge| {
            match self.graph[edge.source()] {
                GraphNode::Version { resource, writer, .. } => Some((writer, resource)),
                GraphNode::Pass(_) => None,
            }
        })
    }

    /// Returns the passes that read the writes of a pass, each with the resource that is read.
    pub fn consumers(&self, pass: PassHandle) -> impl Iterator<Item = (PassHandle, ResourceHandle)> + '_ {
        self.versions(pass).flat_map(move |(node, resource)| {
            self.graph.neighbors(node).filter_map(move |reader| match self.graph[reader] {
                GraphNode::Pass(reader) => Some((reader, resource)),
                GraphNode::Version { .. } => None,
            })
        })
    }

    /// Returns the passes that read the writes of a pass to a resource.
    pub(crate) fn readers(&self, pass: PassHandle, resource: ResourceHandle) -> BTreeSet<PassHandle> {
        self.consumers(pass).filter(|(_, of)| *of == resource).map(|(reader, _)| reader).collect()
    }

    /// Returns `true` if the resource has too many writers with different ranges or toggles for an exact analysis of
    /// the read. The reader may then have edges from writers of which it reads nothing.
    pub fn is_coarse(&self, reader: PassHandle, resource: ResourceHandle) -> bool {
        self.coarse.contains(&(reader, resource))
    }

    /// Returns the versions of a resource in write order, each as its subresource range and the pass that writes it.
    pub fn versions_of(
        &self,
        resource: ResourceHandle,
    ) -> impl DoubleEndedIterator<Item = (SubresourceRange, PassHandle)> + '_ {
        self.versions[resource.index()].iter().filter_map(|node| match self.graph[*node] {
            GraphNode::Version { range, writer, .. } => Some((range, writer)),
            GraphNode::Pass(_) => None,
        })
    }

    /// Returns the nodes of the versions that a pass writes, each with its resource.
    fn versions(&self, pass: PassHandle) -> impl Iterator<Item = (NodeIndex, ResourceHandle)> + '_ {
        self.graph.neighbors(self.node(pass)).filter_map(|node| match self.graph[node] {
            GraphNode::Version { resource, .. } => Some((node, resource)),
            GraphNode::Pass(_) => None,
        })
    }
}
