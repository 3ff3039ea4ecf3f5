//! The command line of `test`.

use std::path::PathBuf;

use clap::Args;

use super::drawing::Drawn;
use super::{DiagnosticsFormat, Files};

#[derive(Args)]
pub(crate) struct TestArguments {
    /// Test files (NAME.test.wgsl), templates with a test file beside them, folders, or pipelines. For pipelines: the
    /// tests in the folder of --templates whose templates their passes use.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) paths: Vec<PathBuf>,
    /// Runs only tests whose names contain this text.
    #[arg(long, value_name = "NAME")]
    pub(crate) filter: Option<String>,
    /// The time limit for all test rows of one variant, which run together, in seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub(crate) timeout: u64,
    /// The format of the diagnostics: human, json, github, sarif or junit.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: DiagnosticsFormat,
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    #[command(flatten)]
    pub(crate) files: Files,
}
