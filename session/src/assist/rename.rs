//! Renames that leave the values of shader axes as they are.
//!
//! An axis of a template takes its value by its own name: from a feature, parameter or derived value, unless the pass
//! sets it under `axes`. No text of the pipeline names it, so a rename of the feature alone gives the axis its default,
//! and the picture changes. Where an axis takes the renamed value, the old name stays as a derived value:
//!
//! ```jsonc
//! "features": { "hot": { "type": "bool", "default": true } },
//! "derived": { "warm": "=hot" } // added: the template has an axis "warm"
//! ```
//!
//! One line serves all passes, those of bundled files and of other pipelines that read the file among them. A name that
//! an axis has already is refused as the new one, since the axis would take the value.
//!
//! Limits: only settings with the key `shader` of a pass are known to name a template. The variable of a loop in a
//! subgraph file cannot be a derived value, and is refused. Parameter files belong to no pipeline, and are not renamed;
//! the language server names them to the user.

use std::collections::BTreeMap;

use serde_json::{Value as Json, json};

use super::context::Context;
use crate::graph::compose::{Layer, is_path};
use crate::graph::document::{Document, Kind, Value, parse};
use crate::graph::edit::{EditError, Edits, Item, insert, rename_declaration};
use crate::graph::language::node_kind;
use crate::graph::model::{Declaration, DeclarationKind as K, Id};
use crate::graph::shader::{Axis, AxisValue};
use crate::graph::source::Span;

/// The edits of a rename, by file name, or the error that prevents the rename.
pub type Renamed = Result<BTreeMap<String, Edits>, RenameError>;

/// The reason why a name cannot be changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RenameError {
    /// A name that is invalid or taken, or a use that does not spell out the name.
    Edit(EditError),
    /// A new name that is also an axis of a template, which would take the renamed value.
    AxisTakes {
        /// The axis, and the new name.
        axis: String,
        /// The name of the template.
        template: String,
        /// The name of the pass.
        pass: String,
        /// The default of the axis as JSON, which is its value before the rename.
        default: String,
    },
    /// A name of a template that cannot get another name, with the reason.
    Refused(String),
    /// An axis that takes the value of the old name, which cannot stay as a derived value.
    AxisLoses {
        /// The axis, and the old name.
        axis: String,
        /// The name of the template.
        template: String,
        /// The name of the pass.
        pass: String,
        /// The reason why no derived value can have the old name.
        obstacle: &'static str,
    },
}

impl std::fmt::Display for RenameError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Edit(error) => write!(f, "{error}"),
            Self::Refused(reason) => write!(f, "{reason}"),
            Self::AxisTakes { axis, template, pass, default } => write!(
                f,
                "the axis \"{axis}\" of {template} would take this value, since the pass \"{pass}\" does not set \
                 it; choose another name, or write \"axes\": {{ \"{axis}\": {default} }} in the pass"
            ),
            Self::AxisLoses { axis, template, pass, obstacle } => write!(
                f,
                "the axis \"{axis}\" of {template} takes this value by its name, and {obstacle}; write \
                 \"axes\": {{ \"{axis}\": \"={axis}\" }} in the pass \"{pass}\" first"
            ),
        }
    }
}

impl std::error::Error for RenameError {}

impl From<EditError> for RenameError {
    fn from(error: EditError) -> Self {
        Self::Edit(error)
    }
}

/// An axis that takes the value of its own name in a pass.
struct Reader<'a> {
    pass: &'a str,
    template: &'a str,
    axis: &'a Axis,
}

/// Returns the edits that rename a declaration and all its uses, and that keep the values of axes.
pub(super) fn rename(context: &Context<'_>, id: Id, name: &str) -> Renamed {
    let Context { sources, composed, model, .. } = *context;
    let mut edits = rename_declaration(sources, composed, model, id, name)?;
    if let Some(Reader { pass, template, axis }) = readers(context, id, name).next() {
        let default = match &axis.default {
            AxisValue::Name(word) => Json::from(word.as_str()).to_string(),
            other => other.to_string(),
        };
        let [axis, template, pass] = [&axis.name, template, pass].map(str::to_owned);
        return Err(RenameError::AxisTakes { axis, template, pass, default });
    }
    let old = &model.declaration(id).name;
    let Some(Reader { pass, template, .. }) = readers(context, id, old).next() else { return Ok(edits) };
    if let Some(obstacle) = obstacle(context, id) {
        let [axis, template, pass] = [old, template, pass].map(str::to_owned);
        return Err(RenameError::AxisLoses { axis, template, pass, obstacle });
    }
    for file in declaring(context, id) {
        let (file, kept) = kept(context, id, name, file)?;
        let of_file = edits.entry(file).or_default();
        *of_file = of_file.and(&kept)?;
    }
    Ok(edits)
}

