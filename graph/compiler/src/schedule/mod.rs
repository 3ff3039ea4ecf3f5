//! Schedule of the passes: those that run, their order, and the render passes that they share.

pub(crate) mod cull;
pub(crate) mod memory_order;
pub(crate) mod merge;
pub(crate) mod order;
