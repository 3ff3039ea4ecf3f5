//! The diagnostics of a session, printed in the form that is asked for.

use std::path::Path;

use umbragraph::diagnostic::{Diagnostic, Severity, codes, render};
use umbragraph::low_level::compose::normalize;

use super::{Session, causes};
use crate::annotations;
use crate::arguments::DiagnosticsFormat;
use crate::cache::Said;
use crate::junit::{self, Fine};
use crate::show::SCHEME;
use crate::streams::{complain, print, print_json};

impl Session {
    /// Sorts the diagnostics for display and merges duplicates. Leaves out what only follows from others, and joins those
    /// with one cause.
    pub(crate) fn arrange(&mut self) {
        let all = std::mem::take(&mut self.diagnostics).into_iter();
        let all = all.map(|one| causes::of_deleted(one, &self.deleted));
        let all = all.map(|one| match self.is_template(&one) {
            true => one.help("this is a template: check a pipeline that uses it, with --templates FOLDER"),
            false => one,
        });
        self.diagnostics = all.collect();
        self.diagnostics.sort();
        self.diagnostics.merge();
        let all = std::mem::take(&mut self.diagnostics);
        let beside = |template: &str, pipeline: &Diagnostic| {
            let file = pipeline.span().and_then(|span| self.sources().get(span.file))?;
            causes::folder_with(Path::new(file.name()), template)
        };
        let is_cut = |one: &Diagnostic| {
            let file = one.span().and_then(|span| self.sources().get(span.file));
            let is_bundled = |name: &str| !self.cut.is_empty() && name.starts_with(SCHEME);
            file.is_some_and(|file| {
                is_bundled(file.name()) || self.cut.contains(&normalize(Path::new(file.name())))
            })
        };
        self.diagnostics = causes::joined(causes::first(all, &is_cut), self.own_files.is_none(), &beside);
    }

    /// Returns `true` for a template that is read as if it were JSON.
    fn is_template(&self, diagnostic: &Diagnostic) -> bool {
        let file = diagnostic.span().and_then(|span| self.sources().get(span.file));
        diagnostic.code == codes::SYNTAX && file.is_some_and(|file| file.name().ends_with(".jinja"))
    }

    /// Removes notes unless `all` is set or there are errors. A survey also makes notes about values that no user has
    /// selected.
    pub(crate) fn quiet(&mut self, all: bool) {
        if !all && !self.diagnostics.has_errors() {
            let diagnostics = std::mem::take(&mut self.diagnostics).into_iter();
            self.diagnostics = diagnostics.filter(|one| one.severity != Severity::Note).collect();
        }
    }

    /// Prints the diagnostics to standard error. Returns `true` if none is an error.
    pub(crate) fn report(&mut self) -> bool {
        self.arrange();
        self.complain()
    }

    fn complain(&self) -> bool {
        complain(&self.rendered());
        !self.diagnostics.has_errors()
    }

    /// Returns the diagnostics as text for people.
    fn rendered(&self) -> String {
        render::human_all(&self.diagnostics, self.sources())
    }

    /// Returns a diagnostic as JSON.
    pub(crate) fn json(&self, diagnostic: &Diagnostic) -> serde_json::Value {
        render::json(diagnostic, self.sources())
    }

    /// Returns the output of [`Self::report_as`] for a format that is not machine-readable.
    pub(crate) fn said(&self, format: DiagnosticsFormat, text: String) -> Said {
        match format {
            DiagnosticsFormat::Github => {
                let (diagnostics, sources) = (&self.diagnostics, self.sources());
                let summary = annotations::summary(diagnostics, sources, &text);
                Said { text: annotations::lines(diagnostics, sources) + &text, summary, ..Said::default() }
            }
            _ => Said { text, diagnostics: self.rendered(), ..Said::default() },
        }
    }

    /// Prints the diagnostics and the results of a command in a format. `text` makes the results for people; `json`
    /// makes the JSON output from the diagnostics. `fine` lists the pipelines without errors. Returns `true` if there
    /// was no error.
    pub(crate) fn report_as(
        &mut self,
        format: DiagnosticsFormat,
        text: impl FnOnce() -> String,
        json: impl FnOnce(Vec<serde_json::Value>) -> String,
        fine: &[Fine],
    ) -> bool {
        self.arrange();
        let (diagnostics, sources) = (&self.diagnostics, self.sources());
        match format {
            DiagnosticsFormat::Human => {
                print(&text());
                return self.complain();
            }
            DiagnosticsFormat::Json => {
                let diagnostics = diagnostics.iter().map(|diagnostic| render::json(diagnostic, sources));
                print_json(&(json(diagnostics.collect()) + "\n"));
            }
            DiagnosticsFormat::Sarif => print_json(&format!("{:#}\n", render::sarif(diagnostics, sources))),
            DiagnosticsFormat::Junit => print(&junit::report(diagnostics, sources, fine)),
            DiagnosticsFormat::Github => {
                let text = text();
                annotations::add_summary(&annotations::summary(diagnostics, sources, &text));
                print(&(annotations::lines(diagnostics, sources) + &text));
            }
        }
        !diagnostics.has_errors()
    }

    /// Prints a diagnostic to standard error and returns `false`.
    pub(crate) fn fail(&self, diagnostic: Diagnostic) -> bool {
        complain(&render::human_all([&diagnostic], self.sources()));
        false
    }
}
