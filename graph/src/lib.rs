//! The engine of umbragraph: from the text of a pipeline to frames.
//!
//! ```text
//!  text ──parse──▶ Document ──load──▶ Pipeline ──build──▶ Graph ──plan──▶ Plan ──new──▶ Executor ──record──▶ frame
//! ```
//!
//! Each arrow is one function from one type to the next: [`document::parse`], [`pipeline::load`],
//! [`compiler::build`], [`compiler::plan`]; with the feature `gpu` an executor instantiates plans with wgpu. Everything
//! before that is deterministic and needs no device. [`check`](check()) goes all the way in one call.
//!
//! Diagnostics are collected, never the first only: see [`diagnostic`]. What a pass can be is open: see [`node`]. This
//! crate knows nothing of shadows; the node kinds that do are built on its public interface alone.
//!
//! This crate is the facade of the engine's crates, of which each sees only those before it:
//!
//! ```text
//!  text ◀── shaders ◀── pipeline ◀── compiler ◀─┬─ executor
//!                                               └─ tools
//! ```

pub use umbragraph_shaders as shader;
pub use umbragraph_text::{
    Error, codes, compose, diagnostic, document, edit, expression, language, model, source,
};

pub use umbragraph_pipeline::{data, frame, glam, node, work};

pub use umbragraph_tools::{
    CheckOptions, CheckReport, Coverage, Examination, Verify, capture, check, check_configurations,
    check_document, check_sharing, report, why,
};

#[cfg(feature = "gpu")]
pub use umbragraph_executor as executor;
#[cfg(feature = "gpu")]
pub use wgpu;
pub use wgpu_types;

pub use compose::read_source;

/// The draw contract: the way the host's meshes enter a pass.
///
/// A [`HostInterface`](draw::HostInterface) describes how the host stores its meshes, without a device; with the
/// feature `gpu`, a `DrawSource` draws them into a `DrawPass`.
pub mod draw {
    #[cfg(feature = "gpu")]
    pub use umbragraph_executor::{DrawPass, DrawSource};
    pub use umbragraph_pipeline::draw::*;
}

/// Loading of one typed configuration of a pipeline, and enumeration of all configurations.
///
/// [`load`](pipeline::load) loads a configuration from a document. [`Configurations`](pipeline::Configurations) lists
/// configurations; [`reach`](pipeline::reach) finds the shader variants that they use.
pub mod pipeline {
    pub use umbragraph_pipeline::pipeline::*;
    pub use umbragraph_tools::{
        AxisProduct, Configuration, Configurations, Cover, MAX_CONFIGURATIONS, Reached, ReachedProgram,
        Surveyed, reach,
    };
}

pub use umbragraph_compiler as compiler;
