//! Sizes in the work of a pass: copies, workgroup counts, and the elements that draws need of their buffers.

pub(crate) mod copies;
pub(crate) mod dispatch;
pub(crate) mod drawn_buffers;
