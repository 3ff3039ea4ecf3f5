//! Passes and resources once loops and subgraphs are expanded.

use std::sync::Arc;

use crate::pipeline::names::environment::Environment;
use umbragraph_text::document::Entry;

/// A pass, a use of a subgraph or a resource as it is used once.
#[derive(Clone)]
pub(crate) struct Instance<'a> {
    /// Its name outside of all subgraphs; what the names of the passes of a used subgraph start with.
    pub(crate) name: String,
    pub(crate) entry: &'a Entry,
    pub(crate) pointer: String,
    /// The scope of names there.
    pub(crate) environment: Arc<Environment>,
    /// Whether it does not fit the schema, so that it has diagnostics already.
    pub(crate) is_broken: bool,
}
