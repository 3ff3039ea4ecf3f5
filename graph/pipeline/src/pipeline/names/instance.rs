//! Passes and resources once loops and subgraphs are expanded.

use std::sync::Arc;

use crate::pipeline::names::environment::Environment;
use umbragraph_text::document::Entry;

/// One instance of a pass, a use of a subgraph or a resource, after loops and subgraphs are expanded.
#[derive(Clone)]
pub(crate) struct Instance<'a> {
    /// The name outside of all subgraphs; for a use of a subgraph, the first part of the names of its passes.
    pub(crate) name: String,
    pub(crate) entry: &'a Entry,
    pub(crate) pointer: String,
    /// The scope of names for expressions in the entry.
    pub(crate) environment: Arc<Environment>,
    /// Whether the entry does not fit the schema. A diagnostic was then reported.
    pub(crate) is_broken: bool,
}
