//! Folders that a document may read.
//!
//! A document names files: those that it extends and includes, subgraphs, buffers of a scene. It comes from anywhere,
//! so that not everything that its reader could read is its business. [`Roots`] are the folders below which it reads:
//! the working folder, its own, and those that a host adds. They are names alone; [`find_below`](super::find_below)
//! compares paths of a disk with them.

use std::path::{Path, PathBuf};

/// The root folders below which a document may read files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roots(Vec<PathBuf>);

impl Roots {
    /// The root folders for the files that a document names: the working folder, and the folder that contains the
    /// document.
    pub fn of(document: &Path) -> Self {
        Self::below(document.parent().unwrap_or_else(|| Path::new("")))
    }

    /// The root folders for files in `folder`: the working folder and `folder`.
    pub fn below(folder: &Path) -> Self {
        Self::default().and(Path::new(".")).and(folder)
    }

    /// Adds a root folder, unless its path is empty or already in the list.
    #[must_use]
    pub fn and(mut self, folder: &Path) -> Self {
        let is_new = !folder.as_os_str().is_empty() && !self.0.iter().any(|known| known == folder);
        self.0.extend(is_new.then(|| folder.to_owned()));
        self
    }

    /// Adds the root folders of `others` that are not in the list yet.
    #[must_use]
    pub fn with(mut self, others: &Self) -> Self {
        let new = others.0.iter().filter(|folder| !self.0.contains(folder)).cloned().collect::<Vec<_>>();
        self.0.extend(new);
        self
    }

    /// The root folders; they need not exist.
    pub fn folders(&self) -> impl Iterator<Item = &Path> {
        self.0.iter().map(PathBuf::as_path)
    }
}
