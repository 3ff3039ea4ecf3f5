//! `umbragraph view`: starts the viewer, which is a program of its own.
//!
//! A window needs much that the command does not, so that `umbragraph-view` is installed by itself. It is looked for
//! beside this program first, then on PATH.

use std::path::PathBuf;
use std::process::{Command, ExitCode};

use umbragraph::diagnostic::{Diagnostic, Place, render};
use umbragraph::low_level::source::Sources;

use crate::arguments::ViewArguments;
use crate::codes;
use crate::streams::complain;

/// The name of the viewer's program.
const NAME: &str = "umbragraph-view";

/// Runs the viewer until its window is closed. Returns the viewer's exit status, which has the same meanings as that of
/// this command.
pub(crate) fn run(arguments: &ViewArguments) -> ExitCode {
    let program = found();
    match Command::new(&program).args(&arguments.arguments).status() {
        Ok(status) => {
            // A viewer that a signal ended has no status.
            let code = status.code().and_then(|code| u8::try_from(code).ok());
            code.map_or(ExitCode::FAILURE, ExitCode::from)
        }
        Err(error) => {
            let message = format!("the viewer \"{}\" cannot be started: {error}", program.display());
            let diagnostic = Diagnostic::error(codes::VIEWER, Place::Nowhere, message).help(
                "install it with `cargo install --path view`, or run `cargo xtask view` in the project",
            );
            complain(&render::human(&diagnostic, &Sources::new()));
            ExitCode::FAILURE
        }
    }
}

/// Returns the viewer's path beside this executable, or else its name, which the operating system searches on PATH.
fn found() -> PathBuf {
    let beside = std::env::current_exe().ok().map(|own| own.with_file_name(NAME));
    let beside = beside.map(|path| path.with_extension(std::env::consts::EXE_EXTENSION));
    beside.filter(|path| path.is_file()).unwrap_or_else(|| PathBuf::from(NAME))
}
