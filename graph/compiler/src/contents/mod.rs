//! Contents that reads find: texels and bytes that no pass has written, and what toggles leave in place of a resource.

pub(crate) mod toggles;
pub(crate) mod uninitialised;
