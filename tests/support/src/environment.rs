//! The environment variables that steer tests, and the places that follow from them.
//!
//! Each is read through a [`Lookup`], so that the rules built on them are tested without changing the
//! environment of the process, which other tests share.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Makes a test that finds no graphics adapter fail instead of being skipped.
pub const REQUIRE_GPU: &str = "UMBRAGRAPH_REQUIRE_GPU";
/// Selects the adapter whose name contains this text, whatever its case.
pub const ADAPTER: &str = "UMBRAGRAPH_ADAPTER";
/// Accepts pictures that differ from their references.
pub const BLESS: &str = "UMBRAGRAPH_BLESS";
/// The folder with the ray-traced truth, in place of `../shared/truth` beside the workspace.
pub const TRUTH: &str = "UMBRAGRAPH_TRUTH";
/// A file to which each skipped test appends its reason, so that a runner can count across processes.
pub const SKIP_LOG: &str = "UMBRAGRAPH_SKIP_LOG";

/// A source of the values of environment variables.
pub type Lookup<'a> = &'a dyn Fn(&str) -> Option<OsString>;

/// Looks a variable up in the environment of this process.
pub fn process(name: &str) -> Option<OsString> {
    std::env::var_os(name)
}

/// Whether a variable is set to something other than nothing or `0`.
pub fn is_set(lookup: Lookup<'_>, name: &str) -> bool {
    lookup(name).is_some_and(|value| !value.is_empty() && value != "0")
}

/// The root of the workspace.
pub fn workspace_root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).unwrap_or(package).to_path_buf()
}

/// The folder for what the build and the tests write.
pub fn target_folder(lookup: Lookup<'_>) -> PathBuf {
    match lookup("CARGO_TARGET_DIR") {
        Some(folder) if !folder.is_empty() => workspace_root().join(folder),
        _ => workspace_root().join("target"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_and_nothing_count_as_unset() {
        for (value, expected) in [(None, false), (Some(""), false), (Some("0"), false), (Some("1"), true)] {
            let lookup = |_: &str| value.map(OsString::from);
            assert_eq!(is_set(&lookup, REQUIRE_GPU), expected, "{value:?}");
        }
    }

    #[test]
    fn the_workspace_root_holds_the_lock_file() {
        assert!(workspace_root().join("Cargo.lock").is_file());
    }

    #[test]
    fn a_relative_target_folder_is_taken_from_the_workspace_root() {
        let lookup = |_: &str| Some(OsString::from("elsewhere"));
        assert_eq!(target_folder(&lookup), workspace_root().join("elsewhere"));
        assert_eq!(target_folder(&|_| None), workspace_root().join("target"));
    }
}
