//! The command line.

mod beginning;
mod comparing;
#[cfg(feature = "gpu")]
mod drawing;
mod proving;
#[cfg(feature = "score")]
mod scoring;
#[cfg(feature = "gpu")]
mod testing;
mod viewing;
mod watching;

use std::ffi::OsStr;
use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Args, CommandFactory as _, Parser, Subcommand};
use umbragraph::diagnostic::list_of;
use umbragraph::low_level::compiler::Objective;
use umbragraph::low_level::shader::TargetLanguage;

pub(crate) use beginning::NewArguments;
pub(crate) use comparing::{DiffArguments, GraphArguments};
#[cfg(feature = "gpu")]
pub(crate) use drawing::{AdaptersArguments, RenderArguments, Shot, ToggleArgument};
pub(crate) use proving::PermutationsArguments;
#[cfg(feature = "score")]
pub(crate) use scoring::{ColorArguments, Measure, Of, ScoreArguments, TuneArguments};
#[cfg(feature = "gpu")]
pub(crate) use testing::TestArguments;
pub(crate) use viewing::ViewArguments;
pub(crate) use watching::WatchArguments;

/// The subcommands that a build can leave out, each with the feature that adds it.
const OF_FEATURES: [(&str, &str); 6] = [
    ("adapters", "gpu"),
    ("lsp", "lsp"),
    ("render", "gpu"),
    ("score", "score"),
    ("test", "gpu"),
    ("tune", "score"),
];

/// Checks, inspects and renders render-graph pipelines.
#[derive(Parser)]
#[command(name = "umbragraph", version, about)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

impl Arguments {
    /// Parses the command line of this process.
    ///
    /// # Errors
    /// A command line that cannot be parsed, or one that requests the help text.
    pub(crate) fn of_process() -> Result<Self, clap::Error> {
        let subcommand = std::env::args_os().nth(1);
        let arguments = Self::try_parse().map_err(|error| explained(error, subcommand.as_deref()))?;
        let conflict = match &arguments.command {
            Command::Fmt(FmtArguments { files, strict: true, .. }) if files.len() > 1 => {
                (ErrorKind::TooManyValues, "--strict prints one file; give it one")
            }
            Command::Wgsl(WgslArguments { map: true, target, .. }) if *target != TargetLanguage::Wgsl => {
                (ErrorKind::ArgumentConflict, "--map shows the lines of WGSL; leave out --target")
            }
            Command::Permutations(permutations)
                if permutations.shard.is_some() && (permutations.locked || permutations.update) =>
            {
                let message = "a lock has all that is reached: leave out --shard, or join the reports of all shards with \
                               `umbragraph permutations --merge REPORT.json... --locked` (or --update)";
                (ErrorKind::ArgumentConflict, message)
            }
            Command::Graph(graph) if !graph.is_page() && graph.compare.is_some() => {
                let message =
                    "--compare is part of the page: add --format html; `umbragraph diff` compares as text";
                (ErrorKind::ArgumentConflict, message)
            }
            Command::Graph(graph)
                if !graph.is_page() && (graph.captures.is_some() || graph.timings.is_some()) =>
            {
                let message = "--captures and --timings are shown on the page: add --format html";
                (ErrorKind::ArgumentConflict, message)
            }
            #[cfg(feature = "gpu")]
            Command::Render(render) if render.toggle_beyond().is_some() => {
                let message = render.toggle_beyond().unwrap_or_default();
                return Err(Self::command().error(ErrorKind::ValueValidation, message));
            }
            _ => return Ok(arguments),
        };
        Err(Self::command().error(conflict.0, conflict.1))
    }
}

/// Replaces the error for a subcommand that this build leaves out by one that names its cargo feature. Adds a tip to the
/// error for an option that may be a setting of the pipeline, if the subcommand takes settings.
fn explained(mut error: clap::Error, subcommand: Option<&OsStr>) -> clap::Error {
    if error.kind() == ErrorKind::UnknownArgument
        && let Some(ContextValue::String(argument)) = error.get(ContextKind::InvalidArg)
        && error.get(ContextKind::SuggestedArg).is_none()
        && takes_settings(subcommand)
    {
        let tip = match argument.as_str() {
            word @ ("on" | "off" | "true" | "false") => {
                Some(format!("a value stands behind \"=\": NAME={word}"))
            }
            option => option.strip_prefix("--").filter(|name| !name.is_empty()).map(|name| {
                format!(
                    "a parameter \"{name}\" is set with --set {name}=VALUE, a feature with --feature {name}"
                )
            }),
        };
        if let Some(tip) = tip {
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
        }
    }
    let Some(ContextValue::String(name)) = error.get(ContextKind::InvalidSubcommand) else { return error };
    let Some((name, feature)) = OF_FEATURES.iter().find(|(known, _)| known == name) else { return error };
    let message = format!(
        "this build of the command has no `{name}`: install it with the cargo feature `{feature}`, which is on by default"
    );
    Arguments::command().error(ErrorKind::InvalidSubcommand, message)
}

