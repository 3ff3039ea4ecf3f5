//! Texts of pipelines: JSON documents with places, and the language that they are written in.
//!
//! ```text
//! files ──read──▶ Sources ──parse──▶ Document ──compose──▶ one Document ──decode──▶ declarations
//! ```
//!
//! - [`source`]: registered texts, and places in them;
//! - [`diagnostic`], [`Error`]: errors and warnings with a code, a place and a way out;
//! - [`document`]: JSON in which each value keeps its place; [`edit`]: changes of its text that keep comments and
//!   layout;
//! - [`compose`]: several files as one document (`extends`, `include`, `use`);
//! - [`expression`]: strings that begin with `=` or `&`;
//! - [`language`]: the types that documents are decoded into.
//!
//! Nothing here knows of shaders, node kinds or devices.

pub mod compose;
pub mod diagnostic;
pub mod document;
pub mod edit;
mod error;
pub mod expression;
pub mod language;
pub mod model;
mod setters;
pub mod source;

pub use error::Error;
