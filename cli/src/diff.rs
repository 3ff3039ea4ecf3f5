//! `umbragraph diff`
//!
//! Each side is a pipeline, or the report of one that was kept (`umbragraph graph --format json`), so that a change can
//! be compared with what was there before it. With `--lock` both sides are locks of `umbragraph permutations`.

use std::path::Path;

use umbragraph::diagnostic::Diagnostic;
use umbragraph::low_level::read_source;
use umbragraph::low_level::report::{Report, diff};
use umbragraph::low_level::source::Sources;

use crate::arguments::{Choices, DiffArguments};
use crate::codes;
use crate::graph::report;
use crate::lock;
use crate::session::Session;
use crate::streams::print;

/// Prints the differences between two plans. Returns `true` if there were no errors.
pub(crate) fn run(arguments: &DiffArguments) -> bool {
    let mut session = Session::new(&arguments.choices.files);
    let after = arguments.after.as_ref().unwrap_or(&arguments.before);
    if arguments.lock {
        return locks(&mut session, &arguments.before, after);
    }
    let before = side(&mut session, &arguments.before, &arguments.choices);
    let after = side(&mut session, after, &arguments.after_choices());
    if !session.report() {
        return false;
    }
    let (Some(before), Some(after)) = (before, after) else { return false };
    let lines = diff(&before, &after);
    print(&if lines.is_empty() { "the plans are the same\n".to_owned() } else { lines.join("\n") + "\n" });
    true
}

/// Prints the differences between two lock files. Returns `true` if both files could be read.
fn locks(session: &mut Session, before: &Path, after: &Path) -> bool {
    let mut sides = Vec::new();
    for path in [before, after] {
        match lock::read(session, path) {
            Ok(Some((parsed, _))) => sides.push(parsed.lock),
            Ok(None) => {
                let name = path.display().to_string();
                let message = format!("there is no lock \"{name}\"");
                let missing = Diagnostic::in_file(codes::LOCK_INVALID, name, "", message);
                session.diagnostics.push(
                    missing
                        .help("`git show main:permutations.lock > before.lock` takes one of another branch"),
                );
            }
            Err(diagnostic) => session.diagnostics.push(diagnostic),
        }
    }
    if !session.report() {
        return false;
    }
    let [before, after] = &sides[..] else { return false };
    let changes = lock::difference(before, after);
    let line = |change: &lock::Change| format!("{}: {}\n", change.pipeline, change.message);
    print(&if changes.is_empty() {
        "the locks are the same\n".to_owned()
    } else {
        changes.iter().map(line).collect()
    });
    true
}

fn side(session: &mut Session, path: &Path, choices: &Choices) -> Option<Report> {
    // Of what cannot be read, the pipeline's own diagnostics tell more.
    let Some(value) = kept(path) else { return report(session, path, choices) };
    match serde_json::from_value(value) {
        Ok(report) => Some(report),
        Err(error) => {
            let message = format!("the file \"{}\" is no report: {error}", path.display());
            let diagnostic =
                Diagnostic::in_file(codes::NOT_A_REPORT, path.display().to_string(), "", message);
            let help = "print one with `umbragraph graph PIPELINE --format json`";
            session.diagnostics.push(diagnostic.help(help));
            None
        }
    }
}

/// Reads a saved JSON report of a plan. `None` if the file is no report: `passes` is an array in a report, and an
/// object in a pipeline.
fn kept(path: &Path) -> Option<serde_json::Value> {
    let mut sources = Sources::new();
    let file = read_source(path, &mut sources).ok()?;
    let value: serde_json::Value = serde_json::from_str(sources.get(file)?.text()).ok()?;
    value["passes"].is_array().then_some(value)
}
