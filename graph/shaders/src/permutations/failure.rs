//! Places rejections and opinions about generated text in the templates.
//!
//! A rejection is about a generated text; the diagnostic is about the template that it came from. Literal text maps
//! exactly. Where the place was captured by a macro, a block or a filter, the marked templates give it, with the tags
//! through which it was written out.

use super::prove::{Proof, Task};
use super::proven::Explored;
use super::validator::{Opinion, Validator};
use crate::codes;
use crate::rendering::markers;
use crate::rendering::templates::TemplateSet;
use crate::written::rejection::{Rejection, Scope};
use crate::written::text_map::Source;
use umbragraph_text::diagnostic::{Diagnostic, Place};

/// Returns the result of each external validator for a module. Modules that naga rejects are not passed to validators.
pub(super) fn judge(task: &Task<'_>, proof: &Proof, validators: &[&dyn Validator]) -> Vec<Opinion> {
    let accepted = proof.is_accepted(&task.subject);
    let judge = |each: &&dyn Validator| {
        if accepted { each.judge(&task.source.wgsl) } else { Opinion::Accepts }
    };
    validators.iter().map(judge).collect()
}

/// Returns the rejection or time-out of an external validator; `None` if it accepts the module or cannot run.
pub(super) fn disagreement(
    opinion: &Opinion,
    validator: &dyn Validator,
    source: &Source,
) -> Option<Rejection> {
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
    let rejection = Rejection::new(code, message, naga::Span::UNDEFINED).of(Scope::Text);
    Some(Rejection { range, ..rejection })
}

fn offset_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (start + column.saturating_sub(1)).min(text.len())
}

/// Converts a rejection of generated WGSL into a diagnostic in the template. Text that a macro or block captured is
/// located by rendering with markers.
pub(super) fn place_rejection(
    templates: &TemplateSet,
    each: &Explored<'_>,
    text: usize,
    source: &Source,
    rejection: &Rejection,
) -> Diagnostic {
    let template = &each.request.template;
    let Some(file) = templates.file(template) else { return templates.unknown(template, Place::Nowhere) };
    markers::place(templates, rejection, &source.wgsl, &source.map, file, || {
        let leaf = each.exploration.leaves.get(each.exploration.texts.get(text)?.leaf)?;
        templates.marked().map(template, &leaf.decided.values(), &source.wgsl)
    })
}
