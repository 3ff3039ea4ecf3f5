//! Features that need more of the target than every one has.
//!
//! ```json
//! "features": { "clustered": { "type": "bool", "default": true, "required_limits": { "max_storage_buffers_per_shader_stage": 2 } } }
//! ```
//!
//! Where the profile has less, the feature is off by default and cannot be switched on, nor can those that require it; so that one pipeline takes the
//! better way on each device without anybody switching anything. No configuration with it is gone through there; where
//! the profile has it, both are.

use super::setting::Setting;
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::document::{Entry, Kind, Value, pointer_join};
use crate::language::{FeatureDeclaration, FeatureType};
use crate::shader::TargetProfile;
use crate::source::Span;

/// A limit of which a profile has less than a feature requires.
#[derive(Clone, Debug)]
pub struct Lacking {
    /// Its name.
    pub limit: String,
    /// The limit that the feature requires.
    pub required: u64,
    /// The limit of the profile.
    pub guaranteed: u64,
    /// The place of the requirement.
    pub place: Span,
}

/// The first limit, in the order of the document, of which a profile has less than a feature requires: the feature
/// itself, or one that it requires to be on.
pub fn lacking(entry: &Entry, features: &[Entry], profile: &TargetProfile) -> Option<Lacking> {
    lacking_within(entry, features, profile, features.len())
}

fn lacking_within(
    entry: &Entry,
    features: &[Entry],
    profile: &TargetProfile,
    depth: usize,
) -> Option<Lacking> {
    let own = required_limits(entry).iter().find_map(|written| {
        let required = written.value.to_json().as_u64()?;
        let guaranteed = profile.limit(&written.key).filter(|guaranteed| *guaranteed < required)?;
        Some(Lacking { limit: written.key.clone(), required, guaranteed, place: written.key_span })
    });
    let required = entry.value.get("requires").and_then(Value::elements).unwrap_or_default();
    own.or_else(|| {
        required.iter().filter_map(Value::text).find_map(|name| {
            let other = features.iter().find(|other| other.key == name)?;
            lacking_within(other, features, profile, depth.checked_sub(1)?)
        })
    })
}

/// The value with which a feature is off.
pub fn off(declaration: &FeatureDeclaration, place: Span) -> Value {
    let word = declaration.values.first().filter(|_| declaration.feature_type == FeatureType::Enum);
    Value { span: place, kind: word.map_or(Kind::Bool(false), |word| Kind::Text(word.clone())) }
}

/// Reports required limits that no profile has.
pub(super) fn check_names(entry: &Entry, diagnostics: &mut Diagnostics) {
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
            |names| format!("the limits are {}", names.join(", ")),
        ));
    }
}

/// The diagnostic that a feature is switched on where the profile lacks what it requires.
pub(super) fn cannot_be_on(setting: &Setting, lacking: &Lacking, profile: &TargetProfile) -> Diagnostic {
    let Lacking { limit, required, guaranteed, place } = lacking;
    Diagnostic::error(
        codes::FEATURE_UNAVAILABLE,
        setting.place,
        format!(
            "\"{}\" requires {limit} of at least {required}, but {} has {guaranteed}",
            setting.name, profile.name
        ),
    )
    .related(*place, "required here")
    .help("leave it away: it is off by itself where the target lacks what it requires")
}

fn required_limits(entry: &Entry) -> &[Entry] {
    entry.value.get("required_limits").and_then(Value::entries).unwrap_or_default()
}
