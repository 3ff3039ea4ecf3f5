//! Bind groups: of what the module binds, and of the materials and objects of the host.

pub(crate) mod blocks;
pub(crate) mod draw;
pub(crate) mod groups;
pub(crate) mod host_groups;
