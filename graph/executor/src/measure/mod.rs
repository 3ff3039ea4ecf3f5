//! Counts and times of frames.

pub(crate) mod gpu_times;
pub(crate) mod statistics;
pub(crate) mod times;
