//! `umbragraph why`: explains a value, or why a pass is culled.

use serde_json::json;
use umbragraph::low_level::why::{Subject, human, why, why_memory};

use crate::arguments::{AnswerFormat, WhyArguments};
use crate::session::Session;
use crate::streams::{print, print_json};

/// Explains a name, or the memory that two resources share. Returns `true` if the name exists and the pipeline has no
/// error.
pub(crate) fn run(arguments: &WhyArguments) -> bool {
    let mut session = Session::new(&arguments.choices.files);
    let Some((loaded, overrides, checked)) = session.trace(&arguments.pipeline, &arguments.choices) else {
        return session.report();
    };
    let place = session.on_command_line(&arguments.name);
    let other = arguments.other.as_deref().map(|other| (other, session.on_command_line(other)));
    let (Some(composed), Some(model)) = (loaded.composed(), loaded.model()) else { return session.report() };
    let (overrides, checked) = (&overrides, &checked);
    let subject = Subject { composed, model, overrides, checked, sources: session.sources() };
    let answer = match other {
        None => match why(&subject, &arguments.name, place) {
            Ok(things) => Ok(match arguments.format {
                AnswerFormat::Human => human(&things),
                AnswerFormat::Json => format!("{:#}\n", json!({ "things": things })),
            }),
            Err(diagnostic) => Err(vec![*diagnostic]),
        },
        Some(other) => {
            why_memory(&subject, [(&arguments.name, place), other]).map(|memory| match arguments.format {
                AnswerFormat::Human => memory.reasons.iter().map(|reason| format!("{reason}\n")).collect(),
                AnswerFormat::Json => format!("{:#}\n", json!({ "memory": memory })),
            })
        }
    };
    match answer {
        Ok(text) => match arguments.format {
            AnswerFormat::Human => print(&text),
            AnswerFormat::Json => print_json(&text),
        },
        Err(diagnostics) => session.diagnostics.extend(diagnostics),
    }
    session.report()
}
