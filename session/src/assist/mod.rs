//! Answers for editors: what can stand at a place, what stands there, where it is declared and used.
//!
//! Each answer is about a [`Cursor`]: a byte of a file of a pipeline. Files may be broken, and need not be saved. Keys
//! come from the schema of the file's kind, names from the [model](crate::graph::model) of what is understood of the
//! pipeline, bindings and axes from the shaders of the pass at hand.
//!
//! Limits: values that another file replaces are in no composed document, so names in them lead nowhere. Paths of files
//! are not proposed, since a [`Storage`](crate::Storage) lists none.

mod axes;
mod bindings;
mod changes;
mod colors;
mod context;
mod expected;
mod rename;
mod rules;
mod site;
mod template;
mod values;
mod words;

use std::path::Path;
use std::sync::Arc;

use serde_json::Value as Json;

use crate::cancel::Cancelled;
use crate::choice::{Choice, Target};
use crate::files::{Read, Role};
use crate::graph::compose::normalize;
use crate::graph::diagnostic::Diagnostics;
use crate::graph::document::schema::Schema;
use crate::graph::document::{Document, Parsed, Value};
use crate::graph::model::{Declaration, DeclarationKind, Id};
use crate::graph::pipeline::{FileKind, schema_of};
use crate::graph::source::{FileId, Span};
use crate::graph::why::{Subject, human, why};
use crate::session::Session;
pub use changes::{Change, ChangeError, Changes, Slot, Written};
pub use colors::{Color, is_about_color};
use context::Context;
pub use rename::{RenameError, Renamed};
use site::Spot;
pub use template::{TemplateItem, TemplateSymbol};
pub use values::Computed;

/// A position in a file of a pipeline, and the configuration to show there.
#[derive(Clone, Copy, Debug)]
pub struct Cursor<'a> {
    /// The pipeline that the file belongs to.
    pub target: &'a Target,
    /// The configuration whose values are shown.
    pub choice: &'a Choice,
    /// The path of the file that contains the position.
    pub path: &'a Path,
    /// The byte offset of the position in the file.
    pub offset: usize,
}

/// The completion candidates for a position.
#[derive(Clone, Debug)]
pub struct Expected {
    /// The byte range that a candidate replaces.
    pub replaced: Span,
    /// The proposed completions; empty if nothing fits.
    pub candidates: Vec<Candidate>,
}

/// A completion candidate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// The kind of thing that the candidate names.
    pub kind: CandidateKind,
    /// The name shown to the user.
    pub label: String,
    /// The text that replaces the range.
    pub text: String,
    /// A short detail, such as type, default or format; `None` if there is none.
    pub detail: Option<String>,
    /// The description of the key, name or function, in Markdown; `None` if there is none.
    pub description: Option<String>,
}

/// The kinds of completion candidates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CandidateKind {
    /// An object key that the JSON schema defines.
    Key,
    /// A fixed value: a word of an enumeration, `true` or `false`.
    Word,
    /// The name of a declaration, such as a resource or a pass.
    Name(DeclarationKind),
    /// A function of the expression language, or its built-in value `viewport`.
    Function,
    /// A shader template.
    Template,
    /// A binding that the shader of a pass declares.
    Binding,
    /// An axis of the shader template of a pass: an option that selects a shader variant.
    Axis,
    /// A declaration in a template.
    OfTemplate(TemplateItem),
}

/// The hover text for a position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hover {
    /// The source range that the text describes.
    pub place: Span,
    /// The content to display.
    pub text: String,
    /// Whether line breaks and spaces must be kept, as in the output of `umbragraph why`; `false` for Markdown.
    pub is_preformatted: bool,
}

/// Returns the kind of a file, recognized by the top-level keys of its document. Returns `None` if the file may be
/// unrelated to pipelines, such as `package.json`.
pub fn kind_of(document: &Document) -> Option<FileKind> {
    let has = |key| document.root.get(key).is_some();
    if has("inserts") {
        return Some(FileKind::Extension);
    }
    if document.root.get("inputs").is_some_and(|inputs| inputs.entries().is_some()) {
        return Some(FileKind::Subgraph);
    }
    let sections = ["passes", "resources", "subgraphs", "extends", "include", "geometry", "name"];
    let is_pipeline = ["format", "passes", "resources"].into_iter().any(has);
    let pipeline = is_pipeline.then_some(FileKind::Pipeline);
    if sections.into_iter().any(has) {
        return pipeline;
    }
    let is_declared = |value: &Value| value.get("type").is_some();
    let given = ["parameters", "features"].map(|key| document.root.get(key).and_then(Value::entries));
    let mut given = given.into_iter().flatten().flatten().peekable();
    let has_values = given.peek().is_some() || has("preset");
    match has_values && !given.any(|entry| is_declared(&entry.value)) {
        true => Some(FileKind::Parameters),
        false => pipeline,
    }
}

