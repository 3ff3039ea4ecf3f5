//! Reads of which something may not be written, as the graph leaves them to be decided when sizes are known.

use crate::regions::extents::Extents;
use umbragraph_pipeline::pipeline::{Condition, SubresourceRange};
use umbragraph_pipeline::source::Span;
use umbragraph_pipeline::work::PassHandle;

/// A read of which a subresource range may not be written.
#[derive(Clone, Debug)]
pub(crate) struct PartialRead {
    pub(crate) reader: PassHandle,
    /// The index of the access among those of its pass.
    pub(crate) at: usize,
    pub(crate) left: Left,
}

/// The remainder of a read that no write covers.
#[derive(Clone, Debug)]
pub(crate) enum Left {
    /// These boxes, as far as they exist.
    Boxes(Vec<Extents>),
    /// All but these ranges, which have one mip and one layer at most.
    AllBut(Vec<SubresourceRange>),
    /// Boxes in frames in which a condition does not hold, each with the pass that writes it in others, and where.
    Toggled(Vec<(Extents, PassHandle, Span, Condition)>),
    /// Boxes that a copy of texels to a buffer leaves between its rows.
    BetweenRows(Vec<Extents>),
}
