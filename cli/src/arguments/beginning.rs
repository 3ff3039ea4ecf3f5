//! The command line of `new`.

use std::path::PathBuf;

use clap::Args;

use crate::new::Kind;

#[derive(Args)]
pub(crate) struct NewArguments {
    /// The folder, which is created if it is missing. The pipeline is named after the folder.
    pub(crate) name: PathBuf,
    /// The kind of pipeline to create: post, shadows or system.
    #[arg(long, value_enum, value_name = "KIND", default_value_t)]
    pub(crate) kind: Kind,
}
