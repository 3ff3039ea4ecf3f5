//! Sizes and modification times of files, by which changes are found.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use umbragraph::low_level::compose::files_below;
use umbragraph::low_level::shader::TEMPLATE_ENDS;

/// The size in bytes and the modification time of a file; `None` if the file does not exist.
type Stamp = Option<(u64, Option<SystemTime>)>;

/// The stamps (size and modification time) of watched files, by path. A folder has the stamps of the templates below
/// it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Stamps(BTreeMap<PathBuf, Vec<(PathBuf, Stamp)>>);

impl Stamps {
    /// Reads the current stamps of files and folders.
    pub(super) fn of<'p>(paths: impl IntoIterator<Item = &'p Path>) -> Self {
        Self(paths.into_iter().map(|path| (path.to_owned(), stamps(path))).collect())
    }

    /// Adds the stamps of further paths; existing stamps are kept.
    pub(super) fn with(mut self, paths: impl IntoIterator<Item = PathBuf>) -> Self {
        for path in paths {
            self.0.entry(path).or_insert_with_key(|path| stamps(path));
        }
        self
    }

    /// Adds the stamp of a path that stands for one file, also where a folder has this path; an existing stamp is kept.
    #[cfg(feature = "gpu")]
    pub(super) fn with_file(mut self, path: PathBuf) -> Self {
        let one = (path.clone(), stamp(&path));
        self.0.entry(path).or_insert_with(|| vec![one]);
        self
    }

    /// Adds the stamps of others; existing stamps are kept.
    #[cfg(feature = "gpu")]
    pub(super) fn and(mut self, others: &Self) -> Self {
        for (path, stamps) in &others.0 {
            self.0.entry(path.clone()).or_insert_with(|| stamps.clone());
        }
        self
    }

    /// Returns the watched paths.
    pub(super) fn paths(&self) -> impl Iterator<Item = &Path> {
        self.0.keys().map(PathBuf::as_path)
    }
}

fn stamps(path: &Path) -> Vec<(PathBuf, Stamp)> {
    let stamped = |path: &Path| (path.to_owned(), stamp(path));
    if !path.is_dir() {
        return vec![stamped(path)];
    }
    let files = files_below(path, &TEMPLATE_ENDS).unwrap_or_default();
    files.iter().map(|(_, path)| stamped(path)).collect()
}

fn stamp(path: &Path) -> Stamp {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.len(), metadata.modified().ok()))
}
