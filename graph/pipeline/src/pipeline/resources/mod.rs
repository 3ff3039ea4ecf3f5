//! Resources in one configuration: declared values that depend on parameters, and histories.

pub(crate) mod history;
pub(crate) mod value;
