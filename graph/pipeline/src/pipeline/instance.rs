//! Passes and resources once loops and subgraphs are expanded.

use std::sync::Arc;

use super::environment::Environment;
use crate::document::Entry;

/// A pass, a use of a subgraph or a resource as it is used once.
#[derive(Clone)]
pub(in crate::pipeline) struct Instance<'a> {
    /// Its name outside of all subgraphs; what the names of the passes of a used subgraph start with.
    pub(in crate::pipeline) name: String,
    pub(in crate::pipeline) entry: &'a Entry,
    pub(in crate::pipeline) pointer: String,
    /// The scope of names there.
    pub(in crate::pipeline) environment: Arc<Environment>,
    /// Whether it does not fit the schema, so that it has diagnostics already.
    pub(in crate::pipeline) is_broken: bool,
}
