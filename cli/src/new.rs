//! `umbragraph new`: a folder with a pipeline that renders, and what an author needs around it.
//!
//! The files are those of `front/starter/`. A file that exists stays as it is.

use std::path::{Path, PathBuf};

use umbragraph::diagnostic::{Diagnostic, Diagnostics, render};
use umbragraph::low_level::source::Sources;
use umbragraph::low_level::starter;

use crate::arguments::NewArguments;
use crate::replace::{replace, unwritable};
use crate::streams::{complain, print};

/// The kinds of pipelines that `new` can create.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Kind {
    /// Full-screen passes after the picture of a pipeline that comes with the command.
    #[default]
    Post,
    /// Cascaded shadows over meshes that a template of your own lights.
    Shadows,
    /// One of the systems that come with the command, with values and a pass of your own.
    System,
}

impl From<Kind> for starter::Kind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Post => Self::Post,
            Kind::Shadows => Self::Shadows,
            Kind::System => Self::System,
        }
    }
}

/// Writes the files of a new pipeline. Returns `true` if all could be written.
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
    let name = pipeline_name(folder);
    let files = starter::files(arguments.kind.into(), &name)?;
    let files: Vec<(PathBuf, String)> =
        files.into_iter().map(|(path, text)| (folder.join(path), text)).collect();
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
         --templates shaders --scene scene.gltf --out {name}.png\n  umbragraph watch {name}.json --templates shaders \
         --render {name}.png --scene scene.gltf\n  umbragraph view {name}.json --templates shaders --scene scene.gltf\n",
        files.len()
    ))
}

/// Returns the name of a folder, which is also the name of its pipeline.
fn pipeline_name(folder: &Path) -> String {
    let whole = if folder.file_name().is_none() { std::fs::canonicalize(folder).ok() } else { None };
    whole.as_deref().unwrap_or(folder).file_name().unwrap_or_default().to_string_lossy().into_owned()
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
