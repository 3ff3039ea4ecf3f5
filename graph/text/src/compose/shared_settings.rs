//! Settings that passes share.
//!
//! ```jsonc
//! "shared_settings": { "lit": { "draw": { "shader": "lit.wgsl.jinja", "bind": { … } } } },
//! "passes": {
//!   "shade": { "extends": "lit", "draw": { "mesh_filter": "opaque" } },
//!   "glass": { "extends": "lit", "draw": { "mesh_filter": "transparent", "cull": null } }
//! }
//! ```
//!
//! A group is a part of a pass. A pass is laid over the groups that it extends, the first the lowest, just as a file is
//! laid over the files that it extends: objects are merged key by key, everything else is replaced, `null` deletes.
//! Groups extend one another in the same way. This is done once all files are put together, so that a file changes a
//! group of the file that it extends for the passes of both. What stands under `settings` in a group is for the node
//! kind of the pass, whichever that is: so a draw and a full-screen pass share what they bind. A subgraph sees its own
//! groups, and behind them those of the pipeline; a subgraph in a file of its own does not see the latter.
//!
//! Settings that a pass takes over keep the place where they are written: diagnostics about them point to the group,
//! and name the passes.
//!
//! Limits: [`MAX_LEVELS`] groups that extend one another, [`MAX_VALUES`] values taken over in one document.

use std::collections::BTreeMap;

use super::is_path;
use super::merge::{self, Changes};
use crate::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use crate::document::{Document, Entry, Kind, Pointer, Value, pointer_join};
use crate::language::{SETTINGS, node_kind};
use crate::source::Span;

const MAX_LEVELS: usize = 32;
const MAX_VALUES: usize = 1_500_000;

/// Merges groups of shared settings into the passes that extend them, in a document that consists of a single file.
pub fn share(document: &mut Document, diagnostics: &mut Diagnostics) {
    take_over(&mut document.root, &|_, _| true, &mut Changes::default(), diagnostics);
}

/// Merges groups of shared settings into the passes that extend them. `wanted` selects the passes and subgraphs to
/// process, by section (`passes` or `subgraphs`) and name.
pub(super) fn take_over(
    root: &mut Value,
    wanted: &dyn Fn(&str, &str) -> bool,
    changes: &mut Changes,
    diagnostics: &mut Diagnostics,
) {
    let extends =
        |owner: &Value| owner.entries_of("passes").iter().any(|pass| pass.value.get("extends").is_some());
    if !extends(root) && !root.entries_of("subgraphs").iter().any(|subgraph| extends(&subgraph.value)) {
        return;
    }
    let of_pipeline = Section {
        pointer: "/shared_settings".to_owned(),
        groups: root.entries_of("shared_settings").to_vec(),
    };
    let mut sharing = Sharing { changes, diagnostics, whole: BTreeMap::new(), values: 0 };
    sharing.passes(root, "", std::slice::from_ref(&of_pipeline), &|pass| wanted("passes", pass));
    let subgraphs = root.entries_of_mut("subgraphs").into_iter().flatten();
    for subgraph in subgraphs.filter(|subgraph| wanted("subgraphs", &subgraph.key)) {
        let pointer = pointer_join("/subgraphs", &subgraph.key);
        let own = Section {
            pointer: format!("{pointer}/shared_settings"),
            groups: subgraph.value.entries_of("shared_settings").to_vec(),
        };
        let mut seen = vec![own];
        if !is_path(&subgraph.key) {
            seen.push(of_pipeline.clone());
        }
        sharing.passes(&mut subgraph.value, &pointer, &seen, &|_| true);
    }
}

/// A `shared_settings` section, with the JSON pointer of the section.
#[derive(Clone)]
struct Section {
    pointer: String,
    groups: Vec<Entry>,
}

struct Sharing<'s> {
    changes: &'s mut Changes,
    diagnostics: &'s mut Diagnostics,
    /// Groups of shared settings, merged with the groups that they extend, by the span of the group's key. `None` for a
    /// group with an error.
    whole: BTreeMap<Span, Option<Value>>,
    /// The number of values copied from groups so far.
    values: usize,
}

