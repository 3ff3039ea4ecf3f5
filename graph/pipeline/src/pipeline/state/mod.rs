//! Declarations of one pipeline so far: resources, programs, diagnostics.

pub(crate) mod programs;
pub(crate) mod shared;
