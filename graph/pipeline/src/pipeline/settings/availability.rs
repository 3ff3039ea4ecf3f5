//! Features that need more of the target than every one has.
//!
//! ```json
//! "features": { "clustered": { "type": "bool", "default": true, "required_limits": { "max_storage_buffers_per_shader_stage": 2 } } }
//! ```
//!
//! `"required_features": ["float32-filterable"]` does the same for optional features of WebGPU, which no profile has by
//! itself (`webgpu+float32-filterable` has one), but a device may; and for parts of WebGPU's core mode that OpenGL and
//! compatibility mode lack, such as `"view-formats"` ([`Capability`]). Where the profile has less, the feature is off
//! by default and cannot be switched on, nor can those that require it; so that one pipeline takes the better way on
//! each device without anybody switching anything. A preset cannot switch it on there either. Such a profile has no
//! configurations with it; a profile that has it has both.

use crate::pipeline::settings::overrides::Override;
use crate::pipeline::settings::preset;
use umbragraph_shaders::{Capability, TargetProfile};
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use umbragraph_text::document::{Entry, Kind, Value, pointer_join};
use umbragraph_text::language::{FeatureDeclaration, FeatureType};
use umbragraph_text::source::Span;

/// A requirement of a feature that the target profile does not meet.
#[derive(Clone, Debug)]
pub struct Lacking {
    /// The requirement as text: a limit with its minimum, or a feature of WebGPU.
    pub required: String,
    /// The limit that the profile guarantees, as text; "not" for a feature of WebGPU.
    pub guaranteed: String,
    /// The place of the requirement in the document.
    pub place: Span,
}

/// Returns the first requirement that the profile does not meet: of a feature, or of features that it requires to be
/// on. `None` if the profile meets all requirements.
pub fn lacking(entry: &Entry, features: &[Entry], profile: &TargetProfile) -> Option<Lacking> {
    lacking_within(entry, features, profile, features.len())
}

fn lacking_within(
    entry: &Entry,
    features: &[Entry],
    profile: &TargetProfile,
    depth: usize,
) -> Option<Lacking> {
    let limit = required_limits(entry).iter().find_map(|written| {
        let required = written.value.to_json().as_u64()?;
        let guaranteed = profile.limit(&written.key).filter(|guaranteed| *guaranteed < required)?;
        let (limit, guaranteed) = (&written.key, guaranteed.to_string());
        Some(Lacking {
            required: format!("{limit} of at least {required}"),
            guaranteed,
            place: written.key_span,
        })
    });
    let own = limit.or_else(|| {
        required_features(entry).iter().find_map(|written| {
            let name = written.text()?;
            let is_missing = Capability::from_name(name).is_some_and(|one| !profile.has(one));
            let required = format!("the device feature \"{name}\"");
            is_missing.then(|| Lacking { required, guaranteed: "not".to_owned(), place: written.span })
        })
    });
    let required = entry.value.elements_of("requires");
    own.or_else(|| {
        required.iter().filter_map(Value::text).find_map(|name| {
            let other = features.iter().find(|other| other.key == name)?;
            lacking_within(other, features, profile, depth.checked_sub(1)?)
        })
    })
}

/// Returns the settings of features. A preset's value is left out if the profile does not meet the requirements of its
/// feature.
pub(crate) fn without_lacking(
    settings: &[Override],
    presets: &[Entry],
    features: &[Entry],
    profile: &TargetProfile,
) -> Vec<Override> {
    let is_lacking = |setting: &Override| {
        let entry = features.iter().find(|entry| entry.key == setting.name);
        entry.is_some_and(|entry| lacking(entry, features, profile).is_some())
    };
    let is_left_out = |setting: &Override| preset::sets(presets, setting) && is_lacking(setting);
    settings.iter().filter(|setting| !is_left_out(setting)).cloned().collect()
}

/// The value of a feature that is off: false, or the first word of an enumeration.
pub fn off(declaration: &FeatureDeclaration, place: Span) -> Value {
    let word = declaration.values.first().filter(|_| declaration.feature_type == FeatureType::Enum);
    Value { span: place, kind: word.map_or(Kind::Bool(false), |word| Kind::Text(word.clone())) }
}

/// Reports required limits and WebGPU features with unknown names.
pub(crate) fn check_names(entry: &Entry, diagnostics: &mut Diagnostics) {
    for (at, written) in required_features(entry).iter().enumerate() {
        let Some(name) = written.text().filter(|name| Capability::from_name(name).is_none()) else {
            continue;
        };
        let message = format!("no device has a feature \"{name}\"");
        let pointer = format!("{}/required_features/{at}", pointer_join("/features", &entry.key));
        let diagnostic = Diagnostic::error(codes::UNKNOWN_LIMIT, written.span, message).pointer(pointer);
        let known = Capability::names();
        diagnostics.push(diagnostic.suggest(name, known, Some(written.span), |names| {
            format!("the features are {}", list_of(names))
        }));
    }
    let written = required_limits(entry);
    for limit in written.iter().filter(|limit| !TargetProfile::LIMITS.contains(&limit.key.as_str())) {
        let message = format!("there is no limit \"{}\"", limit.key);
        let pointer = format!("{}/required_limits", pointer_join("/features", &entry.key));
        let taken = |name: &str| written.iter().any(|other| other.key == name);
        let diagnostic = Diagnostic::error(codes::UNKNOWN_LIMIT, limit.key_span, message);
        diagnostics.push(diagnostic.pointer(pointer_join(&pointer, &limit.key)).suggest_unless(
            &limit.key,
            TargetProfile::LIMITS.iter().copied(),
            Some(limit.key_span),
            taken,
            |names| format!("the limits are {}", list_of(names)),
        ));
    }
}

/// The diagnostic for a feature that is switched on although the profile does not meet its requirements.
pub(crate) fn cannot_be_on(setting: &Override, lacking: &Lacking, profile: &TargetProfile) -> Diagnostic {
    let Lacking { required, guaranteed, place } = lacking;
    let message = format!("\"{}\" requires {required}, but {} has {guaranteed}", setting.name, profile.name);
    Diagnostic::error(codes::FEATURE_UNAVAILABLE, setting.place, message)
        .related(*place, "required here")
        .help("leave it away: it is off by itself where the target lacks what it requires")
}

fn required_limits(entry: &Entry) -> &[Entry] {
    entry.value.entries_of("required_limits")
}

fn required_features(entry: &Entry) -> &[Value] {
    entry.value.elements_of("required_features")
}
