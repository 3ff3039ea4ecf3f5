//! The file of a lock: held to what is reached, or written.
//!
//! A run concerns the pipelines that it is given; what the lock says of others stays, unless their files are gone. A
//! lock that cannot be read, such as one with the marks of a merge conflict, is written anew if the run is given every
//! pipeline that it names.

use std::collections::{BTreeMap, BTreeSet};
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use umbragraph::diagnostic::{Diagnostic, Place};
use umbragraph::low_level::compose::{normalize, read_bytes};
use umbragraph::low_level::source::Span;

use super::text::Invalid;
use super::{Change, Lock, Parsed, difference, is_notable};
use crate::codes;
use crate::replace::replace;
use crate::session::Session;

/// The maximum size in bytes of a lock file.
const MAX_BYTES: u64 = 64 << 20;

/// The path of the lock file if the command line names none.
pub(crate) const DEFAULT: &str = "permutations.lock";

/// The path of a lock file.
pub(crate) struct LockFile<'p> {
    path: &'p Path,
}

/// The source places of passes, by the names of pipeline and pass.
pub(crate) type PassPlaces = BTreeMap<(String, String), Span>;

/// Lines of templates, each with its share of the cost.
type Expensive = Vec<(Span, u64)>;

/// The source places of passes and of expensive lines that diagnostics show.
pub(crate) struct Shown<'a> {
    pub(crate) places: &'a PassPlaces,
    /// Returns the most expensive template lines in the most expensive shader variant of a pass, from the names of the
    /// pipeline and the pass.
    pub(crate) expensive: &'a dyn Fn(&str, &str) -> Expensive,
}

impl Shown<'_> {
    /// Adds the most expensive template lines to a diagnostic about the cost of a pass.
    pub(crate) fn with_lines(&self, diagnostic: Diagnostic, pipeline: &str, pass: &str) -> Diagnostic {
        let add = |diagnostic: Diagnostic, (line, cost): (Span, u64)| {
            diagnostic.related(line, format!("{cost} of the cost is here"))
        };
        (self.expensive)(pipeline, pass).into_iter().fold(diagnostic, add)
    }
}

impl<'p> LockFile<'p> {
    pub(crate) fn new(path: &'p Path) -> Self {
        Self { path }
    }

    /// Returns the name of a pipeline in the lock file: its path relative to the lock file's folder.
    pub(crate) fn name_of(&self, pipeline: &Path) -> String {
        let slashed = |path: &Path| path.display().to_string().replace('\\', "/");
        let plain = |path: &Path| Some(normalize(&std::path::absolute(path).ok()?));
        let is_bundled = pipeline.to_string_lossy().starts_with("umbragraph:");
        let (Some(own), Some(path)) = (plain(self.path), plain(pipeline).filter(|_| !is_bundled)) else {
            return slashed(pipeline);
        };
        let folder = own.parent().unwrap_or(Path::new(""));
        let shared = folder.components().zip(path.components()).take_while(|(a, b)| a == b).count();
        if shared == 0 {
            return slashed(&path);
        }
        let up = folder.components().skip(shared).map(|_| Component::ParentDir);
        slashed(&up.chain(path.components().skip(shared)).collect::<PathBuf>())
    }

    /// Normalizes a pipeline's name in the file, which may be written as any relative path.
    pub(crate) fn usual(&self, name: &str) -> String {
        match name.starts_with("umbragraph:") {
            true => name.to_owned(),
            false => self.name_of(&self.path.parent().unwrap_or(Path::new("")).join(name)),
        }
    }

    /// Returns `true` if the pipeline with this name in the lock file exists on disk, or is bundled with the command.
    pub(crate) fn exists(&self, name: &str) -> bool {
        name.starts_with("umbragraph:") || self.path.parent().unwrap_or(Path::new("")).join(name).is_file()
    }

    /// Returns the help text with the command that writes the lock file.
    fn mend(&self) -> String {
        let is_default = self.path == Path::new(DEFAULT);
        let lock = if is_default { String::new() } else { format!(" --lock {}", self.name()) };
        format!("`umbragraph permutations PIPELINE... --update{lock}` writes it")
    }

    fn name(&self) -> String {
        self.path.display().to_string()
    }

    /// Reads the text of the lock file; `None` if the file does not exist.
    fn text(&self) -> Result<Option<String>, Diagnostic> {
        let failed = |reason: String| {
            let message = format!("the lock \"{}\" cannot be read: {reason}", self.name());
            Diagnostic::in_file(codes::LOCK_INVALID, self.name(), "", message).help(self.mend())
        };
        match read_bytes(self.path, MAX_BYTES) {
            Ok(Some(bytes)) => {
                String::from_utf8(bytes).map(Some).map_err(|_| failed("it is not UTF-8".to_owned()))
            }
            Ok(None) => Err(failed(format!("it has more than {MAX_BYTES} bytes"))),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(failed(error.to_string())),
        }
    }

    /// Returns the differences between the lock file and the reachable shaders. Includes locked pipelines whose files
    /// no longer exist.
    fn changes(&self, lock: &Lock, reached: &Lock) -> Vec<Change> {
        let mut before = lock.clone();
        before.pipelines.retain(|name, _| reached.pipelines.contains_key(name) || !self.exists(name));
        difference(&before, reached)
    }

