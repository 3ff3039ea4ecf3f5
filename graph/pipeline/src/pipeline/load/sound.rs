//! Decoded parts of a document that fit the schema; the other parts have their diagnostics already.

use std::collections::{BTreeMap, BTreeSet};

use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_text::document::{Document, Entry, pointer_join};
use umbragraph_text::language::{
    ConstraintDeclaration, FeatureDeclaration, GeometryDeclaration, ParameterDeclaration,
    PipelineDeclaration, ToggleDeclaration,
};

/// The JSON pointers at which a document does not fit the schema.
pub(super) struct Broken(BTreeSet<String>);

impl Broken {
    /// Creates the set from the diagnostics of the schema. What they say of `corrected` keys is mended in the document.
    pub(super) fn new(schema_diagnostics: &Diagnostics, corrected: Option<&BTreeSet<String>>) -> Self {
        // A texture in an unknown format is a texture all the same, with errors of its own.
        let is_corrected = |pointer: &String| corrected.is_some_and(|keys| keys.contains(pointer));
        let is_breaking = |diagnostic: &&Diagnostic| {
            diagnostic.code != codes::FORMAT_UNKNOWN
                && !(diagnostic.code == codes::UNKNOWN_KEY && is_corrected(&diagnostic.pointer))
        };
        Self(
            schema_diagnostics
                .iter()
                .filter(is_breaking)
                .map(|diagnostic| diagnostic.pointer.clone())
                .collect(),
        )
    }

    /// Returns `true` if the value at a JSON pointer, or any value within it, does not fit the schema.
    pub(super) fn has(&self, pointer: &str) -> bool {
        if self.0.is_empty() {
            return false;
        }
        let below = format!("{pointer}/");
        self.0.contains(pointer)
            || self.0.range(below.clone()..).next().is_some_and(|known| known.starts_with(&below))
    }
}

/// The parts of a document that fit the schema, decoded.
pub(super) struct Sound {
    pub(super) parameters: BTreeMap<String, ParameterDeclaration>,
    pub(super) features: BTreeMap<String, FeatureDeclaration>,
    pub(super) constraints: BTreeMap<String, ConstraintDeclaration>,
    pub(super) toggles: BTreeMap<String, ToggleDeclaration>,
    pub(super) geometry: BTreeMap<String, GeometryDeclaration>,
}

impl Sound {
    /// Decodes the parts that fit the schema; `None` if the document is not an object.
    pub(super) fn decode(document: &Document, broken: &Broken) -> Option<Self> {
        // Assures that the sections decoded one by one below are those of the declared type.
        let _: fn(&PipelineDeclaration) -> &BTreeMap<String, serde_json::Value> = |pipeline| &pipeline.passes;
        document.root.entries()?;
        Some(Self {
            parameters: decode(document, "parameters", broken),
            features: decode(document, "features", broken),
            constraints: decode(document, "constraints", broken),
            toggles: decode(document, "toggles", broken),
            geometry: decode(document, "geometry", broken),
        })
    }
}

fn decode<T: serde::de::DeserializeOwned>(
    document: &Document,
    name: &str,
    broken: &Broken,
) -> BTreeMap<String, T> {
    section(document, name)
        .iter()
        .filter(|entry| !broken.has(&pointer_join(&format!("/{name}"), &entry.key)))
        .filter_map(|entry| Some((entry.key.clone(), entry.value.decode().ok()?)))
        .collect()
}

/// The entries of a section; empty if the section is missing.
pub(super) fn section<'a>(document: &'a Document, name: &str) -> &'a [Entry] {
    document.root.entries_of(name)
}
