//! Textures and buffers of a plan: of its own, of the host, of earlier frames.

pub(crate) mod histories;
pub(crate) mod imports;
pub(crate) mod pool;
pub(crate) mod read_back;
pub(crate) mod resources;
pub(crate) mod reuse;
pub(crate) mod samples;
pub(crate) mod textures;
pub(crate) mod transfer;
