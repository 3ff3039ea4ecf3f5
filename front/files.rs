//! Files that are written as a whole or not at all, and never over one that somebody changed meanwhile.
//!
//! A file is written beside its place and renamed when it is whole. A program that is interrupted calls [`give_up`],
//! which removes what is not whole yet.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::fs::{File, Permissions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::diagnostic::Diagnostic;
use crate::low_level::compose::read_bytes;

pub use super::codes::FILE_UNWRITABLE;

/// The paths of temporary files that are still being written.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Replaces a file atomically: writes a temporary file beside it, then renames that. A symbolic link stays a link, and
/// its target is replaced; permissions are kept. A path that is not a plain file, such as a device, is written
/// directly.
///
/// # Errors
/// A folder that does not exist or is not writable. An existing file is left unchanged.
pub fn replace(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Diagnostic> {
    let failed = |error: std::io::Error| unwritable(path, &error);
    if path.metadata().is_ok_and(|known| !known.is_file()) {
        return std::fs::write(path, contents).map_err(failed);
    }
    let (unfinished, file) = Unfinished::create(path)?;
    write_and_close(file, contents.as_ref()).map_err(failed)?;
    unfinished.finish()
}

fn write_and_close(mut file: File, contents: &[u8]) -> std::io::Result<()> {
    file.write_all(contents)
}

/// Replaces the contents of a text file if they are still `known`. A byte order mark is kept.
///
/// # Errors
/// A file whose text is no longer `known`, or that cannot be written.
pub fn replace_if(path: &Path, known: &str, text: &str) -> Result<(), Diagnostic> {
    let present =
        read_bytes(path, u64::MAX - 1).map_err(|error| unwritable(path, &error))?.unwrap_or_default();
    let (mark, rest) = match present.strip_prefix("\u{feff}".as_bytes()) {
        Some(rest) => ("\u{feff}", rest),
        None => ("", present.as_slice()),
    };
    if rest != known.as_bytes() {
        return Err(unwritable(path, &"it was changed meanwhile"));
    }
    replace(path, format!("{mark}{text}"))
}

/// Size in bytes and modification time of a file; `None` if the file does not exist.
#[cfg(any(feature = "environment", feature = "watch"))]
pub(crate) type Stamp = Option<(u64, Option<std::time::SystemTime>)>;

/// Returns the size and modification time of a file now.
#[cfg(any(feature = "environment", feature = "watch"))]
pub(crate) fn stamp(path: &Path) -> Stamp {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()))
}

/// A file under construction: a temporary file beside the final path, renamed to that path once it is complete.
#[derive(Debug)]
pub struct Unfinished {
    /// The final path, as the caller gave it.
    path: PathBuf,
    /// The final path with symbolic links resolved.
    place: PathBuf,
    temporary: PathBuf,
    /// The permissions of the file to be replaced; `None` for a new file.
    permissions: Option<Permissions>,
}

impl Unfinished {
    /// Creates the temporary file for a final path, and returns it open for writing.
    ///
    /// # Errors
    /// A folder that does not exist or is not writable.
    pub fn create(path: &Path) -> Result<(Self, File), Diagnostic> {
        let failed = |error: std::io::Error| unwritable(path, &error);
        let permissions = path.metadata().ok().map(|known| known.permissions());
        let place =
            if permissions.is_some() { path.canonicalize().map_err(failed)? } else { path.to_owned() };
        let mut temporary = place.clone().into_os_string();
        // Other jobs and other threads may write the same file.
        temporary.push(format!(".{}.{:?}.part", std::process::id(), std::thread::current().id()));
        let unfinished = Self { path: path.to_owned(), place, temporary: temporary.into(), permissions };
        list().insert(unfinished.temporary.clone());
        let file = File::create(&unfinished.temporary).map_err(failed)?;
        Ok((unfinished, file))
    }

    /// The final path, as the caller gave it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Renames the temporary file to the final path.
    ///
    /// # Errors
    /// A final path that is not writable.
    pub fn finish(mut self) -> Result<(), Diagnostic> {
        let permissions = self.permissions.take();
        permissions
            .map_or(Ok(()), |permissions| std::fs::set_permissions(&self.temporary, permissions))
            .and_then(|()| std::fs::rename(&self.temporary, &self.place))
            .map_err(|error| unwritable(&self.path, &error))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        // Not there any more where it is finished.
        let _ = std::fs::remove_file(&self.temporary);
        list().remove(&self.temporary);
    }
}

fn list() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all unfinished temporary files and calls `end`. No other thread can begin a file until this returns.
pub fn give_up<T>(end: impl FnOnce() -> T) -> T {
    let unfinished = list();
    for file in unfinished.iter() {
        let _ = std::fs::remove_file(file);
    }
    end()
}

/// The diagnostic for a file that cannot be written.
pub fn unwritable(path: &Path, error: &dyn Display) -> Diagnostic {
    let name = path.display().to_string();
    let message = format!("\"{name}\" cannot be written: {error}");
    Diagnostic::in_file(FILE_UNWRITABLE, &name, "", message)
        .help("check that the folder exists and may be written to; a file that was there is as it was")
}

#[cfg(test)]
mod tests {
    use umbragraph_test_support::scratch::ScratchFolder;

    use super::*;

    #[test]
    fn a_file_is_replaced_as_a_whole_and_nothing_else_is_left() {
        let folder = ScratchFolder::new("replace");
        let path = folder.join("file.png");
        for text in ["one", "two"] {
            replace(&path, text).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
        // The folder cannot be renamed over; nothing of the attempt stays.
        std::fs::create_dir(folder.join("folder")).unwrap();
        assert!(replace(&folder.join("folder"), "three").is_err());
        assert!(replace(&folder.join("missing/file"), "three").is_err());
        let names: Vec<_> =
            std::fs::read_dir(folder.join("")).unwrap().map(|one| one.unwrap().file_name()).collect();
        assert_eq!(names.len(), 2, "{names:?}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_permissions_stay() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = ScratchFolder::new("replace-link");
        let (path, link) = (folder.join("file"), folder.join("link"));
        replace(&path, "one").unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        replace(&link, "two").unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(std::fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[test]
    fn a_file_that_was_changed_meanwhile_is_left_alone() {
        let folder = ScratchFolder::new("replace-if");
        let path = folder.join("file.json");
        replace(&path, "\u{feff}one").unwrap();
        let error = replace_if(&path, "two", "three").unwrap_err();
        assert!(error.message.contains("changed meanwhile"), "{error}");
        replace_if(&path, "one", "two").unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "\u{feff}two");
    }
}
