//! Resources that the host looks at between frames, as if the pipeline said so.

use std::borrow::Cow;
use std::collections::BTreeSet;

use crate::graph::diagnostic::{Diagnostic, Diagnostics, Place, codes, list_of};
use crate::graph::document::{Document, Entry, Kind, Value};

/// Returns the document with `"exposed": true` in the named resources. Adds a diagnostic for each unknown name.
pub(crate) fn exposing<'d>(
    document: &'d Document,
    exposed: &BTreeSet<String>,
    diagnostics: &mut Diagnostics,
) -> Cow<'d, Document> {
    let mut changed = Cow::Borrowed(document);
    for name in exposed {
        let declared = document.root.get("resources").and_then(|all| all.entry(name));
        let Some(place) = declared.map(|entry| entry.key_span) else {
            let known = document.root.entries_of("resources").iter().map(|entry| entry.key.as_str());
            let message = format!("there is no resource \"{name}\" to expose");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_RESOURCE, Place::Nowhere, message);
            diagnostics.push(diagnostic.suggest(name, known, None, |known| {
                format!("the resources are {}", list_of(known.iter().copied()))
            }));
            continue;
        };
        let resources = changed.to_mut().root.entries_of_mut("resources");
        let resource = resources.and_then(|all| all.iter_mut().find(|entry| entry.key == *name));
        let Some(Kind::Object(kinds)) = resource.map(|entry| &mut entry.value.kind) else { continue };
        for Entry { value, .. } in kinds {
            let Kind::Object(keys) = &mut value.kind else { continue };
            keys.retain(|entry| entry.key != "exposed");
            let value = Value { span: place, kind: Kind::Bool(true) };
            keys.push(Entry { key: "exposed".to_owned(), key_span: place, value });
        }
    }
    changed
}
