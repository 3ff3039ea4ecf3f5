//! The tools of umbragraph: what looks at pipelines and plans, and makes neither.
//!
//! - [`check`], [`check_document`]: the whole way from a text to a plan in one call;
//! - [`Configurations`], [`check_configurations`], [`reach`]: the configurations of a pipeline, chosen, checked
//!   and proven;
//! - [`verify`](verify::verify): a second opinion on a plan, which shares no code with what made it;
//! - [`report`] and [`why`]: a plan shown, and the reasons for it;
//! - [`capture`]: textures of a frame for somebody to look at.

use umbragraph_compiler as compiler;
use umbragraph_pipeline::{
    compose, data, diagnostic, document, expression, language, node, pipeline, shader, source, work,
};

pub mod capture;
mod check;
mod configurations;
mod cover;
mod coverage;
mod dependence;
#[cfg(test)]
mod property_tests;
#[cfg(test)]
mod property_tests_toggles;
#[cfg(test)]
mod property_tests_uninitialised;
#[cfg(test)]
mod property_tests_writers;
mod reach;
mod remarks;
pub mod report;
mod thresholds;
mod unused;
mod varied;
mod varied_setting;
pub mod verify;
pub mod why;
mod witness;

pub use check::{CheckOptions, CheckReport, check, check_document, check_sharing};
pub use configurations::{Configuration, Configurations, MAX as MAX_CONFIGURATIONS};
pub use cover::Cover;
pub use coverage::{Coverage, Judge, check_configurations};
pub use reach::{AxisProduct, Reached, ReachedProgram, reach};
pub use remarks::Remarks;
