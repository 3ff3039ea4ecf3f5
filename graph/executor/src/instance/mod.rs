//! A plan on a device: everything that it needs, taken over from the plan before where it can be.

pub(crate) mod instantiate;
pub(crate) mod parameters;
pub(crate) mod pipelines;
pub(crate) mod preparation;
pub(crate) mod requirements;
