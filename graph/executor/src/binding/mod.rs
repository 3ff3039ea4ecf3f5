//! Bind groups of the module's own resources, and of the host's materials and objects.

pub(crate) mod blocks;
pub(crate) mod draw;
pub(crate) mod groups;
pub(crate) mod host_groups;
