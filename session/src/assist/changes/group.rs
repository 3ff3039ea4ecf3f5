//! Passes that become a subgraph, with a use of it in their place.
//!
//! Resources and data that the passes refer to become inputs of the same names, so that the passes keep their texts.
//! The passes after which they have to run become those of the use. Others name them by their new names, `group.pass`.
//!
//! Limits: the passes stand in the pipeline's own file; a resource that they use in two versions of passes outside is
//! not told apart.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value as Json, json};

use super::draft::{at, path_to, position};
use super::error::{ChangeError, Changes};
use super::graph::Graph;
use super::pass::draft_of;
use crate::graph::document::Value;
use crate::graph::edit::{Edit, EditError, Edits, Item};
use crate::graph::model::{DeclarationKind as K, Id};
use crate::graph::source::Span;

impl Graph<'_, '_> {
    pub(super) fn group(&self, passes: &[String], name: &str) -> Changes {
        let model = self.context.model;
        let own = *self.context.composed.files.first().ok_or(ChangeError::Gone)?;
        let mut grouped = BTreeSet::new();
        for pass in passes {
            grouped.insert(self.pass(pass)?.0);
        }
        if grouped.is_empty() || grouped.iter().any(|id| self.files_of(self.name(*id)) != [own]) {
            return Err(ChangeError::Scattered);
        }
        let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(is_of_name) {
            return Err(EditError::NoName(name.to_owned()).into());
        }
        let is_taken = |id: Id| model.declaration(id).name == name && !grouped.contains(&id);
        if model.declarations().any(|(id, _)| is_taken(id)) {
            return Err(EditError::KeyTaken(name.to_owned()).into());
        }
        let Boundary { inputs, after, edits } = self.boundary(&grouped, name)?;
        let mut drafts = BTreeMap::new();
        for (file, list) in edits {
            draft_of(&mut drafts, self, file)?.1.make(&Edits::new(list)?)?;
        }
        let (_, draft) = draft_of(&mut drafts, self, own)?;
        let root = draft.root();
        let all = root.get("passes").and_then(Value::entries).ok_or(ChangeError::Gone)?;
        let members: BTreeSet<&str> = grouped.iter().map(|id| self.name(*id)).collect();
        let members: Vec<&str> =
            all.iter().map(|entry| entry.key.as_str()).filter(|key| members.contains(key)).collect();
        let copies =
            members.iter().map(|member| draft.copied(&["passes", member])).collect::<Result<Vec<_>, _>>()?;
        let first = members
            .first()
            .and_then(|first| position(root.get("passes")?, first))
            .ok_or(ChangeError::Gone)?;
        let mut of_use: Map<String, Json> = [("use".to_owned(), Json::from(name))].into_iter().collect();
        if !inputs.is_empty() {
            of_use.insert(
                "with".to_owned(),
                inputs
                    .iter()
                    .map(|(key, to)| (key.clone(), to.as_str().into()))
                    .collect::<Map<_, _>>()
                    .into(),
            );
        }
        if !after.is_empty() {
            of_use.insert("after".to_owned(), after.into_iter().collect());
        }
        for member in &members {
            draft.remove(&["passes", member])?;
        }
        draft.insert(&["passes"], first, &Item::member(name, of_use.into()))?;
        let described: Map<String, Json> =
            inputs.keys().map(|key| (key.clone(), self.described(key).into())).collect();
        draft.put(&["subgraphs", name], &json!({ "inputs": described, "passes": {} }))?;
        for (position, copy) in copies.iter().enumerate() {
            draft.insert(&["subgraphs", name, "passes"], position, copy)?;
        }
        Ok(drafts.into_values().map(|(file, draft)| (file, draft.into_edits())).collect())
    }

    /// Returns the description for an input of a new subgraph: that of the resource with the same name, or else a
    /// generated one.
    fn described(&self, name: &str) -> String {
        let resource = self.context.model.find(K::Resource, name);
        let value = resource.and_then(|id| self.context.value_of(self.context.model.declaration(id)));
        let words = value.and_then(|value| {
            ["texture", "buffer"].iter().find_map(|kind| value.get(kind)?.get("description")?.text())
        });
        words.map_or_else(|| format!("the pipeline's \"{name}\""), str::to_owned)
    }

