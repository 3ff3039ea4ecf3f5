//! The pipeline room of umbragraph: what node kinds are written against.
//!
//! A [`pipeline::TypedPipeline`] is one typed configuration of a document, made by [`pipeline::load`]; its passes are declared
//! by node kinds ([`node`]), each with its [`work`]. [`data`], [`frame`] and [`draw`] are what host and passes exchange at
//! each frame. The rooms below are re-exported: this crate is all that a crate of node kinds needs.

pub use glam;
pub use umbragraph_shaders as shader;
pub use umbragraph_text::{
    Error, codes, compose, diagnostic, document, expression, language, model, setters, source, webgpu_words,
};
pub use wgpu_types;

mod access;
pub mod data;
pub mod draw;
pub mod frame;
pub mod node;
pub mod pipeline;
mod projection;
mod whole_number;
pub mod work;
