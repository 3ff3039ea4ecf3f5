//! The files of a disk, and those that come with this crate.

use std::path::{Path, PathBuf};

use umbragraph_session::{Storage, Template, TemplateText};

use crate::Bundled;
use crate::diagnostic::Diagnostic;
use crate::low_level::compose::{Disk, Files as _, Named, Roots, Unreachable, find_below, normalize};
use crate::low_level::source::{FileId, Sources};

/// Access to files on disk and to the bundled files of this crate.
#[derive(Clone, Copy, Debug, Default)]
pub struct DiskStorage;

impl Storage for DiskStorage {
    fn read(
        &mut self,
        path: &Path,
        roots: Option<&Roots>,
        sources: &mut Sources,
    ) -> Result<FileId, Diagnostic> {
        match roots {
            None => Bundled(Named).read(path, sources),
            Some(roots) => Bundled(Disk(roots.clone())).read(path, sources),
        }
    }

    fn may_read(&self, path: &Path, roots: &Roots) -> bool {
        Bundled::<Named>::has(path) || !matches!(find_below(roots, path), Err(Unreachable::Outside))
    }

    fn has_scheme(&self, scheme: &str) -> bool {
        Bundled(Named).has_scheme(scheme)
    }

    fn identity(&self, path: &Path) -> PathBuf {
        if let Ok(path) = std::fs::canonicalize(path) {
            return path;
        }
        // What is not there is called by the folder that is.
        let path = normalize(path);
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        match (std::fs::canonicalize(folder), path.file_name()) {
            (Ok(folder), Some(name)) => folder.join(name),
            _ => path,
        }
    }
}

/// Returns the given templates, followed by the bundled templates of this crate.
pub fn with_templates(own: impl IntoIterator<Item = Template>) -> Vec<Template> {
    let library = umbragraph_shaders_templates::FILES.iter().map(|(name, text)| Template {
        name: (*name).to_owned(),
        text: TemplateText::Library { folder: "shaders-templates", text },
    });
    own.into_iter().chain(library).collect()
}
