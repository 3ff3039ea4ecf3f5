//! Objects of a device, made once and shared.

pub(crate) mod cache;
pub(crate) mod creation;
pub(crate) mod shared;
