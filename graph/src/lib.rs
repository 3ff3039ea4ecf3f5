//! graph
pub mod diagnostic;
pub mod document;
pub mod expression;
pub mod frame;
pub mod source;
