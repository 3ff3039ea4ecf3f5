//! Resolved properties of each resource, whatever the order of the passes: its size, format and usages, and WebGPU's
//! rules for them.

pub(crate) mod format;
pub(crate) mod resolved;
pub(crate) mod size;
pub(crate) mod subresources;
pub(crate) mod texture_bytes;
pub(crate) mod texture_rules;
pub(crate) mod view_shape;
