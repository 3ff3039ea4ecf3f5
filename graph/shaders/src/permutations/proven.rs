//! Requests that were explored, and what is known of their texts.

use std::sync::Arc;

use super::explore::Exploration;
use super::report::Costs;
use super::request::Request;
use crate::axes::Space;
use crate::reflection::Reflection;

/// A request that can be explored, with what came of it.
pub(super) struct Explored<'a> {
    pub(super) request: &'a Request,
    /// Its index among all requests.
    pub(super) at: usize,
    pub(super) space: Arc<Space>,
    pub(super) exploration: Arc<Exploration>,
    /// The index of each distinct text among all of all requests.
    pub(super) tasks: Vec<usize>,
}

/// The verdict of a text.
#[derive(Clone, Debug, Default)]
pub(super) struct Verdict {
    /// Whether every profile accepts it.
    pub(super) is_valid: bool,
    /// The reflection, if at least one profile accepts it.
    pub(super) reflection: Option<Arc<Reflection>>,
    pub(super) costs: Arc<Costs>,
}
