//! Resources that are added and removed.
//!
//! A new texture is like one that is chosen: format, size and the rest are copied, but not that it is imported or kept.
//! A resource that something uses stays: the reason names what.

use std::collections::BTreeSet;

use serde_json::{Value as Json, json};

use super::error::{ChangeError, Changes};
use super::graph::{Graph, one};
use crate::graph::edit::Item;
use crate::graph::model::{DeclarationKind, Id};

/// The keys of a resource that are not copied to a new resource, such as its purpose and lifetime.
const OWN: [&str; 5] = ["description", "lifetime", "frames", "initial", "exposed"];

impl Graph<'_, '_> {
    pub(super) fn declare(&self, like: Option<&str>) -> Changes {
        let own = *self.context.composed.files.first().ok_or(ChangeError::Gone)?;
        let (file, mut draft) = self.draft(own)?;
        let shown = like.and_then(|like| self.context.composed.document.root.get("resources")?.get(like));
        let kind =
            if shown.is_some_and(|shown| shown.get("buffer").is_some()) { "buffer" } else { "texture" };
        let mut inner = match shown.and_then(|shown| shown.get(kind)) {
            Some(shown) => shown.to_json(),
            None => json!({ "format": "rgba8unorm", "size": "=viewport" }),
        };
        if let Json::Object(settings) = &mut inner {
            settings.retain(|key, _| !OWN.contains(&key.as_str()));
        }
        let name = self.free_name(kind);
        let content = json!({ kind: inner });
        let count = draft.root().get("resources").and_then(|all| Some(all.entries()?.len()));
        match count {
            Some(count) => draft.insert(&["resources"], count, &Item::member(name, content))?,
            None => draft.put(&["resources", &name], &content)?,
        }
        Ok(one(file, draft))
    }

    pub(super) fn forget(&self, resource: &str) -> Changes {
        let model = self.context.model;
        let unknown = || ChangeError::Unknown(resource.to_owned());
        let id = model.find(DeclarationKind::Resource, resource).ok_or_else(unknown)?;
        let users = self.users(id);
        if !users.is_empty() {
            return Err(ChangeError::Used(resource.to_owned(), users.into_iter().collect()));
        }
        let (file, mut draft) = self.draft(model.declaration(id).place.file)?;
        draft.remove(&["resources", resource])?;
        Ok(one(file, draft))
    }

    /// Returns the names of the passes and other declarations that refer to a resource.
    fn users(&self, resource: Id) -> BTreeSet<String> {
        let model = self.context.model;
        let texts = model.texts().iter().filter(|text| model.named_in(text).any(|named| named == resource));
        texts.filter(|text| text.within != resource).map(|text| self.name(text.within).to_owned()).collect()
    }
}
