//! A folder of one test's own, empty at first and gone at the end.

use std::ops::Deref;
use std::path::{Path, PathBuf};

use crate::environment;

/// A temporary folder under the target folder, which is removed when this value is dropped.
#[derive(Debug)]
pub struct ScratchFolder(PathBuf);

impl ScratchFolder {
    /// Creates the folder of a test; the name must be unique among the tests of the process.
    ///
    /// # Panics
    /// If the folder cannot be created.
    #[must_use]
    pub fn new(test: &str) -> Self {
        // Two runs may share a target folder, so the process is part of the name.
        let folder = environment::target_folder(&environment::process)
            .join("scratch")
            .join(format!("{test}-{}", std::process::id()));
        let made = std::fs::create_dir_all(&folder);
        assert!(made.is_ok(), "cannot make {}: {made:?}", folder.display());
        Self(folder)
    }
}

impl Deref for ScratchFolder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl AsRef<Path> for ScratchFolder {
    fn as_ref(&self) -> &Path {
        &self.0
    }
}

impl Drop for ScratchFolder {
    fn drop(&mut self) {
        // What is left over lies in the target folder and hurts nobody.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scratch_folder_is_gone_after_its_test() {
        let folder = ScratchFolder::new("a_scratch_folder_is_gone_after_its_test");
        let path = folder.to_path_buf();
        std::fs::write(folder.join("file"), b"content").unwrap();
        assert!(path.join("file").is_file());
        drop(folder);
        assert!(!path.exists());
    }
}
