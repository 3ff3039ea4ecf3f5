//! [`Library`]: the environment that pipelines are loaded with.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use umbragraph_session::{Session, Target, Template, TemplateText};

use crate::Error;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::draw::HostInterface;
#[cfg(feature = "watch")]
use crate::front::watch::Read;
use crate::front::{DiskStorage, Pipeline, with_templates};
use crate::low_level::compose::{self, Roots};
#[cfg(feature = "watch")]
use crate::low_level::pipeline::ParameterFile;
use crate::low_level::shader::{TEMPLATE_ENDS, TargetProfile};
use crate::node::{Node, NodeKind, Registry};

/// The environment that pipelines are loaded with: node kinds, templates, layouts of the host's meshes, and the target
/// profile.
///
/// Loads share a [`Session`]: files that one load has read, and shader modules that it has validated, are reused by all
/// other loads of the same library.
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
    /// The session that all loads share; `None` before the first load.
    session: Arc<Mutex<Option<Session>>>,
}

impl Default for Library {
    fn default() -> Self {
        Self::new()
    }
}

impl Library {
    /// Creates a library with the node kinds and templates of this crate, for devices with the features and limits that
    /// WebGPU guarantees.
    pub fn new() -> Self {
        Self {
            registry: crate::registry(),
            profile: TargetProfile::webgpu(),
            folders: Vec::new(),
            texts: Vec::new(),
            roots: Vec::new(),
            session: Arc::default(),
        }
    }

    /// Adds the shader templates in a folder and its subfolders. A template replaces one of the same name that
    /// is bundled or was added before.
    #[must_use]
    pub fn templates(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folders.push(folder.into());
        self.again()
    }

    /// Adds a shader template from its source, or the axes file of a template (`.axes.json`) from its text. `name` is
    /// the path relative to a template folder.
    #[must_use]
    pub fn template(mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> Self {
        self.texts.push((name.into(), text.into()));
        self.again()
    }

    /// Declares the layout of the host's meshes for a geometry contract. Planning a pipeline checks shaders against
    /// this layout.
    #[must_use]
    pub fn host(mut self, geometry: impl Into<String>, interface: HostInterface) -> Self {
        self.registry.host(geometry, interface);
        self.again()
    }

    /// Registers a custom node kind.
    #[must_use]
    pub fn register<N: Node>(mut self) -> Self {
        self.registry.register::<N>();
        self.again()
    }

    /// Registers a custom node kind that is an object with state of its own.
    #[must_use]
    pub fn register_kind(mut self, kind: impl NodeKind + 'static) -> Self {
        self.registry.register_kind(kind);
        self.again()
    }

    /// Sets the features and limits that shaders and plans may rely on. The default is what WebGPU guarantees.
    #[must_use]
    pub fn profile(mut self, profile: TargetProfile) -> Self {
        self.profile = profile;
        self.again()
    }

    /// Adds a folder below which documents may name files, besides the working folder and the documents' own folders.
    #[must_use]
    pub fn root(mut self, folder: impl Into<PathBuf>) -> Self {
        self.roots.push(folder.into());
        self.again()
    }

    /// Returns this library without its session, so that the next load begins a new one.
    fn again(mut self) -> Self {
        self.session = Arc::default();
        self
    }

    /// Loads a pipeline file, with the files that it extends, includes and uses. Pipelines of this crate have names
    /// such as `umbragraph:nebula.json`.
    ///
    /// # Errors
    /// Files that cannot be read, texts that are not JSON, templates that cannot be parsed. Errors that depend on
    /// parameters and features are reported by [`Pipeline::plan`].
    pub fn load(&self, path: impl AsRef<Path>) -> Result<Pipeline, Error> {
        let target = Target::new(path.as_ref());
        self.with_session(|session| {
            session.refresh_target(&target);
            self.open(session, &target)
        })
    }

    /// Loads a pipeline from the text of its document. `name` stands for the document's path, which need not exist;
    /// paths in the document are relative to this path.
    ///
    /// # Errors
    /// The errors of [`Library::load`].
    pub fn load_text(&self, name: &str, text: &str) -> Result<Pipeline, Error> {
        let target = Target::new(name);
        self.with_session(|session| {
            session.overlay(name, text.as_bytes());
            session.refresh_target(&target);
            let pipeline = self.open(session, &target);
            session.close(name);
            pipeline
        })
    }

    fn open(&self, session: &mut Session, target: &Target) -> Result<Pipeline, Error> {
        let loaded = session.load_exactly(target).and_then(|loaded| Ok((loaded, session.diagnose(target)?)));
        // Nobody has the switch that cancels it.
        let Ok((loaded, findings)) = loaded else {
            return Err(Error::new(Diagnostics::new(), session.sources()));
        };
        let pipeline = Pipeline::new(loaded, self.profile.clone(), findings.clone());
        pipeline.filter(|_| !findings.has_errors()).ok_or_else(|| Error::new(findings, session.sources()))
    }

    fn with_session<T>(&self, work: impl FnOnce(&mut Session) -> T) -> T {
        let mut session = self.session.lock().unwrap_or_else(PoisonError::into_inner);
        work(session.get_or_insert_with(|| self.new_session()))
    }

    fn new_session(&self) -> Session {
        let (own, unreadable) = self.own_templates();
        let mut session = Session::new(DiskStorage, self.registry.clone(), with_templates(own));
        session.set_roots(&self.roots);
        session.report_always(unreadable);
        session
    }

    /// Returns the templates of the added folders and texts, and a diagnostic for each folder that cannot be read.
    fn own_templates(&self) -> (Vec<Template>, Vec<Diagnostic>) {
        let mut roots = Roots::default();
        let mut unreadable = Vec::new();
        let mut own: Vec<(String, TemplateText)> = Vec::new();
        for folder in &self.folders {
            roots = roots.and(folder);
            match compose::files_below(folder, &TEMPLATE_ENDS) {
                Ok(files) => own.extend(
                    files
                        .into_iter()
                        .map(|(name, path)| (name, TemplateText::File { path, roots: roots.clone() })),
                ),
                Err(diagnostic) => unreadable.push(diagnostic),
            }
        }
        own.extend(self.texts.iter().map(|(name, text)| (name.clone(), TemplateText::Text(text.clone()))));
        // Of one name the last.
        own.reverse();
        own.sort_by(|a, b| a.0.cmp(&b.0));
        own.dedup_by(|a, b| a.0 == b.0);
        (own.into_iter().map(|(name, text)| Template { name, text }).collect(), unreadable)
    }
}

/// Methods that only [`Watcher`](crate::Watcher) uses.
#[cfg(feature = "watch")]
impl Library {
    /// The folders with shader templates, in the order in which they were added.
    pub(super) fn folders(&self) -> &[PathBuf] {
        &self.folders
    }

