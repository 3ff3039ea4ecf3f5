//! What each resource is, whatever the order of the passes: its size, its format, its usages, and the rules of WebGPU for
//! those.

pub(crate) mod format;
pub(crate) mod resolved;
pub(crate) mod size;
pub(crate) mod subresources;
pub(crate) mod texture_rules;
