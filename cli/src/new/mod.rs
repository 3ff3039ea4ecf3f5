//! `umbragraph new`: a folder with a pipeline that renders, and what an author needs around it.
//!
//! The files come from `cli/src/new/`, where `NAME` stands for the name of the pipeline, and from the schema of this
//! version. A file that exists stays as it is.

use std::path::{Path, PathBuf};

use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes, render};
use umbragraph::low_level::pipeline::{self, FileKind};
use umbragraph::low_level::source::Sources;

use crate::arguments::NewArguments;
use crate::replace::{replace, unwritable};
use crate::streams::{complain, print};

/// The kinds of pipelines to begin with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Kind {
    /// Full-screen passes behind the picture of a pipeline that comes with the command.
    #[default]
    Post,
    /// Cascaded shadows over meshes that a template of your own lights.
    Shadows,
    /// One of the systems that come with the command, with values and a pass of your own.
    System,
}

/// A file: where it goes, and what it says.
type File = (&'static str, &'static str);

const COMMON: &[File] = &[
    ("scene.gltf", include_str!("common/scene.gltf")),
    ("README.md", include_str!("common/README.md")),
    (".github/workflows/pipelines.yml", include_str!("common/ci.yml")),
    (".vscode/settings.json", include_str!("common/settings.json")),
    (".vscode/tasks.json", include_str!("common/tasks.json")),
];

impl Kind {
    fn files(self) -> &'static [File] {
        match self {
            Self::Post => &[
                ("NAME.json", include_str!("post/pipeline.json")),
                ("shaders/glow.wgsl.jinja", include_str!("post/glow.wgsl.jinja")),
                ("shaders/glow.axes.json", include_str!("post/glow.axes.json")),
                ("shaders/finish.wgsl.jinja", include_str!("post/finish.wgsl.jinja")),
            ],
            Self::Shadows => &[
                ("NAME.json", include_str!("shadows/pipeline.json")),
                ("shaders/stepped.wgsl.jinja", include_str!("shadows/stepped.wgsl.jinja")),
                ("shaders/stepped.axes.json", include_str!("shadows/stepped.axes.json")),
            ],
            Self::System => &[
                ("NAME.json", include_str!("system/pipeline.json")),
                ("look.params.json", include_str!("system/look.params.json")),
                ("shaders/vignette.wgsl.jinja", include_str!("common/vignette.wgsl.jinja")),
            ],
        }
    }
}

/// Writes the files; whether all of them were.
pub(crate) fn run(arguments: &NewArguments) -> bool {
    match write(arguments) {
        Ok(said) => {
            print(&said);
            true
        }
        Err(diagnostics) => {
            complain(&render::human_all(&diagnostics, &Sources::new()));
            false
        }
    }
}

fn write(arguments: &NewArguments) -> Result<String, Diagnostics> {
    let folder = &arguments.name;
    let name = pipeline_name(folder)?;
    let schema = pipeline::schema_of(FileKind::Pipeline, &umbragraph::registry());
    let schema = serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n";
    let named = |text: &str| text.replace("NAME", &name);
    let files = COMMON.iter().chain(arguments.kind.files());
    let files = files.map(|(path, text)| (folder.join(named(path)), named(text)));
    let files: Vec<(PathBuf, String)> =
        files.chain([(folder.join("pipeline.schema.json"), schema)]).collect();
    let there = files.iter().filter(|(path, _)| path.exists());
    let there: Diagnostics = there.map(|(path, _)| is_there(path)).collect();
    if there.has_errors() {
        return Err(there);
    }
    for (path, text) in &files {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| unwritable(folder, &error))?;
        }
        replace(path, text)?;
    }
    let shown = folder.display();
    Ok(format!(
        "{shown}: {} files\n\n  cd {shown}\n  umbragraph check {name}.json --templates shaders\n  umbragraph render {name}.json \
         --templates shaders --scene scene.gltf --out {name}.png\n",
        files.len()
    ))
}

/// The name of the pipeline of a folder.
///
/// # Errors
/// A folder whose name is no name of a pipeline.
fn pipeline_name(folder: &Path) -> Result<String, Diagnostic> {
    let whole = if folder.file_name().is_none() { std::fs::canonicalize(folder).ok() } else { None };
    let name = whole.as_deref().unwrap_or(folder).file_name().unwrap_or_default().to_string_lossy();
    let is_fine = name.starts_with(|one: char| one.is_ascii_alphabetic())
        && name.chars().all(|one| one.is_ascii_alphanumeric() || one == '_' || one == '-');
    if is_fine {
        return Ok(name.into_owned());
    }
    let message = format!("\"{name}\" cannot name a pipeline");
    let help = "begin with a letter, and go on with letters, digits, _ and -";
    Err(Diagnostic::error(codes::BAD_NAME, Place::Nowhere, message).help(help))
}

fn is_there(path: &Path) -> Diagnostic {
    let message = format!("\"{}\" is there already", path.display());
    Diagnostic::in_file(
        umbragraph::low_level::files::FILE_UNWRITABLE,
        path.display().to_string(),
        "",
        message,
    )
    .help("name a folder that is empty, or is not there")
}
