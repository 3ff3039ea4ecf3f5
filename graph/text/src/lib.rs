//! The text room of umbragraph: what is known of a pipeline before anything is made of it.
//!
//! Registered texts ([`source`]), what is wrong with them ([`diagnostic`], [`Error`]), JSON with places ([`document`]) and changes of
//! it ([`edit`]), several files as one ([`compose`]), expressions ([`expression`]), and the types that documents are decoded into ([`language`]).
//! Nothing here knows of shaders, passes at work, or devices.

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
