//! `cargo xtask integrations`: the packages that adopt the module in an engine, a window or an editor, built and tested.
//!
//! Those of engines and windows are separate packages, since their engines build slowly and need a newer Rust than the module. Each names its
//! toolchain in a file `rust-toolchain.toml`; rustup installs it if it is missing. The build goes to
//! `target/integrations/`.
//!
//! A window needs a display. On Linux without one, a virtual display is installed if possible; otherwise the test of
//! the window reports that it is skipped.

use std::path::Path;
use std::process::Command;

use crate::{adapter, job, process};

/// A package that integrates the library, and the source files whose lines are counted.
struct Integration {
    name: &'static str,
    /// The path of the folder, relative to the root of the workspace.
    folder: &'static str,
    sources: &'static [&'static str],
    has_window: bool,
}

const ALL: [Integration; 3] = [
    Integration {
        name: "bevy",
        folder: "examples/bevy",
        sources: &["src/lib.rs", "src/meshes.rs"],
        has_window: false,
    },
    Integration { name: "egui", folder: "examples/egui", sources: &[], has_window: true },
    Integration { name: "view", folder: "view", sources: &[], has_window: true },
];

/// The Debian packages that a window needs on a machine without a display.
const DISPLAY_PACKAGES: [&str; 7] =
    ["xvfb", "xauth", "libxcursor1", "libxi6", "libxrandr2", "libxkbcommon-x11-0", "libx11-xcb1"];

/// The name of the CI job that users copy, which is no package.
const JOB: &str = "ci";
/// The name of the language server's test over a pipe, with the protocol library of Visual Studio Code's client.
const EDITOR: &str = "editor";

/// Returns the names of all packages, of the CI job and of the test of the language server.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    [JOB, EDITOR].into_iter().chain(ALL.iter().map(|integration| integration.name))
}

/// Builds and tests one integration, or all if `None`.
pub(crate) fn run(only: Option<&str>) -> Result<bool, String> {
    let mut failed = Vec::new();
    if only.is_none_or(|only| only == JOB) {
        failed.extend(job::run().err());
    }
    if only.is_none_or(|only| only == EDITOR) {
        failed.extend(editor().err().map(|reason| format!("{EDITOR}: {reason}")));
    }
    if !matches!(only, Some(JOB | EDITOR)) && !adapter::ensure() {
        eprintln!("tests that need a graphics adapter will fail");
    }
    for integration in ALL.iter().filter(|integration| only.is_none_or(|only| only == integration.name)) {
        let folder = process::workspace_root().join(integration.folder);
        if !integration.sources.is_empty() {
            println!("{}: {}", integration.folder, lines(&folder, integration.sources));
        }
        let tested = process::run(&mut test(integration, &folder), "cargo");
        failed.extend(tested.err().map(|reason| format!("{}: {reason}", integration.name)));
    }
    if failed.is_empty() { Ok(true) } else { Err(failed.join("\n")) }
}

/// Tests the language server with the libraries of the extension's lock file.
fn editor() -> Result<(), String> {
    if !process::succeeds("npm", &["--version"]) {
        return Err(
            "node and npm are not installed; the test speaks to the server with a library of npm".to_owned()
        );
    }
    process::run(process::program("cargo").args(["build", "--package", "umbragraph-cli"]), "cargo")?;
    let command =
        process::target_folder().join("debug").join(format!("umbragraph{}", std::env::consts::EXE_SUFFIX));
    for arguments in [&process::NPM_CI[..], &["test"]] {
        let mut npm = process::program("npm");
        npm.current_dir(process::workspace_root().join("editors/vscode")).env("UMBRAGRAPH_COMMAND", &command);
        process::run(npm.args(arguments), "npm")?;
    }
    Ok(())
}

/// Tests the viewer's window with random edits of files and random input.
pub(crate) fn soak_viewer(seed: u64, edits: u32, seconds: u64) -> Result<(), String> {
    let viewer = ALL.iter().find(|integration| integration.name == "view");
    let viewer = viewer.ok_or("there is no integration \"view\"")?;
    let mut command = test(viewer, &process::workspace_root().join(viewer.folder));
    command.args(["random", "--nocapture"]);
    command
        .env("UMBRAGRAPH_SEED", seed.to_string())
        .env("UMBRAGRAPH_VIEW_EDITS", edits.to_string())
        .env("UMBRAGRAPH_VIEW_SECONDS", seconds.to_string());
    process::run(&mut command, "cargo")
}

fn test(integration: &Integration, folder: &Path) -> Command {
    let mut command = if integration.has_window && lacks_display() {
        let mut command = Command::new("xvfb-run");
        command.args(["--auto-servernum", "--server-args=-screen 0 1600x1000x24", "cargo"]);
        command
    } else {
        Command::new("cargo")
    };
    command.args(["test", "--locked"]).current_dir(folder);
    if integration.has_window {
        // One pointer and one keyboard.
        command.args(["--", "--test-threads=1"]);
    }
    command.env("CARGO_TARGET_DIR", process::target_folder().join("integrations").join(integration.name));
    // The toolchain is the package's, not that which runs this command.
    command.env_remove("RUSTUP_TOOLCHAIN").env_remove("CARGO");
    command
}

/// Returns `true` if a window needs a virtual display and one is available.
fn lacks_display() -> bool {
    if std::env::consts::OS != "linux" || std::env::var_os("DISPLAY").is_some() {
        return false;
    }
    let is_there = || process::succeeds("xvfb-run", &["--help"]);
    if !is_there()
        && let Err(reason) = adapter::install_packages(&DISPLAY_PACKAGES)
    {
        eprintln!("there is no display, and no virtual one, Xvfb: {reason}; tests of windows are skipped");
    }
    is_there()
}

/// Counts the lines of source files, without empty lines and comments.
fn lines(folder: &Path, sources: &[&str]) -> String {
    let (mut all, mut imports) = (0, 0);
    for source in sources {
        let text = std::fs::read_to_string(folder.join(source)).unwrap_or_default();
        let lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
        for line in lines {
            all += 1;
            imports += usize::from(line.starts_with("use ") && !line.contains("umbragraph"));
        }
    }
    format!(
        "{all} lines concern the module, {imports} of them imports of other crates ({})",
        sources.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_package_has_a_lock_file_and_sources_that_are_counted() {
        for Integration { name, folder, sources, .. } in ALL {
            let folder = process::workspace_root().join(folder);
            assert!(folder.join("Cargo.lock").is_file(), "{name}");
            assert!(sources.iter().all(|source| folder.join(source).is_file()), "{name}: {sources:?}");
            assert!(sources.is_empty() || !lines(&folder, sources).starts_with("0 "), "{name}");
        }
    }
}
