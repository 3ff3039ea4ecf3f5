//! The command line of `new`.

use std::path::PathBuf;

use clap::Args;

use crate::new::Kind;

#[derive(Args)]
pub(crate) struct NewArguments {
    /// The folder; it is created where it is missing. The pipeline gets its name.
    pub(crate) name: PathBuf,
    /// The kind of pipeline to begin with: post, shadows or system.
    #[arg(long, value_enum, value_name = "KIND", default_value_t)]
    pub(crate) kind: Kind,
}
