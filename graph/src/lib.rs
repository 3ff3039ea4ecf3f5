//! graph
pub mod diagnostic;
pub mod frame;
pub mod source;
