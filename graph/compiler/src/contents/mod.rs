//! Contents that reads find: texels and bytes that no pass has written, and what toggles leave in place of a resource.

pub(crate) mod toggles;
pub(crate) mod uninitialised;

use crate::graph::Graph;
use crate::resources::resolved::ResolvedResources;
use umbragraph_pipeline::work::PassHandle;

/// Resources as the passes that run use them.
#[derive(Clone, Copy)]
pub(crate) struct LiveResources<'r, 'a> {
    pub(crate) resolved: &'r ResolvedResources<'a>,
    pub(crate) graph: &'r Graph,
    pub(crate) is_live: &'r dyn Fn(PassHandle) -> bool,
}
