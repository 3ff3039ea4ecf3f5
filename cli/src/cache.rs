//! Results of earlier runs, in a folder of plain files.
//!
//! Three kinds: shader declarations that were proven, what a whole run without errors printed, and the visibility of
//! lights that rays have found. Every name is a hash of all that the contents follow from: this program (its own bytes,
//! and so naga and every rule), the command line and the texts of all files read; for proofs the program and the
//! targets, for rays the surfaces, the camera and the light. So a folder can be shared by jobs and restored on
//! another machine; another build of the program finds nothing in it.
//!
//! A file begins with the hash of its contents: one that is cut short or changed is not there. Files are written beside
//! their place and renamed. Where a folder cannot be written, nothing is kept, and nothing else changes.

use std::path::PathBuf;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};
use umbragraph::low_level::compose::read_bytes;
use umbragraph::low_level::shader::permutations::Keep;
use umbragraph::low_level::source::Sources;

use crate::arguments::CacheArguments;
use crate::lock::Lock;
use crate::replace::replace;

/// The maximum size in bytes of all files in the folder; beyond it, the oldest files are removed.
const MAX_BYTES: u64 = 256 << 20;

/// The cache of earlier runs: its folder, and the hash of this program's executable.
pub(crate) struct Cache {
    folder: PathBuf,
    program: blake3::Hash,
}

/// The stored output of a run without errors.
#[derive(Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Said {
    /// The text on standard output.
    pub(crate) text: String,
    /// The text on standard error.
    pub(crate) diagnostics: String,
    /// The Markdown summary for GitHub; empty if no annotations were requested.
    pub(crate) summary: String,
    /// The reachable shaders; `None` if the run needed no lock file.
    pub(crate) lock: Option<Lock>,
}

impl Cache {
    /// Opens the cache that the arguments name; `None` with `--no-cache`, or if the user has no cache folder.
    pub(crate) fn new(arguments: &CacheArguments) -> Option<Self> {
        if arguments.no_cache {
            return None;
        }
        let folder = arguments.cache.clone().or_else(users_folder)?;
        let program = read_bytes(&std::env::current_exe().ok()?, u64::MAX).ok()??;
        Some(Self { folder, program: blake3::hash(&program) })
    }

    /// Returns the cache key for this command line and these sources.
    pub(crate) fn run(&self, sources: &Sources) -> String {
        let mut hash = blake3::Hasher::new();
        let mut add = |bytes: &[u8]| {
            hash.update(&(bytes.len() as u64).to_le_bytes()).update(bytes);
        };
        for argument in std::env::args_os().skip(1) {
            add(argument.as_encoded_bytes());
        }
        for (_, file) in sources.iter() {
            add(file.name().as_bytes());
            add(file.text().as_bytes());
        }
        format!("run {}", hash.finalize())
    }

    /// Returns the output stored under a key; `None` if there is none.
    pub(crate) fn said(&self, name: &str) -> Option<Said> {
        serde_json::from_slice(&self.get(name)?).ok()
    }

    /// Stores the output of a run under a key.
    pub(crate) fn keep(&self, name: &str, said: &Said) {
        if let Ok(bytes) = serde_json::to_vec(said) {
            self.put(name, &bytes);
        }
    }

    fn path(&self, name: &str) -> PathBuf {
        let mut hash = blake3::Hasher::new();
        hash.update(self.program.as_bytes()).update(name.as_bytes());
        self.folder.join(format!("{}.umbragraph", hash.finalize()))
    }

    /// Removes the oldest files if the folder exceeds `MAX_BYTES`.
    fn bound(&self) {
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return };
        let files =
            entries.flatten().filter(|entry| entry.path().extension().is_some_and(|end| end == "umbragraph"));
        let mut files: Vec<(SystemTime, u64, PathBuf)> = files
            .filter_map(|entry| {
                let metadata = entry.metadata().ok()?;
                Some((metadata.modified().ok()?, metadata.len(), entry.path()))
            })
            .collect();
        let mut bytes: u64 = files.iter().map(|(_, bytes, _)| bytes).sum();
        files.sort();
        for (_, length, path) in files {
            if bytes <= MAX_BYTES {
                return;
            }
            bytes -= length;
            let _ = std::fs::remove_file(path);
        }
    }
}

