//! graph
pub mod compiler;
pub mod data;
pub mod diagnostic;
pub mod document;
pub mod draw;
pub mod expression;
pub mod frame;
pub mod language;
pub mod node;
pub mod pipeline;
pub mod shader;
pub mod source;
pub mod work;
