//! The command line of `test`.

use std::path::PathBuf;

use clap::Args;

use super::drawing::Drawn;
use super::{DiagnosticsFormat, Files};

#[derive(Args)]
pub(crate) struct TestArguments {
    /// Files of tests (NAME.test.wgsl), templates with one beside them, folders, or pipelines: of these the tests in
    /// the folder of --templates whose templates their passes use.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) paths: Vec<PathBuf>,
    /// Only tests whose names contain this.
    #[arg(long, value_name = "NAME")]
    pub(crate) filter: Option<String>,
    /// The time limit of the rows of one variant, which run together.
    #[arg(long, value_name = "SECONDS", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=3600))]
    pub(crate) timeout: u64,
    /// The form of the diagnostics: human, json, github, sarif or junit.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: DiagnosticsFormat,
    #[command(flatten)]
    pub(crate) drawn: Drawn,
    #[command(flatten)]
    pub(crate) files: Files,
}
