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

/// Files, caches, and answers about pipelines. See the [crate](crate).
pub struct Session {
    pub(crate) files: FileTable,
    registry: Arc<Registry>,
    roots: Roots,
    list: Vec<Template>,
    /// Whether the list is another than the one that was read.
    has_other_list: bool,
    /// Diagnostics of the host's own mistakes, such as a folder that is not there.
    always: Diagnostics,
    templates: Option<Arc<Templates>>,
    loads: BTreeMap<Target, Loaded>,
    surveys: BTreeMap<Target, (Loaded, String, Option<Surveyed>)>,
    pub(crate) done: Done,
    cancel: Cancel,
    /// The schemas of kinds of files, as far as they were asked for.
    pub(crate) schemas: Vec<(FileKind, Arc<Json>)>,
}

impl std::fmt::Debug for Session {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Session").field("loads", &self.loads.keys()).finish_non_exhaustive()
    }
}

/// Pipelines of which the last load is kept.
const KEPT: usize = 64;

impl Session {
    /// A session over files, with the node kinds and the templates of its pipelines.
    pub fn new(storage: impl Storage + 'static, registry: Registry, templates: Vec<Template>) -> Self {
        Self {
            files: FileTable::new(Box::new(storage)),
            registry: Arc::new(registry),
            roots: Roots::default(),
            list: templates,
            has_other_list: false,
            always: Diagnostics::new(),
            templates: None,
            loads: BTreeMap::new(),
            surveys: BTreeMap::new(),
            done: Done::default(),
            cancel: Cancel::default(),
            schemas: Vec::new(),
        }
    }

    /// Folders below which documents may name files, besides the working folder and their own.
    pub fn set_roots(&mut self, folders: &[PathBuf]) {
        self.roots = folders.iter().fold(Roots::default(), |roots, folder| roots.and(folder));
        self.loads.clear();
    }

    /// Sets the templates: those of folders in which files came or went. Modules of shaders stay if the names are the
    /// same.
    pub fn set_templates(&mut self, templates: Vec<Template>) {
        self.has_other_list |= self.list != templates;
        self.list = templates;
    }

    /// Adds these diagnostics, in place of those before, to the ones of every pipeline: that a folder is not there, for
    /// one.
    pub fn report_always(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        self.always = diagnostics.into_iter().collect();
    }

    /// Lays an unsaved text over a path, whether or not a file is there.
    pub fn overlay(&mut self, path: impl AsRef<Path>, text: impl Into<Arc<[u8]>>) {
        self.files.overlay(path.as_ref(), Some(text.into()), &mut self.done);
    }

    /// Drops the unsaved text of a path.
    pub fn close(&mut self, path: impl AsRef<Path>) {
        self.files.overlay(path.as_ref(), None, &mut self.done);
    }

    /// Reads a file again, if an answer needed it.
    pub fn changed(&mut self, path: impl AsRef<Path>) {
        self.files.changed(path.as_ref(), &mut self.done);
    }

    /// Reads the files of one pipeline again.
    pub fn refresh_target(&mut self, target: &Target) {
        let reads = self.loads.get(target).map(|loaded| loaded.composition().reads.clone());
        for Read { path, .. } in reads.into_iter().flatten() {
            self.files.changed(&path, &mut self.done);
        }
    }

    /// Reads all files again that answers needed, and looks again for those that were not there.
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

    /// The registered node kinds.
    pub fn registry(&self) -> &Registry {
        &self.registry
    }

    /// The texts as they are: the places of diagnostics are in these.
    pub fn sources(&self) -> &Sources {
        self.files.current()
    }

    /// Registers a text that is no file, such as one of the command line; the same one is registered once.
    pub fn text(&mut self, name: &str, text: &str) -> Span {
        let file = self.files.with_sources(|files, sources| files.text(name, text, sources));
        Span::new(file, 0..text.len())
    }

    /// The document of one file, as it is written.
    ///
    /// # Errors
    /// A file that cannot be read, or is no document.
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

    /// The set of all templates.
    pub fn templates(&mut self) -> Arc<TemplateSet> {
        self.read_templates().set.clone()
    }

    /// The diagnostics of the templates.
    pub fn template_diagnostics(&mut self) -> Diagnostics {
        self.read_templates().diagnostics.clone()
    }

    /// The files of the templates that are in no library.
    pub fn own_templates(&mut self) -> std::collections::BTreeSet<FileId> {
        self.read_templates().own.clone()
    }

    fn read_templates(&mut self) -> Arc<Templates> {
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

    /// Reads and composes the files of a pipeline, if one of them changed. Comments may have: places in what is loaded
    /// are in [`Loaded::sources`].
    ///
    /// # Errors
    /// [`Cancel::set`].
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

    /// Like [`Session::load`], with places in the texts as they are.
    ///
    /// # Errors
    /// [`Cancel::set`].
    pub fn load_exactly(&mut self, target: &Target) -> Result<Loaded, Cancelled> {
        let loaded = self.load(target)?;
        self.files.settle(&loaded.composition().reads);
        self.load(target)
    }

    /// Returns the diagnostics of a pipeline's files and of the templates, with places in the current texts.
    ///
    /// # Errors
    /// [`Cancel::set`].
    pub fn diagnose(&mut self, target: &Target) -> Result<Diagnostics, Cancelled> {
        self.placed(target, |_, _| Ok(((), Diagnostics::new()))).map(|((), _, diagnostics)| diagnostics)
    }

    /// Plans one configuration of a pipeline. Diagnostics are placed in the current texts.
    ///
    /// # Errors
    /// [`Cancel::set`].
    pub fn plan(&mut self, target: &Target, choice: &Choice) -> Result<(Planned, Diagnostics), Cancelled> {
        let (planned, _, diagnostics) = self.placed(target, |session, loaded| {
            let planned = loaded.plan_with(choice, session.files.settled(), &mut session.done);
            session.cancel.check()?;
            let diagnostics = planned.diagnostics.clone();
            Ok((planned, diagnostics))
        })?;
        Ok((planned, diagnostics))
    }

    /// Plans all configurations of a pipeline and proves their shaders. Diagnostics are placed in the current texts.
    /// `None` for files that are no document, and without profiles.
    ///
    /// # Errors
    /// [`Cancel::set`].
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

    /// The reasons for what has a name, as the texts say it now. `place` is where the name is asked for.
    ///
    /// # Errors
    /// [`Cancel::set`]. Within the answer: a name that nothing has; nothing but the diagnostics of [`Session::plan`]
    /// where the files are no document.
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

    /// Loads, does something with it, and places all diagnostics in the texts as they are. Where one has no place
    /// there, all is done again with those texts.
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
