//! The documents of an editor, the pipelines that they are part of, and what is wrong with them.
//!
//! A part of a pipeline, such as a file that others extend, is told of as part of that pipeline: all pipelines below
//! the folders of the editor are composed once, so that it is known which files they read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use lsp_types::{DiagnosticRelatedInformation, DiagnosticSeverity, Location, NumberOrString, Range, Uri};

use serde_json::{Map, Value as Json};

use crate::position::{Encoding, is_whole, path_of, uri_of};
use crate::templates::is_axes;
use umbragraph_graph::compiler::PlanOptions;
use umbragraph_graph::compose::read_bytes;
use umbragraph_graph::diagnostic::{Diagnostic, Diagnostics, Place, Severity};
use umbragraph_graph::document::{Document, Entry, Kind, Parsed};
use umbragraph_graph::pipeline::{FileKind, claimed_profiles};
use umbragraph_graph::shader::TargetProfile;
use umbragraph_graph::source::{FileId, SourceFile, Span};
use umbragraph_session::{Cancel, Cancelled, Choice, Judges, Loaded, Session, Survey, Target, kind_of};

/// The maximum number of JSON files that the search for pipelines finds in all workspace folders together.
const MAX_FILES: usize = 2_000;
/// The maximum number of pipelines with which a template is checked while no document of one is open.
const MAX_USERS: usize = 4;
/// The maximum nesting depth of folders that the search for pipelines enters, below a workspace folder.
const MAX_DEPTH: usize = 12;
/// The maximum size, in bytes, of a file that the search for pipelines reads.
const MAX_BYTES: u64 = 4 << 20;
/// The names of folders that the search for pipelines skips.
const LEFT_OUT: [&str; 2] = ["node_modules", "target"];
/// The width and height of the rendered image that plans are made for, in pixels; the defaults of the command line.
const SIZE: [u32; 2] = [1280, 720];

/// A diagnostic as the protocol represents it, and the engine's diagnostic from which it was made.
pub(crate) type Found = (lsp_types::Diagnostic, Diagnostic);

/// The open documents of one editor, the pipelines that they belong to, and the diagnostics of those pipelines.
pub(crate) struct Workspace {
    pub(crate) session: Session,
    pub(crate) cancel: Cancel,
    pub(crate) encoding: Encoding,
    /// The folder for copies of templates that come with the module; `None` where nothing is written.
    pub(crate) library: Option<PathBuf>,
    folders: Vec<PathBuf>,
    /// The current text of each document that is open in the editor, by path.
    open: BTreeMap<PathBuf, String>,
    /// The paths of the pipelines that read a file, by the path of the file. `None` until the workspace is searched.
    readers: Option<BTreeMap<PathBuf, BTreeSet<PathBuf>>>,
    /// The pipeline whose diagnostics a document shows, by the path of the document.
    targets: BTreeMap<PathBuf, Target>,
    /// The pipelines whose diagnostics an open template shows, by the path of the template: those of open documents
    /// that use it, or else some of the workspace. A template that none uses stands for itself.
    users: BTreeMap<PathBuf, Vec<Target>>,
    /// The diagnostics of each pipeline, by the path of the file that shows them.
    found: BTreeMap<Target, BTreeMap<PathBuf, Vec<Found>>>,
    /// The paths of files that changed since the diagnostics of their pipelines were last updated.
    changed: BTreeSet<PathBuf>,
    /// Pipelines that were planned, but not checked in all configurations, since they changed.
    unchecked: BTreeSet<Target>,
    /// The configurations that the client chose, by pipeline, each as the contents of a parameter file.
    pub(crate) configurations: BTreeMap<PathBuf, Map<String, Json>>,
    /// Messages to show to the user with the next answer.
    pub(crate) warnings: Vec<String>,
    /// Whether a configuration was chosen since lenses and hints were last refreshed.
    is_reconfigured: bool,
}

impl Workspace {
    pub(crate) fn new(session: Session, folders: Vec<PathBuf>, encoding: Encoding) -> Self {
        let cancel = session.cancel();
        Self {
            session,
            cancel,
            encoding,
            library: None,
            folders,
            open: BTreeMap::new(),
            readers: None,
            targets: BTreeMap::new(),
            users: BTreeMap::new(),
            found: BTreeMap::new(),
            changed: BTreeSet::new(),
            unchecked: BTreeSet::new(),
            configurations: BTreeMap::new(),
            warnings: Vec::new(),
            is_reconfigured: false,
        }
    }

