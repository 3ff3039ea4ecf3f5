//! The command line of `watch`.

use std::path::PathBuf;

use clap::Args;

use super::Choices;

#[derive(Args)]
pub(crate) struct WatchArguments {
    /// The pipeline files.
    #[arg(required = true)]
    pub(crate) pipelines: Vec<PathBuf>,
    /// Checks one configuration instead of all: the defaults with the given settings.
    #[arg(long)]
    pub(crate) config: bool,
    /// Renders the first pipeline to a .png after each change, if its configuration has no error.
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "FILE", requires = "scene")]
    pub(crate) render: Option<PathBuf>,
    /// The glTF scene to render (.gltf or .glb).
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "FILE", requires = "render")]
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) choices: Choices,
}
