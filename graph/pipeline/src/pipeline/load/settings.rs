//! The values of parameters and features in the configuration that a caller chose, and what is derived from them.

use std::collections::{BTreeMap, BTreeSet};

use crate::pipeline::load::sound::{Broken, Sound, section};
use crate::pipeline::names::identifiers::{name_diagnostic, twin_diagnostic};
use crate::pipeline::settings::{
    Dependence, Derived, Feature, Overrides, StaticScope, ValuedParameter, derived, preset, setting,
};
use crate::pipeline::state::shared::Shared;
use umbragraph_shaders::TargetProfile;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_text::document::{Document, pointer_join};
use umbragraph_text::expression::Scope as _;

/// The parameters, features and derived values of a configuration.
pub(super) struct Settings {
    pub(super) parameters: BTreeMap<String, ValuedParameter>,
    pub(super) features: BTreeMap<String, Feature>,
    pub(super) derived: BTreeMap<String, Derived>,
    /// The names that have no value because of errors.
    pub(super) broken: BTreeSet<String>,
}

impl Settings {
    /// Gives parameters and features the values from `overrides`, or else their defaults, and computes the derived
    /// values.
    pub(super) fn choose(
        document: &Document,
        sound: &Sound,
        unsound: &Broken,
        overrides: &Overrides,
        profile: &TargetProfile,
        diagnostics: &mut Diagnostics,
    ) -> Self {
        let entries = || section(document, "parameters").iter().chain(section(document, "features"));
        diagnostics.extend(entries().filter_map(name_diagnostic));
        setting::unknown(&sound.parameters, &sound.features, document, overrides, diagnostics);
        let parameters = setting::parameters(
            &sound.parameters,
            section(document, "parameters"),
            &overrides.parameters,
            diagnostics,
        );
        let features =
            setting::features(&sound.features, document, &overrides.features, profile, diagnostics);
        preset::check(document, &sound.parameters, &sound.features, overrides, diagnostics);
        check_twins(document, diagnostics);
        let mut broken: BTreeSet<String> = entries()
            .map(|entry| entry.key.clone())
            .filter(|name| !parameters.contains_key(name) && !features.contains_key(name))
            .collect();
        let around = StaticScope::new(&parameters, &features).with_broken(broken.clone());
        let taken = [
            ("parameters", "parameter"),
            ("features", "feature"),
            ("resources", "resource"),
            ("toggles", "toggle"),
        ];
        let taken = taken.into_iter().flat_map(|(name, what)| {
            section(document, name).iter().map(move |entry| (entry.key.as_str(), (entry.key_span, what)))
        });
        let derived = derived::evaluate(
            section(document, "derived"),
            "/derived",
            &around,
            &taken.collect(),
            &|pointer| unsound.has(pointer),
            diagnostics,
        );
        broken.extend(derived.broken);
        Self { parameters, features, derived: derived.values, broken }
    }

    /// The parameters on which each value depends.
    pub(super) fn dependence(&self) -> Dependence {
        Dependence::new(&self.parameters, &self.derived)
    }

    /// The scope of expressions: parameters, features and derived values.
    pub(super) fn scope(&self) -> StaticScope {
        let scope = StaticScope::new(&self.parameters, &self.features);
        scope.with_derived(&self.derived).with_broken(self.broken.clone())
    }
}

/// Reports derived values that have the name of blackboard data that a pass publishes.
pub(super) fn check_data(document: &Document, shared: &mut Shared) {
    for entry in section(document, "derived") {
        let Some(handle) = shared.find(&entry.key) else { continue };
        let data = &shared.resources[handle.index()];
        if shared.scope.lookup(&entry.key).is_some() {
            let message = format!("\"{}\" is a derived value, and data of a pass", entry.key);
            let diagnostic = Diagnostic::error(codes::BAD_NAME, entry.key_span, message)
                .related(data.place, "the data")
                .pointer(pointer_join("/derived", &entry.key))
                .help("give one of the two another name");
            shared.diagnostics.push(diagnostic);
        }
    }
}

/// Reports names that are both a parameter and a feature or a resource, so that an expression could mean either. A
/// resource may have the name of the feature that it belongs to.
fn check_twins(document: &Document, diagnostics: &mut Diagnostics) {
    for (own, what, others, other) in [
        ("features", "feature", "parameters", "parameter"),
        ("resources", "resource", "parameters", "parameter"),
    ] {
        for entry in section(document, own) {
            if let Some(twin) = section(document, others).iter().find(|other| other.key == entry.key) {
                diagnostics.push(twin_diagnostic(entry, what, (twin.key_span, other)));
            }
        }
    }
}
