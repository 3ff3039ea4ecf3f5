//! Sources of the texts that a document names: the disk, memory, or a host's own [`Files`].
//!
//! [`Disk`] reads what lies below its [`Roots`]. [`read_bytes`] is all that opens files: regular ones alone, since a pipe
//! may wait for ever and a device never end, and no more of them than is wanted, whatever they say of their size.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::roots::{Roots, Unreachable};
use crate::diagnostic::{DID_YOU_MEAN, Diagnostic, Diagnostics, codes, suggested_name};
use crate::document::{self, Document};
use crate::source::{FileId, MAX_FILE_BYTES, Sources, Span};

/// Finds the texts that a document names.
pub trait Files {
    /// Reads and registers the text at a path.
    ///
    /// # Errors
    /// A diagnostic without a place worth naming; the caller adds where the path is named.
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic>;

    /// The document of a registered text.
    ///
    /// # Errors
    /// Diagnostics of a text that is no document.
    fn parse(&mut self, file: FileId, sources: &Sources) -> Result<Document, Diagnostics> {
        document::parse(sources, file).valid()
    }

    /// Whether names that begin with a word and `:` are no paths of folders, but names of this.
    fn has_scheme(&self, _scheme: &str) -> bool {
        false
    }
}

/// The files of the file system below some folders.
#[derive(Clone, Debug, Default)]
pub struct Disk(pub Roots);

impl Files for Disk {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let name = path.display().to_string();
        match self.0.find(path) {
            Ok(found) => read_as(&found, name, sources),
            Err(Unreachable::Failed(error)) => {
                let folder = self.0.find(folder_of(path)).ok();
                let meant = folder.and_then(|folder| meant_in(&folder, path, &DOCUMENTS));
                Err(with_meant(unreadable(&name, &error), meant))
            }
            Err(Unreachable::Outside) => {
                let message = format!("the file \"{name}\" is outside of the folders that may be read");
                Err(Diagnostic::in_file(codes::FILE_OUTSIDE, &name, "", message).help(
                    "documents read below the working folder and their own; name another folder with --root",
                ))
            }
        }
    }
}

/// The file system, for what the host names itself, wherever it lies.
#[derive(Clone, Copy, Debug)]
pub struct Named;

impl Files for Named {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        read_source(path, sources).map_err(|diagnostic| {
            let meant = if path.exists() { None } else { meant_beside(path, &DOCUMENTS) };
            with_meant(diagnostic, meant)
        })
    }
}

/// The deepest folder that [`files_below`] looks into.
const MAX_DEPTH: usize = 16;

/// The files below a folder whose names end in one of some ways, each with its path below it (with `/`), in the order of
/// these. Links to folders are not followed: they may lead in a cycle.
///
/// # Errors
/// A folder that cannot be read.
pub fn files_below(folder: &Path, ends: &[&str]) -> Result<Vec<(String, PathBuf)>, Diagnostic> {
    let mut files = Vec::new();
    collect((folder, String::new()), ends, &mut files, 0).map_err(|(name, error)| {
        let message = format!("the folder \"{name}\" cannot be read: {error}");
        Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message)
            .help("paths are relative to the current folder")
    })?;
    files.sort();
    Ok(files)
}

fn collect(
    (folder, prefix): (&Path, String),
    ends: &[&str],
    files: &mut Vec<(String, PathBuf)>,
    depth: usize,
) -> Result<(), (String, std::io::Error)> {
    let unreadable = |error| (folder.display().to_string(), error);
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let entry = entry.map_err(unreadable)?;
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.file_type().map_err(unreadable)?.is_dir() {
            if depth < MAX_DEPTH {
                collect((&entry.path(), name + "/"), ends, files, depth + 1)?;
            }
        } else if ends.iter().any(|end| name.ends_with(end)) {
            files.push((name, entry.path()));
        }
    }
    Ok(())
}

/// Texts in memory, by path.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub BTreeMap<String, String>);

impl Files for Memory {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let name = path.to_string_lossy().replace('\\', "/");
        match self.0.get(&name) {
            Some(text) => Ok(sources.add(name, text.as_str())),
            None => {
                let message = format!("the file \"{name}\" cannot be read: it does not exist");
                let diagnostic = Diagnostic::in_file(codes::FILE_UNREADABLE, &name, "", message)
                    .help("paths are relative to the folder of the file that names them");
                let beside = self.0.keys().map(Path::new).filter(|known| known.parent() == path.parent());
                let names = beside.filter_map(|known| known.file_name()?.to_str());
                Err(with_meant(diagnostic, meant_among(names, path, &DOCUMENTS)))
            }
        }
    }
}

/// Of a folder so many files are compared with the name of one that is not there.
const MAX_BESIDE: usize = 1000;

/// The endings of the names of documents.
const DOCUMENTS: [&str; 2] = [".json", ".jsonc"];

/// The help for a file that is not there: the one beside it, of those whose names end in one of some ways, that was
/// probably meant.
pub fn meant_beside(path: &Path, ends: &[&str]) -> Option<String> {
    meant_in(folder_of(path), path, ends)
}