    /// Finds the references that cross the boundary of a group of passes, and the edits that adapt them.
    fn boundary(&self, grouped: &BTreeSet<Id>, name: &str) -> Result<Boundary, ChangeError> {
        let model = self.context.model;
        let mut boundary = Boundary::default();
        for text in model.texts() {
            let is_inside = grouped.contains(&text.within);
            let first = text.keys.first().map(String::as_str);
            let named: Vec<Id> = model.named_in(text).collect();
            for id in &named {
                let one = model.declaration(*id);
                let is_outer = one.owner.is_none();
                match one.kind {
                    // Data that a pass inside publishes is its own.
                    K::Resource | K::Data if is_inside && is_outer && !self.is_published(grouped, *id) => {
                        let version = named
                            .iter()
                            .find(|id| model.declaration(**id).kind == K::Pass && !grouped.contains(id));
                        let to = match version {
                            Some(version) => format!("&{}@{}", one.name, model.declaration(*version).name),
                            None => format!("&{}", one.name),
                        };
                        let known = boundary.inputs.insert(one.name.clone(), to.clone());
                        if known.is_some_and(|known| known != to) {
                            return Err(ChangeError::Versions(one.name.clone()));
                        }
                        if let (Some(version), true) = (version, text.text.starts_with('&')) {
                            let version = &model.declaration(*version).name;
                            let rest = text.text.find(&format!("@{version}")).ok_or(ChangeError::Gone)?;
                            let place = text.place.of_quoted(&text.text, rest..text.text.len());
                            boundary.replace(place.ok_or(ChangeError::Gone)?, String::new());
                        } else if version.is_some() {
                            return Err(ChangeError::Chosen(text.text.clone()));
                        }
                    }
                    K::Pass if is_inside && !grouped.contains(id) && first == Some("after") => {
                        self.hoist(text.place, &text.text, &mut boundary)?;
                    }
                    K::Pass if !is_inside && grouped.contains(id) => {
                        let place = model.uses_of(*id).find(|one| {
                            one.place.file == text.place.file
                                && (text.place.start..text.place.end).contains(&one.place.start)
                        });
                        let place = place.ok_or(ChangeError::Gone)?.place;
                        let old = self.context.sources.text(place);
                        if !old.starts_with(one.name.as_str()) {
                            return Err(ChangeError::Chosen(text.text.clone()));
                        }
                        boundary.replace(place, format!("{name}.{old}"));
                    }
                    _ => {}
                }
            }
        }
        Ok(boundary)
    }

    /// Removes a pass outside the group from the list `after` of a pass inside. The group itself runs after that pass
    /// instead.
    fn hoist(&self, place: Span, pass: &str, boundary: &mut Boundary) -> Result<(), ChangeError> {
        let root = self.document(place.file).root;
        let path = path_to(&root, place).ok_or(ChangeError::Gone)?;
        let path: Vec<&str> = path.iter().map(String::as_str).collect();
        let (_, list) = path.split_last().ok_or(ChangeError::Gone)?;
        let (_, owner) = list.split_last().ok_or(ChangeError::Gone)?;
        let (text, list) = (self.file(place).1, (at(&root, list), at(&root, owner)));
        let (Some(list), Some(owner)) = list else { return Err(ChangeError::Gone) };
        let elements = list.elements().unwrap_or_default();
        // Lists of one pass go as a whole; of others the element does.
        let edits = match elements.len() {
            1 => crate::graph::edit::remove(text, owner, position(owner, "after").ok_or(ChangeError::Gone)?)?,
            _ => {
                let at = elements.iter().position(|one| one.span == place).ok_or(ChangeError::Gone)?;
                crate::graph::edit::remove(text, list, at)?
            }
        };
        boundary.edits.entry(place.file).or_default().extend(edits.iter().cloned());
        boundary.after.insert(pass.to_owned());
        Ok(())
    }

    /// Returns `true` if a pass of the group publishes the data, by naming it under `to` in its settings.
    fn is_published(&self, grouped: &BTreeSet<Id>, id: Id) -> bool {
        let model = self.context.model;
        let is_data = model.declaration(id).kind == K::Data;
        let publishes = |text: &crate::graph::model::Text| {
            matches!(text.keys.as_slice(), [_, to] if to == "to")
                && model.named_in(text).any(|named| named == id)
        };
        is_data && grouped.iter().any(|pass| model.texts_in(*pass).any(publishes))
    }
}

/// The references that cross the boundary of a group of passes, and the edits that adapt them.
#[derive(Default)]
struct Boundary {
    /// The references to resources and data outside the group, by the name of the subgraph's input.
    inputs: BTreeMap<String, String>,
    /// The names of the passes after which the group runs.
    after: BTreeSet<String>,
    /// The edits that adapt references, by file.
    edits: BTreeMap<crate::graph::source::FileId, Vec<Edit>>,
}

impl Boundary {
    fn replace(&mut self, place: Span, replacement: String) {
        let edit = Edit { range: place.range(), replacement };
        let edits = self.edits.entry(place.file).or_default();
        if !edits.contains(&edit) {
            edits.push(edit);
        }
    }
}
