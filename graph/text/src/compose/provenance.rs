//! Diagnostics about a composed document, told of the text that they are about.
//!
//! A value can be written elsewhere than where it counts: in shared settings that passes extend, or under a key that is
//! misspelt and was read as it was meant. Checks know only where it counts. Here, in one place, each diagnostic gets
//! the pointer of what is written, and as related places the passes that take it over; what is the same then is said
//! once, with the related places of all. (That a subgraph is used several times, its instances know: see
//! `Environment::told` of the pipeline crate.)

use std::collections::BTreeMap;

use super::shared_settings::way_in;
use crate::diagnostic::{Diagnostic, Diagnostics, Place, suggested_name};
use crate::document::{Document, Entry, Value, pointer_join};
use crate::source::{FileId, Span};

/// Changes the JSON pointers in diagnostics about a composed document to those at which the values are written, such as
/// in shared settings. Diagnostics that become equal are merged.
pub fn as_written(document: &Document, diagnostics: Diagnostics) -> Diagnostics {
    if diagnostics.is_empty() {
        return diagnostics;
    }
    let places = SharedPlaces::of(document);
    let told = |diagnostic| in_section(document, in_group(document, &places, diagnostic));
    let mut written: Diagnostics = diagnostics.into_iter().map(told).collect();
    written.merge();
    written
}

/// Redirects a diagnostic about an inherited value to the group of shared settings that contains the value, and adds
/// the pass as a related place.
fn in_group(document: &Document, places: &SharedPlaces<'_>, diagnostic: Diagnostic) -> Diagnostic {
    let Place::Span(place) = diagnostic.place else { return diagnostic };
    let user = places.at(place).zip(pass_at(document, &diagnostic.pointer));
    let Some(((_, group), (pass, below, extends))) = user else { return diagnostic };
    let pointer = [group, &way_in(document.root.nearest(group), &below)].concat();
    diagnostic.related(extends, format!("the pass \"{pass}\" takes it over")).pointer(pointer)
}

/// Changes the JSON pointer of a diagnostic in a section with a misspelt key, so that it has the key as it is written.
fn in_section(document: &Document, diagnostic: Diagnostic) -> Diagnostic {
    let entries = document.root.entries().unwrap_or_default();
    let written = |pointer: &str| -> Option<String> {
        let section = pointer.strip_prefix('/')?.split('/').next()?;
        let is_there = entries.iter().any(|entry| entry.key == section);
        let is_it = |entry: &&Entry| suggested_name(&entry.key, [section]).is_some();
        let key = &entries.iter().filter(|_| !is_there).find(is_it)?.key;
        Some(pointer_join("", key) + &pointer[1 + section.len()..])
    };
    match written(&diagnostic.pointer) {
        Some(pointer) => diagnostic.pointer(pointer),
        None => diagnostic,
    }
}

/// The source ranges of a document that belong to groups of shared settings.
#[derive(Debug)]
pub struct SharedPlaces<'d> {
    /// The ranges by file and first byte offset, each with its end offset, the name of its group and the group's JSON
    /// pointer.
    ranges: BTreeMap<(FileId, u32), (u32, &'d str, String)>,
}

impl<'d> SharedPlaces<'d> {
    /// Collects the source ranges of all groups of shared settings, those of the pipeline and those of its subgraphs.
    pub fn of(document: &'d Document) -> Self {
        let mut places = Self { ranges: BTreeMap::new() };
        let owners = document.root.entries_of("subgraphs").iter();
        let owners = owners.map(|subgraph| (pointer_join("/subgraphs", &subgraph.key), &subgraph.value));
        for (pointer, owner) in owners.chain([(String::new(), &document.root)]) {
            for group in owner.entries_of("shared_settings") {
                let pointer = pointer_join(&format!("{pointer}/shared_settings"), &group.key);
                places.add(&group.key, &pointer, group.key_span, &group.value);
            }
        }
        places
    }

    fn add(&mut self, group: &'d str, pointer: &str, begin: Span, value: &'d Value) {
        // What is laid over another file's holds values of that file.
        let place =
            if begin.file == value.span.file { Span { end: value.span.end, ..begin } } else { value.span };
        if self.at(place).is_none() {
            self.ranges.insert((place.file, place.start), (place.end, group, pointer.to_owned()));
        }
        for member in value.entries().unwrap_or_default() {
            self.add(group, pointer, member.key_span, &member.value);
        }
    }

    /// The name of the group of shared settings that contains a span; `None` if no group contains it.
    pub fn find(&self, place: Span) -> Option<&'d str> {
        self.at(place).map(|(group, _)| group)
    }

    fn at(&self, place: Span) -> Option<(&'d str, &str)> {
        let ((file, _), (end, group, pointer)) =
            self.ranges.range(..=(place.file, place.start)).next_back()?;
        (*file == place.file && place.end <= *end).then_some((*group, pointer.as_str()))
    }
}

/// Returns the pass that a JSON pointer leads to or into: its name, the rest of the pointer, and the span of its
/// `extends` value. `None` for other pointers.
fn pass_at<'d>(document: &'d Document, pointer: &str) -> Option<(&'d str, String, Span)> {
    let way: Vec<&str> = pointer.split('/').skip(1).collect();
    let name = |key: &str| key.replace("~1", "/").replace("~0", "~");
    let (owner, rest) = match way.as_slice() {
        ["subgraphs", subgraph, rest @ ..] => (document.root.get("subgraphs")?.get(&name(subgraph))?, rest),
        rest => (&document.root, rest),
    };
    let ["passes", pass, below @ ..] = rest else { return None };
    let pass = owner.get("passes")?.entry(&name(pass))?;
    let below = below.iter().map(|key| format!("/{key}")).collect();
    Some((&pass.key, below, pass.value.get("extends")?.span))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::codes;
    use crate::document;
    use crate::source::Sources;

    #[test]
    fn diagnostics_keep_the_spelling_of_a_misspelt_section() {
        let mut sources = Sources::new();
        let file = sources.add("a", r#"{ "resuorces": { "a": 1 }, "passes": {} }"#);
        let document = document::parse(&sources, file).valid().unwrap();
        let diagnostic = |pointer: &str| {
            let place = document.root.span;
            Diagnostic::error(codes::UNKNOWN_KEY, place, pointer.to_owned()).pointer(pointer)
        };
        let diagnostics = ["/resources/a/size", "/passes/b", "", "/features/c"].map(diagnostic);
        let pointers: Vec<String> = as_written(&document, diagnostics.into_iter().collect())
            .into_iter()
            .map(|one| one.pointer)
            .collect();
        assert_eq!(pointers, ["/resuorces/a/size", "/passes/b", "", "/features/c"]);
    }
}