    /// Returns the paths on disk of a pipeline's files, including files that were looked for but do not exist.
    pub(super) fn paths_of(&self, target: &Target) -> Vec<PathBuf> {
        let loaded = self.with_session(|session| session.load(target));
        let on_disk = |path: &&Path| !crate::Bundled::<()>::has(path);
        loaded.iter().flat_map(|loaded| loaded.paths().filter(on_disk).map(Path::to_path_buf)).collect()
    }

    /// Reads all files of a pipeline again. Returns `running`, the version in use, if the files differ from that
    /// version at most in comments.
    pub(super) fn read_again(
        &self,
        target: &Target,
        parameters: &[PathBuf],
        running: Option<&Read>,
    ) -> Result<Read, Error> {
        let (own, unreadable) = self.own_templates();
        self.with_session(|session| {
            session.set_templates(with_templates(own));
            session.refresh();
            let mut found: Diagnostics = unreadable.iter().cloned().collect();
            session.report_always(unreadable);
            let mut files = Vec::new();
            for path in parameters {
                match session.document(path) {
                    Ok(document) => files.push(ParameterFile::read(&document, &mut found)),
                    Err(diagnostics) => found.extend(diagnostics),
                }
            }
            if found.has_errors() {
                return Err(Error::new(found, session.sources()));
            }
            let as_it_runs = |loaded| running.filter(|running| running.is_of(loaded, &files)).cloned();
            if let Some(running) = session.load(target).ok().as_ref().and_then(as_it_runs) {
                return Ok(running);
            }
            let pipeline = self.open(session, target)?;
            Ok(Read::new(&target.path, pipeline, files, session.sources().clone()))
        })
    }
}
