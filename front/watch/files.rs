//! [`FileEvents`]: the operating system's notices that files changed, gathered until they pause.
//!
//! An editor writes by truncating, by renaming a temporary file over the old one, or by deleting and creating; a
//! formatter or a branch switch touches ten files at once. So the *folders* of files are watched, not the files: a new
//! file under the same name is seen whatever became of the old one. Notices are gathered for [`PAUSE`], because half of
//! a change is rarely a pipeline. A notice says only *that* something changed; what did, the session finds by reading.
//!
//! Limits: a folder that is not there is replaced by the nearest one above it; file systems without notices (most
//! network mounts) report nothing.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use notify_debouncer_full::notify::event::EventKind;
use notify_debouncer_full::notify::{Config, RecommendedWatcher, RecursiveMode};
use notify_debouncer_full::{DebounceEventResult, Debouncer, NoCache, new_debouncer_opt};

/// The time without further file system events after which a change is reported.
pub(super) const PAUSE: Duration = Duration::from_millis(30);
/// The interval at which the debouncer checks whether events are old enough to be reported.
const TICK: Duration = Duration::from_millis(6);

/// Watched folders, and the function to call after a change in them.
pub(super) struct FileEvents {
    debouncer: Debouncer<RecommendedWatcher, NoCache>,
    watched: BTreeSet<(PathBuf, bool)>,
}

impl FileEvents {
    /// Creates a watcher without folders. `changed` is called after each change, on a thread of the debouncer.
    ///
    /// # Errors
    /// The operating system refuses to watch files.
    pub(super) fn new(changed: impl Fn() + Send + 'static) -> Result<Self, String> {
        let told = move |result: DebounceEventResult| match result {
            // Reading a file is an access, which would tell of itself forever.
            Ok(events) if events.iter().all(|event| matches!(event.kind, EventKind::Access(_))) => {}
            // An overflow of the queue is an error here: something changed, nobody knows what.
            _ => changed(),
        };
        let debouncer = new_debouncer_opt(PAUSE, Some(TICK), told, NoCache, Config::default());
        Ok(Self { debouncer: debouncer.map_err(|error| error.to_string())?, watched: BTreeSet::new() })
    }

    /// Watches the folders that contain `files` and the folder trees `trees`; stops watching all other folders. Returns
    /// `true` if a folder is newly watched, since earlier changes there went unnoticed. Also returns the folders that
    /// cannot be watched, each with the reason.
    pub(super) fn watch(
        &mut self,
        files: impl IntoIterator<Item = PathBuf>,
        trees: &[PathBuf],
    ) -> (bool, Vec<(PathBuf, String)>) {
        let folders = files.into_iter().filter_map(|file| Some((existing(folder_of(&file))?, false)));
        let trees = trees.iter().filter_map(|tree| {
            let found = existing(tree.clone())?;
            let is_whole = found == *tree;
            Some((found, is_whole))
        });
        let mut wanted: BTreeSet<(PathBuf, bool)> = folders.chain(trees).collect();
        let whole: BTreeSet<PathBuf> =
            wanted.iter().filter(|(_, is_tree)| *is_tree).map(|(path, _)| path.clone()).collect();
        wanted.retain(|(path, is_tree)| *is_tree || !whole.iter().any(|tree| path.starts_with(tree)));
        // A folder that was removed and made again is another one, although it has the same name.
        let is_lost = |path: &Path| !path.is_dir();
        let old: Vec<_> =
            self.watched.iter().filter(|one| !wanted.contains(one) || is_lost(&one.0)).cloned().collect();
        for one in old {
            let _ = self.debouncer.unwatch(&one.0);
            self.watched.remove(&one);
        }
        let (mut failed, mut has_new) = (Vec::new(), false);
        for (path, is_tree) in wanted {
            let mode = if is_tree { RecursiveMode::Recursive } else { RecursiveMode::NonRecursive };
            // Watching again costs little, and finds a folder that took the place of another.
            match self.debouncer.watch(&path, mode) {
                Ok(()) => has_new |= self.watched.insert((path, is_tree)),
                Err(error) => failed.push((path, error.to_string())),
            }
        }
        (has_new, failed)
    }
}

/// Returns the folder that contains a file, whether or not the file exists.
fn folder_of(file: &Path) -> PathBuf {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.map_or_else(|| PathBuf::from("."), Path::to_path_buf)
}

/// Returns the canonical path of the folder if it exists, or else of its nearest existing parent; `None` if neither
/// exists.
fn existing(mut folder: PathBuf) -> Option<PathBuf> {
    loop {
        if folder.is_dir() {
            return std::fs::canonicalize(&folder).ok();
        }
        if !folder.pop() {
            return None;
        }
        if folder.as_os_str().is_empty() {
            folder.push(".");
        }
    }
}