/// Returns `true` if a subcommand has the option `--set`.
fn takes_settings(subcommand: Option<&OsStr>) -> bool {
    let command = Arguments::command();
    let found = subcommand.and_then(|name| command.find_subcommand(name));
    found.is_some_and(|found| found.get_arguments().any(|one| one.get_long() == Some("set")))
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Writes a new folder with a pipeline that renders: template, scene, schema, a workflow for CI and settings for an
    /// editor.
    New(NewArguments),
    /// Parses, resolves, compiles and validates pipelines; needs no graphics adapter.
    Check(CheckArguments),
    /// Checks pipelines whenever one of their files changes, and prints the changed diagnostics for a problem matcher.
    Watch(WatchArguments),
    /// Shows a pipeline with a scene in a window, live: parameters, passes, textures and times. Needs the program
    /// umbragraph-view.
    View(ViewArguments),
    /// Validates every shader variant that pipelines can reach, or that templates can express; needs no graphics
    /// adapter.
    Permutations(PermutationsArguments),
    /// Prints the plan of a pipeline: passes in order with what they read and write, resources, and why passes are
    /// culled.
    Plan(PlanArguments),
    /// Explains a name in a pipeline: the file and line that set each value, and the compiler's result for it.
    Why(WhyArguments),
    /// Draws the graph of a pipeline: as a picture, a page to explore, or text for other tools.
    Graph(GraphArguments),
    /// Describes the differences between the plans of two pipelines.
    Diff(DiffArguments),
    /// Prints the generated shaders of a pipeline.
    Wgsl(WgslArguments),
    /// Prints the reference: node kinds and their outputs, keys, types, functions, templates, and codes of diagnostics.
    Reference(ReferenceArguments),
    /// Lists the pipelines and templates that come with the command, or prints one of them.
    Show(ShowArguments),
    /// Formats JSON files in the canonical layout; comments and values stay as they are.
    Fmt(FmtArguments),
    /// Prints the JSON Schema of pipelines, with every node kind, for editors.
    Schema(SchemaArguments),
    /// Runs a language server for editors, with diagnostics, completion and more, on standard input and output.
    #[cfg(feature = "lsp")]
    Lsp(LspArguments),
    /// Renders a scene through a pipeline to a PNG file.
    #[cfg(feature = "gpu")]
    Render(RenderArguments),
    /// Runs tests of shader functions on an adapter, over every variant of the templates that the tests include.
    #[cfg(feature = "gpu")]
    Test(TestArguments),
    /// Lists the graphics adapters, and the features that each lacks for the pipelines that come with the command.
    #[cfg(feature = "gpu")]
    Adapters(AdaptersArguments),
    /// Compares the shadows of a pipeline with ray-traced ones, light by light; or its colors with path-traced ones.
    #[cfg(feature = "score")]
    Score(ScoreArguments),
    /// Searches for the parameter values with which the shadows of a pipeline agree best with ray-traced ones.
    #[cfg(feature = "score")]
    Tune(TuneArguments),
}

/// The options that set the values of parameters and features.
#[derive(Args, Clone, Debug)]
pub(crate) struct Settings {
    /// Gives a parameter a value: JSON, a word of an enumeration, or on or off for a boolean.
    #[arg(long = "set", value_name = "NAME=VALUE")]
    pub(crate) set: Vec<String>,
    /// Gives a feature a value: on, off, true, false or a word of an enumeration. Without a value it is switched on.
    #[arg(long = "feature", value_name = "NAME[=VALUE]")]
    pub(crate) feature: Vec<String>,
    /// Takes the values of one of the pipeline's presets.
    #[arg(long, value_name = "NAME")]
    pub(crate) preset: Option<String>,
    /// Takes the values of a parameter file, which override those of the preset. Later files win.
    #[arg(long, value_name = "FILE")]
    pub(crate) params: Vec<PathBuf>,
}

impl Settings {
    /// Returns `true` if at least one value, preset or parameter file is set.
    pub(crate) fn is_empty(&self) -> bool {
        self.set.is_empty() && self.feature.is_empty() && self.preset.is_none() && self.params.is_empty()
    }
}

/// The files of a pipeline besides the pipeline file itself.
#[derive(Args, Clone, Default)]
pub(crate) struct Files {
    /// Puts the passes of an extension file at the pipeline's extension points. Several run in the order given.
    #[arg(long, value_name = "FILE")]
    pub(crate) extension: Vec<PathBuf>,
    /// A folder with templates that replace or extend those that come with the command.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) templates: Option<PathBuf>,
    /// An additional folder below which pipelines and scenes may name files. The working folder and the file's own
    /// folder are always allowed.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) root: Vec<PathBuf>,
}

