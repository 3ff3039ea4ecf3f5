//! Folders to begin with: what `umbragraph new` writes, and what the page in a browser opens.
//!
//! The files lie beside this one, where `NAME` stands for the name of the pipeline; the schema is that of this version.

use crate::diagnostic::{Diagnostic, Place, codes};
use crate::low_level::pipeline::{self, FileKind};

/// The kinds of starter pipelines that `umbragraph new` can create.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// Full-screen passes that process the picture of a bundled pipeline.
    Post,
    /// Cascaded shadow maps, and meshes lit by a template of the new pipeline.
    Shadows,
    /// A bundled shadow system, to which the new pipeline adds parameter values and a pass.
    System,
}

/// The path of a file, relative to the new folder, and its text.
type File = (&'static str, &'static str);

const COMMON: &[File] = &[
    ("scene.gltf", include_str!("common/scene.gltf")),
    ("README.md", include_str!("common/README.md")),
    (".github/workflows/pipelines.yml", include_str!("common/ci.yml")),
    (".vscode/settings.json", include_str!("common/settings.json")),
    (".vscode/tasks.json", include_str!("common/tasks.json")),
];

impl Kind {
    /// Returns the kind of a keyword: `post`, `shadows` or `system`; `None` for any other.
    pub fn of(word: &str) -> Option<Self> {
        match word {
            "post" => Some(Self::Post),
            "shadows" => Some(Self::Shadows),
            "system" => Some(Self::System),
            _ => None,
        }
    }

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

/// Returns the paths and texts of the files of a new pipeline called `name`.
///
/// # Errors
/// A name that is not valid for a pipeline.
pub fn files(kind: Kind, name: &str) -> Result<Vec<(String, String)>, Diagnostic> {
    let is_fine = name.starts_with(|one: char| one.is_ascii_alphabetic())
        && name.chars().all(|one| one.is_ascii_alphanumeric() || one == '_' || one == '-');
    if !is_fine {
        let message = format!("\"{name}\" cannot name a pipeline");
        let help = "begin with a letter, and go on with letters, digits, _ and -";
        return Err(Diagnostic::error(codes::BAD_NAME, Place::Nowhere, message).help(help));
    }
    let schema = pipeline::schema_of(FileKind::Pipeline, &crate::registry());
    let schema = serde_json::to_string_pretty(&schema).unwrap_or_default() + "\n";
    let named = |text: &str| text.replace("NAME", name);
    let files = COMMON.iter().chain(kind.files()).map(|(path, text)| (named(path), named(text)));
    Ok(files.chain([("pipeline.schema.json".to_owned(), schema)]).collect())
}
