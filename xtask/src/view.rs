//! `cargo xtask view`: the live viewer, built and run.
//!
//! It is a package of its own, which nothing else builds: a window needs much that the module does not.

use crate::{adapter, process};

/// The arguments of the viewer if none are given.
const DEFAULTS: [&str; 3] = ["pipelines/umbra.json", "--scene", "examples/scenes/courtyard.glb"];

/// Builds and runs the viewer. Returns `true` if its window was closed without errors.
pub(crate) fn run(arguments: &[String]) -> Result<bool, String> {
    adapter::ensure_if_possible();
    let mut command = process::program("cargo");
    command.args(["run", "--release", "--locked", "--manifest-path", "view/Cargo.toml", "--"]);
    command.env("CARGO_TARGET_DIR", process::target_folder().join("view"));
    if arguments.is_empty() {
        command.args(DEFAULTS)
    } else {
        command.args(arguments)
    };
    process::cargo(&mut command)
}
