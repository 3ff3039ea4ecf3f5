//! Requests that were explored, and texts that were proven.

use std::sync::Arc;

use super::explore::Exploration;
use super::prove::Proof;
use super::request::Request;
use super::validator::Opinion;
use crate::axes::Space;
use crate::written::text_map::Source;

/// A request that can be explored, with what came of it.
pub(super) struct Explored<'a> {
    pub(super) request: &'a Request,
    pub(super) space: Arc<Space>,
    pub(super) exploration: Exploration,
    /// The index of each distinct text among all tasks.
    pub(super) tasks: Vec<usize>,
}

/// The proof of a distinct text.
pub(super) struct Proven {
    pub(super) proof: Proof,
    pub(super) opinions: Vec<Opinion>,
    /// The text, where somebody rejects it, or advises against something in it.
    pub(super) source: Option<Source>,
}