    /// Returns `true` if the lock file exists and has no difference from the reachable shaders.
    pub(crate) fn is_held(&self, reached: &Lock) -> bool {
        let text = self.text().ok().flatten();
        let parsed = text.and_then(|text| Parsed::new(&text).ok());
        parsed.is_some_and(|parsed| self.changes(&parsed.lock, reached).is_empty())
    }
}

/// Reads and parses a lock file, and adds its text to the session's sources; `None` if the file does not exist.
///
/// # Errors
/// A file that is no valid lock file.
pub(crate) fn read(session: &mut Session, path: &Path) -> Result<Option<(Parsed, Span)>, Diagnostic> {
    let file = LockFile::new(path);
    let Some(text) = file.text()? else { return Ok(None) };
    let whole = session.text_of(&file.name(), &text);
    match Parsed::new(&text) {
        Ok(parsed) => Ok(Some((parsed, whole))),
        Err(Invalid { range, message, .. }) => {
            Err(Diagnostic::error(codes::LOCK_INVALID, whole.inside(range), message).help(file.mend()))
        }
    }
}

/// Compares the reachable shaders with the lock file, and adds a diagnostic for each difference.
pub(crate) fn hold(session: &mut Session, file: &LockFile<'_>, reached: &Lock, shown: &Shown<'_>) {
    let (parsed, whole) = match read(session, file.path) {
        Ok(Some(found)) => found,
        Ok(None) => {
            let message = format!("there is no lock \"{}\"", file.name());
            let missing = Diagnostic::in_file(codes::LOCK_DIFFERS, file.name(), "", message);
            session.diagnostics.push(missing.help(format!("{}; commit it", file.mend())));
            return;
        }
        Err(diagnostic) => {
            session.diagnostics.push(diagnostic);
            return;
        }
    };
    for Change { pipeline, pass, message } in file.changes(&parsed.lock, reached) {
        let key = pass.map(|pass| (pipeline.clone(), pass));
        let line = key.as_ref().and_then(|key| parsed.passes.get(key));
        let line = line.or_else(|| parsed.pipelines.get(&pipeline)).map(|line| whole.inside(line.clone()));
        let of_pass = key.as_ref().and_then(|key| shown.places.get(key)).copied();
        let whole_file = || Place::File { path: pipeline.clone(), locator: String::new() };
        let place = of_pass.or(line).map_or_else(whole_file, Place::Span);
        let mut difference = Diagnostic::error(codes::LOCK_DIFFERS, place, message)
            .help(format!("if it is meant, replace --locked by --update, and commit \"{}\"", file.name()));
        if let (Some(_), Some(line)) = (of_pass, line) {
            difference = difference.related(line, "the lock has other figures");
        }
        if let Some((pipeline, pass)) = key.filter(|key| costs_more(&parsed.lock, reached, key)) {
            difference = shown.with_lines(difference, &pipeline, &pass);
        }
        session.diagnostics.push(difference);
    }
}

/// Returns `true` if a pass costs notably more than before for some profile.
fn costs_more(before: &Lock, after: &Lock, (pipeline, pass): &(String, String)) -> bool {
    let costs = |lock: &Lock| -> BTreeMap<String, u64> {
        let programs = lock.pipelines.get(pipeline).into_iter().flat_map(|one| &one.programs);
        let own = programs.filter(|((name, _), _)| name == pass).flat_map(|(_, profiles)| profiles);
        own.map(|(profile, texts)| (profile.clone(), texts.worst.cost)).collect()
    };
    let before = costs(before);
    costs(after).iter().any(|(profile, cost)| before.get(profile).is_some_and(|old| is_notable(*old, *cost)))
}

/// Writes the reachable shaders of some pipelines into the lock file, and returns a description of the differences.
///
/// # Errors
/// A file that cannot be written, or that names further pipelines and cannot be read.
pub(crate) fn update(file: &LockFile<'_>, reached: &Lock) -> Result<String, Diagnostic> {
    let name = file.name();
    let text = file.text()?;
    let before = match text.as_deref().map(Parsed::new) {
        None => Lock::default(),
        Some(Ok(parsed)) => parsed.lock,
        Some(Err(invalid)) => {
            let is_lost = |name: &&String| !reached.pipelines.contains_key(*name) && file.exists(name);
            let lost: BTreeSet<&str> = invalid.pipelines.iter().filter(is_lost).map(String::as_str).collect();
            if !lost.is_empty() {
                let lost = lost.into_iter().collect::<Vec<_>>().join(" ");
                let message = format!("the lock \"{name}\" cannot be kept: {}", invalid.message);
                let help = format!("name these pipelines too: {lost}");
                return Err(Diagnostic::in_file(codes::LOCK_INVALID, name, "", message).help(help));
            }
            Lock::default()
        }
    };
    let mut lock = before.clone();
    lock.pipelines.retain(|name, _| file.exists(name));
    lock.pipelines.extend(reached.pipelines.clone());
    let new = lock.text();
    if text.is_some_and(|old| old.replace("\r\n", "\n") == new) {
        return Ok(format!("{name}: unchanged\n"));
    }
    replace(file.path, &new)?;
    let change = |Change { pipeline, message, .. }: Change| format!("{pipeline}: {message}\n");
    let changes: String = difference(&before, &lock).into_iter().map(change).collect();
    Ok(format!("{changes}{name}: written\n"))
}
