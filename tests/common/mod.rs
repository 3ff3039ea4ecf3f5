//! Helpers that the integration tests share.

#![allow(dead_code, missing_docs, unreachable_pub)]

#[cfg(all(feature = "gpu", feature = "gltf"))]
pub mod gpu;
pub mod host;
#[cfg(all(feature = "gpu", feature = "gltf"))]
pub mod labels;
#[cfg(all(feature = "gpu", feature = "gltf"))]
pub mod pictures;
pub mod settings;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use umbragraph::diagnostic::{Diagnostic, Diagnostics, render};
use umbragraph::low_level::CheckReport;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::compose::{Files as _, Named, Roots};
use umbragraph::low_level::document::{self, Document};
use umbragraph::low_level::pipeline::{self, Override, Overrides, ParameterFile};
use umbragraph::low_level::session::{Choice, Session, Storage, Target, Template, TemplateText};
use umbragraph::low_level::shader::{TargetProfile, TemplateSet};
use umbragraph::low_level::source::{FileId, Sources};
use umbragraph::{Bundled, Plan};
use umbragraph_verify::verify;

/// The folder of the workspace.
pub fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The result of checking a text.
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
    /// The features and limits that shaders may rely on; WebGPU without it.
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
    with_session(with.templates, |session| {
        let mut target = Target::new(name);
        target.extensions.extend(with.extension.map(PathBuf::from));
        session.refresh_target(&target);
        session.overlay(name, text.as_bytes());
        let outcome = check_target(session, &target, with);
        session.close(name);
        outcome
    })
}

fn check_target(session: &mut Session, target: &Target, with: &With<'_>) -> Outcome {
    let loaded = session.load_exactly(target).expect("nothing cancels");
    let mut diagnostics = Diagnostics::new();
    let [width, height] = with.size.unwrap_or([640, 480]);
    let options = PlanOptions::new(width, height).aliasing(!with.without_aliasing);
    let mut choice = Choice::new(with.profile.clone().unwrap_or_else(TargetProfile::webgpu), options.clone());
    if let Some(document) = loaded.document() {
        choice = choice.overrides(overrides(document, with, session, &mut diagnostics));
    }
    let (planned, found) = session.plan(target, &choice).expect("nothing cancels");
    diagnostics.extend(found);
    diagnostics.sort();
    if let Some(plan) = planned.report.plan.as_ref().filter(|_| !diagnostics.has_errors()) {
        let violations = verify(plan, &options);
        let name = target.path.display();
        assert!(violations.is_empty(), "the plan of {name} has errors: {violations:#?}");
    }
    Outcome { sources: session.sources().clone(), diagnostics, checked: planned.report }
}

/// The names of the presets of a pipeline and of all that it extends.
pub fn presets(name: &str, text: &str) -> Vec<String> {
    with_session(&[], |session| {
        session.overlay(name, text.as_bytes());
        let loaded = session.load_exactly(&Target::new(name)).expect("nothing cancels");
        session.close(name);
        let presets = loaded.document().expect("a document").root.entries_of("presets");
        presets.iter().map(|preset| preset.key.clone()).collect()
    })
}

/// Lends the session of this thread that has the project's templates and some of the test's own.
fn with_session<T>(own: &[(&str, &str)], work: impl FnOnce(&mut Session) -> T) -> T {
    type Sessions = BTreeMap<Vec<(String, String)>, Session>;
    thread_local!(static SESSIONS: RefCell<Sessions> = RefCell::default());
    let key = own.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect();
    let begin = || {
        let template = |(name, text): (String, Arc<str>)| Template { name, text: TemplateText::Text(text) };
        let templates = template_texts(own).into_iter().map(template).collect();
        Session::new(Workspace, umbragraph::registry(), templates)
    };
    SESSIONS.with_borrow_mut(|sessions| work(sessions.entry(key).or_insert_with(begin)))
}

/// The files of the workspace, by their path in it, which is where tests run.
struct Workspace;

impl Storage for Workspace {
    fn read(&mut self, path: &Path, _: Option<&Roots>, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        Bundled(Named).read(path, sources)
    }
}

fn overrides(
    document: &Document,
    with: &With<'_>,
    session: &mut Session,
    diagnostics: &mut Diagnostics,
) -> Overrides {
    let mut below = Overrides::default();
    let mut preset = with.preset.map(|name| (name.to_owned(), session.text("<test>", name)));
    if let Some(path) = with.file {
        let file = ParameterFile::read(&session.document(Path::new(path)).expect("JSON"), diagnostics);
        preset = preset.or(file.preset);
        below = file.overrides;
    }
    if let Some((name, at)) = preset {
        below = pipeline::of_preset(document, &name, at, diagnostics).under(below);
    }
    let mut settings = |all: &[(&str, &str)]| all.iter().map(|one| setting(*one, session)).collect();
    below.under(Overrides { parameters: settings(with.parameters), features: settings(with.features) })
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
    for (name, text) in template_texts(own) {
        set.add(&mut sources, &name, &text, &mut diagnostics);
    }
    set.check(&mut diagnostics);
    (sources, diagnostics, Arc::new(set))
}

/// The texts of the project's templates, and of some of the test's own, which may stand in place of the project's.
fn template_texts(own: &[(&str, &str)]) -> Vec<(String, Arc<str>)> {
    let folder = root().join("shaders-templates");
    let mut names = Vec::new();
    collect(&folder, &folder, &mut names);
    names.retain(|name| own.iter().all(|(other, _)| other != name));
    let read = |name: String| {
        let text = std::fs::read_to_string(folder.join(&name)).expect("a template");
        (name, text.into())
    };
    let own = own.iter().map(|(name, text)| ((*name).to_owned(), (*text).into()));
    names.into_iter().map(read).chain(own).collect()
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

fn setting((name, value): (&str, &str), session: &mut Session) -> Override {
    let place = session.text("<test>", value);
    let value = document::parse(session.sources(), place.file).valid().expect("JSON").root;
    Override { name: name.to_owned(), place: value.span, value }
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
