//! Facts that a plan holds about a name.

use serde::Serialize;

use super::origin::{Location, location};
use super::subject::Subject;
use umbragraph_pipeline::source::Span;

/// One thing that the plan says of a name.
#[derive(Clone, Debug, Serialize)]
pub struct PlanFact {
    /// The subject: `runs`, `kept`, `memory`.
    pub about: &'static str,
    /// The fact in words.
    pub text: String,
    /// The place in a document that causes it, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<Location>,
}

/// A fact that somebody says at a place.
pub(super) fn said(subject: &Subject<'_>, about: &'static str, text: String, place: Span) -> PlanFact {
    PlanFact { about, text, at: Some(location(subject.sources, place)) }
}

/// A fact that no file says.
pub(super) fn fact(about: &'static str, text: impl Into<String>) -> PlanFact {
    PlanFact { about, text: text.into(), at: None }
}
