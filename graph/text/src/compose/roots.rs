//! Folders that a document may read.
//!
//! A document names files: those that it extends and includes, subgraphs, buffers of a scene. It comes from anywhere, so
//! that not everything that its reader could read is its business. [`Roots`] are the folders below which it reads: the
//! working folder, its own, and those that a host adds. A path is taken as the system takes it, `..` and links resolved,
//! before it is compared with them; what lies elsewhere is never opened, nor said to exist or not.
//!
//! Limits: whoever changes the folders while a document is read can exchange a file between the look at its path and its
//! opening.

use std::path::{Component, Path, PathBuf};

/// The folders below which a document reads files.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Roots(Vec<PathBuf>);

/// Why a path leads to no file of some roots.
#[derive(Debug)]
pub enum Unreachable {
    /// It leads outside of them.
    Outside,
    /// The system has a reason.
    Failed(std::io::Error),
}

impl Roots {
    /// The working folder, and the folder of a document.
    pub fn of(document: &Path) -> Self {
        Self::below(document.parent().unwrap_or_else(|| Path::new("")))
    }

    /// The working folder, and another.
    pub fn below(folder: &Path) -> Self {
        Self::default().and(Path::new(".")).and(folder)
    }

    /// The same, and another folder; one that does not exist adds nothing.
    #[must_use]
    pub fn and(mut self, folder: &Path) -> Self {
        let folder = std::fs::canonicalize(folder).ok().filter(|folder| !self.0.contains(folder));
        self.0.extend(folder);
        self
    }

    /// These folders and others.
    #[must_use]
    pub fn with(mut self, others: &Self) -> Self {
        let new = others.0.iter().filter(|folder| !self.0.contains(folder)).cloned().collect::<Vec<_>>();
        self.0.extend(new);
        self
    }

    /// The target of a path, if that is below a root.
    ///
    /// # Errors
    /// A path that leads elsewhere, or nowhere.
    pub fn find(&self, path: &Path) -> Result<PathBuf, Unreachable> {
        let is_inside = |path: &Path| self.0.iter().any(|root| path.starts_with(root));
        match std::fs::canonicalize(path) {
            Ok(found) if is_inside(&found) => Ok(found),
            Ok(_) => Err(Unreachable::Outside),
            // Of what is not there the nearest folder that is there tells where it would be.
            Err(error) => match nearest(path) {
                Some(folder) if is_inside(&folder) => Err(Unreachable::Failed(error)),
                _ => Err(Unreachable::Outside),
            },
        }
    }
}

/// The target of a path that does not exist, found from the longest part of it that does.
fn nearest(path: &Path) -> Option<PathBuf> {
    let existing = path.ancestors().skip(1).find_map(|rest| {
        let folder = if rest.as_os_str().is_empty() { Path::new(".") } else { rest };
        Some((std::fs::canonicalize(folder).ok()?, path.strip_prefix(rest).unwrap_or(path)))
    });
    // A name beyond what does not exist may lead up again.
    let (found, behind) = existing?;
    behind.components().all(|part| part != Component::ParentDir).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_outside_roots_look_like_missing_ones() {
        let scratch = std::env::temp_dir().join(format!("umbragraph-roots-{}", std::process::id()));
        let (inside, outside) = (scratch.join("inside"), scratch.join("outside"));
        for folder in [&inside, &outside] {
            std::fs::create_dir_all(folder).unwrap();
            std::fs::write(folder.join("a"), "").unwrap();
        }
        let roots = Roots::default().and(&inside);
        assert_eq!(roots.find(&inside.join("a")).unwrap(), inside.canonicalize().unwrap().join("a"));
        assert!(roots.find(&inside.join("../inside/a")).is_ok());
        assert!(matches!(roots.find(&inside.join("b")), Err(Unreachable::Failed(_))));
        assert!(matches!(roots.find(&inside.join("b/c")), Err(Unreachable::Failed(_))));
        for path in ["../outside/a", "../outside/b", "b/../../outside/a", "../../nowhere/b"] {
            assert!(matches!(roots.find(&inside.join(path)), Err(Unreachable::Outside)), "{path}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(outside.join("a"), inside.join("link")).unwrap();
            std::os::unix::fs::symlink(&outside, inside.join("folder")).unwrap();
            for path in ["link", "folder/a", "folder/b"] {
                assert!(matches!(roots.find(&inside.join(path)), Err(Unreachable::Outside)), "{path}");
            }
            assert!(roots.clone().and(&outside).find(&inside.join("link")).is_ok());
        }
        assert!(matches!(Roots::default().find(&inside.join("a")), Err(Unreachable::Outside)));
        std::fs::remove_dir_all(&scratch).unwrap();
    }
}
