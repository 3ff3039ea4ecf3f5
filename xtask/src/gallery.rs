//! `cargo xtask gallery`: what each pipeline makes of each scene, in the sheets of `examples/gallery/`.

use std::process::ExitCode;

use crate::{adapter, process};

/// Runs the command.
pub(crate) fn run() -> ExitCode {
    if !adapter::ensure() {
        eprintln!(
            "going on all the same: the search for a driver goes by file names and may have missed one"
        );
    }
    match process::program("cargo").args(["run", "--quiet", "--example", "gallery"]).status() {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(1),
        Err(error) => {
            eprintln!("cargo could not be started: {error}");
            ExitCode::from(1)
        }
    }
}