/// The options that every command has for a pipeline.
#[derive(Args, Clone)]
pub(crate) struct Choices {
    #[command(flatten)]
    pub(crate) settings: Settings,
    /// The target profile. By default, `check` uses every profile that the pipeline claims; commands for one plan or
    /// shader use the first. A pipeline without claims uses webgpu.
    #[arg(long, value_name = "NAME")]
    pub(crate) profile: Option<String>,
    #[command(flatten)]
    pub(crate) files: Files,
    /// Width and height of the picture, in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = parse_size)]
    pub(crate) size: [u32; 2],
    /// The goal of the order of the passes: declaration, memory or few-passes.
    #[arg(long, value_name = "NAME", default_value = "declaration", value_parser = one_of("objectives", Objective::ALL, Objective::name))]
    pub(crate) objective: Objective,
}

#[cfg(feature = "lsp")]
#[derive(Args)]
pub(crate) struct LspArguments {
    /// A folder with templates that replace or extend those that come with the command. A relative path is searched
    /// below the current folder, then below the first folder of the workspace.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) templates: Option<PathBuf>,
    /// An additional folder below which pipelines may name files. The workspace and the file's own folder are always
    /// allowed.
    #[arg(long, value_name = "FOLDER")]
    pub(crate) root: Vec<PathBuf>,
    /// Accepted because many editors pass the option; standard input and output are always used.
    #[arg(long)]
    pub(crate) stdio: bool,
}

#[derive(Args)]
pub(crate) struct CheckArguments {
    /// The pipeline files.
    #[arg(required = true)]
    pub(crate) pipelines: Vec<PathBuf>,
    /// The format of the diagnostics: human (on standard error), json, github, sarif or junit (on standard output).
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: DiagnosticsFormat,
    /// Checks one configuration: the given settings, and defaults for the rest. By default, every value of the features
    /// that are not given is checked.
    #[arg(long)]
    pub(crate) config: bool,
    /// Checks each plan by a second, independent algorithm.
    #[arg(long)]
    pub(crate) verify: bool,
    /// Also lists passes and settings that are culled, have no effect, or are not checked.
    #[arg(long)]
    pub(crate) verbose: bool,
    /// Fixes errors that have only one possible fix, in all files of the pipelines, and reports the changes.
    #[arg(long)]
    pub(crate) fix: bool,
    /// Prints the changes of --fix as a unified diff, and writes nothing. The exit status is 1 if a file would change.
    #[arg(long, requires = "fix")]
    pub(crate) dry_run: bool,
    #[command(flatten)]
    pub(crate) choices: Choices,
    #[command(flatten)]
    pub(crate) cache: CacheArguments,
}

/// The options for the cache of earlier runs' results.
#[derive(Args)]
pub(crate) struct CacheArguments {
    /// The folder with the cached results of earlier runs. The default is the environment variable UMBRAGRAPH_CACHE (no
    /// cache if empty), then the user's cache folder.
    #[arg(long, value_name = "FOLDER", conflicts_with = "no_cache")]
    pub(crate) cache: Option<PathBuf>,
    /// Neither reads nor stores results of other runs.
    #[arg(long)]
    pub(crate) no_cache: bool,
}

/// The output format of diagnostics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum DiagnosticsFormat {
    /// For people: diagnostics with their source lines, then a summary.
    #[default]
    Human,
    /// One JSON object with diagnostics and statistics.
    Json,
    /// Annotations that GitHub shows on a pull request, then a summary.
    Github,
    /// A SARIF 2.1.0 log, for code scanning and editors.
    Sarif,
    /// JUnit XML, which most CI systems show as tests: each error is a failed test.
    Junit,
}

impl DiagnosticsFormat {
    /// Returns `true` if standard output is a single machine-readable document.
    pub(crate) fn is_data(self) -> bool {
        matches!(self, Self::Json | Self::Sarif | Self::Junit)
    }
}

