//! The command line of `view`.

use std::ffi::OsString;

use clap::Args;

#[derive(Args)]
#[command(disable_help_flag = true)]
pub(crate) struct ViewArguments {
    /// The pipeline, --scene FILE and further options: `umbragraph view --help` lists them.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, value_name = "ARGUMENT")]
    pub(crate) arguments: Vec<OsString>,
}
