//! Notices about what a frame lacks for shadows: bounds, or a light that casts any.

use umbragraph_pipeline::diagnostic::{Diagnostic, Place, Severity, list_of};
use umbragraph_pipeline::frame::{FrameInput, Light, LightKind};

use crate::codes;
use crate::words::{CAST_SHADOW, filters::CASTERS};

/// Returns `true` if the frame has neither bounds of the scene nor bounds of its casters.
pub(crate) fn has_no_bounds(frame: &FrameInput) -> bool {
    frame.scene_bounds.is_empty() && frame.bounds_of(CASTERS).is_empty()
}

/// The finding that a frame for which cascades are fitted has no bounds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoBounds {
    /// The distance along the view axis at which shadows end, in metres, if it is a guess; else `None`.
    pub(crate) reach: Option<f64>,
}

impl NoBounds {
    pub(crate) fn notice(self) -> Diagnostic {
        let reach = self.reach.map(|reach| format!(", and shadows end {reach} m before the camera"));
        let message = format!(
            "the frame has no bounds: casters outside of what the camera sees cast no shadows{}",
            reach.unwrap_or_default()
        );
        Diagnostic::warning(codes::NO_BOUNDS, Place::Nowhere, message)
            .help("give the box around the scene with FrameInput::scene_bounds")
    }
}

/// Builds the notice that a frame has no directional light with the configured name; `lights` are those of the frame.
pub(crate) fn named_light(name: &str, lights: &[Light]) -> Diagnostic {
    let directional = lights.iter().filter(|light| matches!(light.kind, LightKind::Directional));
    let names: Vec<&str> = directional.map(|light| &*light.name).collect();
    let message = format!("the frame has no directional light \"{name}\", so that nothing casts its shadows");
    let diagnostic = Diagnostic::warning(codes::NO_CASTING_LIGHT, Place::Nowhere, message);
    diagnostic.suggest(name, names, None, |names| match names {
        [] => "the frame has no directional lights".to_owned(),
        [only] => {
            format!("did you mean \"{only}\", the only one? Name it under \"light\", or leave \"light\" out")
        }
        names => format!("it has {}: name one under \"light\"", list_of(&names[..names.len().min(5)])),
    })
}

/// Builds the notice that no light casts shadows; `lights` are the lights that could.
pub(crate) fn casting_light<'a>(lights: impl Iterator<Item = &'a Light>) -> Diagnostic {
    let names: Vec<&str> = lights.map(|light| &*light.name).collect();
    let shown = names[..names.len().min(5)].iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>();
    let more = match names.len().saturating_sub(shown.len()) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let (light, has) = if names.len() == 1 { ("the light", "does") } else { ("the lights", "do") };
    let message = format!(
        "nothing casts shadows: {light} {}{more} {has} not have the property \"{CAST_SHADOW}\"",
        shown.join(", ")
    );
    Diagnostic::warning(codes::NO_CASTING_LIGHT, Place::Nowhere, message)
        .help("give it to lights that cast shadows: Light::casts_shadow (umbragraph::prelude), or Light::property")
        .severity(Severity::Note)
}
