//! Memory of a plan: its textures and buffers, the resources that share one, and those that take turns from frame to
//! frame.

pub(crate) mod history;
pub(crate) mod lifetime;
pub(crate) mod physical;
