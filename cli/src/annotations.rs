//! Diagnostics for GitHub: annotations on lines of a pull request, and the summary of a step.
//!
//! GitHub shows ten errors, ten warnings and ten notices of a step, and drops the others without a word
//! (<https://docs.github.com/en/actions/reference/limits>). So only that many become annotations, errors first; the
//! others are printed to the log. The summary lists all: it is Markdown, appended to the file that the variable
//! `GITHUB_STEP_SUMMARY` names.

use std::fmt::Write as _;
use std::io::Write as _;

use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, Severity, counted, render};
use umbragraph::low_level::source::Sources;

use crate::streams::complain;

/// The maximum number of annotations of each severity.
const MAX: usize = 10;
/// The maximum size in bytes of the diagnostics in a summary; GitHub drops a summary of more than a mebibyte.
const MAX_SUMMARY: usize = 500_000;

/// Returns the diagnostics as GitHub annotations, and those beyond the maximum as plain text.
pub(crate) fn lines(diagnostics: &Diagnostics, sources: &Sources) -> String {
    let mut text = String::new();
    let mut others: Vec<&Diagnostic> = Vec::new();
    for (severity, noun) in
        [(Severity::Error, "error"), (Severity::Warning, "warning"), (Severity::Note, "note")]
    {
        let all: Vec<&Diagnostic> = diagnostics.iter().filter(|one| one.severity == severity).collect();
        let (shown, rest) = all.split_at(all.len().min(MAX));
        text.extend(shown.iter().map(|diagnostic| render::github(diagnostic, sources)));
        if !rest.is_empty() {
            // Writing to a string cannot fail.
            let more = counted(rest.len(), &format!("more {noun}"));
            let _ = writeln!(text, "{more} without an annotation, since GitHub shows {MAX} of a step:");
            others.extend(rest);
        }
    }
    for diagnostic in others {
        text.push_str(&render::human(diagnostic, sources));
    }
    text
}

/// Returns the Markdown summary of a workflow step: the command's output about its pipelines, and all diagnostics.
pub(crate) fn summary(diagnostics: &Diagnostics, sources: &Sources, text: &str) -> String {
    let of = |severity| diagnostics.iter().filter(move |one| one.severity == severity);
    let errors = of(Severity::Error).count();
    let mut out = match errors {
        0 => "### umbragraph: no errors\n\n".to_owned(),
        errors => format!("### umbragraph: {}\n\n", counted(errors, "error")),
    };
    for line in text.lines() {
        let _ = writeln!(out, "- {}", plain(line));
    }
    let all = [Severity::Error, Severity::Warning, Severity::Note].into_iter().flat_map(of);
    if !diagnostics.is_empty() {
        out.push_str("\n| | place | message |\n|---|---|---|\n");
    }
    let mut left = 0;
    for diagnostic in all {
        if out.len() > MAX_SUMMARY {
            left += 1;
            continue;
        }
        let (severity, code) = (diagnostic.severity.name(), diagnostic.code.id);
        let message = plain(&diagnostic.message);
        let help = diagnostic.help.as_deref().map_or_else(String::new, |help| format!(" ({})", plain(help)));
        let _ =
            writeln!(out, "| {severity} {code} | {} | {message}{help} |", plain(&place(diagnostic, sources)));
    }
    if left > 0 {
        let _ = writeln!(out, "\n{} in the log only", counted(left, "more diagnostic"));
    }
    out.push('\n');
    out
}

/// Appends a summary to the file that `GITHUB_STEP_SUMMARY` names; does nothing if the variable is not set.
pub(crate) fn add_summary(summary: &str) {
    // Of a run without annotations there is none.
    if summary.is_empty() {
        return;
    }
    let Some(path) = std::env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty()) else { return };
    // A pipe that nobody reads would be waited for.
    if std::fs::metadata(&path).is_ok_and(|found| !found.is_file()) {
        complain("the summary of the step cannot be written: GITHUB_STEP_SUMMARY names no regular file\n");
        return;
    }
    let file = std::fs::OpenOptions::new().append(true).create(true).open(&path);
    if let Err(error) = file.and_then(|mut file| file.write_all(summary.as_bytes())) {
        complain(&format!("the summary of the step cannot be written: {error}\n"));
    }
}

fn place(diagnostic: &Diagnostic, sources: &Sources) -> String {
    match &diagnostic.place {
        Place::Span(span) => sources.get(span.file).map_or_else(String::new, |file| {
            let at = file.line_column(span.start);
            format!("{}:{}:{}", file.name(), at.line, at.column)
        }),
        Place::File { path, .. } => path.clone(),
        Place::Nowhere => String::new(),
    }
}

/// Escapes text for a Markdown table cell.
fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for each in render::visible(text).chars() {
        match each {
            '\n' => out.push(' '),
            '<' => out.push_str("&lt;"),
            '&' => out.push_str("&amp;"),
            '|' | '\\' | '`' | '*' | '_' | '[' | ']' | '#' | '@' => {
                out.push('\\');
                out.push(each);
            }
            each => out.push(each),
        }
    }
    out
}
