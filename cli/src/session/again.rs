//! A session that goes on after its files changed.

use std::path::{Path, PathBuf};

use umbragraph::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph::low_level::compose::{Roots, files_below};
use umbragraph::low_level::session::{Target, Template, TemplateText};
use umbragraph::low_level::shader::TEMPLATE_ENDS;

use super::Session;
use crate::arguments::Files;

impl Session {
    /// Reads all files again and clears the diagnostics.
    pub(crate) fn again(&mut self, files: &Files) {
        self.diagnostics = Diagnostics::new();
        self.deleted.clear();
        self.cut.clear();
        let own = own_templates(files, &mut self.diagnostics);
        self.session.set_templates(umbragraph::with_templates(own.into_iter().flatten()));
        self.session.refresh();
        self.diagnostics.extend(self.session.template_diagnostics());
        self.templates = self.session.templates();
        self.own_files = self.own_files.is_some().then(|| self.session.own_templates());
    }

    /// Returns the files that pipelines were read from, including searched paths at which no file exists.
    pub(crate) fn paths(&mut self, pipelines: &[PathBuf], extensions: &[PathBuf]) -> Vec<PathBuf> {
        let targets: Vec<Target> = pipelines.iter().map(|path| self.target(path, extensions)).collect();
        let loads = targets.iter().filter_map(|target| self.session.load(target).ok());
        loads.flat_map(|loaded| loaded.paths().map(Path::to_path_buf).collect::<Vec<_>>()).collect()
    }
}

/// Reads the templates in the folder of `--templates`; `None` if no folder is given. Adds diagnostics for folders that
/// are missing or cannot be read.
pub(super) fn own_templates(files: &Files, diagnostics: &mut Diagnostics) -> Option<Vec<Template>> {
    diagnostics.extend(files.root.iter().filter(|root| !root.is_dir()).map(|root| {
        let name = root.display().to_string();
        let message = format!("there is no folder \"{name}\"");
        Diagnostic::in_file(codes::FILE_UNREADABLE, name, "", message).help("--root names a folder")
    }));
    let folder = files.templates.as_deref()?;
    let found = files_below(folder, &TEMPLATE_ENDS).unwrap_or_else(|diagnostic| {
        diagnostics.push(diagnostic);
        Vec::new()
    });
    let roots = files.root.iter().fold(Roots::below(folder), |roots, folder| roots.and(folder));
    let template = |(name, path)| Template { name, text: TemplateText::File { path, roots: roots.clone() } };
    Some(found.into_iter().map(template).collect())
}
