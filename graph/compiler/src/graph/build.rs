//! Builds the graph of a pipeline.

use crate::graph::Graph;
use crate::graph::access::accesses;
use crate::graph::discards;
use crate::graph::writers::Builder;
use crate::memory::history;
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::pipeline::TypedPipeline;

/// Builds the graph of a pipeline.
///
/// Diagnostics: reads of what nothing writes or of what is discarded, unordered writers, cycles, a pass that reads and
/// writes one subresource range in a way that no device allows. The result is `None` after errors that leave no order.
pub fn build(pipeline: &TypedPipeline, diagnostics: &mut Diagnostics) -> Option<Graph> {
    history::check_use(pipeline, diagnostics);
    let accesses = accesses(pipeline, diagnostics);
    let mut builder = Builder::new(pipeline, &accesses);
    let graph = builder.order_all(diagnostics).then(|| builder.finish())?;
    discards::check(pipeline, &graph, diagnostics);
    Some(graph)
}
