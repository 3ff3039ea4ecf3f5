//! Builds the graph of a pipeline.

use std::collections::BTreeSet;

use crate::graph::Graph;
use crate::graph::access::accesses;
use crate::graph::discards;
use crate::graph::misfits::{misfits, unwritten};
use crate::graph::writers::Builder;
use crate::memory::history;
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::pipeline::TypedPipeline;
use umbragraph_pipeline::work::ResourceHandle;

/// Builds the dependency graph of a pipeline. Returns `None` if errors leave no valid order of the passes.
///
/// Diagnostics: reads of contents that are never written or are discarded, writers without an order, and cycles. Also a
/// pass that reads and writes one subresource range in a way that no device allows.
pub fn build(pipeline: &TypedPipeline, diagnostics: &mut Diagnostics) -> Option<Graph> {
    history::check_use(pipeline, diagnostics);
    let mut unclear = BTreeSet::new();
    let accesses = accesses(pipeline, &mut unclear, diagnostics);
    let misfits = misfits(pipeline);
    let mut suspects: BTreeSet<ResourceHandle> = misfits.iter().map(|(resource, _)| *resource).collect();
    if !misfits.is_empty() {
        suspects.extend(unwritten(pipeline));
    }
    unclear.extend(&suspects);
    let mut builder = Builder::new(pipeline, &accesses, unclear);
    let is_ordered = builder.order_all(diagnostics);
    // Formats are checked with the plan; here only if the order of passes fails because of one.
    let is_fit = builder.untold.is_disjoint(&suspects);
    if !is_fit {
        diagnostics.extend(misfits.into_iter().map(|(_, diagnostic)| diagnostic));
    }
    let graph = (is_ordered && is_fit).then(|| builder.finish())?;
    discards::check(pipeline, &graph, diagnostics);
    Some(graph)
}
