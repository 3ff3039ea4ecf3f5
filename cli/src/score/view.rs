//! The ray-traced reference of a frame, and the comparison of rendered shadow terms with it.

use umbragraph::diagnostic::{Diagnostic, Diagnostics};
use umbragraph::frame::{FrameInput, Light};
use umbragraph::low_level::shader::permutations::Keep as _;
use umbragraph::passes::words::CAST_SHADOW;
use umbragraph_score::{LightTruth, Rays, Rendered, Scores, Seen, Truth, difference};

use super::nothing;
use crate::cache::Cache;
use crate::progress::Progress;
use crate::render::Drawing;

/// The ray-traced reference of a frame: camera rays, and shadow rays to each light that casts shadows.
pub(crate) struct View<'r> {
    truth: Truth<'r>,
    /// The lights with their ray-traced visibility; `None` for a light that the frame cannot use.
    lights: Vec<(Light, Option<LightTruth>)>,
}

/// Returns the ray-traced visibility of a light, from the cache if possible. `row` is called for each traced row.
fn traced(
    truth: &Truth<'_>,
    light: &Light,
    cache: Option<&Cache>,
    row: &(dyn Fn() + Sync),
) -> Option<LightTruth> {
    let name = cache.map(|_| {
        let mut hash = blake3::Hasher::new();
        truth.describe(light, &mut |bytes| {
            hash.update(bytes);
        });
        format!("rays {}", hash.finalize())
    });
    let kept = cache.zip(name.as_ref()).and_then(|(cache, name)| cache.get(name));
    if let Some(known) = kept.and_then(|bytes| LightTruth::from_bytes(&bytes, truth.points().len())) {
        return Some(known);
    }
    let traced = truth.light_by_rows(light, row)?;
    if let Some((cache, name)) = cache.zip(name) {
        cache.put(&name, &traced.to_bytes());
    }
    Some(traced)
}

/// Returns the lights of a frame that cast shadows.
pub(crate) fn casting(input: &FrameInput) -> impl Iterator<Item = &Light> {
    input.lights.iter().filter(|light| light.has(CAST_SHADOW))
}

/// The rendered shadow term of one light, together with its ray-traced reference.
pub(crate) struct Answer<'v> {
    traced: &'v LightTruth,
    /// The index of the light among those that cast shadows.
    pub(crate) at: usize,
    pub(crate) scores: Scores,
    /// Set if no pixel of the rendered picture is in shadow.
    pub(crate) is_lit_everywhere: bool,
    /// The pixels of the rendered shadow term, in RGBA with 8 bits per channel.
    pub(crate) pixels: Vec<u8>,
}

impl<'r> View<'r> {
    /// Traces the rays of a frame; `None` if the camera sees no surface.
    ///
    /// # Errors
    /// No light casts shadows.
    pub(crate) fn new(
        rays: &'r Rays<'r>,
        input: &FrameInput,
        size: [u32; 2],
        (cache, progress): (Option<&Cache>, &mut Progress),
    ) -> Result<Option<Self>, Diagnostic> {
        let truth = progress.stage("rays of the camera", || Truth::new(rays, &input.camera, size));
        if truth.points().iter().all(Option::is_none) {
            return Ok(None);
        }
        let counter = progress.counter();
        let lights: Vec<_> = progress.stage("rays to lights", || {
            let traced = |light: &Light| (light.clone(), traced(&truth, light, cache, &|| counter(1)));
            casting(input).map(traced).collect()
        });
        if lights.is_empty() {
            let help = "let one cast shadows: \"castShadow\" in its extras is not false";
            return Err(nothing("no light of the scene casts shadows", help));
        }
        Ok(Some(Self { truth, lights }))
    }

    /// Returns the names of the lights that cast shadows.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.lights.iter().map(|(light, _)| &*light.name)
    }

    /// Renders the shadow term of each light separately, and scores it against the ray-traced reference.
    pub(crate) fn answers(
        &self,
        drawing: &mut Drawing<'_>,
        input: &FrameInput,
        progress: &mut Progress,
    ) -> Result<Vec<Answer<'_>>, Diagnostics> {
        let mut answers = Vec::new();
        for (at, (light, traced)) in self.lights.iter().enumerate() {
            let Some(traced) = traced else { continue };
            let alone = input.clone().lights(vec![light.clone()]);
            progress.stage("draw", || drawing.frame(&alone))?;
            let pixels = drawing.picture()?;
            let rendered = Rendered::new(&pixels);
            let scores = Scores::of(&self.truth, traced, rendered);
            let is_lit_everywhere = rendered.is_lit_everywhere();
            answers.push(Answer { traced, at, scores, is_lit_everywhere, pixels });
        }
        Ok(answers)
    }

    /// Returns the visibility in a rendered answer, for comparison with the next frame.
    pub(crate) fn seen(&self, answer: &Answer<'_>) -> Seen {
        Seen::new(&self.truth, answer.traced, Rendered::new(&answer.pixels))
    }

    /// Returns a picture that marks the pixels in which an answer differs from the ray-traced reference.
    pub(crate) fn difference(&self, answer: &Answer<'_>) -> Vec<u8> {
        difference::picture(&self.truth, answer.traced, Rendered::new(&answer.pixels))
    }
}
