//! Several files to one document: `extends`, `include`, and extensions.
//!
//! - `"extends": "base.json"` (or a list, the first is the lowest): the base's document with this one laid over it.
//!   Objects are merged key by key, everything else is replaced, and `null` deletes what the base has. A base that
//!   several files extend is laid once, below all of them, so that it undoes nothing of theirs.
//! - `"include": ["parts.json"]`: the sections of another file beside one's own. Here nothing may stand twice: an
//!   include adds, it never changes.
//! - extensions: further files, named by the host, whose `inserts` put passes at the pipeline's extension points
//!   ([`insert`]).
//! - `"use": "parts/blur.json"`: a pass that is a subgraph in a file of its own.
//! - `"extends": "NAME"` of a pass: a group of `shared_settings` with the pass laid over it.
//!
//! Paths are relative to the folder of the file that names them; `umbragraph:NAME.json` is a file that comes with the
//! module. The result is one [`Document`] whose every value still
//! knows where it was written; what it replaced is kept in [`Composed::replaced`], so that `why` can tell all layers.
//!
//! Limits: 64 files, 32 levels; a file that leads back to itself is a diagnostic.

mod disk;
mod files;
mod format_number;
mod insert;
mod merge;
mod provenance;
mod roots;
mod shared_settings;
mod subgraphs;

pub use disk::{
    Disk, Named, Unreachable, files_below, find_below, meant_beside, read_bytes, read_source, unreadable,
};
pub use files::{Files, Memory, add_bytes};
pub use format_number::other_format;
pub use insert::insert;
pub use merge::SECTIONS;
pub use provenance::{SharedPlaces, as_written};
pub use roots::Roots;
pub use shared_settings::{is_incomplete, share};
pub use subgraphs::is_path;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

use crate::diagnostic::{Diagnostic, Diagnostics, codes, suggested_name};
use crate::document::{self, Document, Kind, Pointer, Value};
use crate::source::{FileId, Sources, Span};

const MAX_FILES: usize = 64;
const MAX_LEVELS: usize = 32;
/// The JSON pointer of the root of a document.
const TOP: Pointer<'_> = Pointer::Text("");

/// A document composed of several files, with the origin of its values.
#[derive(Clone, Debug)]
pub struct Composed {
    /// The composed document. Each value keeps the span at which it was written.
    pub document: Document,
    /// The spans of overridden values, newest first, by the JSON pointer of the value that was replaced or deleted.
    pub replaced: BTreeMap<String, Vec<Span>>,
    /// The span of the `null` that deleted a value, by the JSON pointer of that value.
    pub deleted: BTreeMap<String, Span>,
    /// The role of each file in the document.
    pub layers: BTreeMap<FileId, Layer>,
    /// The files of the document; the first is the pipeline file itself.
    pub files: Vec<FileId>,
    /// The keys under `subgraphs` that are paths of subgraph files.
    pub used: BTreeSet<String>,
}

/// The role of a file in a composed document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Layer {
    /// The pipeline file itself.
    Pipeline,
    /// A file that another file extends.
    Extended,
    /// A file that another file includes.
    Included,
    /// An extension file that the host application names, or a file that the extension is composed of.
    Extension,
    /// A subgraph file that a pass uses.
    Used,
}

impl Composed {
    /// Inserts an extension into the document, and adds its files and the origin of its values.
    pub fn insert(&mut self, mut extension: Composed, diagnostics: &mut Diagnostics) {
        // A file that both use is one subgraph.
        if let Some(members) = extension.document.root.entries_of_mut("subgraphs") {
            members.retain(|member| !self.used.contains(&member.key));
        }
        self.used.append(&mut extension.used);
        let inserted = |pointer: String| match pointer.strip_prefix("/inserts/") {
            Some(below) => format!("/passes/{}", below.split_once('/').map_or("", |(_, pass)| pass)),
            None => pointer,
        };
        for (pointer, older) in extension.replaced {
            self.replaced.entry(inserted(pointer)).or_default().extend(older);
        }
        self.deleted.extend(extension.deleted.into_iter().map(|(pointer, place)| (inserted(pointer), place)));
        self.layers.extend(extension.files.iter().map(|file| (*file, Layer::Extension)));
        self.files.extend(extension.files);
        let merge::Changes { replaced, deleted } =
            insert::put_in(&mut self.document.root, extension.document.root, diagnostics);
        for (pointer, older) in replaced {
            let known = self.replaced.entry(pointer).or_default();
            known.splice(..0, older);
        }
        self.deleted.extend(deleted);
    }

