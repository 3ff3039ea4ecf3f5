//! Sets of mips, layers, aspects and bytes of one resource, together with states of toggles: what covers what, what is
//! seen through what, and what follows from what.

pub(crate) mod extents;
pub(crate) mod implied;
pub(crate) mod partial_read;
pub(crate) mod runs;
pub(crate) mod visible;

pub(crate) use extents::{Extents, extents};
pub(crate) use implied::Unmet;
pub(crate) use partial_read::{Left, PartialRead};
pub(crate) use runs::{Runs, between, joined};
pub(crate) use visible::{Effort, View, Write};