impl Session {
    /// Parses one file, without the files that it names. Returns its identifier and what the text was parsed to, even
    /// if parts of it are invalid; `None` if the file cannot be read.
    pub fn parsed(&mut self, path: &Path) -> Option<(FileId, Arc<Parsed>)> {
        let reads = [Read { path: path.to_owned(), revision: 0 }];
        self.files.settle(&reads);
        let done = &mut self.done;
        self.files.with_sources(|files, sources| {
            let file = files.read(path, None, Role::Document, sources, done).ok()?;
            Some((file, files.parsed(file, sources, done)))
        })
    }

    /// Validates an extension, subgraph or parameter file against the JSON schema of its kind. Returns `None` for a
    /// pipeline, an unknown kind of file, or an invalid document.
    pub fn check_part(&mut self, path: &Path) -> Option<(FileKind, Diagnostics)> {
        let (_, parsed) = self.parsed(path).filter(|(_, parsed)| parsed.diagnostics.is_empty())?;
        let kind = kind_of(&parsed.document).filter(|kind| *kind != FileKind::Pipeline)?;
        let mut diagnostics = Diagnostics::new();
        Schema::new(&self.schema(kind)).check(&parsed.document.root, "", &mut diagnostics);
        Some((kind, diagnostics))
    }

    fn schema(&mut self, kind: FileKind) -> Arc<Json> {
        if let Some((_, schema)) = self.schemas.iter().find(|(known, _)| *known == kind) {
            return schema.clone();
        }
        let schema = Arc::new(schema_of(kind, self.registry()));
        self.schemas.push((kind, schema.clone()));
        schema
    }

    /// Loads the pipeline of a cursor, and calls `answer` with the context. Returns `None` if `answer` does,
    /// or if the cursor's file or the first file of the pipeline cannot be read.
    fn around<T>(
        &mut self,
        cursor: &Cursor<'_>,
        answer: impl FnOnce(&Context<'_>) -> Option<T>,
    ) -> Result<Option<T>, Cancelled> {
        let Cursor { target, choice, path, offset } = *cursor;
        let loaded = self.load_exactly(target)?;
        let known = self.files.path_among(path, &loaded.composition().reads);
        let Some((file, parsed)) = self.parsed(known.as_deref().unwrap_or(path)) else { return Ok(None) };
        let document = &parsed.document;
        let kind = kind_of(document).unwrap_or(FileKind::Pipeline);
        let schema = self.schema(kind);
        let sources = self.files.settled();
        let text = sources.get(file).map(|file| file.text().clone()).unwrap_or_else(|| "".into());
        let Some((composed, model)) = loaded.understood().zip(loaded.model()) else { return Ok(None) };
        Ok(answer(&Context {
            loaded: &loaded,
            choice,
            composed,
            model,
            sources,
            files: &self.files,
            schema: &schema,
            kind,
            file,
            text: &text,
            document,
            offset,
        }))
    }

    /// Returns the completion candidates for a position; `None` if the file cannot be read.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn expected_at(&mut self, cursor: &Cursor<'_>) -> Result<Option<Expected>, Cancelled> {
        self.around(cursor, |context| Some(expected::expected(context)))
    }

