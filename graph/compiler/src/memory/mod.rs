//! Where resources lie: textures and buffers of a plan, which resources share one, and which take turns from frame to frame.

pub(crate) mod history;
pub(crate) mod lifetime;
pub(crate) mod physical;
