//! [`Session`]: files, caches, and answers about pipelines.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value as Json;

use crate::cancel::{Cancel, Cancelled};
use crate::choice::{Choice, Target};
use crate::composition::Composition;
use crate::done::Done;
use crate::files::{FileTable, Read, Role, Storage};
use crate::graph::compose::Roots;
use crate::graph::diagnostic::{Diagnostic, Diagnostics};
use crate::graph::document::Document;
use crate::graph::node::Registry;
use crate::graph::pipeline::FileKind;
use crate::graph::shader::TemplateSet;
use crate::graph::source::{FileId, Sources, Span};
use crate::graph::why::{Subject, Thing, why};
use crate::loaded::{Loaded, Planned};
use crate::places;
use crate::survey::{Judges, Survey, Surveyed, survey};
use crate::templates::{Template, Templates};

/// The files of pipelines, with cached results and answers to requests about them. See the [crate
/// documentation](crate).
pub struct Session {
    pub(crate) files: FileTable,
    registry: Arc<Registry>,
    roots: Roots,
    list: Vec<Template>,
    /// Whether the list of templates has changed since the templates were read.
    has_other_list: bool,
    /// Diagnostics that are added to those of every pipeline, such as about a missing folder.
    always: Diagnostics,
    templates: Option<Arc<Templates>>,
    /// The texts of the templates as answers for editors look at them.
    pub(crate) texts: Option<Arc<crate::texts::Texts>>,
    loads: BTreeMap<Target, Loaded>,
    surveys: BTreeMap<Target, (Loaded, String, Option<Surveyed>)>,
    pub(crate) done: Done,
    cancel: Cancel,
    /// The JSON schemas of the kinds of files that were needed so far.
    pub(crate) schemas: Vec<(FileKind, Arc<Json>)>,
}

impl std::fmt::Debug for Session {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Session").field("loads", &self.loads.keys()).finish_non_exhaustive()
    }
}

/// The maximum number of pipelines whose last load is cached. A load beyond it clears the cache first.
const KEPT: usize = 64;

impl Session {
    /// Creates a session that reads files from `storage`. Its pipelines can use the node kinds in `registry` and the
    /// shader templates in `templates`.
    pub fn new(storage: impl Storage + 'static, registry: Registry, templates: Vec<Template>) -> Self {
        Self {
            files: FileTable::new(Box::new(storage)),
            registry: Arc::new(registry),
            roots: Roots::default(),
            list: templates,
            has_other_list: false,
            always: Diagnostics::new(),
            templates: None,
            texts: None,
            loads: BTreeMap::new(),
            surveys: BTreeMap::new(),
            done: Done::default(),
            cancel: Cancel::default(),
            schemas: Vec::new(),
        }
    }

    /// Sets the folders below which documents may name files, besides the working folder and the document's own folder.
    pub fn set_roots(&mut self, folders: &[PathBuf]) {
        self.roots = folders.iter().fold(Roots::default(), |roots, folder| roots.and(folder));
        self.loads.clear();
    }

    /// Sets the list of shader templates, such as after files were added to a template folder. Compiled modules of
    /// unchanged templates are kept if the names in the list are the same.
    pub fn set_templates(&mut self, templates: Vec<Template>) {
        self.has_other_list |= self.list != templates;
        self.list = templates;
    }

    /// Sets diagnostics that are added to those of every pipeline, such as about a missing folder. Replaces the
    /// diagnostics of an earlier call.
    pub fn report_always(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        self.always = diagnostics.into_iter().collect();
    }

    /// Sets the unsaved text of a path, which the session uses instead of the file's content. The file need not exist.
    pub fn overlay(&mut self, path: impl AsRef<Path>, text: impl Into<Arc<[u8]>>) {
        self.files.overlay(path.as_ref(), Some(text.into()), &mut self.done);
    }

    /// Removes the unsaved text of a path, so that the session uses the file's content again.
    pub fn close(&mut self, path: impl AsRef<Path>) {
        self.files.overlay(path.as_ref(), None, &mut self.done);
    }

    /// Reads a changed file again. Does nothing if no answer has needed the file yet.
    pub fn changed(&mut self, path: impl AsRef<Path>) {
        self.files.changed(path.as_ref(), &mut self.done);
    }

