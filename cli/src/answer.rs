//! The answer of a command that works for a while: in words with the time that it took, or as JSON.

use umbragraph::diagnostic::Diagnostics;

use crate::arguments::{AnswerFormat, Choices};
use crate::progress::Progress;
use crate::session::Session;
use crate::streams::{print, print_json};

/// The result of a command, as text for people and as JSON.
pub(crate) trait Answer {
    /// Returns the answer as text for people.
    fn text(&self) -> String;
    /// Returns the answer as JSON.
    fn json(&self) -> serde_json::Value;
}

/// Prints the answer of a command and all diagnostics. `work` must return only diagnostics that the session does not
/// have yet. Returns `true` if there were no errors.
pub(crate) fn answer<A: Answer>(
    choices: &Choices,
    format: AnswerFormat,
    work: impl FnOnce(&mut Session, &mut Progress) -> Result<A, Diagnostics>,
) -> bool {
    let mut session = Session::new(&choices.files);
    let mut progress = Progress::new();
    let result = work(&mut session, &mut progress);
    progress.finish();
    match result {
        Ok(found) => match format {
            AnswerFormat::Human => print(&format!("{}{}\n", found.text(), progress.summary())),
            AnswerFormat::Json => print_json(&format!("{:#}\n", found.json())),
        },
        Err(diagnostics) => session.diagnostics.extend(diagnostics),
    }
    session.report()
}
