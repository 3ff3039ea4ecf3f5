//! Inputs of a plan: the viewport, the host's own textures, and the objective of the order.

pub(crate) mod objective;
pub(crate) mod options;
pub(crate) mod texture_size;
