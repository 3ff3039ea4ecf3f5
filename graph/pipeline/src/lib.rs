//! Typed pipelines, and the interface that node kinds are written against.
//!
//! [`pipeline::load`] makes a [`pipeline::TypedPipeline`] of a document: one configuration, with a value for each
//! parameter and feature. Its passes are declared by node kinds ([`node`]), each with its [`work`]: data that a device
//! is not needed for. Host and passes exchange [`data`], [`frame`] and [`draw`] in each frame. The crates below are
//! re-exported: a crate of node kinds needs this one alone.

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
