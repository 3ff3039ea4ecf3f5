//! `umbragraph graph`

use std::path::Path;

use umbragraph::diagnostic::Diagnostics;
use umbragraph::diagnostic::render::human_all;
use umbragraph::report::{GraphFormat, Report, diff, draw};

use crate::arguments::{Choices, GraphArguments};
use crate::replace::{replace, unwritable};
use crate::session::Session;
use crate::streams::{complain, print_contents, print_json};

/// Draws a graph; whether there were no errors.
pub(crate) fn run(arguments: &GraphArguments) -> bool {
    let mut session = Session::new(arguments.choices.templates.as_deref(), &arguments.choices.root);
    let report = report(&mut session, &arguments.pipeline, &arguments.choices);
    let other =
        arguments.compare.as_ref().and_then(|path| self::report(&mut session, path, &arguments.choices));
    // Of a pipeline with errors, the passes that are sound are drawn.
    let fine = session.report();
    let Some(report) = report else { return false };
    let comparison = other.map(|other| diff(&report, &other));
    let text = draw(&report, arguments.format, comparison.as_deref());
    match &arguments.out {
        None => {
            match arguments.format {
                GraphFormat::Json => print_json(&text),
                _ => print_contents(text.as_bytes()),
            }
            fine
        }
        Some(path) => {
            if let Err(error) = replace(path, text) {
                complain(&human_all(&Diagnostics::from_iter([unwritable(path, &error)]), &session.sources));
                return false;
            }
            if arguments.format == GraphFormat::Html {
                complain(&format!("open {} in a browser; it needs no network\n", path.display()));
            }
            fine
        }
    }
}

/// What there is to say of one pipeline; nothing after an error.
pub(crate) fn report(session: &mut Session, path: &Path, choices: &Choices) -> Option<Report> {
    let checked = session.check(path, choices);
    Some(Report::new(&checked.plan?, &checked.graph?, &session.sources))
}
