//! The command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Checks, inspects and renders pipelines of umbragraph.
#[derive(Parser)]
#[command(name = "umbragraph", version, about)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Parses, resolves, compiles and validates pipelines; needs no graphics adapter.
    Check(CheckArguments),
    /// Prints the plan of a pipeline as JSON: passes in order, resources, what is culled and why.
    Plan(PlanArguments),
    /// Prints the generated shaders of a pipeline.
    Wgsl(WgslArguments),
    /// Explains the code of a finding.
    Explain(ExplainArguments),
    /// Renders a scene through a pipeline to a PNG file.
    #[cfg(feature = "gpu")]
    Render(RenderArguments),
}

/// What every command can be told of a pipeline.
#[derive(Args, Clone)]
pub(crate) struct Choices {
    /// Gives a parameter a value: JSON, or a word of an enumeration.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
    /// Gives a feature a value; without one it is switched on.
    #[arg(long = "feature", value_name = "NAME[=VALUE]")]
    pub(crate) feature: Vec<String>,
    /// The target profile; without it the first that the pipeline claims, or webgpu.
    #[arg(long, value_name = "NAME")]
    pub(crate) profile: Option<String>,
    /// A folder with templates that replace or join those that come with the command.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) templates: Option<PathBuf>,
    /// Width and height of the picture.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
}

#[derive(Args)]
pub(crate) struct CheckArguments {
    /// The pipelines.
    #[arg(required = true)]
    pub(crate) pipelines: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

#[derive(Args)]
pub(crate) struct PlanArguments {
    /// The pipeline.
    pub(crate) pipeline: PathBuf,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

#[derive(Args)]
pub(crate) struct WgslArguments {
    /// The pipeline.
    pub(crate) pipeline: PathBuf,
    /// Only the shaders of this pass.
    #[arg(long, value_name = "NAME")]
    pub(crate) pass: Option<String>,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

#[derive(Args)]
pub(crate) struct ExplainArguments {
    /// The code, such as UG0402; without it all codes are listed.
    pub(crate) code: Option<String>,
}

#[cfg(feature = "gpu")]
#[derive(Args)]
pub(crate) struct RenderArguments {
    /// The pipeline.
    pub(crate) pipeline: PathBuf,
    /// The glTF scene (.gltf or .glb).
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: PathBuf,
    /// Where the picture goes.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) out: PathBuf,
    /// Seconds since the start of the scene's animations.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0)]
    pub(crate) time: f64,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse::<u32>().map_err(|_| format!("\"{text}\" is no whole number"));
    let (width, height) = text.split_once('x').ok_or("a size is written as WIDTHxHEIGHT, such as 1280x720")?;
    Ok([side(width)?, side(height)?])
}
