//! [`Slot`]: the places of a pass that refer to resources or published data, and what they are connected to.

use std::collections::BTreeSet;

use serde_json::Value as Json;

use super::draft::{at, path_to};
use super::error::{ChangeError, Changes};
use super::graph::{Graph, keys, one};
use crate::assist::context::PassAt;
use crate::assist::rules::Rules;
use crate::graph::document::Kind;
use crate::graph::expression::{Expression, ExpressionKind};
use crate::graph::language::node_kind;
use crate::graph::model::{Content, DeclarationKind, Id, Text};

/// The index of the bind group whose bindings a pass sets. Lower groups belong to views, higher groups to the host.
const PASS_GROUP: u32 = 1;

/// A place in a pass that holds, or can hold, a reference to a resource or to published data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slot {
    /// The object keys and array indices that lead from the pass to the slot.
    pub keys: Vec<String>,
    /// The display name: the name of the binding, attachment or input, such as `color 0`.
    pub label: String,
    /// The current reference or expression, as written in the file; `None` for an empty slot.
    pub value: Option<String>,
    /// The reason why the slot cannot be connected to another resource; `None` if it can.
    pub refused: Option<String>,
}

impl Graph<'_, '_> {
    /// Returns the slots of a pass: first those with references, then bindings and inputs without a value, then a new
    /// color attachment. Empty if there is no such pass.
    pub(super) fn slots(&self, pass: &str) -> Vec<Slot> {
        let Ok((id, pass)) = self.pass(pass) else { return Vec::new() };
        let mut slots: Vec<Slot> = self
            .references(id)
            .map(|text| Slot {
                label: label(&text.keys),
                keys: text.keys.clone(),
                value: Some(text.text.clone()),
                refused: None,
            })
            .collect();
        let free = self.free(id, &pass).into_iter().map(|keys| Slot {
            label: label(&keys),
            keys,
            value: None,
            refused: None,
        });
        slots.extend(free);
        for slot in &mut slots {
            // Another name of the same length shows whether one can be written there.
            let refused = self.connect_in(id, &pass, &slot.keys, slot.value.as_deref().unwrap_or("&x"));
            slot.refused = refused.err().map(|error| error.to_string());
        }
        slots
    }

    /// Returns the strings of a pass that contain references, outside of `passthrough`. A string may be an expression
    /// that selects one of several references.
    fn references(&self, id: Id) -> impl Iterator<Item = &Text> {
        self.context.model.texts_in(id).filter(|text| match &text.content {
            Content::Expression(expression) => {
                let mut refers = false;
                expression.visit(&mut |part| refers |= matches!(part.kind, ExpressionKind::Reference(_)));
                refers && text.keys.first().is_none_or(|key| key != "passthrough")
            }
            _ => false,
        })
    }

    /// Returns the keys of bindings and inputs without a value, and of a further color attachment if the node kind has
    /// them.
    fn free(&self, id: Id, pass: &PassAt<'_>) -> Vec<Vec<String>> {
        let owned = |keys: &[&str]| keys.iter().map(|key| (*key).to_owned()).collect::<Vec<_>>();
        let mut free = Vec::new();
        if let Some(used) = pass.value.get("use").and_then(|used| used.text()) {
            let subgraph = self.context.model.find(DeclarationKind::Subgraph, used);
            let inputs = self.context.model.declarations().filter(|(_, one)| {
                one.kind == DeclarationKind::Input && one.owner.is_some() && one.owner == subgraph
            });
            let given = pass.value.entries_of("with");
            let missing = inputs.filter(|(_, one)| !given.iter().any(|entry| entry.key == one.name));
            free.extend(missing.map(|(_, one)| owned(&["with", &one.name])));
        }
        let Some(kind) = node_kind(pass.value) else { return free };
        let given = kind.value.entries_of("bind");
        let modules = self.context.modules(pass);
        let bindings = modules.iter().flat_map(|module| &module.reflection.bindings);
        let missing: BTreeSet<&str> = bindings
            .filter(|one| one.group == PASS_GROUP && !one.type_name.starts_with("sampler"))
            .map(|one| one.name.as_str())
            .filter(|name| !given.iter().any(|entry| entry.key == *name))
            .collect();
        free.extend(missing.into_iter().map(|name| owned(&[&kind.key, "bind", name])));
        let settings = Rules::of(self.context.schema).below(["passes", self.name(id), kind.key.as_str()]);
        if settings.keys().iter().any(|(key, _)| *key == "color") {
            let count = kind.value.elements_of("color").len().to_string();
            free.push(owned(&[&kind.key, "color", &count, "to"]));
        }
        free
    }

    pub(super) fn connect(&self, pass: &str, slot: &[String], to: &str) -> Changes {
        let (id, pass) = self.pass(pass)?;
        self.connect_in(id, &pass, slot, to)
    }

    fn connect_in(&self, id: Id, pass: &PassAt<'_>, slot: &[String], to: &str) -> Changes {
        let name = self.name(id);
        let mut path = vec!["passes", name];
        path.extend(keys(slot));
        let there = at(pass.value, &path[2..]);
        if let Some(there) = there {
            let text = there.text().unwrap_or_default();
            if !is_reference(self.references(id).find(|text| text.place == there.span)) {
                return Err(ChangeError::Chosen(text.to_owned()));
            }
            let written = path_to(&self.document(there.span.file).root, there.span);
            if let Some(written) =
                written.filter(|written| written.first().is_some_and(|key| key == "passes"))
            {
                let (file, mut draft) = self.draft(there.span.file)?;
                draft.set(&keys(&written), &Json::from(to))?;
                return Ok(one(file, draft));
            }
        }
        let (file, mut draft) = self.draft(self.file_of(id)?)?;
        let root = draft.root();
        let own = at(&root, &path[..2]).ok_or(ChangeError::Gone)?;
        for count in 1..slot.len() {
            let keys = &path[2..2 + count];
            let is_list = at(pass.value, keys).is_some_and(|one| matches!(one.kind, Kind::Array(_)));
            if is_list && at(own, keys).is_none() {
                return Err(ChangeError::Inherited(label(slot)));
            }
        }
        draft.put(&path, &Json::from(to))?;
        Ok(one(file, draft))
    }
}

/// Returns `true` if a string is a single reference, and not another expression that contains references.
fn is_reference(text: Option<&Text>) -> bool {
    let expression = text.and_then(|text| text.content.expression());
    matches!(expression, Some(Expression { kind: ExpressionKind::Reference(_), .. }))
}

/// Returns the display name of a slot, such as `source`, `color 0`, `depth` or `from`.
fn label(keys: &[String]) -> String {
    let is_said =
        |key: &&String| !matches!(key.as_str(), "bind" | "with" | "to" | "name" | "texture" | "buffer");
    let rest =
        if keys.first().is_some_and(|key| key == "with") { keys } else { keys.get(1..).unwrap_or_default() };
    let said: Vec<&str> = rest.iter().filter(is_said).map(String::as_str).collect();
    match said.as_slice() {
        // A key that is called like one that is left out.
        [] => rest.last().cloned().unwrap_or_default(),
        said => said.join(" "),
    }
}