    /// Adds the sections of another document, as the key `"include"` does. A member that exists in both documents is an
    /// error.
    pub fn include(&mut self, part: Composed, diagnostics: &mut Diagnostics) {
        self.layers.extend(part.files.iter().map(|file| (*file, Layer::Included)));
        self.files.extend(part.files);
        merge::beside(&mut self.document.root, part.document.root, diagnostics);
    }
}

/// Composes a registered file with the files that it extends, includes or uses into one document. Paths in a file are
/// relative to the folder of the file; `path` is the path of the registered file. Returns `None` if composing fails;
/// `diagnostics` then has errors.
pub fn compose(
    file: FileId,
    path: &Path,
    files: &mut dyn Files,
    sources: &mut Sources,
    diagnostics: &mut Diagnostics,
) -> Option<Composed> {
    compose_as((file, path), files, sources, diagnostics, false)
}

/// Composes as much of a document as can be understood, even where [`compose`] returns `None`. Editors need this while
/// a file is incomplete. Diagnostics are discarded; [`compose`] reports them.
pub fn compose_understood(
    file: FileId,
    path: &Path,
    files: &mut dyn Files,
    sources: &mut Sources,
) -> Option<Composed> {
    compose_as((file, path), files, sources, &mut Diagnostics::new(), true)
}

fn compose_as(
    (file, path): (FileId, &Path),
    files: &mut dyn Files,
    sources: &mut Sources,
    diagnostics: &mut Diagnostics,
    is_lenient: bool,
) -> Option<Composed> {
    let mut composer = Composer {
        files,
        sources,
        diagnostics,
        is_lenient,
        seen: Vec::new(),
        chain: Vec::new(),
        changes: merge::Changes::default(),
        layers: BTreeMap::from([(file, Layer::Pipeline)]),
        paths: BTreeSet::new(),
        laid: BTreeSet::new(),
        read: BTreeMap::new(),
    };
    let bundled = path.to_str().and_then(|name| with_scheme(composer.files, name));
    let mut root = composer.file(file, bundled.as_deref().unwrap_or(path), None)?;
    let used = composer.use_files(&mut root)?;
    // The passes of an extension take over what the pipeline shares, too, once they are there.
    if root.get("inserts").is_none() {
        let Composer { changes, diagnostics, .. } = &mut composer;
        shared_settings::take_over(&mut root, &|_, _| true, changes, diagnostics);
    }
    let merge::Changes { replaced, deleted } = composer.changes;
    let (layers, files) = (composer.layers, composer.seen);
    Some(Composed { document: Document { root }, replaced, deleted, layers, files, used })
}

struct Composer<'a> {
    files: &'a mut dyn Files,
    sources: &'a mut Sources,
    diagnostics: &'a mut Diagnostics,
    /// Whether broken or missing parts are left out instead of being errors.
    is_lenient: bool,
    seen: Vec<FileId>,
    /// The paths of the files that lead to the current file, each with the span that names the next file.
    chain: Vec<(PathBuf, Option<Span>)>,
    changes: merge::Changes,
    layers: BTreeMap<FileId, Layer>,
    /// The normalized paths of the files that are merged by `extends` and `include`.
    paths: BTreeSet<PathBuf>,
    /// The paths of the base files already applied below the current file.
    laid: BTreeSet<PathBuf>,
    /// The files read so far by path, so that none is read twice.
    read: BTreeMap<PathBuf, FileId>,
}

