//! The guarantees of a target: its profile, and the limits and capabilities that pipelines can require by name.

pub(crate) mod capabilities;
pub(crate) mod named_limits;
pub(crate) mod profile;
