//! The values of parameters and features in the configuration that a caller chose.

use std::collections::{BTreeMap, BTreeSet};

use super::sound::{Sound, section};
use super::{RESERVED, bad_name, is_name};
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::document::Document;
use crate::pipeline::{Choice, Feature, Parameter, preset, setting};
use crate::shader::TargetProfile;

/// Parameters and features with their values.
pub(super) struct Settings {
    pub(super) parameters: BTreeMap<String, Parameter>,
    pub(super) features: BTreeMap<String, Feature>,
    /// Those without a value, because of diagnostics of their own.
    pub(super) broken: BTreeSet<String>,
}

impl Settings {
    /// Gives parameters and features the values that `choice` names, or their defaults.
    pub(super) fn choose(
        document: &Document,
        sound: &Sound,
        choice: &Choice,
        profile: &TargetProfile,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let entries = || section(document, "parameters").iter().chain(section(document, "features"));
        for entry in entries() {
            if RESERVED.contains(&entry.key.as_str()) || !is_name(&entry.key) {
                diagnostics.push(bad_name(entry));
            }
        }
        let parameters = setting::parameters(
            &sound.parameters,
            section(document, "parameters"),
            &choice.parameters,
            diagnostics,
        );
        let features = setting::features(
            &sound.features,
            section(document, "features"),
            &choice.features,
            profile,
            diagnostics,
        );
        preset::check(section(document, "presets"), &sound.parameters, &sound.features, choice, diagnostics);
        check_twins(document, diagnostics);
        let broken = entries()
            .map(|entry| entry.key.clone())
            .filter(|name| !parameters.contains_key(name) && !features.contains_key(name))
            .collect();
        Self { parameters, features, broken }
    }
}

/// Finds names that are a feature and a parameter.
fn check_twins(document: &Document, diagnostics: &mut Diagnostics) {
    for entry in section(document, "features") {
        let mut parameters = section(document, "parameters").iter();
        if let Some(twin) = parameters.find(|other| other.key == entry.key) {
            let message = format!("\"{}\" is a feature and a parameter", entry.key);
            diagnostics.push(
                Diagnostic::error(codes::BAD_NAME, entry.key_span, message)
                    .related(twin.key_span, "the parameter")
                    .help("give one of the two another name"),
            );
        }
    }
}
