//! Tools that check, report and explain pipelines and plans.
//!
//! - [`check`], [`check_document`]: from a text to a plan in one call;
//! - [`Configurations`], [`check_configurations`], [`reach`]: the configurations of a pipeline, chosen, checked
//!   and proven;
//! - [`report`] and [`why`]: a plan as text, SVG or data, and the reasons for it;
//! - [`capture`]: textures of a frame, copied for a person to look at.

pub mod capture;
mod check;
mod configurations;
mod remarks;
pub mod report;
mod unused;
pub mod why;

pub use check::{CheckOptions, CheckReport, check, check_document, check_sharing};
pub use configurations::{
    AxisProduct, Configuration, Configurations, Cover, Coverage, Examination, Judge,
    MAX as MAX_CONFIGURATIONS, Reached, ReachedProgram, Surveyed, Verify, check_configurations, reach,
};
pub use remarks::Remarks;