    /// Reads all files of one pipeline again, except shader templates. Does nothing if the pipeline has not been
    /// loaded.
    pub fn refresh_target(&mut self, target: &Target) {
        let reads = self.loads.get(target).map(|loaded| loaded.composition().reads.clone());
        for Read { path, .. } in reads.into_iter().flatten() {
            self.files.changed(&path, &mut self.done);
        }
    }

    /// Reads again all files that answers have needed, including those that did not exist.
    pub fn refresh(&mut self) {
        self.files.refresh(&mut self.done);
    }

    /// Returns the switch that cancels an answer under way, for use on another thread.
    pub fn cancel(&self) -> Cancel {
        self.cancel.clone()
    }

    /// Returns the counts of work since the last call, and resets the counts to zero.
    pub fn take_done(&mut self) -> Done {
        std::mem::take(&mut self.done)
    }

    /// The node kinds that pipelines of this session can use.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// The current texts of all files. The source places of diagnostics refer to these texts.
    pub fn sources(&self) -> &Sources {
        self.files.current()
    }

    /// Registers a text that is not a file, such as a command-line argument, and returns its source range. The same
    /// name and text are registered only once.
    pub fn text(&mut self, name: &str, text: &str) -> Span {
        let file = self.files.with_sources(|files, sources| files.text(name, text, sources));
        Span::new(file, 0..text.len())
    }

    /// Returns the document of one file, not composed with other files.
    ///
    /// # Errors
    /// Returns diagnostics if the file cannot be read or is not a valid document.
    pub fn document(&mut self, path: &Path) -> Result<Document, Diagnostics> {
        self.files.settle(&[Read { path: path.to_owned(), revision: 0 }]);
        let done = &mut self.done;
        self.files.with_sources(|files, sources| {
            let file = files.read(path, None, Role::Document, sources, done)?;
            files.document(file, sources, done)
        })
    }

    /// Returns `true` if an answer has read this file.
    pub fn has_read(&self, path: &Path) -> bool {
        self.files.has_read(path)
    }

    /// Returns the set of all shader templates. Reads the templates first if they are new or have changed.
    pub fn templates(&mut self) -> Arc<TemplateSet> {
        self.read_templates().set.clone()
    }

    /// Returns the diagnostics of the shader templates, such as syntax errors and duplicate names.
    pub fn template_diagnostics(&mut self) -> Diagnostics {
        self.read_templates().diagnostics.clone()
    }

    /// Returns the files of the shader templates that belong to no library.
    pub fn own_templates(&mut self) -> std::collections::BTreeSet<FileId> {
        self.read_templates().own.clone()
    }

    pub(crate) fn read_templates(&mut self) -> Arc<Templates> {
        match &self.templates {
            Some(known) if !self.has_other_list && known.is_current(&self.files) => known.clone(),
            _ => {
                self.has_other_list = false;
                let Self { list, files, done, templates: before, .. } = &mut *self;
                let templates = Arc::new(Templates::read(list, before.as_deref(), files, done));
                self.templates = Some(templates.clone());
                templates
            }
        }
    }

