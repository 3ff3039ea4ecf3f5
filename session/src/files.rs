//! The files of a session: each read once, with unsaved texts over them.
//!
//! Each path has a slot: one [`FileId`] for as long as the session lives, so that what stays the same keeps its places.
//! There are two texts per slot. The *settled* one is what documents and results were made of. The *current* one is
//! what the file says now. They differ only in comments and layout: a text with other tokens is settled at once, and
//! gives the file another revision, by which compositions see that they are out of date.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::done::Done;
use crate::graph::compose::{Roots, add_bytes, normalize};
use crate::graph::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use crate::graph::document::{self, Document, Parsed};
use crate::graph::source::{FileId, Sources, Span};
use crate::tokens::{Token, are_alike, moved, tokens};

/// The storage that a session reads files from, such as a disk or the memory of a web page.
pub trait Storage: Send {
    /// Reads and registers the text at a path. A path that a document names must lie below `roots`. For a path that the
    /// host names, `roots` is `None`, and the path may lie anywhere.
    ///
    /// # Errors
    /// Returns a diagnostic if the file does not exist, may not be read, or is not text.
    fn read(
        &mut self,
        path: &Path,
        roots: Option<&Roots>,
        sources: &mut Sources,
    ) -> Result<FileId, Diagnostic>;

    /// Returns `true` if a document with these root folders may read a path.
    fn may_read(&self, _path: &Path, _roots: &Roots) -> bool {
        true
    }

    /// Returns `true` if names that begin with this scheme and `:`, such as `umbragraph:effects/taa.json`, are files of
    /// the storage instead of relative paths.
    fn has_scheme(&self, _scheme: &str) -> bool {
        false
    }

    /// Returns the canonical path of a file, equal for all paths to the same file.
    fn identity(&self, path: &Path) -> PathBuf {
        normalize(path)
    }
}

/// The role in which a file is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// A JSON document, in which comments and layout have no meaning.
    Document,
    /// A shader template, in which every character matters.
    Template,
}

/// A file that was read, or searched for and not found, with the revision of its text at that time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Read {
    pub(crate) path: PathBuf,
    pub(crate) revision: u64,
}

pub(crate) struct FileTable {
    storage: Box<dyn Storage>,
    overlays: BTreeMap<PathBuf, Overlay>,
    known: BTreeMap<PathBuf, Known>,
    paths: HashMap<FileId, PathBuf>,
    settled: Sources,
    current: Sources,
    /// Registered texts that are not files, by name.
    texts: HashMap<String, Vec<FileId>>,
    revision: u64,
}

/// An unsaved text that replaces the content of a file.
struct Overlay {
    /// The path under which the text was given.
    path: PathBuf,
    bytes: Arc<[u8]>,
    /// A different path to the same file, under which an unsaved text was given before; `None` if there is none.
    again: Option<PathBuf>,
}

struct Known {
    identity: PathBuf,
    roots: Option<Roots>,
    role: Role,
    slot: Option<FileId>,
    failure: Option<Diagnostic>,
    revision: u64,
    /// The document parsed from the settled text, which cached results are based on; `None` until the document is
    /// needed.
    parsed: Option<Arc<Parsed>>,
    /// The tokens of the settled text, which cached results are based on; `None` until the tokens are needed.
    tokens: Option<Vec<Token>>,
    /// The tokens of the current text if its comments or layout differ from the settled text; otherwise `None`.
    moved: Option<Vec<Token>>,
}

impl Known {
    fn answer(&self) -> Result<FileId, Diagnostic> {
        match (&self.failure, self.slot) {
            (None, Some(slot)) => Ok(slot),
            (Some(failure), _) => Err(failure.clone()),
            (None, None) => {
                Err(Diagnostic::error(codes::FILE_UNREADABLE, Place::Nowhere, "no text was read"))
            }
        }
    }
}

impl FileTable {
    pub(crate) fn new(storage: Box<dyn Storage>) -> Self {
        Self {
            storage,
            overlays: BTreeMap::new(),
            known: BTreeMap::new(),
            paths: HashMap::new(),
            settled: Sources::new(),
            current: Sources::new(),
            texts: HashMap::new(),
            revision: 0,
        }
    }