    /// Returns an answer of the session, and repeats the request while it is cancelled.
    pub(crate) fn sure<T>(&mut self, mut ask: impl FnMut(&mut Session) -> Result<T, Cancelled>) -> T {
        loop {
            self.cancel.clear();
            if let Ok(answer) = ask(&mut self.session) {
                return answer;
            }
        }
    }

    pub(crate) fn text(&self, path: &Path) -> Option<&str> {
        self.open.get(path).map(String::as_str)
    }

    /// Registers a document that the editor opened. Finds its pipeline at once, since text typed later may be invalid.
    pub(crate) fn open(&mut self, path: &Path, text: String) {
        self.targets.remove(path);
        self.users.clear();
        self.write(path, text);
        if is_document(path) {
            self.target(path);
        }
    }

    pub(crate) fn write(&mut self, path: &Path, text: String) {
        self.session.overlay(path, text.as_bytes());
        self.open.insert(path.to_owned(), text);
        self.changed.insert(path.to_owned());
    }

    pub(crate) fn close(&mut self, path: &Path) {
        self.session.close(path);
        self.open.remove(path);
        self.users.clear();
        self.changed.insert(path.to_owned());
    }

    /// Handles a file on disk that changed, is new, or was deleted. Ignores files that are open in the editor.
    pub(crate) fn changed_on_disk(&mut self, path: &Path) {
        if self.open.contains_key(path) {
            return;
        }
        self.session.changed(path);
        self.changed.insert(path.to_owned());
        if is_document(path) && self.readers.is_some() {
            self.compose(path);
            self.users.clear();
        }
    }

    /// Reads all files again and marks all open documents as changed. Needed since not all clients report changes on
    /// disk.
    pub(crate) fn refresh(&mut self) {
        self.session.refresh();
        self.changed.extend(self.open.keys().cloned());
    }

    /// Returns the paths of the pipelines that read a file. The first call searches the workspace folders for
    /// pipelines.
    pub(crate) fn readers_of(&mut self, path: &Path) -> BTreeSet<PathBuf> {
        if self.readers.is_none() {
            self.readers = Some(BTreeMap::new());
            let files = self.documents();
            // A cheap look first: most files of a workspace are no pipelines.
            let has_format = |path: &&PathBuf| {
                let bytes = read_bytes(path, MAX_BYTES).ok().flatten().unwrap_or_default();
                String::from_utf8_lossy(&bytes).contains("\"format\"")
            };
            files.iter().filter(has_format).for_each(|path| self.compose(path));
        }
        self.readers.as_ref().and_then(|readers| readers.get(path)).cloned().unwrap_or_default()
    }

    /// The paths of the JSON files below the workspace folders.
    fn documents(&self) -> Vec<PathBuf> {
        let mut files = Vec::new();
        self.folders.iter().for_each(|folder| collect(folder, 0, &mut files));
        files
    }

    /// Returns all pipelines of the workspace.
    pub(crate) fn pipelines(&mut self) -> Vec<Target> {
        self.readers_of(Path::new(""));
        let paths: BTreeSet<&PathBuf> =
            self.readers.iter().flatten().flat_map(|(_, targets)| targets).collect();
        // An open document may lie outside of the folders.
        let all: BTreeSet<Target> = paths.into_iter().map(Target::new).chain(self.told()).collect();
        all.into_iter().collect()
    }

    /// Returns the parameter files of the workspace in which a section, such as `parameters`, has a key.
    pub(crate) fn parameter_files(&mut self, section: &str, key: &str) -> Vec<PathBuf> {
        let has_word = |path: &PathBuf| {
            let bytes = read_bytes(path, MAX_BYTES).ok().flatten().unwrap_or_default();
            String::from_utf8_lossy(&bytes).contains(key)
        };
        let mut files = self.documents();
        files.retain(has_word);
        files.retain(|path| {
            let Some((FileKind::Parameters, parsed)) = self.kind(path) else { return false };
            let named = parsed.document.root.get(section);
            named.is_some_and(|named| named.get(key).is_some() || named.text() == Some(key))
        });
        files
    }