    /// Reads and composes the files of a pipeline, or returns the previous load if none of them changed. Changes that
    /// only affect comments and layout do not count, so source places of the result refer to [`Loaded::sources`].
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`].
    pub fn load(&mut self, target: &Target) -> Result<Loaded, Cancelled> {
        self.cancel.check()?;
        let templates = self.read_templates();
        let known = self.loads.get(target).filter(|known| {
            let Composition { reads, .. } = &**known.composition();
            self.files.are_unchanged(reads)
        });
        let composition = match known {
            Some(known) if Arc::ptr_eq(known.kept_templates(), &templates) => return Ok(known.clone()),
            Some(known) => known.composition().clone(),
            None => {
                let Self { files, roots, done, cancel, .. } = self;
                Arc::new(Composition::new(target, roots, files, (done, cancel))?)
            }
        };
        let loaded = Loaded::new(composition, templates, self.registry.clone());
        if self.loads.len() >= KEPT {
            self.loads.clear();
            self.surveys.clear();
        }
        self.loads.insert(target.clone(), loaded.clone());
        Ok(loaded)
    }

    /// Loads a pipeline like [`Session::load`], but loads again after changes of comments and layout too. Source places
    /// of the result refer to the current texts.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`].
    pub fn load_exactly(&mut self, target: &Target) -> Result<Loaded, Cancelled> {
        let loaded = self.load(target)?;
        self.files.settle(&loaded.composition().reads);
        self.load(target)
    }

    /// Returns the diagnostics of a pipeline's files and of the templates, with places in the current texts.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`].
    pub fn diagnose(&mut self, target: &Target) -> Result<Diagnostics, Cancelled> {
        self.placed(target, |_, _| Ok(((), Diagnostics::new()))).map(|((), _, diagnostics)| diagnostics)
    }

    /// Plans one configuration of a pipeline. Diagnostics are placed in the current texts.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`].
    pub fn plan(&mut self, target: &Target, choice: &Choice) -> Result<(Planned, Diagnostics), Cancelled> {
        let (planned, _, diagnostics) = self.placed(target, |session, loaded| {
            let planned = loaded.plan_with(choice, session.files.settled(), &mut session.done);
            session.cancel.check()?;
            let diagnostics = planned.diagnostics.clone();
            Ok((planned, diagnostics))
        })?;
        Ok((planned, diagnostics))
    }

    /// Plans all configurations of a pipeline and validates their shader variants. `judges` adds further checks of each
    /// plan. Diagnostics are placed in the current texts. The result is `None` if a file is broken or missing, or if
    /// `asked` has no profiles.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`].
    pub fn check(
        &mut self,
        target: &Target,
        asked: &Survey,
        judges: Judges<'_>,
    ) -> Result<(Option<Surveyed>, Diagnostics), Cancelled> {
        let key = asked.key();
        let (surveyed, _, diagnostics) = self.placed(target, |session, loaded| {
            let known = session.surveys.get(target);
            let surveyed = match known.filter(|(of, known, _)| of == loaded && *known == key) {
                Some((_, _, surveyed)) => surveyed.clone(),
                None => {
                    let Self { files, done, cancel, .. } = session;
                    let surveyed = survey(loaded, asked, &mut *judges, files.settled(), (done, cancel))?;
                    let kept = (loaded.clone(), key.clone(), surveyed.clone());
                    session.surveys.insert(target.clone(), kept);
                    surveyed
                }
            };
            let diagnostics = surveyed.as_ref().map(|found| found.diagnostics.clone());
            Ok((surveyed, diagnostics.unwrap_or_default()))
        })?;
        Ok((surveyed, diagnostics))
    }

    /// Explains every part of a pipeline that has the given name, with places in the current texts. `place` is the
    /// source range of the request, at which an unknown name is reported.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`]. The inner result is an error if the name does not exist. If a file
    /// is broken or missing, it has the diagnostics of [`Session::plan`].
    pub fn why(
        &mut self,
        target: &Target,
        choice: &Choice,
        (name, place): (&str, Span),
    ) -> Result<Result<Vec<Thing>, Diagnostics>, Cancelled> {
        let loaded = self.load_exactly(target)?;
        let (planned, found) = self.plan(target, choice)?;
        let Some((composed, model)) = loaded.composed().zip(loaded.model()) else { return Ok(Err(found)) };
        let (overrides, checked, sources) = (&choice.overrides, &planned.report, self.files.settled());
        let subject = Subject { composed, model, overrides, checked, sources };
        Ok(why(&subject, name, place).map_err(|diagnostic| Diagnostics::from(*diagnostic)))
    }

    /// Loads a pipeline, calls `work`, and moves the places of all diagnostics to the current texts. If a place has no
    /// counterpart there, loads the current texts and calls `work` again.
    fn placed<T>(
        &mut self,
        target: &Target,
        mut work: impl FnMut(&mut Self, &Loaded) -> Result<(T, Diagnostics), Cancelled>,
    ) -> Result<(T, Loaded, Diagnostics), Cancelled> {
        let mut loaded = self.load(target)?;
        let (mut result, mut found) = work(self, &loaded)?;
        let mut all = self.all(&loaded, found);
        if places::moved(&all, &self.files).is_none() {
            loaded = self.load_exactly(target)?;
            (result, found) = work(self, &loaded)?;
            all = self.all(&loaded, found);
        }
        let mut placed = places::moved(&all, &self.files).unwrap_or(all);
        places::sort(&mut placed, loaded.files());
        Ok((result, loaded, placed))
    }

    fn all(&self, loaded: &Loaded, found: Diagnostics) -> Diagnostics {
        let mut all = self.always.clone();
        all.extend(loaded.diagnostics());
        all.extend(self.files.twins(&loaded.composition().reads));
        all.extend(found);
        all
    }
}
