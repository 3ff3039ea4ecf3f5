//! A plan on a device: its objects, reused from the plan before if possible.

pub(crate) mod instantiate;
pub(crate) mod parameters;
pub(crate) mod pipelines;
pub(crate) mod preparation;
pub(crate) mod requirements;