    /// Loads a pipeline and records which files it reads. A file that is not a pipeline is recorded as reading none.
    fn compose(&mut self, path: &Path) {
        match self.kind(path) {
            Some((FileKind::Pipeline, _)) => {
                let loaded = self.sure(|session| session.load(&Target::new(path)));
                self.read_by(path, &loaded);
            }
            _ => self.read(path, BTreeSet::new()),
        }
    }

    /// Returns the kind of a file, and what its text was parsed to. `None` if the file cannot be read or may be
    /// unrelated to pipelines.
    fn kind(&mut self, path: &Path) -> Option<(FileKind, Arc<Parsed>)> {
        let (_, parsed) = self.session.parsed(path)?;
        Some((kind_of(&parsed.document)?, parsed))
    }

    /// Records which files a pipeline reads. If the pipeline cannot be composed, the files recorded before are kept as
    /// well.
    fn read_by(&mut self, target: &Path, loaded: &Loaded) {
        let mut reads: BTreeSet<PathBuf> = loaded.paths().map(Path::to_owned).collect();
        if loaded.document().is_none() {
            let known = self.readers.iter().flatten().filter(|(_, targets)| targets.contains(target));
            reads.extend(known.map(|(path, _)| path.clone()));
        }
        self.read(target, reads);
    }

    fn read(&mut self, target: &Path, reads: BTreeSet<PathBuf>) {
        let Some(readers) = &mut self.readers else { return };
        let mut revised = BTreeSet::new();
        for (path, targets) in readers.iter_mut().filter(|(path, _)| !reads.contains(*path)) {
            if targets.remove(target) {
                revised.insert(path.clone());
            }
        }
        for path in reads {
            if readers.entry(path.clone()).or_default().insert(target.to_owned()) {
                revised.insert(path);
            }
        }
        self.targets.retain(|path, _| path == target || !revised.contains(path));
    }

    /// Returns the pipeline whose diagnostics a document shows: the document itself, or the first other pipeline that
    /// reads it if the document is not a valid pipeline. `None` if no pipeline reads it and it may be unrelated to
    /// pipelines.
    pub(crate) fn target(&mut self, path: &Path) -> Option<Target> {
        if let Some(known) = self.targets.get(path) {
            return Some(known.clone());
        }
        let own = Target::new(path);
        let readers = self.readers_of(path);
        let target = match readers.iter().find(|reader| *reader != path) {
            Some(other) if !self.is_right(&own) => Target::new(other),
            None if self.kind(path).is_none() => return None,
            _ => own,
        };
        self.targets.insert(path.to_owned(), target.clone());
        Some(target)
    }

    /// Returns the pipeline of a document like [`Workspace::target`]. A document in which no key has a value yet counts
    /// as a pipeline of its own.
    pub(crate) fn target_of_text(&mut self, path: &Path) -> Option<Target> {
        let target = self.target(path);
        let is_whole = |entry: &Entry| !matches!(entry.value.kind, Kind::Missing);
        target.or_else(|| {
            let (_, parsed) = self.session.parsed(path)?;
            let is_new = !parsed.document.root.entries().unwrap_or_default().iter().any(is_whole);
            is_new.then(|| Target::new(path))
        })
    }

    fn is_right(&mut self, target: &Target) -> bool {
        let kind = self.kind(&target.path);
        kind.is_some_and(|(kind, parsed)| {
            kind == FileKind::Pipeline && parsed.document.root.get("passes").is_some()
        }) && !self.planned(target).has_errors()
    }

    /// Returns the configuration whose values the editor shows: the one that the client chose, or else that of the
    /// command without further arguments.
    pub(crate) fn choice(&mut self, target: &Target) -> Choice {
        self.choice_and_diagnostics(target).0
    }

    fn choice_and_diagnostics(&mut self, target: &Target) -> (Choice, Diagnostics) {
        let loaded = self.sure(|session| session.load(target));
        let profiles = loaded.understood().map(|composed| profiles(&composed.document));
        let first = profiles.and_then(|profiles| profiles.into_iter().next());
        let (overrides, diagnostics) = self.chosen(target, loaded.document());
        let plan = PlanOptions::new(SIZE[0], SIZE[1]);
        (Choice::new(first.unwrap_or_else(TargetProfile::webgpu), plan).overrides(overrides), diagnostics)
    }