#[derive(Args)]
pub(crate) struct PlanArguments {
    /// The pipeline file.
    pub(crate) pipeline: PathBuf,
    /// The format of the plan: human, tables of passes and resources; or json, with load and store operations, shader
    /// variants and the bytes of blocks.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: AnswerFormat,
    /// Checks the plan by a second, independent algorithm.
    #[arg(long)]
    pub(crate) verify: bool,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

#[derive(Args)]
pub(crate) struct WhyArguments {
    /// The pipeline file.
    pub(crate) pipeline: PathBuf,
    /// A pass, resource, parameter, feature, toggle, preset, subgraph, extension point or geometry. Names inside a
    /// subgraph or a loop have a prefix: soft.down, down.0.
    pub(crate) name: String,
    /// A second resource: explains whether the two resources share memory, and the reason.
    pub(crate) other: Option<String>,
    /// The format of the answer: human or json.
    #[arg(long, value_enum, value_name = "NAME", default_value_t)]
    pub(crate) format: AnswerFormat,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

/// The output format of an answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum AnswerFormat {
    /// Text for people.
    #[default]
    Human,
    /// One JSON object.
    Json,
}

#[derive(Args)]
pub(crate) struct WgslArguments {
    /// The pipeline file.
    pub(crate) pipeline: PathBuf,
    /// Prints only the shaders of this pass, or of the passes of this loop or subgraph.
    #[arg(long, value_name = "NAME")]
    pub(crate) pass: Option<String>,
    /// Prints only the variant for meshes with these properties; an empty list selects the variant without properties.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', num_args = 0..=1, require_equals = true)]
    pub(crate) properties: Option<Vec<String>>,
    /// The language: wgsl, spirv (binary, only the variant without mesh properties), msl, hlsl or glsl.
    #[arg(long, value_name = "NAME", default_value = "wgsl", value_parser = one_of("languages", TargetLanguage::ALL, TargetLanguage::name))]
    pub(crate) target: TargetLanguage,
    /// Prints the template's file and line before each line; WGSL only.
    #[arg(long)]
    pub(crate) map: bool,
    #[command(flatten)]
    pub(crate) choices: Choices,
}

#[derive(Args)]
pub(crate) struct ShowArguments {
    /// The file to print: a pipeline such as umbragraph:nebula.json, or a template such as lib/fullscreen.wgsl.jinja. By
    /// default, all names are listed.
    pub(crate) name: Option<String>,
}

#[derive(Args)]
pub(crate) struct FmtArguments {
    /// The files; - reads standard input and writes to standard output.
    #[arg(required = true, value_name = "FILE")]
    pub(crate) files: Vec<PathBuf>,
    /// Lists the files that would change, and writes nothing; exits with 1 if the list is not empty.
    #[arg(long)]
    pub(crate) check: bool,
    /// Prints one file as strict JSON without comments, in a layout that depends only on its values; writes nothing.
    #[arg(long, conflicts_with = "check")]
    pub(crate) strict: bool,
}

#[derive(Args)]
pub(crate) struct SchemaArguments {
    /// The kind of file that the schema describes.
    #[arg(long, value_name = "KIND", value_enum, default_value = "pipeline")]
    pub(crate) of: SchemaKind,
    /// Compares the schema with this file instead of printing; a difference is reported as a diagnostic.
    #[arg(long, value_name = "FILE")]
    pub(crate) check: Option<PathBuf>,
}

/// The kinds of files that have a schema.
#[derive(Clone, Copy, clap::ValueEnum)]
pub(crate) enum SchemaKind {
    /// Pipelines.
    Pipeline,
    /// Extensions: passes for the extension points of a pipeline.
    Extension,
    /// Parameter files.
    Parameters,
    /// Subgraphs in separate files.
    Subgraph,
    /// Axes of templates: the constants that select a shader variant.
    Axes,
}

#[derive(Args)]
pub(crate) struct ReferenceArguments {
    /// The entry to print: a node kind, a type, a function, a template, or a code such as UG0402. By default, all
    /// entries are listed.
    pub(crate) name: Option<String>,
    /// Writes the whole reference as Markdown files into a folder.
    #[arg(long, value_name = "FOLDER", conflicts_with = "name")]
    pub(crate) write: Option<PathBuf>,
}

/// Returns a value parser that accepts one of a fixed list of named values.
fn one_of<const N: usize, T: Copy + Send + Sync + 'static>(
    what: &'static str,
    all: [T; N],
    name: fn(T) -> &'static str,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let found = all.into_iter().find(|one| name(*one) == text);
        found.ok_or_else(|| format!("the {what} are {}", list_of(all.map(name))))
    }
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let side = |text: &str| text.parse::<u32>().map_err(|_| format!("\"{text}\" is no whole number"));
    let (width, height) =
        text.split_once('x').ok_or("a size is written as WIDTHxHEIGHT, such as 1280x720")?;
    match [side(width)?, side(height)?] {
        [0, _] | [_, 0] => Err("a picture has at least one pixel in each direction".to_owned()),
        size => Ok(size),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_commands_with_set_take_settings() {
        for (name, takes) in [("check", true), ("plan", true), ("fmt", false), ("schema", false)] {
            assert_eq!(takes_settings(Some(OsStr::new(name))), takes, "{name}");
        }
        assert!(!takes_settings(None));
    }

    #[test]
    #[cfg(all(feature = "lsp", feature = "score"))]
    fn what_a_build_can_leave_out_is_there_with_all_features() {
        let command = Arguments::command();
        let missing = OF_FEATURES.iter().find(|(name, _)| command.find_subcommand(name).is_none());
        assert_eq!(missing, None);
    }
}
