//! The scene of a watcher: a glTF file with the buffers and images beside it.
//!
//! The files that the document names are noted while it is read, found or not. When the size or time of one changes,
//! the scene is loaded again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use umbragraph_graph::compose::read_bytes;

use crate::diagnostic::Diagnostics;
use crate::front::files::{Stamp, stamp};
use crate::scene::{self, Folder, ResolveError, Resolver, Scene};

/// A scene file, and the state of the files that the scene was loaded from.
pub(super) struct WatchedScene {
    path: PathBuf,
    stamps: BTreeMap<PathBuf, Stamp>,
}

impl WatchedScene {
    /// Creates the state of a scene file that is not loaded yet.
    pub(super) fn new(path: PathBuf) -> Self {
        Self { path, stamps: BTreeMap::new() }
    }

    /// Returns the paths of the files that the scene was loaded from, including missing files that it references.
    pub(super) fn files(&self) -> impl Iterator<Item = PathBuf> {
        self.stamps.keys().cloned()
    }

    /// Loads the scene if it is new or one of its files has changed; otherwise returns `None`.
    pub(super) fn load_again(&mut self) -> Option<Result<Scene, Diagnostics>> {
        if !self.stamps.is_empty() && self.stamps.iter().all(|(path, known)| stamp(path) == *known) {
            return None;
        }
        self.stamps = [(self.path.clone(), stamp(&self.path))].into();
        let Ok(Some(bytes)) = read_bytes(&self.path, scene::MAX_FILE_BYTES) else {
            // It says why.
            return Some(scene::load(&self.path));
        };
        let folder = self.path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
        let noting = Noting { files: Folder::new(&folder), folder, stamps: Mutex::default() };
        let loaded = scene::from_slice(&self.path.display().to_string(), &bytes, &noting);
        self.stamps.extend(noting.stamps.into_inner().unwrap_or_default());
        Some(loaded)
    }
}

/// Reads the files that a scene references, and records the path, size and modification time of each.
struct Noting {
    files: Folder,
    folder: PathBuf,
    stamps: Mutex<BTreeMap<PathBuf, Stamp>>,
}

impl Resolver for Noting {
    fn read(&self, path: &str) -> Result<Vec<u8>, ResolveError> {
        let file = self.folder.join(path);
        let stamp = stamp(&file);
        if let Ok(mut stamps) = self.stamps.lock() {
            stamps.insert(file, stamp);
        }
        self.files.read(path)
    }
}
