//! The file system: documents below their [`Roots`], and what the host names itself.
//!
//! A path is taken as the system takes it, `..` and links resolved, before it is compared with the roots; what lies
//! elsewhere is never opened, nor said to exist or not. [`read_bytes`] is all that opens files: regular ones alone,
//! since a pipe may wait for ever and a device never end, and no more of them than is wanted, whatever they say of
//! their size.
//!
//! Limits: whoever changes the folders while a document is read can exchange a file between the look at its path and
//! its opening.

use std::io::Read as _;
use std::path::{Component, Path, PathBuf};

use super::files::{DOCUMENTS, Files, add_bytes, meant_among, too_large, with_meant};
use super::roots::Roots;
use crate::diagnostic::{DID_YOU_MEAN, Diagnostic, codes, suggested_name};
use crate::source::{FileId, MAX_FILE_BYTES, Sources};

/// A source of files on disk that only reads files below its root folders.
#[derive(Clone, Debug, Default)]
pub struct Disk(pub Roots);

impl Files for Disk {
    fn read(&mut self, path: &Path, sources: &mut Sources) -> Result<FileId, Diagnostic> {
        let name = path.display().to_string();
        match find_below(&self.0, path) {
            Ok(found) => read_as(&found, name, sources),
            Err(Unreachable::Failed(error)) => {
                let folder = find_below(&self.0, folder_of(path)).ok();
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

/// A source of files on disk without a check against root folders, for paths that the host application passes itself.
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

/// The maximum depth of folders that [`files_below`] searches.
const MAX_DEPTH: usize = 16;

/// Returns the files below a folder whose names end in one of `ends`, sorted. Each has its path relative to `folder`,
/// with `/` as separator, and its path on disk. Links to folders are not followed, since they may form a cycle.
///
/// # Errors
/// A folder that cannot be read.
pub fn files_below(folder: &Path, ends: &[&str]) -> Result<Vec<(String, PathBuf)>, Diagnostic> {
    let mut files = Vec::new();
    collect((folder, String::new()), ends, &mut files, 0).map_err(|(name, error)| {
        let message = format!("the folder \"{name}\" cannot be read: {error}");
        let help = folder_beside(Path::new(&name))
            .map(|meant| format!("{DID_YOU_MEAN} \"{meant}\", which lies beside it?"))
            .unwrap_or_else(|| "paths are relative to the current folder".to_owned());
        Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message).help(help)
    })?;
    files.sort();
    Ok(files)
}

/// Returns the name of the folder beside a missing one that is most like it; `None` if the folder exists, or if no name
/// is similar.
fn folder_beside(folder: &Path) -> Option<String> {
    let wanted = folder.file_name()?.to_str()?;
    let entries = std::fs::read_dir(folder_of(folder)).ok().filter(|_| !folder.exists())?.take(MAX_BESIDE);
    let folders = entries.flatten().filter(|entry| entry.path().is_dir());
    let names: Vec<String> = folders.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    suggested_name(wanted, names.iter().map(String::as_str)).map(str::to_owned)
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

/// The maximum number of files in a folder that are compared with the name of a missing file.
const MAX_BESIDE: usize = 1000;

/// Returns a help text for the missing file `path`. It suggests the most similar file name in the same folder that ends
/// in one of `ends`. `None` if no name is similar.
pub fn meant_beside(path: &Path, ends: &[&str]) -> Option<String> {
    meant_in(folder_of(path), path, ends)
}

fn meant_in(folder: &Path, path: &Path, ends: &[&str]) -> Option<String> {
    let entries = std::fs::read_dir(folder).ok()?.take(MAX_BESIDE).flatten();
    let names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    meant_among(names.iter().map(String::as_str), path, ends)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
}

/// Reads and registers a text file whose path the host application passes itself, without a check against root folders.
/// Diagnostics show the path as given.
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

/// The reason why a path cannot be resolved to a file below the root folders.
#[derive(Debug)]
pub enum Unreachable {
    /// The path leads outside of the root folders.
    Outside,
    /// The operating system reports an error.
    Failed(std::io::Error),
}

/// Resolves a path, links included, to its target if that is below one of the root folders.
///
/// # Errors
/// A path that leads outside of the root folders, or to a file that does not exist.
pub fn find_below(roots: &Roots, path: &Path) -> Result<PathBuf, Unreachable> {
    let folders = roots.folders().filter_map(|folder| std::fs::canonicalize(folder).ok());
    let folders: Vec<PathBuf> = folders.collect();
    let is_inside = |path: &Path| folders.iter().any(|root| path.starts_with(root));
    match std::fs::canonicalize(path) {
        Ok(found) if is_inside(&found) => Ok(found),
        Ok(_) => Err(Unreachable::Outside),
        // Of what is not there the nearest folder that is there tells where it would be.
        Err(error) => match nearest(path) {
            Some(folder) if is_inside(&folder) => Err(Unreachable::Failed(error)),
            _ => Err(Unreachable::Outside),
        },
    }
}

/// Resolves the longest existing ancestor of a path that does not exist. `None` if the rest of the path contains `..`.
fn nearest(path: &Path) -> Option<PathBuf> {
    let existing = path.ancestors().skip(1).find_map(|rest| {
        let folder = if rest.as_os_str().is_empty() { Path::new(".") } else { rest };
        Some((std::fs::canonicalize(folder).ok()?, path.strip_prefix(rest).unwrap_or(path)))
    });
    // A name beyond what does not exist may lead up again.
    let (found, behind) = existing?;
    behind.components().all(|part| part != Component::ParentDir).then_some(found)
}

/// Reads a regular file; returns `None` if it has more than `max` bytes.
///
/// # Errors
/// A path to something other than a regular file, an error of the system, or a file that changed while it was read.
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

/// Reads `file` to its end; an error if `state` (such as length and modification time) differs before and after.
/// Returns `None` if there are more than `max` bytes.
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

/// Creates the diagnostic for a file that cannot be read; `name` is the file's path for the message.
pub fn unreadable(name: &str, error: &std::io::Error) -> Diagnostic {
    let reason = match error.kind() {
        std::io::ErrorKind::NotFound => "it does not exist".to_owned(),
        std::io::ErrorKind::PermissionDenied => "permission is denied".to_owned(),
        _ => error.to_string(),
    };
    let help = match reason.as_str() {
        "it is a folder" => format!("name the files in it, such as {}/*.json", name.trim_end_matches('/')),
        _ => "paths are relative to the current folder".to_owned(),
    };
    let message = format!("the file \"{name}\" cannot be read: {reason}");
    Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message).help(help)
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

    #[test]
    fn paths_outside_roots_look_like_missing_ones() {
        let scratch = std::env::temp_dir().join(format!("umbragraph-roots-{}", std::process::id()));
        let (inside, outside) = (scratch.join("inside"), scratch.join("outside"));
        for folder in [&inside, &outside] {
            std::fs::create_dir_all(folder).unwrap();
            std::fs::write(folder.join("a"), "").unwrap();
        }
        let roots = Roots::default().and(&inside);
        assert_eq!(find_below(&roots, &inside.join("a")).unwrap(), inside.canonicalize().unwrap().join("a"));
        assert!(find_below(&roots, &inside.join("../inside/a")).is_ok());
        assert!(matches!(find_below(&roots, &inside.join("b")), Err(Unreachable::Failed(_))));
        assert!(matches!(find_below(&roots, &inside.join("b/c")), Err(Unreachable::Failed(_))));
        for path in ["../outside/a", "../outside/b", "b/../../outside/a", "../../nowhere/b"] {
            assert!(matches!(find_below(&roots, &inside.join(path)), Err(Unreachable::Outside)), "{path}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(outside.join("a"), inside.join("link")).unwrap();
            std::os::unix::fs::symlink(&outside, inside.join("folder")).unwrap();
            for path in ["link", "folder/a", "folder/b"] {
                assert!(
                    matches!(find_below(&roots, &inside.join(path)), Err(Unreachable::Outside)),
                    "{path}"
                );
            }
            assert!(find_below(&roots.clone().and(&outside), &inside.join("link")).is_ok());
        }
        assert!(matches!(find_below(&Roots::default(), &inside.join("a")), Err(Unreachable::Outside)));
        std::fs::remove_dir_all(&scratch).unwrap();
    }
}
