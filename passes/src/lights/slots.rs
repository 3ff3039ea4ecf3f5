//! Slots of lights in textures as large as the picture, in which passes keep something of each light for the shading.
//!
//! Such a texture has a channel for each slot, four to a layer, so there are few. The most important lights that the
//! camera sees something of have one; the others are named by a notice, and shading does without it.
//!
//! Limits: a slot is not kept from frame to frame, so such a texture is no history.

use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::BlackboardData;
use umbragraph_pipeline::frame::{FrameInput, Light};
use umbragraph_pipeline::language::{Expr, Word};
use umbragraph_pipeline::pipeline::{Evaluate, PassBuilder};

use super::list::NO_SHADOW;
use super::placement::{self, capacity};
use crate::importance::Eye;
use crate::words::{CAST_SHADOW, CONTACT_SHADOW};

/// The maximum number of lights that have a slot in textures as large as the picture.
pub const MAX_SLOTS: u32 = 32;

/// The number of four-component vectors that map lights to slots.
pub(super) const GROUPS: u32 = MAX_SLOTS / 4;

/// The slots for lights in textures as large as the picture: one channel for each light.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlotSettings {
    /// The maximum number of slots, 1 to 32; the most important lights get one each.
    pub capacity: Expr,
    /// The lights that request a slot; "shadows" by default.
    pub of: Option<Word<SlotsOf>>,
}

/// The choice of the lights that request a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SlotsOf {
    /// Lights that cast shadows.
    Shadows,
    /// Lights that cast shadows and have contact shadows.
    ContactShadows,
}

/// The evaluated slot settings: the maximum number of slots, and the choice of lights that request one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slots {
    capacity: usize,
    of: SlotsOf,
}

impl Slots {
    pub(super) fn declare(pass: &mut PassBuilder<'_>, settings: &SlotSettings) -> Option<Self> {
        let of = pass.word_or(&settings.of, "/slots/of", SlotsOf::Shadows);
        let capacity = capacity(pass, &settings.capacity, "/slots/capacity", MAX_SLOTS);
        Some(Self { capacity: capacity? as usize, of: of? })
    }

    /// Collects in `asking` the importance and index of each listed light that requests a slot, the most important
    /// first. Returns the number of lights that get one.
    pub(super) fn choose(&self, frame: &FrameInput, listed: &[u32], asking: &mut Vec<(f32, u32)>) -> usize {
        asking.clear();
        let Some(eye) = Eye::new(&frame.camera) else { return 0 };
        let asks = |light: &Light| {
            light.has(CAST_SHADOW) && (self.of == SlotsOf::Shadows || light.has(CONTACT_SHADOW))
        };
        let of = |at: u32| &frame.lights[at as usize];
        let asked =
            listed.iter().filter(|at| asks(of(**at))).map(|at| (eye.importance(of(*at)).value(), *at));
        asking.extend(asked.filter(|(importance, _)| *importance > 0.0));
        asking
            .sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then_with(|| placement::compare(of(a.1), of(b.1))));
        asking.len().min(self.capacity)
    }
}

/// Publishes, for each slot, the position of its light in the list of lights, or [`NO_SHADOW`] for a free slot.
pub(super) fn publish(data: &mut BlackboardData, listed: &[u32], slotted: &[(f32, u32)]) {
    let place =
        |at: &u32| listed.iter().position(|listed| listed == at).map_or(NO_SHADOW, |place| place as u32);
    let places = slotted.iter().map(|(_, at)| place(at));
    data.set_words("slot", places.chain(std::iter::repeat(NO_SHADOW)).take(MAX_SLOTS as usize));
}