impl Sharing<'_> {
    fn passes(&mut self, owner: &mut Value, pointer: &str, seen: &[Section], wanted: &dyn Fn(&str) -> bool) {
        let above = format!("{pointer}/passes");
        for pass in owner.entries_of_mut("passes").into_iter().flatten().filter(|pass| wanted(&pass.key)) {
            if pass.value.get("extends").is_none() {
                continue;
            }
            let pointer = pointer_join(&above, &pass.key);
            let nothing = Value { span: pass.value.span, kind: Kind::Null };
            let own = std::mem::replace(&mut pass.value, nothing);
            pass.value = self.laid_over(own, &pointer, seen, &mut Vec::new()).unwrap_or_else(|own| own);
        }
    }

    /// Merges groups of shared settings into a pass or group that extends them; the result keeps its `extends` key. If
    /// one of the groups is missing or broken, the unmerged value is returned as an error, with `extends` set to null
    /// (see [`is_incomplete`]).
    fn laid_over(
        &mut self,
        mut own: Value,
        pointer: &str,
        seen: &[Section],
        chain: &mut Vec<(Span, Span)>,
    ) -> Result<Value, Value> {
        let Kind::Object(members) = &mut own.kind else { return Err(own) };
        let Some(at) = members.iter().position(|member| member.key == "extends") else { return Ok(own) };
        let mut extends = members.remove(at);
        let is_deleted = matches!(extends.value.kind, Kind::Null);
        let at = format!("{pointer}/extends");
        let names = names_in(&extends.value);
        let groups: Vec<_> = names.iter().map(|name| self.group(name, seen, chain, &at)).collect();
        let fine = groups.iter().all(Option::is_some);
        let kind = std::iter::once(&own).chain(groups.iter().flatten()).find_map(node_kind);
        let kind = kind.map(|kind| kind.key.clone());
        let mut below = Value { span: own.span, kind: Kind::Object(Vec::new()) };
        for mut group in groups.into_iter().flatten() {
            if let (Kind::Object(members), Some(kind)) = (&mut group.kind, &kind)
                && let Some(at) = members.iter().position(|member| member.key == SETTINGS)
            {
                let settings = Entry { key: kind.clone(), ..members.remove(at) };
                let settings = Value { span: settings.value.span, kind: Kind::Object(vec![settings]) };
                below = self.over(below, settings, pointer);
            }
            below = self.over(below, group, pointer);
        }
        let mut whole = if fine { self.over(below, own, pointer) } else { own };
        if let Kind::Object(members) = &mut whole.kind
            && !is_deleted
        {
            if !fine {
                extends.value.kind = Kind::Null;
            }
            members.push(extends);
        }
        if fine { Ok(whole) } else { Err(whole) }
    }

    fn over(&mut self, below: Value, value: Value, pointer: &str) -> Value {
        merge::over(below, value, &Pointer::Text(pointer), self.changes, self.diagnostics)
    }

    /// Returns the group of shared settings with the given name, without its `extends` key but merged with the groups
    /// that it extends. `None` after reporting an error.
    fn group(
        &mut self,
        name: &Value,
        seen: &[Section],
        chain: &mut Vec<(Span, Span)>,
        pointer: &str,
    ) -> Option<Value> {
        let error = |code, message| Diagnostic::error(code, name.span, message).pointer(pointer);
        let Some(wanted) = name.text() else {
            let message = format!("the name of shared settings is wanted here, this is {}", name.kind_name());
            let help = "name a group of \"shared_settings\", or a list of several";
            self.diagnostics.push(error(codes::WRONG_TYPE, message).help(help));
            return None;
        };
        let found = seen.iter().enumerate().find_map(|(at, section)| {
            Some((at, section, section.groups.iter().find(|group| group.key == wanted)?))
        });
        let Some((at, section, group)) = found else {
            let known = seen.iter().flat_map(|section| &section.groups).map(|group| group.key.as_str());
            let message = format!("there are no shared settings \"{wanted}\"");
            let diagnostic = error(codes::UNKNOWN_SHARED_SETTINGS, message);
            self.diagnostics.push(diagnostic.suggest(wanted, known, Some(name.span), |known| match known {
                [] => "declare them under \"shared_settings\"".to_owned(),
                known => format!("the shared settings are {}", list_of(known)),
            }));
            return None;
        };
        if let Some(first) = chain.iter().position(|(open, _)| *open == group.key_span) {
            let message = format!("the shared settings \"{wanted}\" extend themselves");
            let diagnostic = error(codes::UNKNOWN_SHARED_SETTINGS, message);
            let diagnostic = diagnostic.help("take what both need into a third group");
            let way = chain[first + 1..].iter().map(|(_, place)| *place);
            self.diagnostics
                .push(way.fold(diagnostic, |diagnostic, place| diagnostic.related(place, "on the way")));
            return None;
        }
        if !self.whole.contains_key(&group.key_span) {
            if chain.len() >= MAX_LEVELS {
                let message = format!("shared settings extend one another on {MAX_LEVELS} levels at most");
                let diagnostic = error(codes::UNKNOWN_SHARED_SETTINGS, message);
                self.diagnostics.push(diagnostic.help("join some of the groups"));
                return None;
            }
            chain.push((group.key_span, name.span));
            let pointer = pointer_join(&section.pointer, wanted);
            let whole = self.laid_over(group.value.clone(), &pointer, &seen[at..], chain).ok();
            chain.pop();
            self.whole.insert(group.key_span, whole.filter(|whole| whole.entries().is_some()));
        }
        let mut whole = self.whole.get(&group.key_span).cloned().flatten()?;
        if let Kind::Object(members) = &mut whole.kind {
            members.retain(|member| member.key != "extends");
        }
        self.values += count(&whole);
        if self.values > MAX_VALUES {
            let message = format!("the passes take over more than {MAX_VALUES} values");
            let help = "write fewer passes, or smaller groups of shared settings";
            self.diagnostics.push(error(codes::FILE_TOO_LARGE, message).help(help));
            return None;
        }
        Some(whole)
    }
}

