//! Accesses of passes to resources: usages, subresources, versions.

pub(crate) mod subresource_range;
pub(crate) mod usage;
pub(crate) mod version;
