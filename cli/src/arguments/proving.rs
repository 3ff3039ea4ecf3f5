//! The command line of `permutations`.

use std::path::PathBuf;

use clap::Args;

use super::{CacheArguments, DiagnosticsFormat, Files, Settings};
use crate::permutations::Shard;
use crate::validator::ExternalValidator;

/// The options that take a part of what is reached, or more; a lock has exactly that.
const PARTIAL: [&str; 8] = ["all", "config", "set", "feature", "preset", "params", "axes", "profiles"];

#[derive(Args)]
pub(crate) struct PermutationsArguments {
    /// The pipelines; without --all or --axes at least one.
    #[arg(required_unless_present_any = ["all", "axes"])]
    pub(crate) pipelines: Vec<PathBuf>,
    /// Only these target profiles; without one those that the pipelines claim, or webgpu.
    #[arg(long = "profile", value_name = "NAME")]
    pub(crate) profiles: Vec<String>,
    /// Everything that the templates of the pipelines, or all templates, can express. What is dead in a folder of
    /// `--templates` is reported always, and with this also in other templates, unless further ones share and may need
    /// it.
    #[arg(long, conflicts_with_all = ["set", "feature", "preset", "params"])]
    pub(crate) all: bool,
    /// One configuration: the pipeline's defaults; implied by anything that gives settings their values.
    #[arg(long, conflicts_with = "all")]
    pub(crate) config: bool,
    #[command(flatten)]
    pub(crate) settings: Settings,
    /// The number of threads; without it as many as there are processors. The outcome is the same with any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Writes every distinct text to a folder, with its pass and axes in its name.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) write: Option<PathBuf>,
    /// Lists the axes of the templates instead of checking.
    #[arg(long)]
    pub(crate) axes: bool,
    /// A further validator for every distinct text, such as 'tint --format wgsl -o /dev/null {}'.
    #[arg(long, value_name = "COMMAND", value_parser = ExternalValidator::parse)]
    pub(crate) also: Vec<ExternalValidator>,
    /// The time limit of a further validator for one text.
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub(crate) also_time_limit: u64,
    /// Proves each distinct text by itself, not only a few that together hold every declaration.
    #[arg(long)]
    pub(crate) exhaustive: bool,
    /// A line for each pass as well, one for what was proven now, and notes.
    #[arg(long)]
    pub(crate) verbose: bool,
    /// The third of eight parts of the work, for several machines. The parts are the same on each, of about equal cost,
    /// and together the whole.
    #[arg(long, value_name = "K/N", value_parser = Shard::parse, conflicts_with_all = ["all", "axes", "config", "set", "feature", "preset", "params"])]
    pub(crate) shard: Option<Shard>,
    /// Joins the JSON reports of all shards, which are given instead of pipelines, into one.
    #[arg(long, conflicts_with_all = ["shard", "all", "axes", "config", "set", "feature", "preset", "params", "profiles", "write", "also", "exhaustive"])]
    pub(crate) merge: bool,
    /// Fails if other shaders are reached than the lock says, and names the passes and the values that differ.
    #[arg(long, group = "uses_lock", conflicts_with_all = PARTIAL)]
    pub(crate) locked: bool,
    /// Writes what is reached into the lock, to be committed, and says what differs from before.
    #[arg(long, group = "uses_lock", conflicts_with_all = PARTIAL)]
    pub(crate) update: bool,
    /// The lock that --locked compares with, or --update writes; without it permutations.lock.
    #[arg(long, value_name = "FILE", requires = "uses_lock")]
    pub(crate) lock: Option<PathBuf>,
    /// The budgets of passes: numbers of texts, bytes, bindings, registers, and cost; without it
    /// permutations.budgets.json, if there is one.
    #[arg(long, value_name = "FILE", conflicts_with = "shard", conflicts_with_all = PARTIAL)]
    pub(crate) budgets: Option<PathBuf>,
    /// Figures of an offline compiler for variants, by their hashes, to be put into the JSON report.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["merge", "axes", "shard"])]
    pub(crate) measured: Option<PathBuf>,
    /// The form of the diagnostics: human, json, github, sarif or junit.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: DiagnosticsFormat,
    #[command(flatten)]
    pub(crate) files: Files,
    #[command(flatten)]
    pub(crate) cache: CacheArguments,
}

impl PermutationsArguments {
    /// Whether what is proven is a part of what is reached, or more.
    pub(crate) fn is_partial(&self) -> bool {
        self.all || self.config || !self.settings.is_empty() || !self.profiles.is_empty()
    }
}
