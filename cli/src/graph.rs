//! `umbragraph graph`: draws the plan of a pipeline.

use std::path::Path;

use umbragraph::diagnostic::{Diagnostic, Place, codes};
use umbragraph::low_level::report::{GraphFormat, Report, diff, draw, page};

use crate::arguments::{Choices, GraphArguments};
use crate::observed::observed;
use crate::replace::replace;
use crate::session::Session;
use crate::streams::{complain, print_contents, print_json};

/// Draws the graph of a pipeline. Returns `true` if there were no errors. For a pipeline with errors, the graph has
/// only the valid passes.
pub(crate) fn run(arguments: &GraphArguments) -> bool {
    let mut session = Session::new(&arguments.choices.files);
    let report = report(&mut session, &arguments.pipeline, &arguments.choices);
    let other =
        arguments.compare.as_ref().and_then(|path| self::report(&mut session, path, &arguments.choices));
    // Of a pipeline with errors, the passes that are sound are drawn.
    let fine = session.report();
    let Some(report) = report else { return false };
    let comparison = other.map(|other| diff(&report, &other));
    let format = match format(arguments) {
        Ok(format) => format,
        Err(diagnostic) => return session.fail(diagnostic),
    };
    let text = match format {
        GraphFormat::Html => match observed(arguments.captures.as_deref(), arguments.timings.as_deref()) {
            Ok(observed) => page(&report, comparison.as_deref(), &observed),
            Err(diagnostic) => return session.fail(diagnostic),
        },
        format => draw(&report, format, comparison.as_deref()),
    };
    match &arguments.out {
        None => {
            match format {
                GraphFormat::Json => print_json(&text),
                _ => print_contents(text.as_bytes()),
            }
            fine
        }
        Some(path) => {
            if let Err(diagnostic) = replace(path, text) {
                return session.fail(diagnostic);
            }
            if format == GraphFormat::Html {
                complain(&format!("open {} in a browser; it needs no network\n", path.display()));
            }
            fine
        }
    }
}

/// Returns the requested output format: by its name, or by the extension of the file.
///
/// # Errors
/// An unknown extension, or one that contradicts the named format.
fn format(arguments: &GraphArguments) -> Result<GraphFormat, Diagnostic> {
    let extension = arguments.out.as_deref().and_then(Path::extension).and_then(|it| it.to_str());
    let by_extension = match extension {
        Some("mmd" | "md") => Some(GraphFormat::Mermaid),
        Some("gv") => Some(GraphFormat::Dot),
        extension => extension.and_then(GraphFormat::from_name),
    };
    match (arguments.format, by_extension, extension) {
        (Some(format), by_extension, _) if by_extension.is_none_or(|other| other == format) => Ok(format),
        (None, Some(format), _) => Ok(format),
        (None, None, None) => Ok(GraphFormat::Svg),
        (asked, _, extension) => {
            let name = extension.unwrap_or_default();
            let message = match asked {
                Some(format) => format!("--out: \".{name}\" is not the form {}", format.name()),
                None => format!("--out: \".{name}\" is the extension of no form"),
            };
            let help = "the extensions are .svg, .html, .dot or .gv, .mmd or .md, and .json";
            Err(Diagnostic::error(codes::PICTURE, Place::Nowhere, message).help(help))
        }
    }
}

/// Plans one pipeline and returns the report of its plan; `None` if there is no plan.
pub(crate) fn report(session: &mut Session, path: &Path, choices: &Choices) -> Option<Report> {
    let checked = session.check(path, choices);
    Some(Report::new(&*checked.plan?, &*checked.graph?, session.sources()))
}
