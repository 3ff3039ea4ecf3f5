//! `cargo xtask fuzz`: random inputs for all that the module reads, counted target by target.
//!
//! The inputs and their counts are the crate `tests/fuzz`; this command builds and runs it, and writes the counts into
//! docs/trust.md.

use crate::process;

/// The page with the counts.
const PAGE: &str = "docs/trust.md";

/// The time, and the one target, if not all are meant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    /// The time limit in minutes: one if absent, none if only the page is written.
    pub(crate) minutes: Option<u32>,
    pub(crate) target: Option<String>,
    /// Whether the counts are written into the page.
    pub(crate) page: bool,
}

/// Runs the command; whether no input failed.
pub(crate) fn run(options: &Options) -> Result<bool, String> {
    let minutes = options.minutes.unwrap_or(u32::from(!options.page));
    let mut command = program();
    command.args(["run", "--minutes", &minutes.to_string()]);
    command.args(options.target.iter().flat_map(|target| ["--target", target]));
    let is_fine = process::cargo(&mut command)?;
    if options.page {
        process::run(program().args(["page", PAGE]), "umbragraph-fuzz")?;
    }
    Ok(is_fine)
}

fn program() -> std::process::Command {
    let mut command = process::program("cargo");
    command.args(["run", "--quiet", "--profile", "fuzz", "--package", "umbragraph-fuzz", "--"]);
    command
}
