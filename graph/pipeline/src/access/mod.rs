//! Accesses of passes to resources: usages, subresources, versions.

pub(crate) mod subresource_range;
pub(crate) mod usage;
pub(crate) mod version;

pub(crate) use subresource_range::{Aspect, IndexRange, SubresourceRange, canonical};
pub(crate) use usage::Usage;
pub(crate) use version::Version;
