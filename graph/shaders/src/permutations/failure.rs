//! From proofs and opinions to failures in the templates.
//!
//! A rejection is about a generated text; the failure is about the template that it came from. Literal text maps
//! exactly. Where the place was captured by a macro, a block or a filter, the marked templates give it, with the tags
//! through which it was written out.

use super::cause::Failure;
use super::prove::{Proof, Task};
use super::proven::{Explored, Proven};
use super::validator::{Opinion, Validator};
use crate::codes;
use crate::rendering::markers;
use crate::rendering::templates::TemplateSet;
use crate::written::rejection::Rejection;
use crate::written::text_map::Source;
use umbragraph_text::diagnostic::{Diagnostic, Place};

/// The verdict of each external validator on a text, if naga accepts it.
pub(super) fn judge(task: &Task<'_>, proof: &Proof, validators: &[&dyn Validator]) -> Vec<Opinion> {
    let accepted = proof.rejections.is_empty();
    let judge = |each: &&dyn Validator| {
        if accepted { each.judge(&task.source.wgsl) } else { Opinion::Accepts }
    };
    validators.iter().map(judge).collect()
}

pub(super) fn unavailable(proven: &[Proven], validators: &[&dyn Validator]) -> Vec<Diagnostic> {
    let found = validators.iter().enumerate().filter_map(|(at, validator)| {
        proven.iter().find_map(|each| match each.opinions.get(at) {
            Some(Opinion::Unavailable(message)) => Some((validator.place(), message)),
            _ => None,
        })
    });
    let diagnostic =
        |(place, message): (Place, &String)| Diagnostic::error(codes::EXTERNAL_UNAVAILABLE, place, message);
    found.map(diagnostic).collect()
}

/// Rejections by naga, the limits, the writers and external validators, followed by advice.
pub(super) fn rejections(
    templates: &TemplateSet,
    each: &Explored<'_>,
    proven: &[Proven],
    validators: &[&dyn Validator],
) -> Vec<Failure> {
    let every: Vec<usize> = (0..each.request.profiles.len()).collect();
    let mut failures = Vec::new();
    for (text, task) in each.tasks.iter().enumerate() {
        let Some(Proven { proof, opinions, source: Some(source) }) = proven.get(*task) else { continue };
        let opinions = opinions.iter().zip(validators);
        let external: Vec<Rejection> =
            opinions.filter_map(|(opinion, validator)| disagreement(opinion, *validator, source)).collect();
        let of_all = proof.advice.iter().chain(&external).map(|rejection| (rejection, &every));
        for (rejection, profiles) in proof.rejections.iter().map(|(one, some)| (one, some)).chain(of_all) {
            let names = profiles.iter().filter_map(|at| each.request.profiles.get(*at));
            failures.push(Failure {
                diagnostic: place_rejection(templates, each, text, source, rejection),
                leaves: each.exploration.leaves_of(text).iter().copied().collect(),
                profiles: names.map(|profile| profile.name.clone()).collect(),
                excess: rejection.excess.clone(),
                overrides: rejection.overrides.clone(),
            });
        }
    }
    failures
}

/// The rejection or time-out of an external validator.
fn disagreement(opinion: &Opinion, validator: &dyn Validator, source: &Source) -> Option<Rejection> {
    let (code, message, place) = match opinion {
        Opinion::Accepts | Opinion::Unavailable(_) => return None,
        Opinion::Rejects { message, place } => {
            (codes::EXTERNAL_REJECTS, format!("{} rejects this: {message}", validator.name()), *place)
        }
        Opinion::TimedOut => {
            let message = format!("{} does not come to an end on this template", validator.name());
            (codes::EXTERNAL_TIMEOUT, message, None)
        }
    };
    let range = place.map(|(line, column)| offset_of(&source.wgsl, line, column)).map(|at| at..at + 1);
    Some(Rejection { range, ..Rejection::new(code, message, naga::Span::UNDEFINED) })
}

fn offset_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (start + column.saturating_sub(1)).min(text.len())
}

/// The diagnostic for a rejection of a text: by the plain map, or by markers where captured text hides the place.
fn place_rejection(
    templates: &TemplateSet,
    each: &Explored<'_>,
    text: usize,
    source: &Source,
    rejection: &Rejection,
) -> Diagnostic {
    let template = &each.request.template;
    let Some(file) = templates.file(template) else { return templates.unknown(template, Place::Nowhere) };
    markers::place(rejection, &source.wgsl, &source.map, file, || {
        let leaf = each.exploration.leaves.get(each.exploration.texts.get(text)?.leaf)?;
        templates.marked().map(template, &leaf.decided, &source.wgsl)
    })
}
