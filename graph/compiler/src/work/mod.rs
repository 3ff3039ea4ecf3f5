//! What sizes come to in the work of a pass: copies, numbers of workgroups, and what draws need of their buffers.

pub(crate) mod copies;
pub(crate) mod dispatch;
pub(crate) mod drawn_buffers;