    /// Returns the diagnostics of a pipeline in the configuration that the editor shows.
    pub(crate) fn planned(&mut self, target: &Target) -> Diagnostics {
        let (choice, mut diagnostics) = self.choice_and_diagnostics(target);
        diagnostics.extend(self.sure(|session| session.plan(target, &choice)).1);
        diagnostics
    }

    /// Plans a pipeline again, since another configuration was chosen.
    pub(crate) fn reconfigured(&mut self, path: &Path) {
        self.changed.insert(path.to_owned());
        self.is_reconfigured = true;
    }

    /// Returns `true` once after a configuration was chosen.
    pub(crate) fn take_reconfigured(&mut self) -> bool {
        std::mem::take(&mut self.is_reconfigured)
    }

    /// Plans the pipelines of all changed files again. Returns the files whose diagnostics may have changed.
    pub(crate) fn tell(&mut self) -> BTreeSet<PathBuf> {
        let mut files = self.tell_once();
        // A pipeline may have shown that it reads an open document, or no longer does.
        let is_revised = |path: &PathBuf| is_document(path) && !self.targets.contains_key(path);
        if self.open.keys().any(is_revised) {
            files.append(&mut self.tell_once());
        }
        files
    }

    fn tell_once(&mut self) -> BTreeSet<PathBuf> {
        let changed = std::mem::take(&mut self.changed);
        let is_of_templates = changed.iter().any(|path| is_template(path));
        let of_templates = self.of_open_templates();
        let mut targets: BTreeSet<Target> =
            changed.iter().filter_map(|path| self.targets.get(path)).cloned().collect();
        let open: Vec<PathBuf> = self.open.keys().filter(|path| is_document(path)).cloned().collect();
        let told = open.into_iter().filter_map(|path| Some((self.target(&path)?, Some(path))));
        let told: Vec<_> = told.collect();
        for (target, path) in told.into_iter().chain(of_templates.into_iter().map(|target| (target, None))) {
            let reads = |path: &PathBuf| {
                self.readers
                    .as_ref()
                    .and_then(|all| all.get(path))
                    .is_some_and(|of| of.contains(&target.path))
            };
            let is_new = !self.found.contains_key(&target);
            if is_new
                || is_of_templates
                || path.is_some_and(|path| changed.contains(&path))
                || changed.iter().any(reads)
            {
                targets.insert(target);
            }
        }
        let gone: Vec<Target> = self.found.keys().filter(|target| !self.is_wanted(target)).cloned().collect();
        let mut files = BTreeSet::new();
        for target in gone {
            files.append(&mut self.replace(&target, None));
            targets.remove(&target);
            self.unchecked.remove(&target);
        }
        targets.retain(|target| self.is_wanted(target));
        for target in targets {
            files.append(&mut self.tell_of(&target));
        }
        files
    }

    /// The pipelines whose diagnostics are published.
    pub(crate) fn told(&self) -> Vec<Target> {
        self.found.keys().filter(|target| !is_template(&target.path)).cloned().collect()
    }

    /// Returns `true` if an open document or template shows the diagnostics of this pipeline.
    fn is_wanted(&self, target: &Target) -> bool {
        let is_of_template =
            |(path, users): (&PathBuf, &Vec<Target>)| self.open.contains_key(path) && users.contains(target);
        self.is_of_document(target) || self.users.iter().any(is_of_template)
    }

    fn is_of_document(&self, target: &Target) -> bool {
        self.targets.iter().any(|(path, known)| known == target && self.open.contains_key(path))
    }

    /// Returns the pipelines whose diagnostics the open templates show.
    fn of_open_templates(&mut self) -> BTreeSet<Target> {
        let is_wgsl = |path: &&PathBuf| is_template(path) && !is_axes(path);
        let open: Vec<PathBuf> = self.open.keys().filter(is_wgsl).cloned().collect();
        for path in &open {
            let file = path.to_str().and_then(|name| self.session.template_file(name));
            let Some(file) = file.filter(|_| !self.users.contains_key(path)) else { continue };
            let mut users = self.pipelines();
            users.retain(|target| self.sure(|session| session.uses_template(target, file)));
            if users.iter().any(|target| self.is_of_document(target)) {
                users.retain(|target| self.is_of_document(target));
            }
            users.truncate(MAX_USERS);
            if users.is_empty() {
                users.push(Target::new(path));
            }
            self.users.insert(path.clone(), users);
        }
        open.iter().filter_map(|path| self.users.get(path)).flatten().cloned().collect()
    }

