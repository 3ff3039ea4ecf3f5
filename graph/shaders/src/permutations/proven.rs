//! Requests that were explored, and what is known of their texts.

use std::sync::Arc;

use super::explore::Exploration;
use super::report::Costs;
use super::request::Request;
use crate::axes::Space;
use crate::reflection::Reflection;

/// A request whose template paths have been explored.
pub(super) struct Explored<'a> {
    pub(super) request: &'a Request,
    /// The index of the request among all requests.
    pub(super) at: usize,
    pub(super) space: Arc<Space>,
    pub(super) exploration: Arc<Exploration>,
    /// The index in [`Composition::texts`](super::compose::Composition::texts) of each distinct module.
    pub(super) tasks: Vec<usize>,
}

/// The result of validating a module for the profiles of a request.
#[derive(Clone, Debug, Default)]
pub(super) struct Verdict {
    /// Whether every profile accepts the module.
    pub(super) is_valid: bool,
    /// The reflection; `None` if no profile accepts the module.
    pub(super) reflection: Option<Arc<Reflection>>,
    pub(super) costs: Arc<Costs>,
}