    /// The settled texts, which cached documents and results are based on.
    pub(crate) fn settled(&self) -> &Sources {
        &self.settled
    }

    /// The current texts. Documents may differ from the settled texts in comments and layout.
    pub(crate) fn current(&self) -> &Sources {
        &self.current
    }

    /// Calls `work` with this table and its settled texts. Texts that `work` adds become current texts as well.
    pub(crate) fn with_sources<T>(&mut self, work: impl FnOnce(&mut Self, &mut Sources) -> T) -> T {
        let sources = std::mem::take(&mut self.settled);
        let mut lent = Lent { files: self, sources };
        work(lent.files, &mut lent.sources)
    }

    pub(crate) fn has_scheme(&self, scheme: &str) -> bool {
        self.storage.has_scheme(scheme)
    }

    /// Registers a text that is not a file. The same name and text are registered only once.
    pub(crate) fn text(&mut self, name: &str, text: &str, sources: &mut Sources) -> FileId {
        let known = self.texts.entry(name.to_owned()).or_default();
        let is_it = |file: &&FileId| sources.get(**file).is_some_and(|file| **file.text() == *text);
        if let Some(file) = known.iter().find(is_it) {
            return *file;
        }
        let file = sources.add(name, text);
        known.push(file);
        file
    }

    /// Reads the file at a path, or returns the known file if it was read before.
    pub(crate) fn read(
        &mut self,
        path: &Path,
        roots: Option<&Roots>,
        role: Role,
        sources: &mut Sources,
        done: &mut Done,
    ) -> Result<FileId, Diagnostic> {
        if let Some(known) = self.known.get_mut(path) {
            if role == Role::Template {
                known.role = role;
            }
            if known.roots.as_ref() == roots {
                return known.answer();
            }
            if known.failure.is_none() {
                if roots.is_none_or(|roots| self.storage.may_read(path, roots)) {
                    return known.answer();
                }
                // Who may not read it is told so, and the others keep it.
                let rejected = self.storage.read(path, roots, &mut Sources::new());
                return rejected.and_then(|_| known.answer());
            }
        }
        let identity = self.storage.identity(path);
        self.fetch(path, identity, roots.cloned(), role, sources, done)
    }

    /// Returns the path in `reads` that leads to the same file as `path`; `None` if there is none.
    pub(crate) fn path_among(&self, path: &Path, reads: &[Read]) -> Option<PathBuf> {
        if reads.iter().any(|read| read.path == path) {
            return Some(path.to_owned());
        }
        let identity = self.storage.identity(path);
        let is_it = |read: &&Read| self.known.get(&read.path).is_some_and(|known| known.identity == identity);
        reads.iter().find(is_it).map(|read| read.path.clone())
    }

    pub(crate) fn has_read(&self, path: &Path) -> bool {
        self.known.get(path).is_some_and(|known| known.failure.is_none())
    }

    /// Returns the revision number of a path's settled text, which changes when results must be made again; 0 if the
    /// path is unknown.
    pub(crate) fn revision(&self, path: &Path) -> u64 {
        self.known.get(path).map_or(0, |known| known.revision)
    }

    /// Returns `true` if all files still have the revision that they had when they were read.
    pub(crate) fn are_unchanged(&self, reads: &[Read]) -> bool {
        reads.iter().all(|read| self.revision(&read.path) == read.revision)
    }

    /// Returns the document of a file's settled text, or the diagnostics if the text is invalid.
    pub(crate) fn document(
        &mut self,
        file: FileId,
        sources: &Sources,
        done: &mut Done,
    ) -> Result<Document, Diagnostics> {
        let parsed = self.parsed(file, sources, done);
        if parsed.diagnostics.is_empty() {
            Ok(parsed.document.clone())
        } else {
            Err(parsed.diagnostics.clone())
        }
    }

    /// Returns what a file's settled text was parsed to, even if parts of the text are invalid.
    pub(crate) fn parsed(&mut self, file: FileId, sources: &Sources, done: &mut Done) -> Arc<Parsed> {
        let mut parse = || {
            done.parsed += 1;
            Arc::new(document::parse(sources, file))
        };
        match self.paths.get(&file).and_then(|path| self.known.get_mut(path)) {
            Some(known) => known.parsed.get_or_insert_with(parse).clone(),
            None => parse(),
        }
    }

