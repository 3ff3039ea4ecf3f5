//! What a plan is made for: the viewport, the host's own textures, and what the order of the passes is to be good for.

pub(crate) mod objective;
pub(crate) mod options;
pub(crate) mod texture_size;