    /// Returns the hover text for a position: the explanation by [`why`] for a name, the schema's description for a
    /// key, the value of a function of expressions, and the uses of a texture format. Returns `None` elsewhere.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn hover(&mut self, cursor: &Cursor<'_>) -> Result<Option<Hover>, Cancelled> {
        self.around(cursor, |context| {
            if let Some((place, text)) = words::told(context) {
                let hover = Hover { place, text, is_preformatted: false };
                return Some(hover);
            }
            let site = context.site();
            let (_, rules) = context.named(&site);
            let place = context.span(site.replaced.clone());
            let named = declaration_at(context).and_then(|(id, place)| Some((told(context, id)?, place)));
            let described = rules.description().map(str::to_owned);
            match (named, described) {
                (Some((text, place)), _) => Some(Hover { place, text, is_preformatted: true }),
                (None, Some(text)) if !site.replaced.is_empty() => {
                    Some(Hover { place, text, is_preformatted: false })
                }
                _ => None,
            }
        })
    }

    /// Returns the values of the expressions in a file, in source order; empty if the pipeline cannot be loaded.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn values(
        &mut self,
        target: &Target,
        choice: &Choice,
        path: &Path,
    ) -> Result<Vec<Computed>, Cancelled> {
        let cursor = Cursor { target, choice, path, offset: 0 };
        Ok(self.around(&cursor, |context| Some(values::computed(context)))?.unwrap_or_default())
    }

    /// Returns the colors of a file, in source order; empty if the pipeline cannot be loaded.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn colors(&mut self, target: &Target, choice: &Choice, path: &Path) -> Result<Vec<Color>, Cancelled> {
        let cursor = Cursor { target, choice, path, offset: 0 };
        Ok(self.around(&cursor, |context| Some(colors::colors(context)))?.unwrap_or_default())
    }

    /// Returns the place where the name at a position is declared: in JSON, in a template, or as a binding in WGSL. For
    /// the path of a file, returns the start of that file. Empty if there is no declaration.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn definition(&mut self, cursor: &Cursor<'_>) -> Result<Vec<Span>, Cancelled> {
        let found = self.around(cursor, |context| {
            if let Some((id, _)) = declared_at(context) {
                return Some((vec![context.model.declaration(id).place], None));
            }
            Some(definition_besides(context))
        })?;
        let (mut places, path) = found.unwrap_or_default();
        if let Some((file, _)) = path.and_then(|path| self.parsed(&path)) {
            places.push(Span::new(file, 0..0));
        }
        Ok(places)
    }

    /// Returns the declaration and all uses of the name at a position, the declaration first. For the name of a binding,
    /// these are its declaration in WGSL and the keys of the passes that bind it. Empty if no declared name is there.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn references(&mut self, cursor: &Cursor<'_>) -> Result<Vec<Span>, Cancelled> {
        let found = self.around(cursor, |context| {
            let Some((id, _)) = declared_at(context) else { return Some(bindings::references(context)) };
            let uses = context.model.uses_of(id).map(|one| one.place);
            let mut places = vec![context.model.declaration(id).place];
            places.extend(uses);
            places.dedup();
            Some(places)
        })?;
        Ok(found.unwrap_or_default())
    }

    /// Returns the source range and the text of the name at a position; `None` if there is no name that can be changed.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn renamable(&mut self, cursor: &Cursor<'_>) -> Result<Option<(Span, String)>, Cancelled> {
        self.around(cursor, |context| {
            let (id, place) = declared_at(context)?;
            Some((place, context.model.declaration(id).name.clone()))
        })
    }

    /// Returns the declaration whose name is at a position; `None` if no declared name is there.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn declared(&mut self, cursor: &Cursor<'_>) -> Result<Option<Declaration>, Cancelled> {
        self.around(cursor, |context| Some(context.model.declaration(declared_at(context)?.0).clone()))
    }

    /// Returns the place of a name under `bind` at a position, and the place of its declaration in a template. `None`
    /// if no such name is there, or if the shader of the pass does not declare it.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set).
    pub fn binding_at(&mut self, cursor: &Cursor<'_>) -> Result<Option<(Span, Span)>, Cancelled> {
        self.around(cursor, |context| {
            let (name, declared) = bindings::declared_at(context)?;
            let Spot::Key { entry: Some(entry), .. } = context.site().spot else { return None };
            let key = entry.key_span.of_quoted(name, 0..name.len()).unwrap_or(entry.key_span);
            Some((key, declared))
        })
    }

    /// Returns the edits that rename the declaration at a position, and all its uses, in the pipeline's files. Shader
    /// axes keep their values: for an axis that takes the value of the old name, the edits add a derived value of that
    /// name. Returns `None` if no declared name is there.
    ///
    /// # Errors
    /// Returns [`Cancelled`] after [`Cancel::set`](crate::Cancel::set). The inner result is an error if the new name is
    /// invalid or taken, if a use cannot be renamed, or if an axis would take another value.
    pub fn rename(&mut self, cursor: &Cursor<'_>, name: &str) -> Result<Option<Renamed>, Cancelled> {
        self.around(cursor, |context| {
            let (id, _) = declared_at(context)?;
            Some(rename::rename(context, id, name))
        })
    }
}

