//! `cargo xtask soak`: the tests of random cases with fresh seeds, and checks that take too long for ordinary tests.
//!
//! It runs the tests of every file that gets its cases or seeds from the shared helper
//! (`tests/support/src/property.rs`), so that a new property needs no line here. Each round prints its own seed. Rounds
//! repeat until the time is over or a test fails. Then a scene moves for an hour while everything about its frame changes
//! (`tests/device/long_run.rs`). The viewer's window comes last: 200 random edits of its files, and random input for half an
//! hour. Both take the given time, if that is shorter.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use crate::{integrations, process};

/// The factor for the number of cases in a round, if only the time is given.
const TIMES: u32 = 10;

/// The number of file edits while the viewer's window is open, multiplied by the factor.
const EDITS: u32 = 20;

/// The maximum time of random input to the viewer's window, in seconds.
const WINDOW_SECONDS: u64 = 30 * 60;

/// The maximum time of the run that detects memory growth, in seconds.
const LONG_SECONDS: u64 = 60 * 60;

/// The duration, the number of cases and the first seed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    /// The time in seconds during which new rounds begin; `None` for a single round.
    pub(crate) seconds: Option<u64>,
    /// The factor for the number of cases; `None` for the default.
    pub(crate) times: Option<u32>,
    /// The seed of the first round; `None` for the current time in seconds.
    pub(crate) seed: Option<u64>,
}

/// Runs the randomized tests in rounds. Returns `true` if all passed.
pub(crate) fn run(options: &Options) -> Result<bool, String> {
    let mut tests = BTreeSet::new();
    collect(&process::workspace_root(), &mut tests);
    println!("{} tests", tests.len());
    let start = Instant::now();
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let mut seed = options.seed.unwrap_or(since.as_secs());
    let factor = options.times.unwrap_or(TIMES);
    let times = factor.to_string();
    loop {
        println!("\n==> UMBRAGRAPH_SEED={seed} UMBRAGRAPH_TIMES={times}");
        let mut command = process::program("cargo");
        command.args([
            "test",
            "--quiet",
            "--workspace",
            "--features",
            "umbragraph/watch",
            "--lib",
            "--tests",
            "--no-fail-fast",
            "--",
        ]);
        command.args(&tests).env("UMBRAGRAPH_SEED", seed.to_string()).env("UMBRAGRAPH_TIMES", &times);
        if !process::cargo(&mut command)? {
            return Err(format!(
                "to repeat: UMBRAGRAPH_SEED={seed} UMBRAGRAPH_TIMES={times} cargo test --workspace NAME\n\
                 keep what failed as a test of its own, by name"
            ));
        }
        let goes_on = options.seconds.is_some_and(|seconds| start.elapsed() < Duration::from_secs(seconds));
        if !goes_on {
            let at_most = |most: u64| options.seconds.map_or(most, |seconds| seconds.min(most));
            println!("\n==> a long run: UMBRAGRAPH_SEED={seed}");
            let mut command = process::program("cargo");
            command.args(["test", "--workspace", "--features", "umbragraph/watch", "--test", "device"]);
            command.args(["--", "a_long_run", "--nocapture"]);
            command.env("UMBRAGRAPH_SEED", seed.to_string());
            command.env("UMBRAGRAPH_LONG_RUN", at_most(LONG_SECONDS).to_string());
            if !process::cargo(&mut command)? {
                return Err(format!("something grows, or leaves a trace: UMBRAGRAPH_SEED={seed}"));
            }
            let seconds = at_most(WINDOW_SECONDS);
            println!("\n==> the viewer: UMBRAGRAPH_SEED={seed}");
            return integrations::soak_viewer(seed, factor.saturating_mul(EDITS), seconds).map(|()| true);
        }
        seed = seed.wrapping_add(1);
    }
}

/// Collects the names of the tests below a folder that use the shared `property` helper.
fn collect(folder: &Path, tests: &mut BTreeSet<String>) {
    for path in std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            collect(&path, tests);
        } else if path.extension().is_some_and(|extension| extension == "rs")
            && let Ok(text) = std::fs::read_to_string(&path)
        {
            tests.extend(names(&text));
        }
    }
}

/// Returns the names of the tests in a source file that uses the shared `property` helper.
fn names(text: &str) -> Vec<String> {
    let asks = ["config(", "part(", "seed()", "times()"].map(|call| format!("property::{call}"));
    if !asks.iter().any(|call| text.contains(call)) {
        return Vec::new();
    }
    // Those that stand in a line of their own, and not in a text within a test.
    let mut lines = text.lines().map(str::trim);
    let mut names = Vec::new();
    while lines.any(|line| line == "#[test]") {
        let name =
            lines.find_map(|line| Some(line.strip_prefix("fn ")?.split('(').next()?.trim().to_owned()));
        names.extend(name);
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tests_of_files_that_use_the_helper_are_run_and_no_others() {
        let text = "proptest! {\n    #![proptest_config(property::config(9))]\n    #[test]\n    fn one(a in 0..2) {}\n}\n#[test]\nfn two() {}\nfn three() {}\n";
        assert_eq!(names(text), ["one", "two"]);
        assert_eq!(names(&format!("{text:?}\n#[test]\nfn four() {{}}\n")), ["four"]);
        assert!(names("#[test]\nfn two() {}\n").is_empty());
    }

    #[test]
    fn every_property_of_the_workspace_is_among_them() {
        let mut tests = BTreeSet::new();
        collect(&process::workspace_root(), &mut tests);
        assert!(tests.contains("only_reads_of_unwritten_pieces_are_rejected"));
        assert!(tests.contains("changed_bytes_give_diagnostics_or_a_usable_scene"));
    }
}