    fn tell_of(&mut self, target: &Target) -> BTreeSet<PathBuf> {
        if is_template(&target.path) {
            let file = target.path.to_str().and_then(|name| self.session.template_file(name));
            let diagnostics = file.map(|file| self.session.check_template(file));
            return self.replace(target, Some(diagnostics.unwrap_or_default()));
        }
        let part = self.session.check_part(&target.path);
        let diagnostics = match part {
            Some((_, diagnostics)) => diagnostics,
            None => {
                self.unchecked.insert(target.clone());
                self.planned(target)
            }
        };
        let loaded = self.sure(|session| session.load(target));
        self.read_by(&target.path, &loaded);
        self.replace(target, Some(diagnostics))
    }

    /// Checks the next unchecked pipeline in all configurations. Returns the files whose diagnostics may have changed;
    /// `None` if no pipeline is unchecked, or if the check is cancelled.
    pub(crate) fn check(&mut self, judges: Judges<'_>) -> Option<BTreeSet<PathBuf>> {
        let target = self.unchecked.first()?.clone();
        let loaded = self.session.load(&target).ok()?;
        let profiles = loaded.document().map(profiles).unwrap_or_default();
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let survey = Survey::new(profiles, PlanOptions::new(SIZE[0], SIZE[1])).threads(threads);
        let (_, mut diagnostics) = self.session.check(&target, &survey, judges).ok()?;
        diagnostics.merge();
        // Of all configurations, the chosen one may be one that the pipeline no longer has.
        let chosen = self.planned(&target);
        diagnostics.extend(chosen.into_iter().filter(|one| self.is_of_configuration(one)));
        self.unchecked.remove(&target);
        Some(self.replace(&target, Some(diagnostics)))
    }

    /// Leaves the next pipeline unchecked, since its check panicked.
    pub(crate) fn skip_check(&mut self) {
        self.unchecked.pop_first();
    }

    /// Replaces the stored diagnostics of a pipeline; `None` removes them. Returns the files that have, or had,
    /// diagnostics of this pipeline.
    fn replace(&mut self, target: &Target, diagnostics: Option<Diagnostics>) -> BTreeSet<PathBuf> {
        let mut by_file: BTreeMap<PathBuf, Vec<Found>> = BTreeMap::new();
        for diagnostic in diagnostics.iter().flat_map(Diagnostics::iter) {
            let related = diagnostic.related.iter().map(|one| &one.place);
            let place = std::iter::once(&diagnostic.place).chain(related).find_map(|one| self.shown(one));
            let (path, range) = place.unwrap_or_else(|| (target.path.clone(), Range::default()));
            by_file.entry(path).or_default().push((self.written(diagnostic, range), diagnostic.clone()));
        }
        let mut files: BTreeSet<PathBuf> = by_file.keys().cloned().collect();
        let before = match diagnostics {
            Some(_) => self.found.insert(target.clone(), by_file),
            None => self.found.remove(target),
        };
        files.extend(before.into_iter().flat_map(BTreeMap::into_keys));
        files
    }

    /// Returns `true` if diagnostics of a pipeline are published for this file.
    pub(crate) fn has_diagnostics(&self, target: &Target, path: &Path) -> bool {
        self.found.get(target).and_then(|files| files.get(path)).is_some_and(|found| !found.is_empty())
    }

    /// The diagnostics of a file, each once.
    pub(crate) fn of_file(&self, path: &Path) -> Vec<&Found> {
        let mut all: Vec<&Found> = Vec::new();
        for one in self.found.values().filter_map(|files| files.get(path)).flatten() {
            if !all.iter().any(|(known, _)| known == &one.0) {
                all.push(one);
            }
        }
        all
    }

