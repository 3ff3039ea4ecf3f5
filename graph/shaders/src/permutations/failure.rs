//! From proofs and opinions to failures in the templates.
//!
//! A rejection is about a generated text; the failure is about the template that it came from. Literal text maps
//! exactly. Where the place was captured by a macro, a block or a filter, the marked templates give it, with the tags
//! through which it was written out.

use std::collections::BTreeSet;

use super::cause::Failure;
use super::dead::Marked;
use super::explore::Source;
use super::prove::{Proof, Task};
use super::validator::{Opinion, Validator};
use super::{Explored, Proven};
use crate::diagnostic::{AxisValues, Diagnostic, Place};
use crate::wgsl_error::{Rejection, Stage};
use crate::{TemplateSet, codes, markers};

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

/// What naga, the limits and the writers reject, and what is better avoided.
pub(super) fn rejections(
    templates: &TemplateSet,
    each: &Explored<'_>,
    proven: &[Proven],
    marked: &mut Marked<'_>,
) -> Vec<Failure> {
    let mut failures = Vec::new();
    for (text, task) in each.tasks.iter().enumerate() {
        let Some(Proven { proof, source: Some(source), .. }) = proven.get(*task) else { continue };
        let every: Vec<usize> = (0..each.request.profiles.len()).collect();
        let advice = proof.advice.iter().map(|advice| (advice, &every));
        for (rejection, profiles) in
            proof.rejections.iter().map(|(rejection, profiles)| (rejection, profiles)).chain(advice)
        {
            let names = profiles.iter().filter_map(|at| each.request.profiles.get(*at));
            failures.push(Failure {
                diagnostic: place_rejection(templates, each, text, source, rejection, marked),
                leaves: each.exploration.leaves_of(text).iter().copied().collect(),
                profiles: names.map(|profile| profile.name.clone()).collect(),
                excess: rejection.excess.clone(),
                overrides: rejection.overrides.clone(),
            });
        }
    }
    failures
}

/// The rejections and time-outs of external validators.
pub(super) fn disagreements(
    templates: &TemplateSet,
    each: &Explored<'_>,
    proven: &[Proven],
    validators: &[&dyn Validator],
    marked: &mut Marked<'_>,
) -> Vec<Failure> {
    let mut failures = Vec::new();
    for (text, task) in each.tasks.iter().enumerate() {
        let Some(Proven { opinions, source: Some(source), .. }) = proven.get(*task) else { continue };
        for (opinion, validator) in opinions.iter().zip(validators) {
            let rejection = match opinion {
                Opinion::Accepts | Opinion::Unavailable(_) => continue,
                Opinion::Rejects { message, place } => {
                    let message = format!("{} rejects this: {message}", validator.name());
                    let range = place
                        .map(|(line, column)| offset_of(&source.wgsl, line, column))
                        .map(|at| at..at + 1);
                    Rejection { range, ..Rejection::new(Stage::External, message, naga::Span::UNDEFINED) }
                }
                Opinion::TimedOut => Rejection::new(
                    Stage::ExternalTimeout,
                    format!("{} does not come to an end on this template", validator.name()),
                    naga::Span::UNDEFINED,
                ),
            };
            failures.push(Failure {
                diagnostic: place_rejection(templates, each, text, source, &rejection, marked),
                leaves: each.exploration.leaves_of(text).iter().copied().collect(),
                profiles: BTreeSet::new(),
                excess: None,
                overrides: AxisValues::new(),
            });
        }
    }
    failures
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
    marked: &mut Marked<'_>,
) -> Diagnostic {
    let template = &each.request.template;
    let Some(found) = each.exploration.texts.get(text) else {
        return templates.unknown(template, Place::Nowhere);
    };
    let file = templates.templates.get(template).map(|template| template.file);
    let Some(file) = file else { return templates.unknown(template, Place::Nowhere) };
    markers::place(rejection, &source.wgsl, &source.map, file, || {
        let leaf = each.exploration.leaves.get(found.leaf)?;
        marked.get(templates).map(template, &leaf.decided, &source.wgsl)
    })
}
