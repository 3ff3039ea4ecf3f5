//! Reads of which something may not be written, as the graph leaves them to be decided when sizes are known.

use crate::regions::extents::Extents;
use umbragraph_pipeline::pipeline::{Condition, SubresourceRange};
use umbragraph_pipeline::source::Span;
use umbragraph_pipeline::work::PassHandle;

/// A read that may find unwritten contents in part of its subresource range.
#[derive(Clone, Debug)]
pub(crate) struct PartialRead {
    pub(crate) reader: PassHandle,
    /// The index of the access in the access list of its pass.
    pub(crate) at: usize,
    pub(crate) left: Left,
}

/// The part of the subresource range of a read that no write covers.
#[derive(Clone, Debug)]
pub(crate) enum Left {
    /// These boxes, as far as they lie within the resource.
    Boxes(Vec<Extents>),
    /// All but these plain ranges (one or all mip levels, one or all layers).
    AllBut(Vec<SubresourceRange>),
    /// Boxes that are unwritten in frames in which a condition does not hold. Each has the pass that writes the box in
    /// other frames, and the place of that write.
    Toggled(Vec<(Extents, PassHandle, Span, Condition)>),
    /// Boxes that a copy of texels to a buffer leaves between its rows.
    BetweenRows(Vec<Extents>),
}
