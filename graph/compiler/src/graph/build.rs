//! Builds the graph of a pipeline.

use crate::graph::Graph;
use crate::graph::access::accesses;
use crate::graph::discards;
use crate::graph::writers::Builder;
use crate::memory::history;
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::pipeline::TypedPipeline;

/// Builds the dependency graph of a pipeline. Returns `None` if errors leave no valid order of the passes.
///
/// Diagnostics: reads of contents that are never written or are discarded, writers without an order, and cycles. Also a
/// pass that reads and writes one subresource range in a way that no device allows.
pub fn build(pipeline: &TypedPipeline, diagnostics: &mut Diagnostics) -> Option<Graph> {
    history::check_use(pipeline, diagnostics);
    let accesses = accesses(pipeline, diagnostics);
    let mut builder = Builder::new(pipeline, &accesses);
    let graph = builder.order_all(diagnostics).then(|| builder.finish())?;
    discards::check(pipeline, &graph, diagnostics);
    Some(graph)
}
