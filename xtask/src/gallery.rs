//! `cargo xtask gallery`: what each pipeline makes of each scene, in the sheets of `examples/gallery/`.

use std::process::ExitCode;

use crate::{adapter, process};

/// Runs the command.
pub(crate) fn run() -> ExitCode {
    adapter::ensure_if_possible();
    let mut command = process::program("cargo");
    match process::run(command.args(["run", "--quiet", "--example", "gallery"]), "cargo") {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::from(1)
        }
    }
}
