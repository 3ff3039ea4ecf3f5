//! The declarations of a document, and the scopes in which their names are known.

use std::collections::BTreeMap;

use super::{Declaration, DeclarationKind, Id, Model, section};
use crate::compose::is_path;
use crate::document::{Entry, Value, pointer_join};
use crate::language;

/// The names that are visible in a pipeline or in a subgraph.
#[derive(Debug, Default)]
pub(super) struct Scope {
    /// The subgraph that declares the names; `None` for the pipeline.
    pub(super) owner: Option<Id>,
    /// Whether the names of the pipeline are visible in addition; `false` in subgraph files.
    pub(super) sees_pipeline: bool,
    /// The names that expressions and references can use.
    pub(super) values: BTreeMap<String, Id>,
    pub(super) passes: BTreeMap<String, Id>,
    pub(super) others: BTreeMap<(DeclarationKind, String), Id>,
}

/// The sections of a pipeline or subgraph whose entries are declarations: the key, the kind of declaration, and whether
/// expressions and references can use the names.
pub(super) const SECTIONS: [(&str, DeclarationKind, bool); 12] = [
    ("parameters", DeclarationKind::Parameter, true),
    ("features", DeclarationKind::Feature, true),
    ("derived", DeclarationKind::Derived, true),
    ("inputs", DeclarationKind::Input, true),
    ("resources", DeclarationKind::Resource, true),
    ("constraints", DeclarationKind::Constraint, false),
    ("passes", DeclarationKind::Pass, false),
    ("toggles", DeclarationKind::Toggle, false),
    ("geometry", DeclarationKind::Geometry, false),
    ("presets", DeclarationKind::Preset, false),
    ("extension_points", DeclarationKind::ExtensionPoint, false),
    ("shared_settings", DeclarationKind::SharedSettings, false),
];

/// Adds all declarations of a document to the model. Returns the scope of the pipeline, then the scopes of its
/// subgraphs in the order of the document.
pub(super) fn declare(model: &mut Model, root: &Value) -> Vec<Scope> {
    let subgraphs = section(root, "subgraphs");
    let mut top = of_owner(model, root, None, "");
    top.sees_pipeline = true;
    let ids: Vec<Id> = subgraphs
        .iter()
        .map(|entry| {
            let pointer = pointer_join("/subgraphs", &entry.key);
            let id = add(model, DeclarationKind::Subgraph, entry, None, pointer);
            top.others.insert((DeclarationKind::Subgraph, entry.key.clone()), id);
            id
        })
        .collect();
    let mut scopes = vec![top];
    for (entry, id) in subgraphs.iter().zip(ids) {
        let pointer = model.declaration(id).pointer.clone();
        let scope = of_owner(model, &entry.value, Some(id), &pointer);
        scopes.push(Scope { sees_pipeline: !is_path(&entry.key), ..scope });
    }
    scopes
}

fn of_owner(model: &mut Model, owner: &Value, id: Option<Id>, pointer: &str) -> Scope {
    let mut scope = Scope { owner: id, ..Scope::default() };
    for (name, kind, is_value) in SECTIONS {
        let above = format!("{pointer}/{name}");
        for entry in section(owner, name) {
            let one = add(model, kind, entry, id, pointer_join(&above, &entry.key));
            if is_value {
                scope.values.entry(entry.key.clone()).or_insert(one);
            }
            if kind == DeclarationKind::Pass {
                scope.passes.insert(entry.key.clone(), one);
                let kind = language::node_kind(&entry.value).map(|kind| kind.key.clone());
                kind.into_iter().for_each(|kind| drop(model.kinds.insert(one, kind)));
            } else {
                scope.others.insert((kind, entry.key.clone()), one);
            }
        }
    }
    scope
}

fn add(model: &mut Model, kind: DeclarationKind, entry: &Entry, owner: Option<Id>, pointer: String) -> Id {
    add_at(model, Declaration { kind, name: entry.key.clone(), place: entry.key_span, owner, pointer })
}

pub(super) fn add_at(model: &mut Model, declaration: Declaration) -> Id {
    model.declarations.push(declaration);
    Id(model.declarations.len() - 1)
}