/// Returns `true` if a pass extends shared settings that are missing or broken. The error is already reported, and
/// members that are missing in the pass may be a consequence.
pub fn is_incomplete(pass: &Value) -> bool {
    pass.get("extends").is_some_and(|extends| matches!(extends.kind, Kind::Null))
}

/// Converts the JSON pointer `below` in a pass to the pointer of the same value in `group`. A group may have the value
/// under `settings` instead of under the pass's node kind.
pub(super) fn way_in(group: &Value, below: &str) -> String {
    let depth = |way: &str| {
        let keys = way.split('/').skip(1);
        keys.scan(group, |value, key| value.get(key).map(|inner| *value = inner)).count()
    };
    let rest = below.match_indices('/').nth(1).map_or("", |(at, _)| &below[at..]);
    let shared = format!("/{SETTINGS}{rest}");
    if depth(&shared) > depth(below) { shared } else { below.to_owned() }
}

/// The names in the value of `extends`, which is a string or a list of strings; empty for null.
fn names_in(value: &Value) -> &[Value] {
    match &value.kind {
        Kind::Array(elements) => elements,
        Kind::Null => &[],
        _ => std::slice::from_ref(value),
    }
}

fn count(value: &Value) -> usize {
    match &value.kind {
        Kind::Array(elements) => 1 + elements.iter().map(count).sum::<usize>(),
        Kind::Object(members) => 1 + members.iter().map(|member| count(&member.value)).sum::<usize>(),
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Sources;

    #[test]
    fn passes_of_different_node_kinds_share_settings() {
        let mut sources = Sources::new();
        let file = sources.add(
            "t",
            r#"{
                "shared_settings": {
                    "lit": { "settings": { "bind": { "a": 1, "b": 2 } } },
                    "both": { "when": true, "settings": { "bind": { "a": 1 } }, "draw": { "bind": { "b": 3 } } },
                    "drawn": { "extends": "lit", "draw": { "bind": { "b": 3 } } },
                    "base": { "when": true, "dispatch": { "shader": "s" } }
                },
                "passes": {
                    "one": { "extends": "drawn", "draw": { "mesh_filter": "f" } },
                    "two": { "extends": "lit", "fullscreen": { "bind": { "a": null } } },
                    "three": { "extends": ["base", "lit"] }
                }
            }"#,
        );
        let mut document = crate::document::parse(&sources, file).valid().unwrap();
        let mut diagnostics = Diagnostics::new();
        share(&mut document, &mut diagnostics);
        assert!(diagnostics.is_empty());
        let passes = document.root.get("passes").unwrap().to_json();
        assert_eq!(
            passes,
            serde_json::json!({
                "one": { "draw": { "bind": { "a": 1, "b": 3 }, "mesh_filter": "f" }, "extends": "drawn" },
                "two": { "fullscreen": { "bind": { "b": 2 } }, "extends": "lit" },
                "three": { "when": true, "dispatch": { "shader": "s", "bind": { "a": 1, "b": 2 } }, "extends": ["base", "lit"] },
            })
        );
        let way =
            |group: &str, below| way_in(document.root.nearest(&format!("/shared_settings/{group}")), below);
        assert_eq!(way("lit", "/draw/bind/a"), "/settings/bind/a");
        assert_eq!(way("both", "/draw/bind/a"), "/settings/bind/a");
        assert_eq!(way("both", "/draw/bind/b"), "/draw/bind/b");
        assert_eq!(way("both", "/when"), "/when");
        assert_eq!(way("base", "/dispatch/shader"), "/dispatch/shader");
    }
}
