//! Contents that reads find: texels and bytes that no pass has written, and what toggles leave in place of a resource.

pub(crate) mod toggles;
pub(crate) mod uninitialised;

use crate::graph::Graph;
use crate::resources::resolved::ResolvedResources;
use umbragraph_pipeline::work::PassHandle;

/// The resolved resources and the graph of a pipeline, with a test whether a pass is live (not culled).
#[derive(Clone, Copy)]
pub(crate) struct LiveResources<'r, 'a> {
    pub(crate) resolved: &'r ResolvedResources<'a>,
    pub(crate) graph: &'r Graph,
    pub(crate) is_live: &'r dyn Fn(PassHandle) -> bool,
}
