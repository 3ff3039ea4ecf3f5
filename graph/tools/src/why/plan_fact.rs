//! Facts that a plan holds about a name.

use serde::Serialize;

use super::origin::{Location, location};
use super::subject::Subject;
use umbragraph_pipeline::source::Span;

/// One fact about a named part of a pipeline.
#[derive(Clone, Debug, Serialize)]
pub struct PlanFact {
    /// The subject of the fact, such as `runs`, `kept` or `memory`.
    pub about: &'static str,
    /// The fact in words.
    pub text: String,
    /// The place in a document that states or causes the fact; `None` if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<Location>,
}

/// Creates a fact that a document states or causes at `place`.
pub(super) fn said(subject: &Subject<'_>, about: &'static str, text: String, place: Span) -> PlanFact {
    PlanFact { about, text, at: Some(location(subject.sources, place)) }
}

/// Creates a fact without a place in a document.
pub(super) fn fact(about: &'static str, text: impl Into<String>) -> PlanFact {
    PlanFact { about, text: text.into(), at: None }
}
