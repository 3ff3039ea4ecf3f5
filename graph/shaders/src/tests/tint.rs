//! `tint`, Chrome's compiler, where it is installed.

use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

use umbragraph_test_support::scratch::ScratchFolder;
use umbragraph_test_support::skip;

/// Returns `true` if the program `tint` is installed; if not, counts the test as skipped.
pub(super) fn is_installed() -> bool {
    let mut command = Command::new("tint");
    let is_installed = command.arg("--help").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !is_installed {
        skip::skipped("tint is not installed");
    }
    is_installed
}

/// Compiles WGSL with `tint`. Several threads can call this at the same time.
///
/// # Errors
/// The complete error output if `tint` rejects the WGSL.
pub(super) fn judge(text: &str, folder: &ScratchFolder) -> Result<(), String> {
    static NUMBER: AtomicUsize = AtomicUsize::new(0);
    let path = folder.join(format!("{}.wgsl", NUMBER.fetch_add(1, Ordering::Relaxed)));
    std::fs::write(&path, text).expect("a file");
    let mut command = Command::new("tint");
    let output =
        command.args(["--format", "wgsl", "-o", "/dev/null"]).arg(&path).output().expect("a process");
    std::fs::remove_file(&path).expect("the file");
    let said = || String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(()) } else { Err(said()) }
}
