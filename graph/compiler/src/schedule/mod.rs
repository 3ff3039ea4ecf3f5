//! Which passes run, in which order, and which of them share a render pass.

pub(crate) mod cull;
pub(crate) mod memory_order;
pub(crate) mod merge;
pub(crate) mod order;
