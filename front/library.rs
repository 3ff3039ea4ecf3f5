//! [`Library`]: what pipelines are loaded with.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::compose::{self, Disk, Files, Named, Roots};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::draw::HostInterface;
use crate::front::Pipeline;
use crate::node::{Node, NodeKind, Registry};
use crate::pipeline::Modules;
use crate::shader::{TEMPLATE_ENDS, TargetProfile, TemplateSet};
use crate::source::{FileId, Sources};
use crate::{Bundled, Error};

/// What pipelines are loaded with: node kinds, templates, what the host stores of its meshes, and the target profile.
///
/// Shader modules that one load has proven serve all others of the same library.
///
/// ```
/// # use umbragraph::{Library, Options};
/// let library = Library::new();
/// let pipeline = library.load("umbragraph:nebula.json")?;
/// let plan = pipeline.plan(&Options::new(1280, 720).set("resolution", 1024))?;
/// assert_eq!(plan.viewport, [1280, 720]);
/// # Ok::<(), umbragraph::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Library {
    registry: Registry,
    profile: TargetProfile,
    folders: Vec<PathBuf>,
    texts: Vec<(String, Arc<str>)>,
    roots: Vec<PathBuf>,
    shared: Arc<Mutex<Shared>>,
}

/// What loads share.
#[derive(Debug, Default)]
struct Shared {
    /// The templates, with the texts that they are in; made at the first load.
    templates: Option<(Arc<TemplateSet>, Sources, Diagnostics)>,
    modules: Arc<Mutex<Modules>>,
}

impl Default for Library {
    fn default() -> Self {
        Self::new()
    }
}

impl Library {
    /// The node kinds and templates that come with this crate, for devices with what WebGPU promises.
    pub fn new() -> Self {
        Self {
            registry: crate::registry(),
            profile: TargetProfile::webgpu(),
            folders: Vec::new(),
            texts: Vec::new(),
            roots: Vec::new(),
            shared: Arc::default(),
        }
    }

    /// The templates of a folder besides, those in folders of it included; one replaces another of its name.
    #[must_use]
    pub fn templates(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folders.push(folder.into());
        self.again()
    }

    /// A template, or the axes of one, from a text.
    #[must_use]
    pub fn template(mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> Self {
        self.texts.push((name.into(), text.into()));
        self.again()
    }

    /// What the host stores of the meshes of a geometry. Shaders are compared with it when a pipeline is planned.
    #[must_use]
    pub fn host(mut self, geometry: impl Into<String>, interface: HostInterface) -> Self {
        self.registry.host(geometry, interface);
        self
    }

    /// A node kind of your own.
    #[must_use]
    pub fn register<N: Node>(mut self) -> Self {
        self.registry.register::<N>();
        self
    }

    /// A node kind of your own that is an object, with values of its own.
    #[must_use]
    pub fn register_kind(mut self, kind: impl NodeKind + 'static) -> Self {
        self.registry.register_kind(kind);
        self
    }

    /// What shaders and plans may rely on, in place of what WebGPU promises.
    #[must_use]
    pub fn profile(mut self, profile: TargetProfile) -> Self {
        self.profile = profile;
        self.again()
    }

    /// A folder below which documents may name files, besides the working folder and their own.
    #[must_use]
    pub fn root(mut self, folder: impl Into<PathBuf>) -> Self {
        self.roots.push(folder.into());
        self
    }

    /// Shares nothing with the library that it was before.
    fn again(mut self) -> Self {
        self.shared = Arc::default();
        self
    }

    /// Loads a pipeline file, with the files that it extends, includes and uses; one that comes with this crate is
    /// `umbragraph:nebula.json`.
    ///
    /// # Errors
    /// Files that cannot be read, texts that are no JSON, templates that cannot be parsed. What depends on parameters and
    /// features is checked by [`Pipeline::plan`].
    pub fn load(&self, path: impl AsRef<Path>) -> Result<Pipeline, Error> {
        let path = path.as_ref();
        // What the application names it may read, wherever it lies.
        self.open(path, &mut |sources| Bundled(Named).read(path, sources))
    }

    /// Loads a pipeline from a text. What it names is relative to its name, which is that of a file that need not exist.
    ///
    /// # Errors
    /// As of [`Library::load`].
    pub fn load_text(&self, name: &str, text: &str) -> Result<Pipeline, Error> {
        self.open(Path::new(name), &mut |sources| Ok(sources.add(name, text)))
    }

    fn open(
        &self,
        path: &Path,
        read: &mut dyn FnMut(&mut Sources) -> Result<FileId, Diagnostic>,
    ) -> Result<Pipeline, Error> {
        let (templates, mut sources, mut findings, modules) = self.shared();
        let roots = self.roots.iter().fold(Roots::of(path), |roots, folder| roots.and(folder));
        let composed = match read(&mut sources) {
            Ok(file) => compose::compose(file, path, &mut Bundled(Disk(roots)), &mut sources, &mut findings),
            Err(diagnostic) => {
                findings.push(diagnostic);
                None
            }
        };
        match composed {
            Some(composed) if !findings.has_errors() => {
                let (registry, profile) = (self.registry.clone(), self.profile.clone());
                Ok(Pipeline::new(
                    composed.document,
                    (registry, profile, templates, modules),
                    sources,
                    findings,
                ))
            }
            _ => Err(Error::new(findings, &sources)),
        }
    }

    /// The templates, with their texts and findings, and the modules of all loads.
    fn shared(&self) -> (Arc<TemplateSet>, Sources, Diagnostics, Arc<Mutex<Modules>>) {
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        let modules = shared.modules.clone();
        let (templates, sources, findings) = shared.templates.get_or_insert_with(|| self.read_templates());
        (templates.clone(), sources.clone(), findings.clone(), modules)
    }

    fn read_templates(&self) -> (Arc<TemplateSet>, Sources, Diagnostics) {
        let (mut sources, mut findings) = (Sources::new(), Diagnostics::new());
        let mut files = Vec::new();
        let mut own = Own { disk: Disk(Roots::default()), texts: &self.texts };
        for folder in &self.folders {
            own.disk.0 = std::mem::take(&mut own.disk.0).and(folder);
            match compose::files_below(folder, &TEMPLATE_ENDS) {
                Ok(found) => files.extend(found),
                Err(diagnostic) => findings.push(diagnostic),
            }
        }
        files.extend(self.texts.iter().map(|(name, _)| (name.clone(), PathBuf::from(name))));
        // Of one name the last.
        files.reverse();
        files.sort_by(|a, b| a.0.cmp(&b.0));
        files.dedup_by(|a, b| a.0 == b.0);
        let templates = crate::templates_with(&files, &mut own, &mut sources, &mut findings);
        (templates, sources, findings)
    }
}

/// Templates from texts, and from the disk.
struct Own<'a> {
    disk: Disk,
    texts: &'a [(String, Arc<str>)],
}

impl Files for Own<'_> {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        match self.texts.iter().rev().find(|(name, _)| Path::new(name) == path) {
            Some((name, text)) => Ok(sources.add(name.as_str(), text.clone())),
            None => self.disk.read(path, sources),
        }
    }
}