impl Composer<'_> {
    /// Composes a file: the file overrides its base files, and the result overrides `below`, the base files that were
    /// composed before.
    fn file(&mut self, file: FileId, path: &Path, below: Option<Value>) -> Option<Value> {
        self.seen.push(file);
        self.paths.insert(normalize(path));
        self.chain.push((path.to_owned(), None));
        let root = self.parse(file).and_then(|root| self.compose_value(root, path, below));
        self.chain.pop();
        root
    }

    fn parse(&mut self, file: FileId) -> Option<Value> {
        if self.is_lenient {
            return Some(self.files.recover(file, self.sources).root);
        }
        let parsed = self.files.parse(file, self.sources);
        parsed.map_err(|diagnostics| self.diagnostics.extend(diagnostics)).ok().map(|document| document.root)
    }

    fn compose_value(&mut self, mut root: Value, path: &Path, mut below: Option<Value>) -> Option<Value> {
        if let ([.., (_, Some(place)), _], Some(_), false) =
            (&self.chain[..], root.get("inputs"), self.is_lenient)
        {
            let message =
                "this is a subgraph (it has \"inputs\"), and a pipeline extends or includes pipelines";
            let help = "use it in a pass: { \"use\": \"PATH\", \"with\": { … } }";
            self.diagnostics.push(Diagnostic::error(codes::WRONG_TYPE, *place, message).help(help));
            return None;
        }
        let other = other_format(&root);
        let is_unreadable = other.is_some();
        self.diagnostics.extend(other);
        if (is_unreadable || self.misspells_a_file_key(&root)) && !self.is_lenient {
            return None;
        }
        let bases = self.named_files(&root, "extends");
        let parts = self.named_files(&root, "include");
        if let Kind::Object(entries) = &mut root.kind {
            entries.retain(|entry| entry.key != "extends" && entry.key != "include");
        }
        subgraphs::resolve(self.files, &mut root, path);
        let mut fine = true;
        let extends = !bases.is_empty();
        for (name, place) in bases {
            let before = below.as_ref().filter(|_| self.is_lenient).cloned();
            below = self.follow(&name, place, path, Layer::Extended, below).or(before);
            fine &= below.is_some();
        }
        // What a base that could not be read has is not known.
        if !extends {
            merge::reject_deletions(&mut root, &TOP, &self.changes, self.diagnostics);
        }
        let mut merged = match below {
            None => root,
            Some(below) => merge::over(below, root, &TOP, &mut self.changes, self.diagnostics),
        };
        for (name, place) in parts {
            let laid = std::mem::take(&mut self.laid);
            match self.follow(&name, place, path, Layer::Included, None) {
                Some(value) => merge::beside(&mut merged, value, self.diagnostics),
                None => fine = false,
            }
            self.laid = laid;
        }
        (fine || self.is_lenient).then_some(merged)
    }

    /// Reports keys that look like a misspelt `extends` or `include`. Returns `true` if there are any. Without the
    /// files that they name, no other check makes sense.
    fn misspells_a_file_key(&mut self, root: &Value) -> bool {
        let entries = root.entries().unwrap_or_default();
        let is_there = |name: &str| entries.iter().any(|entry| entry.key == name);
        let known = || ["extends", "include"].into_iter().chain(merge::SECTIONS.iter().copied());
        let mut found = false;
        for entry in entries.iter().filter(|entry| !known().any(|name| name == entry.key)) {
            let names_files = matches!(suggested_name(&entry.key, known()), Some("extends" | "include"));
            let suggested =
                suggested_name(&entry.key, known()).filter(|suggested| names_files && !is_there(suggested));
            let holds_paths = matches!(entry.value.kind, Kind::Text(_) | Kind::Array(_));
            if suggested.is_some() && holds_paths {
                found = true;
                let message = format!("unknown key \"{}\"", entry.key);
                let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, entry.key_span, message)
                    .pointer(document::pointer_join("", &entry.key))
                    .suggest_unless(&entry.key, known(), Some(entry.key_span), is_there, |_| String::new());
                self.diagnostics.push(diagnostic);
            }
        }
        found
    }

    /// Returns the paths that a document names under the key `key`, as a string or a list of strings, each with its
    /// span.
    fn named_files(&mut self, root: &Value, key: &str) -> Vec<(String, Span)> {
        let Some(value) = root.get(key) else { return Vec::new() };
        let list = match &value.kind {
            Kind::Array(elements) => elements.as_slice(),
            _ => std::slice::from_ref(value),
        };
        let mut names = Vec::new();
        for value in list {
            match value.text() {
                Some(name) => names.push((name.to_owned(), value.span)),
                None => {
                    let message = format!("a path is wanted here, this is {}", value.kind_name());
                    self.diagnostics.push(
                        Diagnostic::error(codes::WRONG_TYPE, value.span, message)
                            .pointer(format!("/{key}"))
                            .help("write the path of a file, relative to the folder of this one"),
                    );
                }
            }
        }
        names
    }

    fn follow(
        &mut self,
        name: &str,
        place: Span,
        from: &Path,
        layer: Layer,
        below: Option<Value>,
    ) -> Option<Value> {
        let path = path_in(self.files, from.parent().unwrap_or_else(|| Path::new("")), name);
        if let Some(at) = self.chain.iter().position(|(known, _)| normalize(known) == path) {
            let diagnostic =
                Diagnostic::error(codes::FILE_CYCLE, place, format!("\"{name}\" leads back to itself"));
            let diagnostic = diagnostic.help(match self.chain.len() - at {
                1 => "remove it: this is the file itself",
                _ => "take what both need into a third file",
            });
            let way = self.chain[at..].iter().filter_map(|(_, place)| *place);
            self.diagnostics.push(way.fold(diagnostic, |error, place| error.related(place, "on the way")));
            return None;
        }
        if self.seen.len() >= MAX_FILES || self.chain.len() >= MAX_LEVELS {
            self.too_many_files(place);
            return None;
        }
        if !self.laid.insert(path.clone()) {
            return below;
        }
        let file = self.read(&path, place)?;
        self.layers.insert(file, layer);
        if let Some((_, named)) = self.chain.last_mut() {
            *named = Some(place);
        }
        self.file(file, &path, below)
    }

    fn too_many_files(&mut self, place: Span) {
        let message = format!("a pipeline is made of at most {MAX_FILES} files on {MAX_LEVELS} levels");
        let diagnostic = Diagnostic::error(codes::FILE_CYCLE, place, message);
        self.diagnostics.push(diagnostic.help("join some of the files"));
    }

    /// Reads the file at `path`, or returns it if it was read before. Errors are reported at `place`, where the path is
    /// written.
    fn read(&mut self, path: &Path, place: Span) -> Option<FileId> {
        if let Some(known) = self.read.get(path) {
            return Some(*known);
        }
        let result = self.files.read(path, self.sources);
        let rejected = |mut diagnostic: Diagnostic| {
            diagnostic.place = place.into();
            if diagnostic.code == codes::FILE_UNREADABLE
                && path.to_str().and_then(|name| with_scheme(self.files, name)).is_none()
                && !diagnostic.has_suggestion()
            {
                diagnostic.help =
                    Some("paths are relative to the folder of the file that names them".to_owned());
            }
            self.diagnostics.push(diagnostic);
        };
        let file = result.map_err(rejected).ok()?;
        self.read.insert(path.to_owned(), file);
        Some(file)
    }
}

/// Resolves a file name written in a file of `folder`: relative to `folder`, unless the name has a scheme.
fn path_in(files: &dyn Files, folder: &Path, name: &str) -> PathBuf {
    normalize(&with_scheme(files, name).unwrap_or_else(|| folder.join(name)))
}

/// Returns the path of a name with a scheme that `files` knows, such as `umbragraph:`, with the scheme as first folder.
/// `None` for other names.
fn with_scheme(files: &dyn Files, name: &str) -> Option<PathBuf> {
    let (scheme, rest) = name.split_once(':')?;
    files.has_scheme(scheme).then(|| Path::new(&format!("{scheme}:")).join(rest.trim_start_matches('/')))
}

/// Removes `.` components from a path, and `..` components together with the folder before them.
pub fn normalize(path: &Path) -> PathBuf {
    let mut clean = PathBuf::new();
    for component in path.components() {
        match component {
            Component::CurDir => {}
            Component::ParentDir if matches!(clean.components().next_back(), Some(Component::Normal(_))) => {
                clean.pop();
            }
            other => clean.push(other),
        }
    }
    // Nothing is left of the folder itself, and nothing would be a name to show.
    if clean.as_os_str().is_empty() { PathBuf::from(".") } else { clean }
}