/// Returns the declaration whose name is at the cursor, and the source range of the name there.
fn declaration_at(context: &Context<'_>) -> Option<(Id, Span)> {
    let offset = u32::try_from(context.offset).ok()?;
    let id = context.model.declaration_at(context.file, offset)?;
    let is_here = |place: &Span| place.file == context.file && (place.start..=place.end).contains(&offset);
    let uses = context.model.uses_of(id).map(|one| one.place);
    let places = uses.chain([context.model.declaration(id).place]).filter(is_here);
    Some((id, places.min_by_key(|place| place.end - place.start)?))
}

/// Returns the declaration whose name is at the cursor, and the source range of the name there. For a key that another
/// file declares or sets again, returns the declaration of that name.
fn declared_at(context: &Context<'_>) -> Option<(Id, Span)> {
    declaration_at(context).or_else(|| {
        let site = context.site();
        let Spot::Key { entry: Some(entry), .. } = &site.spot else { return None };
        let position = context.position(&site);
        let (kind, owner) = match position.way.as_slice() {
            ["parameters"] => (DeclarationKind::Parameter, position.owner),
            ["features"] => (DeclarationKind::Feature, position.owner),
            ["derived"] => (DeclarationKind::Derived, position.owner),
            ["resources"] => (DeclarationKind::Resource, position.owner),
            ["passes"] => (DeclarationKind::Pass, position.owner),
            ["presets", _, "parameters"] => (DeclarationKind::Parameter, None),
            ["presets", _, "features"] => (DeclarationKind::Feature, None),
            _ => return None,
        };
        let is_it = |one: &Declaration| one.kind == kind && one.owner == owner && one.name == entry.key;
        let (id, _) = context.model.declarations().find(|(_, one)| is_it(one))?;
        let name = entry.key_span.of_quoted(&entry.key, 0..entry.key.len());
        Some((id, name.unwrap_or(entry.key_span)))
    })
}

/// Returns the explanation of a declaration by [`why`] as text; `None` if there is none.
fn told(context: &Context<'_>, id: Id) -> Option<String> {
    let declaration = context.model.declaration(id);
    let Context { composed, model, sources, choice, .. } = *context;
    let planned = context.planned();
    let subject =
        Subject { composed, model, overrides: &choice.overrides, checked: &planned.report, sources };
    let mut things = why(&subject, &declaration.name, declaration.place).ok()?;
    let (file, place) = (sources.get(declaration.place.file)?, declaration.place);
    let at = file.line_column(place.start);
    let is_it = |thing: &crate::graph::why::Thing| {
        thing.declared.file == file.name()
            && (thing.declared.line, thing.declared.column) == (at.line, at.column)
    };
    if things.iter().any(is_it) {
        things.retain(is_it);
    }
    Some(human(&things))
}

/// Returns the place of the template or binding that is named at the cursor. For the path of a file, returns the path
/// in place of a source range.
fn definition_besides(context: &Context<'_>) -> (Vec<Span>, Option<std::path::PathBuf>) {
    let site = context.site();
    let position = context.position(&site);
    let folder = context.sources.get(context.file).and_then(|file| Path::new(file.name()).parent());
    let path = |name: &str| Some(normalize(&folder?.join(name)));
    match (site.spot, position.way.as_slice()) {
        (Spot::Key { entry: Some(_), .. }, ["passes" | "shared_settings", .., "bind"]) => {
            (bindings::declared_at(context).map(|(_, place)| place).into_iter().collect(), None)
        }
        (Spot::Value(Some(value)), way) => match (value.text(), way) {
            (Some(name), [.., "shader"]) => {
                let file = context.loaded.templates().file(name);
                (file.map(|file| Span::new(file, 0..0)).into_iter().collect(), None)
            }
            (Some(name), ["extends" | "include", ..] | ["passes", _, "use"]) => (Vec::new(), path(name)),
            _ => (Vec::new(), None),
        },
        _ => (Vec::new(), None),
    }
}
