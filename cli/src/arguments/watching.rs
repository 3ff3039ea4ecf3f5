//! The command line of `watch`.

use std::path::PathBuf;

use clap::Args;

use super::Choices;

#[derive(Args)]
pub(crate) struct WatchArguments {
    /// The pipelines.
    #[arg(required = true)]
    pub(crate) pipelines: Vec<PathBuf>,
    /// Checks one configuration, not all: the defaults, or the settings that are given.
    #[arg(long)]
    pub(crate) config: bool,
    /// Writes the picture of the first pipeline after each change, if its configuration has no error, to a .png.
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "FILE", requires = "scene")]
    pub(crate) render: Option<PathBuf>,
    /// The glTF scene of the picture (.gltf or .glb).
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "FILE", requires = "render")]
    pub(crate) scene: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) choices: Choices,
}
