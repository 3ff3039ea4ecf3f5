//! The diagnostics of a session, printed in the form that is asked for.

use umbragraph::diagnostic::{Diagnostic, Severity, render};

use super::Session;
use crate::annotations;
use crate::arguments::DiagnosticsFormat;
use crate::cache::Said;
use crate::junit::{self, Fine};
use crate::streams::{complain, print, print_json};

impl Session {
    /// Puts the diagnostics in the order in which they are shown, each once.
    pub(crate) fn arrange(&mut self) {
        self.diagnostics.sort();
        self.diagnostics.merge();
    }

    /// Drops notes, unless `all` is set or there are errors or warnings. A survey notes values that nobody has
    /// chosen; a user who chooses them gets the note then.
    pub(crate) fn quiet(&mut self, all: bool) {
        if !all && !self.diagnostics.has_errors() {
            let diagnostics = std::mem::take(&mut self.diagnostics).into_iter();
            self.diagnostics = diagnostics.filter(|one| one.severity != Severity::Note).collect();
        }
    }

    /// Prints the diagnostics to standard error; whether there was no error among them.
    pub(crate) fn report(&mut self) -> bool {
        self.arrange();
        self.complain()
    }

    fn complain(&self) -> bool {
        complain(&self.rendered());
        !self.diagnostics.has_errors()
    }

    /// The diagnostics for people.
    fn rendered(&self) -> String {
        render::human_all(&self.diagnostics, self.sources())
    }

    /// A diagnostic as JSON.
    pub(crate) fn json(&self, diagnostic: &Diagnostic) -> serde_json::Value {
        render::json(diagnostic, self.sources())
    }

    /// The text that [`Self::report_as`] has printed in a form that is no data.
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

    /// Prints the diagnostics in a form, with what a command has found besides: as a text for people, and as JSON to be
    /// made of the diagnostics. `fine` are the pipelines without errors. Whether there was no error at all.
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

    /// Prints a diagnostic to standard error; `false`.
    pub(crate) fn fail(&self, diagnostic: Diagnostic) -> bool {
        complain(&render::human_all([&diagnostic], self.sources()));
        false
    }
}
