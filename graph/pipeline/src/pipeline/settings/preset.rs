//! Presets and parameter files: named sets of values for parameters and features.
//!
//! A preset stands in the pipeline, a parameter file beside it; both are lists of settings in the end. What counts is
//! the last of: the declared default, the preset, the parameter file, the caller's own settings. The values of all
//! presets are checked with every pipeline, chosen or not.
//!
//! ```jsonc
//! // courtyard.params.json
//! { "format": 1, "preset": "high", "parameters": { "far": [10, 40, 120] }, "features": { "reverse_z": true } }
//! ```

use std::collections::BTreeMap;

use crate::pipeline::settings::overrides::{Override, Overrides};
use crate::pipeline::settings::setting::{
    SettingKind, declared, decode_feature, decode_parameter, not_there,
};
use umbragraph_text::compose::other_format;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use umbragraph_text::document::{self, Document, Entry, pointer_join};
use umbragraph_text::language::{FeatureDeclaration, ParameterDeclaration};
use umbragraph_text::source::Span;

/// The contents of a parameter file.
#[derive(Clone, Debug, Default)]
pub struct ParameterFile {
    /// The name of the preset that the values are meant for, and its place; `None` if the file names none.
    pub preset: Option<(String, Span)>,
    /// The values of parameters and features.
    pub overrides: Overrides,
}

pub(crate) const KEYS: &[&str] = &["$schema", "format", "description", "preset", "parameters", "features"];

impl ParameterFile {
    /// Reads a document as a parameter file. Names of parameters, features and presets are checked later, when a
    /// pipeline is loaded.
    pub fn read(document: &Document, diagnostics: &mut Diagnostics) -> Self {
        let mut file = Self::default();
        let Some(entries) = document.root.entries() else {
            let message = format!("a parameter file is an object, this is {}", document.root.kind_name());
            let diagnostic = Diagnostic::error(codes::WRONG_TYPE, document.root.span, message);
            diagnostics.push(diagnostic.help("write { \"parameters\": { } }"));
            return file;
        };
        if let Some(entry) =
            entries.iter().find(|entry| ["passes", "resources"].contains(&entry.key.as_str()))
        {
            let message =
                format!("a parameter file is wanted here; this has \"{}\", as a pipeline has", entry.key);
            let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, entry.key_span, message);
            let help =
                "give a file with \"parameters\" and \"features\"; the pipeline is an argument of its own";
            diagnostics.push(diagnostic.pointer(pointer_join("", &entry.key)).help(help));
            return file;
        }
        if let Some(diagnostic) = other_format(&document.root) {
            diagnostics.push(diagnostic);
            return file;
        }
        for entry in entries {
            let wrong = |wanted: &str| {
                let message = format!("\"{}\" is {wanted}, this is {}", entry.key, entry.value.kind_name());
                let diagnostic = Diagnostic::error(codes::WRONG_TYPE, entry.value.span, message);
                diagnostic.pointer(pointer_join("", &entry.key)).help(format!("write {wanted}"))
            };
            match entry.key.as_str() {
                "parameters" | "features" if entry.value.entries().is_none() => {
                    diagnostics.push(wrong("an object of values"));
                }
                "parameters" => file.overrides.parameters = settings(&entry.value),
                "features" => file.overrides.features = settings(&entry.value),
                "preset" => match entry.value.text() {
                    Some(name) => file.preset = Some((name.to_owned(), entry.value.span)),
                    None => diagnostics.push(wrong("a name")),
                },
                "toggles" => {
                    let message = "a parameter file has no toggles: they are no values of a plan";
                    let diagnostic = Diagnostic::error(codes::UNKNOWN_KEY, entry.key_span, message);
                    let help = "switch them for frames: --toggle NAME=off of `render`";
                    diagnostics.push(diagnostic.pointer("/toggles").help(help));
                }
                key if !KEYS.contains(&key) => {
                    diagnostics.push(
                        document::schema::unknown_key(entry, KEYS, entries).pointer(pointer_join("", key)),
                    );
                }
                _ => {}
            }
        }
        file
    }
}

/// Returns the values of a preset in a pipeline's document. `place` is the place of the request, for diagnostics.
///
/// Reports a preset that does not exist, and then returns no values.
pub fn of_preset(document: &Document, name: &str, place: Span, diagnostics: &mut Diagnostics) -> Overrides {
    let presets = document.root.entries_of("presets");
    match presets.iter().find(|preset| preset.key == name) {
        Some(preset) => Overrides {
            parameters: preset.value.get("parameters").map(settings).unwrap_or_default(),
            features: preset.value.get("features").map(settings).unwrap_or_default(),
        },
        None => {
            let names = presets.iter().map(|preset| preset.key.as_str());
            let message = format!("there is no preset \"{name}\"");
            let diagnostic = Diagnostic::error(codes::UNKNOWN_PRESET, place, message);
            diagnostics.push(diagnostic.suggest(name, names, Some(place), |names| match names {
                [] => "this pipeline has no presets".to_owned(),
                names => format!("the presets are {}", list_of(names)),
            }));
            Overrides::default()
        }
    }
}

/// Returns `true` if a setting of a feature comes from one of the presets.
pub(crate) fn sets(presets: &[Entry], setting: &Override) -> bool {
    let mut features = presets.iter().flat_map(|preset| preset.value.entries_of("features"));
    features.any(|entry| entry.key_span == setting.place)
}

/// Checks the values of all presets except the chosen preset, whose values are checked together with the caller's
/// values.
pub(crate) fn check(
    document: &Document,
    parameters: &BTreeMap<String, ParameterDeclaration>,
    features: &BTreeMap<String, FeatureDeclaration>,
    overrides: &Overrides,
    diagnostics: &mut Diagnostics,
) {
    let presets = document.root.entries_of("presets");
    let is_chosen = |entry: &Entry| {
        overrides.parameters.iter().chain(&overrides.features).any(|setting| setting.place == entry.key_span)
    };
    for preset in presets {
        let at = pointer_join("/presets", &preset.key);
        for kind in [SettingKind::Parameter, SettingKind::Feature] {
            let (section, known) = match kind {
                SettingKind::Parameter => ("parameters", declared(parameters)),
                SettingKind::Feature => ("features", declared(features)),
            };
            let entries = preset.value.entries_of(section);
            for entry in entries.iter().filter(|entry| !is_chosen(entry)) {
                let Entry { key, value, key_span } = entry;
                let decoded = match kind {
                    SettingKind::Parameter => {
                        parameters.get(key).map(|one| decode_parameter(key, one, value))
                    }
                    SettingKind::Feature => features.get(key).map(|one| decode_feature(key, one, value)),
                };
                let decoded = decoded.unwrap_or_else(|| {
                    let is_twin = |other: &Entry| other.key_span.file == key_span.file;
                    let taken = |name: &str| entries.iter().any(|other| other.key == name && is_twin(other));
                    Err(not_there(kind, key, &known, document, *key_span, taken).into_iter().collect())
                });
                let pointer = pointer_join(&format!("{at}/{section}"), key);
                let errors = decoded.err().into_iter().flatten();
                diagnostics.extend(errors.map(|diagnostic| diagnostic.pointer(&pointer)));
            }
        }
    }
}

fn settings(values: &document::Value) -> Vec<Override> {
    let entries = values.entries().unwrap_or_default();
    entries
        .iter()
        .map(|entry| Override { name: entry.key.clone(), value: entry.value.clone(), place: entry.key_span })
        .collect()
}
