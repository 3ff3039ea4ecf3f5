//! Passes that are switched on and off, moved and removed.

use std::collections::BTreeMap;

use serde_json::Value as Json;

use super::draft::{Draft, at, path_to, position};
use super::error::{ChangeError, Changes};
use super::graph::{Graph, kind_name, one};
use crate::graph::document::Kind;
use crate::graph::edit::{Edits, Item};
use crate::graph::model::{DeclarationKind, Text};
use crate::graph::source::{FileId, Span};

/// A pass as the files of a pipeline declare it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Written {
    /// The name of the pass.
    pub name: String,
    /// The node kind, or `use` for a pass that uses a subgraph.
    pub kind: String,
    /// The description in the file; `None` if there is none.
    pub description: Option<String>,
    /// Whether the pipeline contains the pass with the chosen values; `true` if errors prevent loading the pipeline.
    pub is_on: bool,
    /// The source range of the name in its declaration.
    pub place: Span,
}

/// The strings that switching off a pass puts before and after its condition.
const OFF: [&str; 2] = ["=false && (", ")"];

impl Graph<'_, '_> {
    pub(super) fn written(&self) -> Vec<Written> {
        let planned = self.context.planned().report.pipeline;
        let is_on = |name: &str| {
            planned.as_deref().is_none_or(|pipeline| {
                pipeline.passes.iter().any(|pass| {
                    pass.name.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
                })
            })
        };
        let passes = self.context.model.declarations().filter_map(|(_, one)| {
            let is_pass = one.kind == DeclarationKind::Pass && one.owner.is_none();
            let value = self.context.value_of(one).filter(|_| is_pass)?;
            Some(Written {
                name: one.name.clone(),
                kind: kind_name(value).unwrap_or_default().to_owned(),
                description: value.get("description").and_then(|text| text.text()).map(str::to_owned),
                is_on: is_on(&one.name),
                place: one.place,
            })
        });
        passes.collect()
    }

    pub(super) fn switch(&self, pass: &str, on: bool) -> Changes {
        let (id, pass) = self.pass(pass)?;
        let when = pass.value.get("when").filter(|when| !matches!(when.kind, Kind::Null));
        let new = match (when.map(|when| &when.kind), on) {
            (None | Some(Kind::Bool(true)), true) | (Some(Kind::Bool(false)), false) => {
                return Ok(BTreeMap::new());
            }
            (None | Some(Kind::Bool(true)), false) => Some(Json::from(false)),
            (Some(Kind::Bool(false)), true) => None,
            (Some(Kind::Text(text)), false) => {
                let [before, behind] = OFF;
                Some(Json::from([before, text.trim_start_matches('='), behind].concat()))
            }
            (Some(Kind::Text(text)), true) => {
                let inner = text.strip_prefix(OFF[0]).and_then(|rest| rest.strip_suffix(OFF[1]));
                let inner = inner.ok_or_else(|| ChangeError::Conditional(text.clone()))?;
                Some(Json::from(format!("={inner}")))
            }
            (Some(_), _) => return Err(ChangeError::Gone),
        };
        let name = self.name(id);
        let keys = ["passes", name, "when"];
        let own = when.and_then(|when| {
            let path = path_to(&self.document(when.span.file).root, when.span)?;
            (path == keys).then_some(when.span.file)
        });
        let (file, mut draft) = self.draft(own.map_or_else(|| self.file_of(id), Ok)?)?;
        match (new, own) {
            (Some(new), Some(_)) => draft.set(&keys, &new)?,
            (None, Some(_)) => draft.remove(&keys)?,
            // Over what the pass takes over from elsewhere.
            (new, None) => {
                let new = Item::member("when", new.unwrap_or(Json::from(true)));
                draft.insert(&keys[..2], 0, &new)?;
            }
        }
        Ok(one(file, draft))
    }

    pub(super) fn reorder(&self, pass: &str, before: Option<&str>) -> Changes {
        let (id, _) = self.pass(pass)?;
        let file = self.file_of(id)?;
        let (file, mut draft) = self.draft(file)?;
        let root = draft.root();
        let passes = root.get("passes").ok_or(ChangeError::Gone)?;
        let from = position(passes, self.name(id)).ok_or(ChangeError::Gone)?;
        let to = match before {
            Some(before) => {
                let (before, _) = self.pass(before)?;
                let to = position(passes, self.name(before)).ok_or(ChangeError::Scattered)?;
                to - usize::from(from < to)
            }
            None => passes.entries().unwrap_or_default().len() - 1,
        };
        draft.reorder(&["passes"], from, to)?;
        Ok(one(file, draft))
    }

    pub(super) fn remove(&self, pass: &str) -> Changes {
        let (id, _) = self.pass(pass)?;
        let name = self.name(id);
        let mut drafts: BTreeMap<FileId, (String, Draft)> = BTreeMap::new();
        let mut listed: Vec<(FileId, Vec<String>)> = Vec::new();
        let is_listed = |text: &&Text| {
            let first = text.keys.first().map(String::as_str);
            matches!(first, Some("after" | "before")) && text.within != id
        };
        for text in self.context.model.texts().iter().filter(is_listed) {
            if self.context.model.named_in(text).any(|named| named == id) {
                let path = path_to(&self.document(text.place.file).root, text.place);
                listed.push((text.place.file, path.ok_or(ChangeError::Gone)?));
            }
        }
        // One that several passes take over is found with each.
        listed.sort();
        listed.dedup();
        for (file, path) in listed.iter().rev() {
            let path: Vec<&str> = path.iter().map(String::as_str).collect();
            let (_, draft) = draft_of(&mut drafts, self, *file)?;
            let (_, list) = path.split_last().ok_or(ChangeError::Gone)?;
            let root = draft.root();
            let left = at(&root, list).and_then(|list| list.elements()).map_or(0, <[_]>::len);
            draft.remove(if left > 1 { &path } else { list })?;
        }
        for file in self.files_of(name) {
            draft_of(&mut drafts, self, file)?.1.remove(&["passes", name])?;
        }
        Ok(drafts
            .into_values()
            .map(|(file, draft)| (file, draft.into_edits()))
            .collect::<BTreeMap<String, Edits>>())
    }
}

/// Returns the draft of a file among `drafts`; creates the draft if it is missing.
pub(super) fn draft_of<'d>(
    drafts: &'d mut BTreeMap<FileId, (String, Draft)>,
    graph: &Graph<'_, '_>,
    file: FileId,
) -> Result<&'d mut (String, Draft), ChangeError> {
    if let std::collections::btree_map::Entry::Vacant(vacant) = drafts.entry(file) {
        vacant.insert(graph.draft(file)?);
    }
    drafts.get_mut(&file).ok_or(ChangeError::Gone)
}
