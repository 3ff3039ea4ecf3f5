//! Templates and files of axes: which of a session's texts a document is, and how its declarations are shown.
//!
//! Templates that come with the module are no files. So that an editor can show where a name is declared, a copy of such
//! a text is written below the [library folder](Workspace::library) of the server, and answers are given in the copy as
//! well. What is changed there changes nothing.

use std::path::{Component, Path, PathBuf};

use lsp_types::{
    CompletionItemKind, DocumentSymbol, Location, SymbolKind, TextDocumentIdentifier,
    TextDocumentPositionParams,
};

use crate::position::uri_of;
use crate::workspace::{Workspace, document_path, is_template};
use umbragraph_graph::compose::read_bytes;
use umbragraph_graph::source::{FileId, Span};
use umbragraph_session::{TemplateItem, TemplateSymbol};

/// A document that belongs to the templates of a session.
pub(crate) enum Template {
    /// A template.
    Wgsl(FileId),
    /// A file of axes, by its path.
    Axes(PathBuf),
}

/// Returns `true` for the path of a file of axes.
pub(crate) fn is_axes(path: &Path) -> bool {
    path.to_str().is_some_and(|path| path.ends_with(".axes.json"))
}

impl Template {
    /// Returns the template that a document is; `None` for other documents, and for templates that the session lacks.
    pub(crate) fn of(workspace: &mut Workspace, document: &TextDocumentIdentifier) -> Option<Self> {
        let path = document_path(&document.uri).filter(|path| is_template(path))?;
        if is_axes(&path) {
            return Some(Self::Axes(path));
        }
        let library = workspace.library.as_deref();
        let name = library.and_then(|library| path.strip_prefix(library).ok()).unwrap_or(&path);
        Some(Self::Wgsl(workspace.session.template_file(name.to_str()?)?))
    }

    /// Returns the template at a position of a document, and the byte of that position.
    pub(crate) fn at(workspace: &mut Workspace, at: &TextDocumentPositionParams) -> Option<(Self, usize)> {
        let template = Self::of(workspace, &at.text_document)?;
        let file = match &template {
            Self::Wgsl(file) => *file,
            Self::Axes(path) => workspace.session.parsed(path)?.0,
        };
        let offset = workspace.encoding.offset(workspace.session.sources().get(file)?, at.position);
        Some((template, offset))
    }
}

/// Returns the outline of a template. Members stand below their structures.
pub(crate) fn symbols(workspace: &mut Workspace, file: FileId) -> Vec<DocumentSymbol> {
    let symbols = workspace.session.template_symbols(file);
    let Some(source) = workspace.session.sources().get(file) else { return Vec::new() };
    let symbol = |one: &TemplateSymbol| {
        #[expect(deprecated, reason = "the type has no other constructor")]
        DocumentSymbol {
            name: one.name.clone(),
            detail: None,
            kind: symbol_kind(one.kind),
            tags: None,
            deprecated: None,
            range: workspace.encoding.range(source, one.whole),
            selection_range: workspace.encoding.range(source, one.place),
            children: None,
        }
    };
    let mut all: Vec<DocumentSymbol> = Vec::new();
    for one in &symbols {
        match all.last_mut().filter(|_| one.kind == TemplateItem::Member) {
            Some(structure) => structure.children.get_or_insert_default().push(symbol(one)),
            None => all.push(symbol(one)),
        }
    }
    all
}

fn symbol_kind(item: TemplateItem) -> SymbolKind {
    match item {
        TemplateItem::Function | TemplateItem::Macro => SymbolKind::FUNCTION,
        TemplateItem::Structure => SymbolKind::STRUCT,
        TemplateItem::Variable => SymbolKind::VARIABLE,
        TemplateItem::Constant => SymbolKind::CONSTANT,
        TemplateItem::Member => SymbolKind::FIELD,
        TemplateItem::Block => SymbolKind::NAMESPACE,
    }
}

/// Returns the kind of a completion that names a declaration of a template.
pub(crate) fn completion_kind(item: TemplateItem) -> CompletionItemKind {
    match item {
        TemplateItem::Function | TemplateItem::Macro => CompletionItemKind::FUNCTION,
        TemplateItem::Structure => CompletionItemKind::STRUCT,
        TemplateItem::Variable => CompletionItemKind::VARIABLE,
        TemplateItem::Constant => CompletionItemKind::CONSTANT,
        TemplateItem::Member => CompletionItemKind::FIELD,
        TemplateItem::Block => CompletionItemKind::MODULE,
    }
}

impl Workspace {
    /// Returns the location of a place. For a text that comes with the module, writes a copy below the library folder,
    /// and returns the location there; `None` without such a folder, or if the copy cannot be written.
    pub(crate) fn readable(&self, place: Span) -> Option<Location> {
        if let Some(location) = self.location(place) {
            return Some(location);
        }
        let file = self.session.sources().get(place.file)?;
        let name = Path::new(file.name());
        if !name.components().all(|part| matches!(part, Component::Normal(_))) || !is_template(name) {
            return None;
        }
        let path = self.library.as_ref()?.join(name);
        let text = file.text().as_bytes();
        if read_bytes(&path, text.len() as u64).ok().flatten().as_deref() != Some(text) {
            // Another server may read it at the same time.
            let part = path.with_extension(format!("{}.part", std::process::id()));
            std::fs::create_dir_all(path.parent()?).ok()?;
            std::fs::write(&part, text).and_then(|()| std::fs::rename(&part, &path)).ok()?;
        }
        Some(Location { uri: uri_of(&path)?, range: self.encoding.range(file, place) })
    }
}
