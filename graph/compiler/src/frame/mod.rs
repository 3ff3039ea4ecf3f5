//! What changes from frame to frame without a device: live parameters, what CPU passes keep and publish, and the toggles.

pub(crate) mod cpu_passes;
pub(crate) mod parameters;
pub(crate) mod switches;
