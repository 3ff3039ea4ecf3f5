//! Running other programs, from the root of the workspace.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The arguments of npm that install what a lock file names, and run nothing of it.
pub(crate) const NPM_CI: [&str; 4] = ["ci", "--ignore-scripts", "--no-audit", "--no-fund"];

/// Returns the root folder of the workspace.
pub(crate) fn workspace_root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.parent().unwrap_or(package).to_path_buf()
}

/// Returns the folder into which cargo builds.
pub(crate) fn target_folder() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) if !folder.is_empty() => workspace_root().join(folder),
        _ => workspace_root().join("target"),
    }
}

/// Creates a command that runs in the root of the workspace; `cargo` is the one that runs this program.
pub(crate) fn program(name: &str) -> Command {
    let mut command = match (name, std::env::var_os("CARGO")) {
        ("cargo", Some(cargo)) => Command::new(cargo),
        _ => Command::new(name),
    };
    command.current_dir(workspace_root());
    // Cargo describes this package to this process; passed on, that would have other packages built again.
    for (variable, _) in std::env::vars_os() {
        let name = variable.to_string_lossy();
        if name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") || name == "CARGO_BIN_NAME" {
            command.env_remove(&variable);
        }
    }
    command
}

/// Runs a command, whose name in messages is `shown`.
///
/// # Errors
/// The command could not be started, or fails.
pub(crate) fn run(command: &mut Command, shown: &str) -> Result<(), String> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{shown} failed ({status})")),
        Err(error) => Err(format!("{shown} could not be started: {error}")),
    }
}

/// Runs a cargo command, which prints its own errors. Returns `true` if it succeeds.
///
/// # Errors
/// The command could not be started.
pub(crate) fn cargo(command: &mut Command) -> Result<bool, String> {
    let status = command.status().map_err(|error| format!("cargo could not be started: {error}"))?;
    Ok(status.success())
}

/// Runs a program and returns its standard output; `None` if it fails.
pub(crate) fn output(name: &str, arguments: &[&str]) -> Option<String> {
    let output = program(name).args(arguments).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Runs a program without showing its output. Returns `true` if it succeeds.
pub(crate) fn succeeds(name: &str, arguments: &[&str]) -> bool {
    program(name).args(arguments).output().is_ok_and(|output| output.status.success())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_workspace_root_holds_the_lock_file() {
        assert!(workspace_root().join("Cargo.lock").is_file());
    }

    #[test]
    fn a_program_that_is_not_there_does_not_succeed() {
        assert!(!succeeds("a-program-that-nobody-has", &[]));
        assert!(succeeds("cargo", &["--version"]));
    }
}