    /// Sets the unsaved text of a path; `None` removes it.
    pub(crate) fn overlay(&mut self, path: &Path, bytes: Option<Arc<[u8]>>, done: &mut Done) {
        let identity = self.storage.identity(path);
        match bytes {
            Some(bytes) => {
                let before = self.overlays.remove(&identity);
                let again = before.and_then(|before| match before.path == path {
                    true => before.again,
                    false => Some(before.path),
                });
                self.overlays.insert(identity.clone(), Overlay { path: path.to_owned(), bytes, again });
            }
            None => {
                self.overlays.remove(&identity);
            }
        }
        self.changed(&identity, done);
    }

    /// Reads a file again, under all known paths that lead to it.
    pub(crate) fn changed(&mut self, path: &Path, done: &mut Done) {
        let identity = self.storage.identity(path);
        let is_it = |known: &Known| known.identity == identity;
        let paths: Vec<PathBuf> =
            self.known.iter().filter(|(_, known)| is_it(known)).map(|(path, _)| path.clone()).collect();
        paths.iter().for_each(|path| self.again(path, done));
    }

    /// Reads all known files again.
    pub(crate) fn refresh(&mut self, done: &mut Done) {
        let paths: Vec<PathBuf> = self.known.keys().cloned().collect();
        paths.iter().for_each(|path| self.again(path, done));
    }

    fn again(&mut self, path: &Path, done: &mut Done) {
        let Some(known) = self.known.get(path) else { return };
        let (roots, role) = (known.roots.clone(), known.role);
        // A link may lead elsewhere by now.
        let identity = self.storage.identity(path);
        self.with_sources(|files, sources| {
            let _ = files.fetch(path, identity, roots, role, sources, done);
        });
    }

    fn fetch(
        &mut self,
        path: &Path,
        identity: PathBuf,
        roots: Option<Roots>,
        role: Role,
        sources: &mut Sources,
        done: &mut Done,
    ) -> Result<FileId, Diagnostic> {
        done.read += 1;
        let mut scratch = Sources::new();
        let may_read = roots.as_ref().is_none_or(|roots| self.storage.may_read(path, roots));
        let read = match self.overlays.get(&identity).filter(|_| may_read) {
            Some(overlay) => add_bytes(overlay.bytes.to_vec(), path.display().to_string(), &mut scratch),
            None => self.storage.read(path, roots.as_ref(), &mut scratch),
        };
        let (file, failure) = match read {
            Ok(file) => (Some(file), None),
            Err(diagnostic) => (diagnostic.span().map(|span| span.file), Some(diagnostic)),
        };
        let read = file.and_then(|file| scratch.get(file)).cloned();
        let revision = self.revision + 1;
        let known = self.known.entry(path.to_owned()).or_insert_with(|| Known {
            identity: identity.clone(),
            roots: roots.clone(),
            role,
            slot: None,
            failure: None,
            revision: 0,
            parsed: None,
            tokens: None,
            moved: None,
        });
        (known.identity, known.roots) = (identity, roots);
        let is_new = known.slot.is_none();
        if let (None, Some(file)) = (known.slot, &read) {
            let slot = sources.add(file.name(), file.text().clone());
            add_new(&mut self.current, sources);
            known.slot = Some(slot);
            self.paths.insert(slot, path.to_owned());
        }
        let failure = failure.map(|failure| match (failure.place.clone(), known.slot) {
            (Place::Span(span), Some(slot)) => {
                let mut failure = failure;
                failure.place = Span { file: slot, ..span }.into();
                failure
            }
            _ => failure,
        });
        let text_of = |sources: &Sources| {
            let file = known.slot.and_then(|slot| sources.get(slot));
            file.map(|file| file.text().clone())
        };
        let text = read.map(|file| file.text().clone());
        let is_same = !is_new && known.revision > 0 && failure == known.failure;
        if is_same && (text.is_none() || text == text_of(&self.current)) {
            return known.answer();
        }
        if let (Some(slot), Some(text)) = (known.slot, &text) {
            self.current.replace(slot, text.clone());
        }
        let mut scanned = None;
        // The same tokens, of a text that was a document.
        if let (true, None, Role::Document, Some(parsed), Some(text), Some(old)) =
            (is_same, &failure, known.role, &known.parsed, &text, text_of(sources))
            && parsed.diagnostics.is_empty()
            && let Some(new) = tokens(text)
        {
            done.compared += 1;
            if known.tokens.is_none() {
                known.tokens = tokens(&old);
            }
            if known.tokens.as_ref().is_some_and(|before| are_alike((before, &old), (&new, text))) {
                known.moved = (**text != *old).then_some(new);
                return known.answer();
            }
            scanned = Some(new);
        }
        if let (Some(slot), Some(text)) = (known.slot, text) {
            sources.replace(slot, text);
        }
        self.revision = revision;
        *known = Known {
            failure,
            revision,
            parsed: None,
            tokens: scanned,
            moved: None,
            identity: std::mem::take(&mut known.identity),
            roots: known.roots.take(),
            ..*known
        };
        known.answer()
    }

