//! The tools of umbragraph: what looks at pipelines and plans, and makes neither.
//!
//! - [`check`], [`check_document`]: the whole way from a text to a plan in one call;
//! - [`Configurations`], [`check_configurations`], [`reach`]: the configurations of a pipeline, chosen, checked
//!   and proven;
//! - [`report`] and [`why`]: a plan shown, and the reasons for it;
//! - [`capture`]: textures of a frame for somebody to look at.

pub mod capture;
mod check;
mod configurations;
mod cover;
mod coverage;
mod dependence;
mod reach;
mod remarks;
pub mod report;
mod thresholds;
mod unused;
mod varied;
mod varied_setting;
pub mod why;
mod witness;

pub use check::{CheckOptions, CheckReport, check, check_document, check_sharing};
pub use configurations::{Configuration, Configurations, MAX as MAX_CONFIGURATIONS};
pub use cover::Cover;
pub use coverage::{Coverage, Examination, Judge, Verify, check_configurations};
pub use reach::{AxisProduct, Reached, ReachedProgram, reach};
pub use remarks::Remarks;
