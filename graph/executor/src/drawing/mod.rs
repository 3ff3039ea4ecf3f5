//! Attachments of render passes, and what of them need not be drawn again.

pub(crate) mod attachments;
pub(crate) mod buffer_draw;
pub(crate) mod redraw;
pub(crate) mod scroll;
