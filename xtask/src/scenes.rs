//! `cargo xtask scenes`: the project's own scenes, written again by the programs that made them.
//!
//! Each `examples/write_NAME/` writes `examples/scenes/NAME.glb`; the list is what is in that folder, so that a new
//! scene needs no line here. With `--check` the programs write to `target/scenes/` instead, and the files are compared
//! byte by byte with those in the tree; a scene without a program is a difference too.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::process;

/// The folder of the scenes, relative to the root of the workspace.
const SCENES: &str = "examples/scenes";

/// The folder for the scenes that `--check` writes, below the target folder of cargo.
const COMPARED: &str = "scenes";

/// The size in bytes that every scene must stay below.
const MAX_BYTES: u64 = 1_000_000;

/// Writes the scenes, or compares them with those in the tree if `check` is set. Returns `true` on success.
pub(crate) fn run(check: bool) -> Result<bool, String> {
    let root = process::workspace_root();
    let in_tree = root.join(SCENES);
    let folder = if check { process::target_folder().join(COMPARED) } else { in_tree.clone() };
    let names = names(&root)?;
    write(&names, &folder)?;
    let faults = if check { compare(&names, &folder, &in_tree) } else { too_large(&names, &folder) };
    if faults.is_empty() { Ok(true) } else { Err(faults.join("\n")) }
}

/// Returns the names of the scenes that have a generating program, sorted.
fn names(root: &Path) -> Result<BTreeSet<String>, String> {
    entries(&root.join("examples"), |name| name.strip_prefix("write_"))
}

/// Returns the names of the scenes in a folder, sorted.
fn files(folder: &Path) -> Result<BTreeSet<String>, String> {
    entries(folder, |name| name.strip_suffix(".glb"))
}

fn entries(folder: &Path, wanted: impl Fn(&str) -> Option<&str>) -> Result<BTreeSet<String>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        names.extend(name.to_str().and_then(&wanted).map(str::to_owned));
    }
    Ok(names)
}

fn file(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.glb"))
}

/// Runs every scene's program, which writes the scene into a folder.
fn write(names: &BTreeSet<String>, folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for name in names {
        let path = file(folder, name);
        let status = process::program("cargo")
            .args(["run", "--quiet", "--package", "umbragraph", "--example", &format!("write_{name}"), "--"])
            .arg(&path)
            .status();
        match status {
            Ok(status) if status.success() && path.is_file() => {}
            Ok(status) => return Err(format!("write_{name} wrote no {} ({status})", path.display())),
            Err(error) => return Err(format!("cargo could not be started: {error}")),
        }
    }
    Ok(())
}

/// Returns descriptions of the differences between the scenes just written and those in the tree.
fn compare(names: &BTreeSet<String>, written: &Path, in_tree: &Path) -> Vec<String> {
    let mut faults = too_large(names, written);
    match files(in_tree) {
        Ok(there) => faults.extend(
            there.difference(names).map(|name| format!("{name}.glb has no program examples/write_{name}")),
        ),
        Err(reason) => faults.push(reason),
    }
    for name in names {
        let bytes = |folder: &Path| {
            std::fs::read(file(folder, name))
                .map_err(|error| format!("{}: {error}", file(folder, name).display()))
        };
        match (bytes(written), bytes(in_tree)) {
            (Ok(new), Ok(old)) => faults.extend(difference(name, &new, &old)),
            (new, old) => faults.extend([new.err(), old.err()].into_iter().flatten()),
        }
    }
    faults
}

/// Describes the first difference between two files; `None` if they are equal.
fn difference(name: &str, new: &[u8], old: &[u8]) -> Option<String> {
    let at = new.iter().zip(old).position(|(new, old)| new != old);
    let at = at.or_else(|| (new.len() != old.len()).then(|| new.len().min(old.len())))?;
    Some(format!(
        "{name}.glb is not what its program writes: {} bytes instead of {}, different from byte {at} on \
         (cargo xtask scenes writes it again)",
        new.len(),
        old.len()
    ))
}

fn too_large(names: &BTreeSet<String>, folder: &Path) -> Vec<String> {
    let size = |name: &String| file(folder, name).metadata().map_or(0, |metadata| metadata.len());
    names
        .iter()
        .map(|name| (name, size(name)))
        .filter(|(_, size)| *size >= MAX_BYTES)
        .map(|(name, size)| format!("{name}.glb has {size} bytes; a scene has less than {MAX_BYTES}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(names: &[&str]) -> BTreeSet<String> {
        names.iter().map(|name| (*name).to_owned()).collect()
    }

    #[test]
    fn every_scene_has_a_program_and_every_program_a_scene() {
        let root = process::workspace_root();
        let programs = names(&root).unwrap();
        assert!(programs.contains("courtyard"));
        assert_eq!(programs, files(&root.join(SCENES)).unwrap());
    }

    #[test]
    fn changed_missing_and_orphaned_scenes_are_told_apart() {
        let folder = std::env::temp_dir().join(format!("xtask-scenes-{}", std::process::id()));
        let (new, old) = (folder.join("new"), folder.join("old"));
        for folder in [&new, &old] {
            std::fs::create_dir_all(folder).unwrap();
            std::fs::write(file(folder, "same"), b"glTF").unwrap();
        }
        std::fs::write(file(&new, "changed"), b"glTF-a").unwrap();
        std::fs::write(file(&old, "changed"), b"glTF-b").unwrap();
        std::fs::write(file(&new, "longer"), b"glTF-").unwrap();
        std::fs::write(file(&old, "longer"), b"glTF").unwrap();
        std::fs::write(file(&new, "new"), b"").unwrap();
        std::fs::write(file(&old, "orphan"), b"").unwrap();
        let faults = compare(&set(&["same", "changed", "longer", "new"]), &new, &old);
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(faults.len(), 4, "{faults:?}");
        assert!(faults[0].starts_with("orphan.glb has no program examples/write_orphan"));
        assert!(faults[1].contains("changed.glb") && faults[1].contains("from byte 5 on"), "{}", faults[1]);
        assert!(faults[2].contains("longer.glb") && faults[2].contains("5 bytes instead of 4"));
        assert!(faults[3].contains("new.glb"));
    }
}
