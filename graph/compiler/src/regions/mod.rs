//! Sets of mips, layers, aspects and bytes of one resource, together with states of toggles: what covers what, what is
//! seen through what, and what follows from what.

pub(crate) mod extents;
pub(crate) mod implied;
pub(crate) mod partial_read;
pub(crate) mod runs;
pub(crate) mod visible;
