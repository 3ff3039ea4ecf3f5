//! What the integration tests share.
#![allow(dead_code, missing_docs, unreachable_pub)]

#[cfg(all(feature = "gpu", feature = "gltf"))]
pub mod gpu;
pub mod host;
#[cfg(all(feature = "gpu", feature = "gltf"))]
pub mod labels;
#[cfg(all(feature = "gpu", feature = "gltf"))]
pub mod pictures;
pub mod settings;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use umbragraph::CheckReport;
use umbragraph::compiler::{Plan, PlanOptions};
use umbragraph::compose;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, render};
use umbragraph::document::{self, Document};
use umbragraph::pipeline::{self, Overrides, ParameterFile, Setting};
use umbragraph::shader::{TargetProfile, TemplateSet};
use umbragraph::source::{FileId, Sources, Span};
use umbragraph_verify::verify;

/// The folder of the workspace.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// What a text came to.
pub struct Outcome {
    pub sources: Sources,
    pub diagnostics: Diagnostics,
    pub checked: CheckReport,
}

impl Outcome {
    /// The diagnostics for people.
    pub fn text(&self) -> String {
        render::human_all(&self.diagnostics, &self.sources)
    }

    /// The codes of the diagnostics, sorted.
    pub fn codes(&self) -> Vec<&'static str> {
        let mut codes: Vec<_> = self.diagnostics.iter().map(|diagnostic| diagnostic.code.id).collect();
        codes.sort_unstable();
        codes
    }

    /// The plan of a text without diagnostics.
    #[track_caller]
    pub fn plan(&self) -> &Plan {
        match &self.checked.plan {
            Some(plan) if self.diagnostics.is_empty() => plan,
            _ => panic!("{}", self.text()),
        }
    }

    /// The names of the live passes in their order.
    #[track_caller]
    pub fn order(&self) -> Vec<&str> {
        self.plan().passes.iter().map(|pass| pass.name.as_str()).collect()
    }
}

/// Values of parameters and features, each as its name and JSON text.
#[derive(Default)]
pub struct With<'a> {
    /// A preset of the pipeline.
    pub preset: Option<&'a str>,
    /// A parameter file of the workspace.
    pub file: Option<&'a str>,
    /// An extension file of the workspace.
    pub extension: Option<&'a str>,
    pub parameters: &'a [(&'a str, &'a str)],
    pub features: &'a [(&'a str, &'a str)],
    pub templates: &'a [(&'a str, &'a str)],
    /// Width and height of the picture; 640 by 480 without it.
    pub size: Option<[u32; 2]>,
    /// What shaders may rely on; WebGPU without it.
    pub profile: Option<TargetProfile>,
    /// Whether transients keep their own memory.
    pub without_aliasing: bool,
}

/// Sides of the maps of `pipelines/awsm.json` that are enough for small pictures.
pub const SMALL_MAPS: &[(&str, &str)] = &[
    ("cascade_side", "256"),
    ("cube_side", "128"),
    ("atlas_min_side", "256"),
    ("atlas_max_side", "1024"),
    ("tile_max_side", "256"),
    ("tile_min_side", "16"),
];

/// Parameters over [`SMALL_MAPS`].
pub fn with_small_maps<'a>(parameters: &[(&'a str, &'a str)]) -> Vec<(&'a str, &'a str)> {
    let is_free = |(name, _): &&(&str, &str)| parameters.iter().all(|(other, _)| other != name);
    SMALL_MAPS.iter().filter(is_free).chain(parameters).copied().collect()
}

/// Takes a text all the way to a plan of 640 by 480.
pub fn check(text: &str) -> Outcome {
    check_with("test.json", text, &With::default())
}

/// Takes a file of the workspace all the way to a plan of 640 by 480.
pub fn check_file(path: &str, with: &With<'_>) -> Outcome {
    check_with(path, &read(path), with)
}

