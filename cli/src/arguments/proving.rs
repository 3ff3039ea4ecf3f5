//! The command line of `permutations`.

use std::path::PathBuf;

use clap::Args;

use super::{CacheArguments, DiagnosticsFormat, Files, Settings};
use crate::permutations::Shard;
use crate::validator::ExternalValidator;

/// The options that make the validated set smaller or larger than the reachable set, so that no lock file can be
/// written from it.
const PARTIAL: [&str; 8] = ["all", "config", "set", "feature", "preset", "params", "axes", "profiles"];

#[derive(Args)]
pub(crate) struct PermutationsArguments {
    /// The pipelines; at least one unless --all or --axes is given.
    #[arg(required_unless_present_any = ["all", "axes"])]
    pub(crate) pipelines: Vec<PathBuf>,
    /// Validates only for these target profiles. The default is the profiles that the pipelines claim, or webgpu.
    #[arg(long = "profile", value_name = "NAME")]
    pub(crate) profiles: Vec<String>,
    /// Validates every variant that the templates of the pipelines, or all templates, can express. Also reports dead
    /// code in bundled templates, unless further templates may use it.
    #[arg(long, conflicts_with_all = ["set", "feature", "preset", "params"])]
    pub(crate) all: bool,
    /// Validates one configuration: the pipeline's defaults with the given settings; implied by --set, --feature,
    /// --preset and --params.
    #[arg(long, conflicts_with = "all")]
    pub(crate) config: bool,
    #[command(flatten)]
    pub(crate) settings: Settings,
    /// The number of threads; the default is the number of processors. The result does not depend on the number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Writes every distinct shader source to a folder; the file names contain the pass and its axis values.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) write: Option<PathBuf>,
    /// Lists the axes of the templates instead of checking.
    #[arg(long)]
    pub(crate) axes: bool,
    /// An additional validator for every distinct shader source, such as 'tint --format wgsl -o /dev/null {}'.
    #[arg(long, value_name = "COMMAND", value_parser = ExternalValidator::parse)]
    pub(crate) also: Vec<ExternalValidator>,
    /// The time limit of an additional validator for one shader source, in seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub(crate) also_time_limit: u64,
    /// Validates each distinct shader source separately, not only a few that together contain every declaration.
    #[arg(long)]
    pub(crate) exhaustive: bool,
    /// Also prints a line for each pass, one for the newly validated variants, and notes.
    #[arg(long)]
    pub(crate) verbose: bool,
    /// Validates one part of the work, such as 3/8, for several machines. The parts are the same on each machine, of
    /// about equal cost, and together complete.
    #[arg(long, value_name = "K/N", value_parser = Shard::parse, conflicts_with_all = ["all", "axes", "config", "set", "feature", "preset", "params"])]
    pub(crate) shard: Option<Shard>,
    /// Joins the JSON reports of all shards, which are given in place of pipelines, into one.
    #[arg(long, conflicts_with_all = ["shard", "all", "axes", "config", "set", "feature", "preset", "params", "profiles", "write", "also", "exhaustive"])]
    pub(crate) merge: bool,
    /// Fails if the reachable shaders differ from those in the lock file, and names the passes and the values that
    /// differ.
    #[arg(long, group = "uses_lock", conflicts_with_all = PARTIAL)]
    pub(crate) locked: bool,
    /// Writes the reachable shaders into the lock file, to be committed, and prints the differences.
    #[arg(long, group = "uses_lock", conflicts_with_all = PARTIAL)]
    pub(crate) update: bool,
    /// The lock file that --locked compares with, or --update writes; the default is permutations.lock.
    #[arg(long, value_name = "FILE", requires = "uses_lock")]
    pub(crate) lock: Option<PathBuf>,
    /// The budgets of passes: numbers of shader sources, bytes, bindings, registers, and cost. The default is
    /// permutations.budgets.json, if the file exists.
    #[arg(long, value_name = "FILE", conflicts_with = "shard", conflicts_with_all = PARTIAL)]
    pub(crate) budgets: Option<PathBuf>,
    /// Measurements of an offline compiler, by the hashes of variants, to be added to the JSON report.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["merge", "axes", "shard"])]
    pub(crate) measured: Option<PathBuf>,
    /// The format of the diagnostics: human, json, github, sarif or junit.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: DiagnosticsFormat,
    #[command(flatten)]
    pub(crate) files: Files,
    #[command(flatten)]
    pub(crate) cache: CacheArguments,
}

impl PermutationsArguments {
    /// Returns `true` if the validated set differs from the reachable set of variants.
    pub(crate) fn is_partial(&self) -> bool {
        self.all || self.config || !self.settings.is_empty() || !self.profiles.is_empty()
    }
}