    /// Maps a source range in a settled text to the current text; `None` if it has no counterpart.
    pub(crate) fn place(&self, span: Span) -> Option<Span> {
        let known = self.paths.get(&span.file).and_then(|path| self.known.get(path));
        match known.and_then(|known| Some((known.tokens.as_ref()?, known.moved.as_ref()?))) {
            Some((from, to)) => moved(span, from, to),
            None => Some(span),
        }
    }

    /// Replaces the settled texts of files by their current texts, so that results based on these files are made again.
    pub(crate) fn settle(&mut self, reads: &[Read]) {
        for Read { path, .. } in reads {
            let Some(known) = self.known.get_mut(path) else { continue };
            let (Some(moved), Some(slot)) = (known.moved.take(), known.slot) else { continue };
            if let Some(file) = self.current.get(slot) {
                self.settled.replace(slot, file.text().clone());
            }
            self.revision += 1;
            (known.revision, known.parsed, known.tokens) = (self.revision, None, Some(moved));
        }
    }

    /// Returns warnings about files that were read under two paths, or have unsaved texts under two paths.
    pub(crate) fn twins(&self, reads: &[Read]) -> Diagnostics {
        let mut first: BTreeMap<&Path, &Path> = BTreeMap::new();
        let mut diagnostics = Diagnostics::new();
        for path in reads.iter().map(|read| read.path.as_path()) {
            let Some(known) = self.known.get(path).filter(|known| known.failure.is_none()) else { continue };
            let other = *first.entry(&known.identity).or_insert(path);
            let again = self.overlays.get(&known.identity).and_then(|overlay| overlay.again.as_deref());
            let names = [other, path].map(|path| path.display().to_string());
            if other != path {
                let message = format!("\"{}\" and \"{}\" are the same file", names[0], names[1]);
                let diagnostic = Diagnostic::in_file(codes::FILE_TWICE, &names[1], "", message);
                diagnostics.push(
                    diagnostic
                        .severity(crate::graph::diagnostic::Severity::Warning)
                        .help("name it by the same path everywhere"),
                );
            }
            if let (Some(again), Some(overlay)) = (again, self.overlays.get(&known.identity)) {
                let (first, last) = (again.display().to_string(), overlay.path.display().to_string());
                let message = format!(
                    "unsaved texts are given for \"{first}\" and for \"{last}\", which are the same file"
                );
                let diagnostic = Diagnostic::in_file(codes::FILE_TWICE, last, "", message);
                diagnostics.push(
                    diagnostic
                        .severity(crate::graph::diagnostic::Severity::Warning)
                        .help("the last text is used; close the other"),
                );
            }
        }
        diagnostics
    }
}

/// The settled texts of a table, lent to a function. They return to the table on drop, even after a panic.
struct Lent<'f> {
    files: &'f mut FileTable,
    sources: Sources,
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        self.files.settled = std::mem::take(&mut self.sources);
        add_new(&mut self.files.current, &self.files.settled);
    }
}

/// Adds to `sources` the texts that only `others` has.
fn add_new(sources: &mut Sources, others: &Sources) {
    let known = sources.iter().count();
    for (_, file) in others.iter().skip(known) {
        sources.add(file.name(), file.text().clone());
    }
}
