//! The environment variables that steer tests, and the places that follow from them.
//!
//! Each is read through a [`Lookup`], so that the rules built on them are tested without changing the
//! environment of the process, which other tests share.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The variable that makes a test fail, not skip, if there is no graphics adapter.
pub const REQUIRE_GPU: &str = "UMBRAGRAPH_REQUIRE_GPU";
/// The variable that selects the adapter whose name contains its value, ignoring case.
pub const ADAPTER: &str = "UMBRAGRAPH_ADAPTER";
/// The variable that accepts changed pictures as new references.
pub const BLESS: &str = "UMBRAGRAPH_BLESS";
/// The variable with the folder of ray-traced reference data, in place of `../shared/truth` beside the workspace.
pub const TRUTH: &str = "UMBRAGRAPH_TRUTH";
/// The variable with a file to which each skipped test appends its reason, so that a runner can count across processes.
pub const SKIP_LOG: &str = "UMBRAGRAPH_SKIP_LOG";

/// A function that returns the value of an environment variable; `None` if it is not set.
pub type Lookup<'a> = &'a dyn Fn(&str) -> Option<OsString>;

/// Returns the value of a variable in the environment of this process.
pub fn process(name: &str) -> Option<OsString> {
    std::env::var_os(name)
}

/// Returns `true` if a variable has a value other than the empty text and `0`.
pub fn is_set(lookup: Lookup<'_>, name: &str) -> bool {
    lookup(name).is_some_and(|value| !value.is_empty() && value != "0")
}

/// Returns the root folder of the workspace.
pub fn workspace_root() -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).unwrap_or(package).to_path_buf()
}

/// Returns the folder for the output of builds and tests.
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
