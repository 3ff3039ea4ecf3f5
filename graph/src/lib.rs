//! The engine of umbragraph: from the text of a pipeline to frames.
//!
//! ```text
//!  text ──parse──▶ Document ──load──▶ Pipeline ──build──▶ Graph ──plan──▶ Plan ──new──▶ Executor ──record──▶ frame
//! ```
//!
//! Each arrow is one function from one type to the next: [`document::parse`], [`pipeline::load`],
//! [`compiler::build`], [`compiler::plan`]; with the feature `gpu` an executor realizes plans with wgpu. Everything
//! before that is deterministic and needs no device. [`check`] goes all the way in one call.
//!
//! Findings are collected, never the first only: see [`diagnostic`]. What a pass can be is open: see [`node`]. This
//! crate knows nothing of shadows; the node kinds that do are built on its public interface alone.

pub mod compiler;
pub mod compose;
pub mod data;
pub mod diagnostic;
pub mod document;
pub mod draw;
#[cfg(feature = "gpu")]
pub mod executor;
pub mod expression;
pub mod frame;
pub mod language;
pub mod node;
pub mod pipeline;
pub mod report;
pub mod shader;
pub mod source;
pub mod why;
pub mod work;

mod check;
mod coverage;

pub use check::{Checked, Job, check, check_document, check_path};
pub use compose::read_source;
pub use coverage::{Coverage, check_configurations};
#[cfg(feature = "gpu")]
pub use wgpu;
pub use wgpu_types;
