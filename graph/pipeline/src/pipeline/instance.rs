//! Passes and resources once loops and subgraphs are expanded.

use std::sync::Arc;

use super::environment::Environment;
use crate::document::Entry;

/// A pass or resource as it is used once.
pub(super) struct Instance<'a> {
    pub(super) name: String,
    pub(super) entry: &'a Entry,
    pub(super) pointer: String,
    pub(super) environment: Arc<Environment>,
    /// Whether it does not fit the schema, so that it has diagnostics already.
    pub(super) is_broken: bool,
}

/// A pass, or a use of a subgraph, that says "after".
pub(in crate::pipeline) struct Waiting<'a> {
    /// Its name outside of all subgraphs.
    pub(in crate::pipeline) name: String,
    pub(in crate::pipeline) entry: &'a Entry,
    pub(in crate::pipeline) pointer: String,
    /// The scope of names there.
    pub(in crate::pipeline) environment: Arc<Environment>,
}
