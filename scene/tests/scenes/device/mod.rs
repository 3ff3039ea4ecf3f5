//! Scenes on a device, drawn through the draw contract as an executor would.

mod drawing;
mod stand_in;