fn meant_in(folder: &Path, path: &Path, ends: &[&str]) -> Option<String> {
    let entries = std::fs::read_dir(folder).ok()?.take(MAX_BESIDE).flatten();
    let names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    meant_among(names.iter().map(String::as_str), path, ends)
}

fn meant_among<'n>(names: impl Iterator<Item = &'n str>, path: &Path, ends: &[&str]) -> Option<String> {
    let names = names.filter(|name| ends.iter().any(|end| name.ends_with(end)));
    let meant = suggested_name(path.file_name()?.to_str()?, names.collect::<BTreeSet<_>>())?;
    Some(format!("{DID_YOU_MEAN} \"{meant}\", which lies beside it?"))
}

fn with_meant(diagnostic: Diagnostic, meant: Option<String>) -> Diagnostic {
    Diagnostic { help: meant.or(diagnostic.help), ..diagnostic }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

/// Reads and registers a text file that the host names itself; diagnostics show it by the path as given.
///
/// # Errors
/// A file that cannot be read, is too large, or is not UTF-8.
pub fn read_source(path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
    read_as(path, path.display().to_string(), sources)
}

fn read_as(path: &Path, name: String, sources: &mut Sources) -> Result<FileId, Diagnostic> {
    let bytes = match read_bytes(path, MAX_FILE_BYTES as u64) {
        Ok(Some(bytes)) => bytes,
        Ok(None) => return Err(too_large(&name)),
        Err(error) => return Err(unreadable(&name, &error)),
    };
    add_bytes(bytes, name, sources)
}

/// Registers the bytes of a text under a name.
///
/// # Errors
/// Bytes that are not UTF-8; they are registered as far as they can be shown. More bytes than texts have.
pub fn add_bytes(bytes: Vec<u8>, name: String, sources: &mut Sources) -> Result<FileId, Diagnostic> {
    if bytes.len() > MAX_FILE_BYTES {
        return Err(too_large(&name));
    }
    match String::from_utf8(bytes) {
        // Some editors begin UTF-8 with a byte-order mark; it is no part of the text.
        Ok(text) => Ok(sources.add(name, text.strip_prefix('\u{feff}').unwrap_or(&text))),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            let file = sources.add(name.clone(), text);
            let message = format!("the file \"{name}\" is not UTF-8");
            Err(Diagnostic::error(codes::FILE_NOT_UTF8, Span::new(file, at..at + 1), message)
                .help("save it as UTF-8"))
        }
    }
}

/// The bytes of a regular file; `None` where there are more than `max`.
///
/// # Errors
/// A path to something other than a regular file, an error of the system, and a file that changed while it was read:
/// its beginning and its end may be of two texts.
pub fn read_bytes(path: &Path, max: u64) -> std::io::Result<Option<Vec<u8>>> {
    let check = |metadata: &std::fs::Metadata| match (metadata.is_file(), metadata.is_dir()) {
        (true, _) => Ok((metadata.len(), metadata.modified().ok())),
        (_, true) => Err(std::io::Error::other("it is a folder")),
        _ => Err(std::io::Error::other("it is no regular file")),
    };
    // To open a pipe is to wait for who writes it.
    if check(&std::fs::metadata(path)?)?.0 > max {
        return Ok(None);
    }
    let file = std::fs::File::open(path)?;
    read_unchanged(&file, || check(&file.metadata()?), max)
}

/// Reads to the end, if the state of what is read (its length and when it was written) is the same before and after.
fn read_unchanged<S: PartialEq>(
    file: impl std::io::Read,
    state: impl Fn() -> std::io::Result<S>,
    max: u64,
) -> std::io::Result<Option<Vec<u8>>> {
    let before = state()?;
    let mut bytes = Vec::new();
    file.take(max.saturating_add(1)).read_to_end(&mut bytes)?;
    if state()? != before {
        return Err(std::io::Error::other("it changed while it was read"));
    }
    Ok((bytes.len() as u64 <= max).then_some(bytes))
}

fn too_large(name: &str) -> Diagnostic {
    let message = format!("the file \"{name}\" has more than {MAX_FILE_BYTES} bytes");
    Diagnostic::in_file(codes::FILE_TOO_LARGE, name, "", message)
        .help(format!("texts have at most {MAX_FILE_BYTES} bytes"))
}

fn unreadable(name: &str, error: &std::io::Error) -> Diagnostic {
    let reason = match error.kind() {
        std::io::ErrorKind::NotFound => "it does not exist".to_owned(),
        std::io::ErrorKind::PermissionDenied => "permission is denied".to_owned(),
        _ => error.to_string(),
    };
    let message = format!("the file \"{name}\" cannot be read: {reason}");
    Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message)
        .help("paths are relative to the current folder")
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn file_that_changes_while_it_is_read_is_an_error() {
        let looks = Cell::new(0);
        let state = || Ok(looks.replace(looks.get() + 1));
        let error = read_unchanged(&b"text"[..], state, 9).unwrap_err();
        assert_eq!(error.to_string(), "it changed while it was read");
        assert_eq!(read_unchanged(&b"text"[..], || Ok(0), 9).unwrap().unwrap(), b"text");
        assert!(read_unchanged(&b"text"[..], || Ok(0), 3).unwrap().is_none());
    }
}
