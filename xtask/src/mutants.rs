//! `cargo xtask mutants`: faults planted on purpose, and whether a test finds them.
//!
//! In the templates of `shaders-templates/` the project's own harness plants them (`tests/mutants/`), which renders the
//! table of reference pictures with planted text and builds nothing again. In Rust, `cargo-mutants` does, over the node
//! kinds, scenes, and the engine's plan and executor.

use std::process::ExitCode;

use crate::process;

/// What faults are planted in for `--rust`.
const FILES: &[&str] = &["passes/src/**", "scene/src/**", "graph/compiler/src/**", "graph/executor/src/**"];

/// The packages and tests that look for them: those that hold what is planned, placed and drawn to a simulation, a
/// figure or a picture. A build and a run of all would take several minutes for each fault.
const PACKAGES: &str =
    "umbragraph,umbragraph-compiler,umbragraph-executor,umbragraph-passes,umbragraph-scene,umbragraph-tools";
const TESTS: &[&str] = &[
    "caching",
    "checker",
    "engine",
    "executing",
    "executor",
    "golden",
    "graph",
    "graph_orders",
    "lights",
    "moment_shadows",
    "nebula",
    "own_scenes",
    "penumbrae",
    "scenes",
];

/// What to plant faults in, and how many.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    pub(crate) rust: bool,
    /// So many, chosen by the seed; all without it.
    pub(crate) sample: Option<u32>,
    pub(crate) seed: Option<u64>,
    /// So many templates at once; as many as there are cores without it.
    pub(crate) jobs: Option<u32>,
    /// Only templates, or files, whose name contains this.
    pub(crate) within: Option<String>,
}

/// Runs the command.
pub(crate) fn run(options: &Options) -> ExitCode {
    if options.rust { rust(options) } else { templates(options) }
}

fn templates(options: &Options) -> ExitCode {
    let mut command = process::program("cargo");
    command.args(["test", "--quiet", "--release", "--package", "umbragraph", "--test", "mutants", "--"]);
    command.args(["nine_of_ten_faults_in_templates_show_in_a_picture", "--ignored", "--nocapture"]);
    command.env("UMBRAGRAPH_REQUIRE_GPU", "1");
    command.envs(options.sample.map(|sample| ("UMBRAGRAPH_MUTANTS_SAMPLE", sample.to_string())));
    // Each job draws on one thread of the software driver.
    command.env("LP_NUM_THREADS", "1");
    command.envs(options.jobs.map(|jobs| ("UMBRAGRAPH_MUTANTS_JOBS", jobs.to_string())));
    command.envs(options.seed.map(|seed| ("UMBRAGRAPH_SEED", seed.to_string())));
    command.envs(options.within.as_ref().map(|name| ("UMBRAGRAPH_MUTANTS_IN", name)));
    finish(command.status())
}

fn rust(options: &Options) -> ExitCode {
    if !process::succeeds("cargo", &["mutants", "--version"]) {
        eprintln!("cargo-mutants is not installed; to install it: cargo install --locked cargo-mutants");
        return ExitCode::from(1);
    }
    let files: Vec<&str> = FILES.iter().flat_map(|file| ["--file", file]).collect();
    let within = options.within.as_deref();
    let mut chosen = Vec::new();
    if let Some(sample) = options.sample {
        let listed =
            process::program("cargo").args(["mutants", "--workspace", "--list"]).args(&files).output();
        let Ok(listed) = listed.map(|output| String::from_utf8_lossy(&output.stdout).into_owned()) else {
            eprintln!("cargo could not be started");
            return ExitCode::from(1);
        };
        let all: Vec<&str> =
            listed.lines().filter(|line| within.is_none_or(|name| line.contains(name))).collect();
        chosen = pick(&all, sample, options.seed.unwrap_or(1));
        println!("{} of {} faults", chosen.len(), all.len());
    }
    let mut command = process::program("cargo");
    command.args(["mutants", "--workspace", "--in-place", "--baseline", "skip"]);
    command.args(["--timeout", "900", "--test-package", PACKAGES]).args(&files);
    for name in &chosen {
        command.args(["--re", &format!("^{}$", escaped(name))]);
    }
    if let Some(name) = within.filter(|_| chosen.is_empty()) {
        command.args(["--re", &escaped(name)]);
    }
    command.args(["--", "--lib"]).args(TESTS.iter().flat_map(|test| ["--test", test]));
    finish(command.status())
}

fn finish(status: std::io::Result<std::process::ExitStatus>) -> ExitCode {
    match status {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(1),
        Err(error) => {
            eprintln!("cargo could not be started: {error}");
            ExitCode::from(1)
        }
    }
}

/// So many lines of a list, the same for one seed.
fn pick(all: &[&str], count: u32, seed: u64) -> Vec<String> {
    let mut list: Vec<&str> = all.to_vec();
    let mut state = seed;
    for end in (1..list.len()).rev() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        list.swap(end, ((state >> 33) % (end as u64 + 1)) as usize);
    }
    list.truncate(count as usize);
    list.into_iter().map(str::to_owned).collect()
}

/// A text as a regular expression that matches just it.
fn escaped(text: &str) -> String {
    let special = |c: char| !c.is_ascii_alphanumeric() && c.is_ascii() && !" _/:,<>\"'&=".contains(c);
    text.chars().flat_map(|c| special(c).then_some('\\').into_iter().chain([c])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_the_same_for_a_seed_and_another_for_another() {
        let all: Vec<String> = (0..100).map(|at| at.to_string()).collect();
        let all: Vec<&str> = all.iter().map(String::as_str).collect();
        assert_eq!(pick(&all, 9, 1), pick(&all, 9, 1));
        assert_ne!(pick(&all, 9, 1), pick(&all, 9, 2));
        assert_eq!(pick(&all, 900, 1).len(), 100);
    }

    #[test]
    fn names_of_faults_are_no_patterns() {
        assert_eq!(escaped("a.rs:1:2: replace + with * in b"), "a\\.rs:1:2: replace \\+ with \\* in b");
    }
}
