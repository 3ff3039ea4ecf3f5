//! `cargo xtask fuzz`: random inputs for all that the module reads, counted target by target.
//!
//! The inputs and their counts are the crate `tests/fuzz`; this command builds and runs it, and writes the counts into
//! docs/trust.md.

use crate::process;

/// The path of the page with the numbers of fuzzed inputs.
const PAGE: &str = "docs/trust.md";

/// The options of a fuzzing run: time, target and output.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    /// The time limit in minutes. `None` means one minute, or zero minutes if `page` is set.
    pub(crate) minutes: Option<u32>,
    pub(crate) target: Option<String>,
    /// Writes the numbers of fuzzed inputs into the page.
    pub(crate) page: bool,
}

/// Runs the fuzzer. Returns `true` if no input caused a failure.
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