    /// Converts the place of a diagnostic to a path and a range for the editor. `None` for a place in a text
    /// without an absolute path, in a file that is neither document nor template, or in no file.
    fn shown(&self, place: &Place) -> Option<(PathBuf, Range)> {
        match place {
            Place::Span(span) => {
                let path = PathBuf::from(self.session.sources().get(span.file)?.name());
                Some((path, self.location(*span)?.range))
            }
            Place::File { path, .. } => {
                let path = Some(PathBuf::from(path)).filter(|path| is_whole(path));
                Some((path.filter(|path| is_document(path) || is_template(path))?, Range::default()))
            }
            Place::Nowhere => None,
        }
    }

    fn written(&self, diagnostic: &Diagnostic, range: Range) -> lsp_types::Diagnostic {
        let mut message = diagnostic.message.clone();
        if let Some(file) = diagnostic.span().and_then(|span| self.session.sources().get(span.file))
            && !is_whole(Path::new(file.name()))
        {
            message.push_str(&format!("\nin {}", file.name()));
        }
        let mut related = Vec::new();
        for one in &diagnostic.related {
            match one.place.clone() {
                Place::Span(span) if self.location(span).is_some() => {
                    related.extend(self.location(span).map(|location| DiagnosticRelatedInformation {
                        location,
                        message: one.message.clone(),
                    }));
                }
                _ => message.push_str(&format!("\n{}", one.message)),
            }
        }
        message.extend(diagnostic.help.iter().map(|help| format!("\nhelp: {help}")));
        lsp_types::Diagnostic {
            range,
            severity: Some(match diagnostic.severity {
                Severity::Error => DiagnosticSeverity::ERROR,
                Severity::Warning => DiagnosticSeverity::WARNING,
                Severity::Note => DiagnosticSeverity::INFORMATION,
            }),
            code: Some(NumberOrString::String(diagnostic.code.id.to_owned())),
            source: Some("umbragraph".to_owned()),
            message,
            related_information: (!related.is_empty()).then_some(related),
            ..lsp_types::Diagnostic::default()
        }
    }

    /// Converts a source range to the protocol's location; `None` in a file bundled with the module.
    pub(crate) fn location(&self, place: Span) -> Option<Location> {
        let file = self.session.sources().get(place.file)?;
        let path = Path::new(file.name());
        Some(Location { uri: self.uri(path)?, range: self.encoding.range(file, place) })
    }

    /// Returns the `file:` URI of an absolute path; `None` for other names, such as those of files bundled with the
    /// module.
    pub(crate) fn uri(&self, path: &Path) -> Option<Uri> {
        is_whole(path).then(|| uri_of(path)).flatten()
    }
}

/// The text of a file; `None` if the session has no such file.
pub(crate) fn source(workspace: &Workspace, file: FileId) -> Option<&SourceFile> {
    workspace.session.sources().get(file).map(AsRef::as_ref)
}

/// The range of a place in its file; `None` if the session has no such file.
pub(crate) fn range(workspace: &Workspace, place: Span) -> Option<Range> {
    Some(workspace.encoding.range(source(workspace, place.file)?, place))
}

/// Returns the path of a `file:` URI, without `.` and `..` components; `None` for other URIs.
pub(crate) fn document_path(uri: &Uri) -> Option<PathBuf> {
    path_of(uri).map(|path| umbragraph_graph::compose::normalize(&path))
}

fn profiles(document: &Document) -> Vec<TargetProfile> {
    claimed_profiles(document, &mut Diagnostics::new())
}

pub(crate) fn is_template(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    umbragraph_graph::shader::TEMPLATE_ENDS.iter().any(|end| name.ends_with(end))
}

pub(crate) fn is_document(path: &Path) -> bool {
    let is_json = path.extension().is_some_and(|end| end == "json" || end == "jsonc");
    is_json && !is_template(path)
}

fn collect(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut entries: Vec<_> = entries.flatten().collect();
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        let (path, name) = (entry.path(), entry.file_name());
        let Ok(kind) = entry.file_type() else { continue };
        let is_hidden = name.to_string_lossy().starts_with('.');
        let is_left_out = is_hidden || LEFT_OUT.iter().any(|left_out| name == *left_out);
        if files.len() >= MAX_FILES {
            return;
        }
        if kind.is_dir() && !is_left_out && depth < MAX_DEPTH {
            collect(&path, depth + 1, files);
        } else if kind.is_file()
            && is_document(&path)
            && entry.metadata().is_ok_and(|file| file.len() <= MAX_BYTES)
        {
            files.push(path);
        }
    }
}
