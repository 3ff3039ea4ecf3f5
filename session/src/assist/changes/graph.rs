//! [`Graph`]: the texts of a pipeline whose graph is changed, and where its passes stand in them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::draft::Draft;
use super::error::{ChangeError, Changes};
use crate::assist::context::{Context, PassAt};
use crate::graph::document::{Document, Value, parse};
use crate::graph::edit::{Edits, rename_declaration};
use crate::graph::language::node_kind;
use crate::graph::model::{DeclarationKind, Id};
use crate::graph::source::{FileId, Span};

/// The pass graph of a pipeline as its files declare it. Its methods return the edits that change the graph.
pub(super) struct Graph<'c, 'a> {
    pub(super) context: &'c Context<'a>,
}

impl<'a> Graph<'_, 'a> {
    /// Returns the declared pass for a name. The name of a loop round (`down.1`) or of a pass in a subgraph (`soft.up`)
    /// gives the pass that the file declares.
    pub(super) fn pass(&self, name: &str) -> Result<(Id, PassAt<'a>), ChangeError> {
        let written = name.split('.').next().unwrap_or_default();
        let model = self.context.model;
        let unknown = || ChangeError::Unknown(name.to_owned());
        let id = model.find(DeclarationKind::Pass, written).ok_or_else(unknown)?;
        let declaration = model.declaration(id);
        let value = self.context.value_of(declaration).ok_or_else(unknown)?;
        Ok((id, PassAt { id, pointer: &declaration.pointer, value }))
    }

    /// Returns `true` if a file name begins with a scheme of the storage, such as `umbragraph:`. Such files are bundled
    /// and cannot be changed.
    pub(super) fn is_bundled(&self, name: &str) -> bool {
        name.split_once(':').is_some_and(|(scheme, _)| self.context.files.has_scheme(scheme))
    }

    pub(super) fn name(&self, id: Id) -> &'a str {
        &self.context.model.declaration(id).name
    }

    pub(super) fn file(&self, place: Span) -> (String, &'a str) {
        let file = self.context.sources.get(place.file);
        file.map_or((String::new(), ""), |file| (file.name().to_owned(), file.text()))
    }

    pub(super) fn document(&self, file: FileId) -> Document {
        parse(self.context.sources, file).document
    }

    /// Creates a draft for editing a file, and returns it with the name of the file. Returns an error for bundled
    /// files.
    pub(super) fn draft(&self, file: FileId) -> Result<(String, Draft), ChangeError> {
        let (name, text) = self.file(Span::new(file, 0..0));
        if self.is_bundled(&name) {
            return Err(ChangeError::Bundled(name));
        }
        let draft = Draft::new(&name, text)?;
        Ok((name, draft))
    }

    /// Returns the files that contain settings of a pass, the pipeline's own file first.
    pub(super) fn files_of(&self, pass: &str) -> Vec<FileId> {
        let has = |file: &&FileId| {
            self.document(**file).root.get("passes").is_some_and(|all| all.get(pass).is_some())
        };
        self.context.composed.files.iter().filter(has).copied().collect()
    }

    /// Returns the file in which to edit a pass: the pipeline's own file if it contains settings of the pass, else the
    /// file that declares the pass.
    pub(super) fn file_of(&self, id: Id) -> Result<FileId, ChangeError> {
        let files = self.files_of(self.name(id));
        let (own, declared) =
            (self.context.composed.files.first(), self.context.model.declaration(id).place.file);
        let found =
            own.filter(|own| files.contains(own)).copied().or(files.contains(&declared).then_some(declared));
        found.or(files.first().copied()).ok_or_else(|| ChangeError::Unknown(self.name(id).to_owned()))
    }

    pub(super) fn rename(&self, from: &str, to: &str) -> Changes {
        use DeclarationKind as K;
        let Context { model, sources, composed, .. } = *self.context;
        let written = from.split('.').next().unwrap_or_default();
        let resource = model.find(K::Resource, from);
        let id = model.find(K::Pass, written).filter(|_| resource.is_none()).or(resource);
        let id = id.ok_or_else(|| ChangeError::Unknown(from.to_owned()))?;
        let edits = rename_declaration(sources, composed, model, id, to)?;
        match edits.keys().find(|name| self.is_bundled(name)) {
            Some(name) => Err(ChangeError::Bundled(name.clone())),
            None => Ok(edits),
        }
    }
}

/// Returns the edits of a draft as a change of that file only.
pub(super) fn one(name: String, draft: Draft) -> BTreeMap<String, Edits> {
    [(name, draft.into_edits())].into_iter().collect()
}

/// Borrows a list of keys as string slices.
pub(super) fn keys(of: &[String]) -> Vec<&str> {
    of.iter().map(String::as_str).collect()
}

/// Returns the node kind of a pass, or `use` for a pass that uses a subgraph; `None` if it has neither.
pub(super) fn kind_name(pass: &Value) -> Option<&str> {
    node_kind(pass).map(|entry| entry.key.as_str()).or_else(|| pass.get("use").map(|_| "use"))
}

/// Returns the folder that contains a file; empty if the path has no folder.
pub(super) fn folder(path: &Path) -> PathBuf {
    path.parent().map(Path::to_owned).unwrap_or_default()
}
