//! The target profiles that a pipeline claims.

use umbragraph_shaders::TargetProfile;
use umbragraph_text::diagnostic::{Diagnostic, Diagnostics, codes, list_of};
use umbragraph_text::document::Document;
use umbragraph_text::source::Span;

/// The target profiles that a document claims, in the order of the document; `webgpu` if it claims none. Reports names
/// of unknown profiles.
pub fn claimed_profiles(document: &Document, diagnostics: &mut Diagnostics) -> Vec<TargetProfile> {
    let claims = document.root.elements_of("profiles");
    let mut profiles: Vec<TargetProfile> = Vec::new();
    for (at, claim) in claims.iter().enumerate() {
        let Some(name) = claim.text() else { continue };
        match profile_named(name, claim.span) {
            Ok(profile) if profiles.contains(&profile) => {}
            Ok(profile) => profiles.push(profile),
            Err(diagnostic) => diagnostics.push(diagnostic.pointer(format!("/profiles/{at}"))),
        }
    }
    if profiles.is_empty() { vec![TargetProfile::webgpu()] } else { profiles }
}

/// Returns the target profile with this name. `place` is the place of the name, for diagnostics.
///
/// # Errors
/// Returns a diagnostic for a name that no profile has.
pub fn profile_named(name: &str, place: Span) -> Result<TargetProfile, Diagnostic> {
    TargetProfile::from_name(name).ok_or_else(|| {
        Diagnostic::error(codes::UNKNOWN_PROFILE, place, format!("there is no profile \"{name}\"")).suggest(
            name,
            TargetProfile::NAMES,
            Some(place),
            |names| format!("the profiles are {}", list_of(names)),
        )
    })
}