impl Keep for Cache {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        let mut bytes = read_bytes(&self.path(name), MAX_BYTES).ok()??;
        let contents = bytes.split_off(bytes.len().min(blake3::OUT_LEN));
        (bytes == blake3::hash(&contents).as_bytes()).then_some(contents)
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        let _ = std::fs::create_dir_all(&self.folder);
        let contents = [blake3::hash(bytes).as_bytes(), bytes].concat();
        if replace(&self.path(name), contents).is_ok() {
            self.bound();
        }
    }
}

/// Returns the folder that `UMBRAGRAPH_CACHE` names, or `umbragraph` in the user's cache folder. `None` if the variable
/// is empty, or no cache folder is known.
pub(crate) fn users_folder() -> Option<PathBuf> {
    if let Some(folder) = std::env::var_os("UMBRAGRAPH_CACHE") {
        return (!folder.is_empty()).then(|| folder.into());
    }
    let folder = |name: &str| std::env::var_os(name).filter(|path| !path.is_empty()).map(PathBuf::from);
    let caches = match std::env::consts::OS {
        "windows" => folder("LOCALAPPDATA"),
        "macos" => folder("HOME").map(|home| home.join("Library/Caches")),
        _ => folder("XDG_CACHE_HOME").or_else(|| Some(folder("HOME")?.join(".cache"))),
    };
    Some(caches?.join("umbragraph"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbragraph_test_support::scratch::ScratchFolder;

    fn cache(folder: &ScratchFolder) -> Cache {
        Cache { folder: folder.join("new/cache"), program: blake3::hash(b"program") }
    }

    #[test]
    fn contents_come_back_until_a_byte_is_changed() {
        let folder = ScratchFolder::new("cache-bytes");
        let cache = cache(&folder);
        assert_eq!(cache.get("one"), None);
        cache.put("one", b"contents");
        cache.put("two", b"");
        assert_eq!(cache.get("one").as_deref(), Some(&b"contents"[..]));
        assert_eq!(cache.get("two").as_deref(), Some(&b""[..]));
        let path = cache.path("one");
        let whole = std::fs::read(&path).expect("the file");
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            std::fs::write(&path, &changed).expect("the file");
            assert_eq!(cache.get("one"), None, "byte {at}");
            std::fs::write(&path, &whole[..at]).expect("the file");
            assert_eq!(cache.get("one"), None, "cut at {at}");
        }
        cache.put("one", b"others");
        assert_eq!(cache.get("one").as_deref(), Some(&b"others"[..]));
    }

    #[test]
    fn another_program_and_a_read_only_folder_keep_nothing() {
        let folder = ScratchFolder::new("cache-others");
        let own = cache(&folder);
        own.put("one", b"contents");
        let other = Cache { program: blake3::hash(b"other"), ..cache(&folder) };
        assert_eq!(other.get("one"), None);
        std::fs::write(folder.join("file"), "").expect("a file");
        let blocked = Cache { folder: folder.join("file/cache"), ..cache(&folder) };
        blocked.put("one", b"contents");
        assert_eq!(blocked.get("one"), None);
    }

    #[test]
    fn threads_that_write_one_name_leave_one_of_their_contents() {
        let folder = ScratchFolder::new("cache-threads");
        let cache = cache(&folder);
        let all: Vec<Vec<u8>> = (0..4_u8).map(|at| vec![at; 10_000]).collect();
        std::thread::scope(|scope| {
            for contents in &all {
                let cache = &cache;
                scope.spawn(move || {
                    for _ in 0..20 {
                        cache.put("one", contents);
                        let found = cache.get("one");
                        assert!(found.is_some_and(|found| found.iter().all(|byte| *byte == found[0])));
                    }
                });
            }
        });
    }
}
