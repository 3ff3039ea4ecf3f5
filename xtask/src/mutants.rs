//! `cargo xtask mutants`: faults planted on purpose, and whether a test finds them.
//!
//! In the templates of `shaders-templates/` the project's own harness plants them (`tests/random/mutants/`), which
//! renders the table of reference pictures with planted text and builds nothing again. In Rust, `cargo-mutants` does,
//! over the node kinds, scenes, and the engine's plan and executor.

use crate::{process, toolchain};

/// The source files that receive artificial faults with `--rust`.
const FILES: &[&str] = &["passes/src/**", "scene/src/**", "graph/compiler/src/**", "graph/executor/src/**"];

/// The packages whose tests must detect the faults: they compare results with a simulation, a number, a picture or a
/// diagnostic. Running all tests would take several minutes for each fault.
const PACKAGES: &str = "umbragraph,umbragraph-compiler,umbragraph-executor,umbragraph-passes,umbragraph-scene,umbragraph-tools,umbragraph-verify";
const TESTS: &str = "kind(lib) or test(/^(broken|caching|checker|device_limits|engine|executing|executor|golden|graph|graph_orders|lights|moment_shadows|nebula|own_scenes|penumbrae|webgpu_rules)::/) or binary(scenes)";
/// Features of a build that needs no graphics driver.
const FEATURES: &[&str] = &["--features", "umbragraph/noop"];

/// The kind and number of the artificial faults.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Options {
    pub(crate) rust: bool,
    /// The number of faults, chosen by the seed; `None` for all.
    pub(crate) sample: Option<u32>,
    pub(crate) seed: Option<u64>,
    /// The number of templates tested in parallel; `None` for the number of cores.
    pub(crate) jobs: Option<u32>,
    /// Tests only templates or files whose name contains this text; `None` for all.
    pub(crate) within: Option<String>,
}

/// Tests whether the tests detect artificial faults in templates, or in Rust code with `rust`. Returns `true` on
/// success.
pub(crate) fn run(options: &Options) -> Result<bool, String> {
    if options.rust { rust(options) } else { templates(options) }
}

fn templates(options: &Options) -> Result<bool, String> {
    let mut command = process::program("cargo");
    command.args(["test", "--quiet", "--release", "--package", "umbragraph", "--test", "random", "--"]);
    command.args(["nine_of_ten_faults_in_templates_show_in_a_picture", "--ignored", "--nocapture"]);
    command.env("UMBRAGRAPH_REQUIRE_GPU", "1");
    command.envs(options.sample.map(|sample| ("UMBRAGRAPH_MUTANTS_SAMPLE", sample.to_string())));
    // Each job draws on one thread of the software driver.
    command.env("LP_NUM_THREADS", "1");
    command.envs(options.jobs.map(|jobs| ("UMBRAGRAPH_MUTANTS_JOBS", jobs.to_string())));
    command.envs(options.seed.map(|seed| ("UMBRAGRAPH_SEED", seed.to_string())));
    command.envs(options.within.as_ref().map(|name| ("UMBRAGRAPH_MUTANTS_IN", name)));
    process::cargo(&mut command)
}

fn rust(options: &Options) -> Result<bool, String> {
    if !process::succeeds("cargo", &["mutants", "--version"]) {
        let help = "cargo-mutants is not installed; to install it: cargo install --locked cargo-mutants";
        return Err(help.to_owned());
    }
    // What is left out, and why, stands in .cargo/mutants.toml.
    let mut selection = vec!["--workspace"];
    selection.extend(FILES.iter().flat_map(|file| ["--file", file]));
    selection.extend(options.within.iter().flat_map(|name| ["--re", name]));
    if !toolchain::has_nextest() {
        return Err(
            "the tests are chosen by cargo-nextest; to install it: cargo install --locked cargo-nextest"
                .to_owned(),
        );
    }
    let tests = ["-E", TESTS];
    // A failure without a fault would be found with each.
    let mut without = process::program("cargo");
    without.args(["nextest", "run", "--cargo-profile", "release"]);
    without.args(PACKAGES.split(',').flat_map(|package| ["--package", package])).args(FEATURES).args(tests);
    if !process::cargo(&mut without)? {
        return Ok(false);
    }
    let mut command = process::program("cargo");
    command.args(["mutants", "--in-place", "--shuffle", "--baseline", "skip", "--timeout", "900"]);
    // Release builds are incremental.
    command.args(["--profile", "release", "--test-tool", "nextest"]);
    command.args(&selection).args(["--test-package", PACKAGES]).args(FEATURES);
    if let Some(sample) = options.sample {
        let listed = process::program("cargo").args(["mutants", "--list"]).args(&selection).output();
        let listed = listed.map_err(|_| "cargo could not be started")?;
        let listed = String::from_utf8_lossy(&listed.stdout).lines().count();
        // Every so manieth fault of the list.
        let shards = (listed / sample.max(1) as usize).max(1) as u64;
        let shard = options.seed.unwrap_or(1) % shards;
        command.args(["--sharding", "round-robin", "--shard", &format!("{shard}/{shards}")]);
    }
    process::cargo(command.arg("--").args(tests))
}
