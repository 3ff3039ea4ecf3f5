//! WGSL text to a validated naga module, and from there to the language of a backend.

pub(crate) mod backend;
mod invalid;
pub(crate) mod wgsl;
pub(crate) mod wgsl_error;
