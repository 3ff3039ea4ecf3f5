//! Answers to "where does this come from?" about a name of a pipeline: its meaning, the file and line that set each of
//! its values, and the compiler's decisions.
//!
//! [`why`] looks a name up among everything that a pipeline names (one name may be that of a pass and of a feature:
//! both are told), and tells of each thing
//!
//! - its values with the places that set them, and what those places replaced ([`Origin`]): a value of a document
//!   made of several files knows where it was written, and [`umbragraph_pipeline::compose::Composed`] keeps what it was
//!   laid over;
//! - for parameters and features everything that gave a value, the lowest first: default, preset, parameter files,
//!   command line; for derived values the expression, and what it follows from;
//! - for passes and resources what the plan says of them ([`PlanFact`]): why they are kept or culled, and what shares
//!   memory.
//!
//! [`why_memory`] says why two resources share memory or do not.
//!
//! A pipeline with errors is told of as far as it goes: names and values need only the documents. Values that nobody
//! writes, the defaults of the language, are not listed.

mod explain;
mod find;
mod given;
mod human;
mod origin;
mod plan_fact;
mod reasons;
mod sharing;
mod subject;

pub use given::Given;
pub use human::human;
pub use origin::{Location, Origin, Written};
pub use plan_fact::PlanFact;
pub use reasons::{why_culled, why_kept};
pub use sharing::why_apart;
pub use subject::{Kind, Subject};

use std::collections::BTreeSet;

use serde::Serialize;

use umbragraph_compiler::Physical;
use umbragraph_pipeline::diagnostic::{Diagnostic, codes, list_of};
use umbragraph_pipeline::source::Span;

/// The explanation of one named part of a pipeline, such as a pass, a resource or a parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Thing {
    /// The name of the explained thing.
    pub name: String,
    /// The kind of the explained thing.
    pub kind: Kind,
    /// The kind in words, with more detail than `kind`, such as "a pass of kind fullscreen".
    pub what: String,
    /// The author's description; `None` if the document has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// The source location of the declaration.
    pub declared: Location,
    /// The effective value of a parameter, feature, derived value or input, as JSON text; `None` for other kinds, or if
    /// no source gives a value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<String>,
    /// The sources of the value in increasing precedence: the last one counts. Empty for kinds without a value.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub given: Vec<Given>,
    /// The facts about the part, such as whether a pass runs, or the memory of a resource.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub facts: Vec<PlanFact>,
    /// The values in the declaration, each with the places that set it.
    pub values: Vec<Origin>,
}

/// The answer to whether two resources share memory.
#[derive(Clone, Debug, Serialize)]
pub struct Memory {
    /// The name of the first resource.
    pub first: String,
    /// The name of the second resource.
    pub second: String,
    /// Whether the resources share memory; `None` for a pipeline with errors, which has no plan.
    pub shared: Option<bool>,
    /// The reason why the resources share memory, or every reason why they do not.
    pub reasons: Vec<String>,
}

/// Explains every part of a pipeline with the name `name`, since one name can be that of a pass and of a feature.
///
/// # Errors
/// Returns a diagnostic at `place`, the place of the request, if the name does not exist.
pub fn why(subject: &Subject<'_>, name: &str, place: Span) -> Result<Vec<Thing>, Box<Diagnostic>> {
    let things = find::things(subject, name);
    if !things.is_empty() {
        return Ok(things);
    }
    let names = find::names(subject);
    let mut diagnostic = unknown("nothing in this pipeline is named", name, place, &names);
    // What a file deleted has left its name behind.
    for (pointer, null) in &subject.composed.deleted {
        if pointer.matches('/').count() == 2 && pointer.ends_with(&format!("/{name}")) {
            for older in subject.composed.replaced.get(pointer).into_iter().flatten() {
                diagnostic = Box::new(diagnostic.related(*older, "it stood here"));
            }
            diagnostic = Box::new(diagnostic.related(*null, "and is deleted here"));
        }
    }
    Err(diagnostic)
}

/// Returns whether two resources share memory, with the reasons. Each resource is given by its name and the place of
/// the request.
///
/// # Errors
/// Returns a diagnostic for each name that no resource has, at the place of the request.
pub fn why_memory(
    subject: &Subject<'_>,
    [first, second]: [(&str, Span); 2],
) -> Result<Memory, Vec<Diagnostic>> {
    let names = find::resource_names(subject);
    let mut diagnostics = Vec::new();
    for (name, place) in [first, second] {
        if !names.contains(name) {
            diagnostics.push(*unknown("there is no resource", name, place, &names));
        }
    }
    if !diagnostics.is_empty() {
        return Err(diagnostics);
    }
    let (first, second) = (first.0, second.0);
    let mut memory =
        Memory { first: first.to_owned(), second: second.to_owned(), shared: None, reasons: Vec::new() };
    let Some(plan) = &subject.checked.plan else {
        memory.reasons.push("the pipeline has errors, so there is no plan, and no memory".to_owned());
        return Ok(memory);
    };
    if first == second {
        memory.shared = Some(true);
        memory.reasons.push(format!("{first} is one resource"));
        return Ok(memory);
    }
    let physical = |name: &str| plan.resources.get(name).map(|resource| resource.physical);
    memory.shared = Some(
        matches!(physical(first), Some(Physical::Texture(_) | Physical::Buffer(_)))
            && physical(first) == physical(second),
    );
    memory.reasons = why_apart(plan, first, second);
    Ok(memory)
}

fn unknown(what: &str, name: &str, place: Span, known: &BTreeSet<String>) -> Box<Diagnostic> {
    let diagnostic = Diagnostic::error(codes::UNKNOWN_NAME, place, format!("{what} \"{name}\""));
    let known = known.iter().map(String::as_str);
    Box::new(diagnostic.suggest(name, known, Some(place), |known| {
        format!("the names are {}", list_of(known.iter().copied()))
    }))
}
