//! Counts of a target, kept in a file from run to run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use umbragraph_test_support::environment;

use crate::target::Target;

/// The inputs of a target so far.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize)]
pub(crate) struct Counts {
    /// A hash of the files that the target is about.
    code: String,
    pub(crate) inputs: u64,
    /// Failures: the number of the input, and the reason.
    pub(crate) failures: BTreeMap<u64, String>,
}

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The folder of all counts.
pub(crate) fn all() -> PathBuf {
    environment::target_folder(&environment::process).join("fuzz")
}

/// The folder of a target's counts and failures.
pub(crate) fn folder(target: &Target) -> PathBuf {
    all().join(target.name)
}

fn hash(target: &Target) -> Result<String, String> {
    fn add(path: &Path, hash: &mut blake3::Hasher) -> std::io::Result<()> {
        if path.is_dir() {
            let mut below: Vec<_> = std::fs::read_dir(path)?.flatten().map(|entry| entry.path()).collect();
            below.sort();
            return below.iter().try_for_each(|path| add(path, hash));
        }
        let text = std::fs::read(path)?;
        hash.update(path.file_name().unwrap_or_default().as_encoded_bytes());
        // Comments decide nothing.
        let lines = text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii_start);
        lines.filter(|line| !line.starts_with(b"//")).for_each(|line| {
            hash.update(line);
        });
        Ok(())
    }
    let mut hash = blake3::Hasher::new();
    // The harness decides what an input is.
    for file in target.files.iter().chain(&[
        "tests/fuzz/src/mutation.rs",
        "tests/fuzz/src/worker.rs",
        "tests/fuzz/src/targets",
    ]) {
        add(&root().join(file), &mut hash).map_err(|error| format!("{file}: {error}"))?;
    }
    Ok(hash.finalize().to_hex()[..16].to_owned())
}

impl Counts {
    /// The counts so far; none where the code is another.
    pub(crate) fn of(target: &Target) -> Result<Self, String> {
        let code = hash(target)?;
        let text = std::fs::read_to_string(folder(target).join("counts.json")).unwrap_or_default();
        let known: Option<Self> = serde_json::from_str(&text).ok();
        Ok(known.filter(|known| known.code == code).unwrap_or(Self { code, ..Self::default() }))
    }

    /// Writes them beside the old ones, and puts them in their place.
    pub(crate) fn keep(&self, target: &Target) -> Result<(), String> {
        let (file, new) = (folder(target).join("counts.json"), folder(target).join("counts.json.new"));
        let text = serde_json::to_string_pretty(self).map_err(|error| error.to_string())?;
        let kept = std::fs::write(&new, text).and_then(|()| std::fs::rename(&new, &file));
        kept.map_err(|error| format!("{}: {error}", file.display()))
    }
}
