//! Frames: their inputs and their commands.

pub(crate) mod input;
pub(crate) mod inputs;
pub(crate) mod record;
pub(crate) mod scene;
