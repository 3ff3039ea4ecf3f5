//! Values of expressions in a plan: the blocks that shaders read, and the settings that live parameters change.

pub(crate) mod packed;
pub(crate) mod settings;
