//! The command lines of `graph` and `diff`.

use std::path::{Path, PathBuf};

use clap::Args;
use umbragraph::low_level::compiler::Objective;
use umbragraph::low_level::report::GraphFormat;

use super::{Choices, one_of, parse_size};

#[derive(Args)]
pub(crate) struct GraphArguments {
    /// The pipeline.
    pub(crate) pipeline: PathBuf,
    /// The format: svg, html, dot, mermaid or json. By default the one that the extension of --out names, else svg.
    #[arg(long, value_name = "NAME", value_parser = one_of("forms", GraphFormat::ALL, GraphFormat::name))]
    pub(crate) format: Option<GraphFormat>,
    /// The file to write; without it the output goes to standard output.
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// A second pipeline to compare with; html only.
    #[arg(long, value_name = "FILE")]
    pub(crate) compare: Option<PathBuf>,
    /// Shows the pictures of resources that `render --capture-all` has written to a folder; html only.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) captures: Option<PathBuf>,
    /// Shows the times of passes that `render --trace` has written; html only.
    #[arg(long, value_name = "FILE.json")]
    pub(crate) timings: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

impl GraphArguments {
    /// Whether a page is asked for, by the form or by the extension of the file.
    pub(super) fn is_page(&self) -> bool {
        let by_extension = self.out.as_deref().and_then(Path::extension).is_some_and(|it| it == "html");
        self.format.map_or(by_extension, |format| format == GraphFormat::Html)
    }
}

#[derive(Args)]
pub(crate) struct DiffArguments {
    /// The first pipeline, or a report of one that `graph --format json` has printed.
    pub(crate) before: PathBuf,
    /// The second; without it the first one again, with what is said of the second alone.
    #[arg(required_unless_present_any = ["after_set", "after_feature", "after_preset", "after_params", "after_profile", "after_size", "after_objective"])]
    pub(crate) after: Option<PathBuf>,
    /// Compares two locks of `umbragraph permutations`: the shaders that a change adds.
    #[arg(long, requires = "after")]
    pub(crate) lock: bool,
    #[command(flatten)]
    pub(crate) choices: Choices,
    /// Gives a parameter of the second pipeline alone a value.
    #[arg(long, value_name = "NAME=VALUE")]
    pub(crate) after_set: Vec<String>,
    /// Gives a feature of the second pipeline alone a value.
    #[arg(long, value_name = "NAME[=VALUE]")]
    pub(crate) after_feature: Vec<String>,
    /// Takes a preset for the second pipeline alone.
    #[arg(long, value_name = "NAME")]
    pub(crate) after_preset: Option<String>,
    /// Takes a parameter file for the second pipeline alone.
    #[arg(long, value_name = "FILE")]
    pub(crate) after_params: Vec<PathBuf>,
    /// The target profile of the second pipeline alone.
    #[arg(long, value_name = "NAME")]
    pub(crate) after_profile: Option<String>,
    /// Width and height of the second picture alone.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(crate) after_size: Option<[u32; 2]>,
    /// The aim of the order of the second plan alone.
    #[arg(long, value_name = "NAME", value_parser = one_of("objectives", Objective::ALL, Objective::name))]
    pub(crate) after_objective: Option<Objective>,
}

impl DiffArguments {
    /// The choices of the second pipeline: the common ones, and over them its own.
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
