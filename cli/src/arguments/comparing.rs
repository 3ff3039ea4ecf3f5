//! The command lines of `graph` and `diff`.

use std::path::{Path, PathBuf};

use clap::Args;
use umbragraph::low_level::compiler::Objective;
use umbragraph::low_level::report::GraphFormat;

use super::{Choices, one_of, parse_size};

#[derive(Args)]
pub(crate) struct GraphArguments {
    /// The pipeline file.
    pub(crate) pipeline: PathBuf,
    /// The format: svg, html, dot, mermaid or json. The default is the extension of --out, or else svg.
    #[arg(long, value_name = "NAME", value_parser = one_of("forms", GraphFormat::ALL, GraphFormat::name))]
    pub(crate) format: Option<GraphFormat>,
    /// The file to write; the default is standard output.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// A second pipeline to compare with; html only.
    #[arg(long, value_name = "FILE")]
    pub(crate) compare: Option<PathBuf>,
    /// Shows the pictures of resources that `render --capture-all` has written to a folder; html only.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) captures: Option<PathBuf>,
    /// Shows the times of passes from a file of `render --trace`; html only.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) timings: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

impl GraphArguments {
    /// Returns `true` if the output is an HTML page, by the format or by the extension of the output file.
    pub(super) fn is_page(&self) -> bool {
        let by_extension = self.out.as_deref().and_then(Path::extension).is_some_and(|it| it == "html");
        self.format.map_or(by_extension, |format| format == GraphFormat::Html)
    }
}

#[derive(Args)]
pub(crate) struct DiffArguments {
    /// The first pipeline, or a JSON report from `graph --format json`.
    pub(crate) before: PathBuf,
    /// The second pipeline. By default, the first one again, with the settings for the second pipeline.
    #[arg(required_unless_present_any = ["after_set", "after_feature", "after_preset", "after_params", "after_profile", "after_size", "after_objective"])]
    pub(crate) after: Option<PathBuf>,
    /// Compares two lock files of `umbragraph permutations`, and lists the shaders that a change adds.
    #[arg(long, requires = "after")]
    pub(crate) lock: bool,
    #[command(flatten)]
    pub(crate) choices: Choices,
    /// Sets a parameter of the second pipeline only.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) after_set: Vec<String>,
    /// Sets a feature of the second pipeline only.
    #[arg(long, value_name = "NAME[=VALUE]")]
    pub(crate) after_feature: Vec<String>,
    /// Selects a preset for the second pipeline only.
    #[arg(long, value_name = "NAME")]
    pub(crate) after_preset: Option<String>,
    /// Takes a parameter file for the second pipeline only.
    #[arg(long, value_name = "FILE")]
    pub(crate) after_params: Vec<PathBuf>,
    /// The target profile of the second pipeline only.
    #[arg(long, value_name = "NAME")]
    pub(crate) after_profile: Option<String>,
    /// Width and height of the second picture only, in pixels.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) after_size: Option<[u32; 2]>,
    /// The goal of the pass order of the second plan only.
    #[arg(long, value_name = "NAME", value_parser = one_of("objectives", Objective::ALL, Objective::name))]
    pub(crate) after_objective: Option<Objective>,
}

impl DiffArguments {
    /// Returns the options of the second pipeline: the common ones, overridden by the `--after-…` options.
    pub(crate) fn after_choices(&self) -> Choices {
        let mut choices = self.choices.clone();
        choices.settings.set.extend(self.after_set.iter().cloned());
        choices.settings.feature.extend(self.after_feature.iter().cloned());
        choices.settings.params.extend(self.after_params.iter().cloned());
        choices.settings.preset = self.after_preset.clone().or(choices.settings.preset);
        choices.profile = self.after_profile.clone().or(choices.profile);
        choices.size = self.after_size.unwrap_or(choices.size);
        choices.objective = self.after_objective.unwrap_or(choices.objective);
        choices
    }
}
