//! Files that are written as a whole or not at all.

use std::fmt::Display;
use std::fs::{File, Permissions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::codes;
#[cfg(feature = "gpu")]
use crate::interrupt;
use umbragraph::diagnostic::Diagnostic;

/// Writes a file: to a temporary one beside it, which is then renamed, so that no half file is ever left. A link stays
/// one, and what it leads to is written; permissions stay as they are. What is no plain file, such as a device, is
/// written directly.
///
/// # Errors
/// A folder that is not there or cannot be written to; a file that was there is as it was.
pub(crate) fn replace(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), Diagnostic> {
    let failed = |error: std::io::Error| unwritable(path, &error);
    if path.metadata().is_ok_and(|known| !known.is_file()) {
        return std::fs::write(path, contents).map_err(failed);
    }
    let (unfinished, mut file) = Unfinished::create(path)?;
    file.write_all(contents.as_ref()).map_err(failed)?;
    drop(file);
    unfinished.finish()
}

/// A file under construction: one beside it, which takes its place once it is whole.
pub(crate) struct Unfinished {
    /// As it is asked for.
    pub(crate) path: PathBuf,
    /// The path itself, or the target of its link.
    place: PathBuf,
    temporary: PathBuf,
    /// The permissions of the file that it replaces; `None` for a new one.
    permissions: Option<Permissions>,
}

impl Unfinished {
    pub(crate) fn create(path: &Path) -> Result<(Self, File), Diagnostic> {
        let failed = |error: std::io::Error| unwritable(path, &error);
        let permissions = path.metadata().ok().map(|known| known.permissions());
        let place =
            if permissions.is_some() { path.canonicalize().map_err(failed)? } else { path.to_owned() };
        let mut temporary = place.clone().into_os_string();
        // Other jobs and other threads may write the same file.
        temporary.push(format!(".{}.{:?}.part", std::process::id(), std::thread::current().id()));
        let unfinished = Self { path: path.to_owned(), place, temporary: temporary.into(), permissions };
        #[cfg(feature = "gpu")]
        interrupt::begun(&unfinished.temporary);
        let file = File::create(&unfinished.temporary).map_err(failed)?;
        Ok((unfinished, file))
    }

    pub(crate) fn finish(mut self) -> Result<(), Diagnostic> {
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
        #[cfg(feature = "gpu")]
        interrupt::ended(&self.temporary);
    }
}

/// The diagnostic for a file that cannot be written.
pub(crate) fn unwritable(path: &Path, error: &dyn Display) -> Diagnostic {
    let name = path.display().to_string();
    let message = format!("\"{name}\" cannot be written: {error}");
    Diagnostic::in_file(codes::FILE_UNWRITABLE, &name, "", message)
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
}
