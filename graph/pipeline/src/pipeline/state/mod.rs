//! What has been declared of one pipeline so far: resources, programs, diagnostics.

pub(crate) mod programs;
pub(crate) mod shared;
