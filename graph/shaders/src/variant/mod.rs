//! One variant of a template: values for its axes in, a proven module out.

pub(crate) mod compile;
pub(crate) mod listing;
pub(crate) mod texture_reads;