/// Returns the passes in which an axis with the name `name` takes the value of a declaration, if that has the name.
fn readers<'a>(context: &Context<'a>, id: Id, name: &str) -> impl Iterator<Item = Reader<'a>> {
    let Context { model, loaded, .. } = *context;
    let declaration = model.declaration(id);
    let typed = context.value_of(declaration).and_then(|value| value.get("type")?.text());
    let is_list = typed.is_some_and(|typed| typed.ends_with("[]"));
    let passes = model.declarations().filter(move |(_, one)| one.kind == K::Pass && !is_list);
    passes.filter_map(move |(at, pass)| {
        // A subgraph in a file of its own sees its own names, any other pass those of the pipeline.
        let file = pass.owner.filter(|owner| is_path(&model.declaration(*owner).name));
        let is_seen = match declaration.kind {
            K::Variable => declaration.owner == Some(at) && file.is_some(),
            K::Parameter | K::Feature | K::Derived => declaration.owner == file,
            _ => false,
        };
        let settings = &node_kind(context.value_of(pass)?)?.value;
        let is_set = settings.get("axes").is_some_and(|axes| axes.get(name).is_some());
        let template = settings.get("shader").and_then(Value::text).filter(|_| is_seen && !is_set)?;
        let axis = loaded.templates().axes(template)?.get(name)?;
        Some(Reader { pass: &pass.name, template, axis })
    })
}

/// Returns the reason why no derived value can have the name of a declaration besides it; `None` if one can.
fn obstacle(context: &Context<'_>, id: Id) -> Option<&'static str> {
    let declaration = context.model.declaration(id);
    let is_twin = |other: &Declaration| {
        let is_other = matches!(other.kind, K::Resource | K::Input | K::Data);
        is_other && other.owner == declaration.owner && other.name == declaration.name
    };
    match declaration.kind {
        K::Variable => Some("the value of a loop cannot stay under its old name"),
        _ if context.model.declarations().any(|(_, other)| is_twin(other)) => {
            Some("a resource, input or data has the same name")
        }
        _ => None,
    }
}

/// Returns the places in all files that declare a value. Each file may be that of another pipeline, too. A file that
/// only gives another default is not one that declares.
fn declaring(context: &Context<'_>, id: Id) -> Vec<Span> {
    let Context { sources, composed, model, .. } = *context;
    let declaration = model.declaration(id);
    let place = context
        .value_of(declaration)
        .map_or(declaration.place, |value| value.get("type").unwrap_or(value).span);
    let mut places = vec![place];
    for file in composed.files.iter().filter(|file| declaration.kind == K::Derived && **file != place.file) {
        let Document { root } = parse(sources, *file).document;
        let is_own = declaration.owner.is_none() && composed.layers.get(file) != Some(&Layer::Used);
        let derived = root.get("derived").and_then(|section| section.get(&declaration.name));
        places.extend(derived.filter(|_| is_own).map(|value| value.span));
    }
    places
}

/// Returns the edits that add a derived value with the old name to the file that declares a renamed value at `place`,
/// and the name of the file.
fn kept(context: &Context<'_>, id: Id, name: &str, place: Span) -> Result<(String, Edits), EditError> {
    let declaration = context.model.declaration(id);
    let file = context.sources.get(place.file).ok_or(EditError::NoContainer)?;
    let Document { root } = parse(context.sources, place.file).document;
    let expression = Json::from(format!("={name}"));
    let edits = match root.get("derived") {
        Some(section) => {
            // A derived value gives its name up by the same edits.
            let mut section = section.clone();
            if let Kind::Object(entries) = &mut section.kind {
                let old = entries.iter_mut().filter(|entry| entry.key == declaration.name);
                old.for_each(|entry| entry.key = name.to_owned());
            }
            let count = section.entries().unwrap_or_default().len();
            insert(file.text(), &section, count, &Item::member(&declaration.name, expression))
        }
        None => {
            let sections = root.entries().unwrap_or_default();
            let is_around = |value: &Value| (value.span.start..value.span.end).contains(&place.start);
            let at = sections.iter().position(|section| is_around(&section.value));
            let at = at.map_or(sections.len(), |at| at + 1);
            let old = declaration.name.as_str();
            insert(file.text(), &root, at, &Item::member("derived", json!({ old: expression })))
        }
    };
    Ok((file.name().to_owned(), edits?))
}