pub fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Takes a text all the way to a plan of 640 by 480. Files that it names are looked for in the workspace.
pub fn check_with(name: &str, text: &str, with: &With<'_>) -> Outcome {
    let (mut sources, mut diagnostics, templates) = templates(with.templates);
    let file = sources.add(name, text);
    let Some(composed) =
        compose::compose(file, Path::new(name), &mut Workspace, &mut sources, &mut diagnostics)
    else {
        return Outcome { sources, diagnostics, checked: CheckReport::default() };
    };
    let mut document = composed.document;
    if let Some(extension) = with.extension {
        let extension = sources.add(extension, read(extension));
        let extension = document::parse(&sources, extension).valid().expect("JSON").root;
        compose::insert(&mut document.root, extension, &mut diagnostics);
    }
    let overrides = overrides(&document, with, &mut sources, &mut diagnostics);
    let [width, height] = with.size.unwrap_or([640, 480]);
    let options = PlanOptions::new(width, height).aliasing(!with.without_aliasing);
    let check_options = umbragraph::CheckOptions {
        registry: &umbragraph::registry(),
        templates: &templates,
        profile: &with.profile.clone().unwrap_or_else(TargetProfile::webgpu),
        overrides: &overrides,
        plan: &options,
    };
    let checked = umbragraph::check_document(&document, &check_options, &sources, &mut diagnostics);
    diagnostics.sort();
    if let Some(plan) = checked.plan.as_ref().filter(|_| !diagnostics.has_errors()) {
        let violations = verify(plan, &options);
        assert!(violations.is_empty(), "the plan of {name} has errors: {violations:#?}");
    }
    Outcome { sources, diagnostics, checked }
}

/// The names of the presets of a pipeline and of all that it extends.
pub fn presets(name: &str, text: &str) -> Vec<String> {
    let (mut sources, mut diagnostics) = (Sources::new(), Diagnostics::new());
    let file = sources.add(name, text);
    let composed = compose::compose(file, Path::new(name), &mut Workspace, &mut sources, &mut diagnostics);
    let root = composed.expect("a document").document.root;
    let presets = root.entries_of("presets");
    presets.iter().map(|preset| preset.key.clone()).collect()
}

/// The files of the workspace, by their path in it, which is where tests run.
struct Workspace;

impl compose::Files for Workspace {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        umbragraph::read_source(path, sources)
    }
}

fn overrides(
    document: &Document,
    with: &With<'_>,
    sources: &mut Sources,
    diagnostics: &mut Diagnostics,
) -> Overrides {
    let mut below = Overrides::default();
    let mut preset = with.preset.map(|name| (name.to_owned(), sources.add("<test>", name)));
    if let Some(path) = with.file {
        let at = sources.add(path, read(path));
        let file = ParameterFile::read(&document::parse(sources, at).valid().expect("JSON"), diagnostics);
        preset = preset.or(file.preset.map(|(name, _)| (name, at)));
        below = file.overrides;
    }
    if let Some((name, at)) = preset {
        below = pipeline::of_preset(document, &name, Span::new(at, 0..1), diagnostics).under(below);
    }
    below.under(Overrides {
        parameters: with.parameters.iter().map(|(name, value)| setting(name, value, sources)).collect(),
        features: with.features.iter().map(|(name, value)| setting(name, value, sources)).collect(),
    })
}

/// The project's templates and some of the test's own, which may stand in place of the project's; read once.
pub fn templates(own: &[(&str, &str)]) -> (Sources, Diagnostics, Arc<TemplateSet>) {
    type Read = (Sources, Diagnostics, Arc<TemplateSet>);
    static KNOWN: Mutex<BTreeMap<Vec<(String, String)>, Read>> = Mutex::new(BTreeMap::new());
    let key = own.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect();
    KNOWN.lock().expect("no panic").entry(key).or_insert_with(|| read_templates(own)).clone()
}

fn read_templates(own: &[(&str, &str)]) -> (Sources, Diagnostics, Arc<TemplateSet>) {
    let (mut sources, mut diagnostics, mut set) = (Sources::new(), Diagnostics::new(), TemplateSet::new());
    let folder = root().join("shaders-templates");
    let mut names = Vec::new();
    collect(&folder, &folder, &mut names);
    names.retain(|name| own.iter().all(|(other, _)| other != name));
    for name in names {
        let text = std::fs::read_to_string(folder.join(&name)).expect("a template");
        set.add(&mut sources, &name, &text, &mut diagnostics);
    }
    for (name, text) in own {
        set.add(&mut sources, name, text, &mut diagnostics);
    }
    set.check(&mut diagnostics);
    (sources, diagnostics, Arc::new(set))
}

fn collect(root: &Path, folder: &Path, names: &mut Vec<String>) {
    let mut entries: Vec<_> =
        std::fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            collect(root, &path, names);
        } else if let Ok(name) = path.strip_prefix(root) {
            let name = name.to_string_lossy().replace('\\', "/");
            if name.ends_with(".jinja") || name.ends_with(".axes.json") {
                names.push(name);
            }
        }
    }
}

fn setting(name: &str, value: &str, sources: &mut Sources) -> Setting {
    let file = sources.add("<test>", value);
    let value = document::parse(sources, file).valid().expect("JSON").root;
    Setting { name: name.to_owned(), place: value.span, value }
}

/// All files below a folder, sorted.
pub fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<_> =
        std::fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() { files(&path, found) } else { found.push(path) }
    }
}
