//! State that changes from frame to frame without a device: live parameters, data and state of CPU passes, and the
//! toggles.

pub(crate) mod cpu_passes;
pub(crate) mod parameters;
pub(crate) mod switches;
