//! The front door: from a file to a plan with [`Library`], [`Pipeline`] and [`Options`].

mod library;
mod options;
mod pipeline;

pub use library::Library;
pub use options::{Options, Setting};
pub use pipeline::Pipeline;
