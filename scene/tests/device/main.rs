//! Scenes on a device, drawn through the draw contract as an executor would.

#[path = "../scenes/document.rs"]
#[allow(dead_code, reason = "shared with the tests that need no device")]
mod document;
mod drawing;
mod stand_in;
