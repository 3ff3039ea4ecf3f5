//! The node kind `spot_shadows`: a view and a descriptor for each spot that has a tile of the atlas.
//!
//! The view is the perspective of [`crate::views::spot`], widened by a border of texels for filters.
//!
//! Limits: a spot that has no view leaves a descriptor that shadows nothing.

use glam::{DVec4, UVec2};
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::{DataShape, ValueType};
use umbragraph_pipeline::language::Expr;
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{PassBuilder, Produced};

use super::described::{self, Describe, Told};
use super::descriptor::Descriptor;
use super::filter::{Filter, FilterSettings};
use super::placement::{self, Backing, Entry};
use crate::atlas::Tile;
use crate::views::spot::SpotView;

/// The texels on each side of a tile that the cone leaves free, for filter taps.
const BORDER: f64 = 2.0;

/// Publishes a view and a descriptor for each spot that has a tile of the atlas.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpotShadows {
    /// The host data to publish.
    pub to: String,
    /// What a `shadow_atlas` publishes.
    pub placement: String,
    /// The most spots.
    pub capacity: Expr,
    /// Whether depth runs from 1 at the near plane to 0 at the far plane; false without it.
    #[serde(default)]
    pub reverse: Option<Expr>,
    /// The filter that shaders use, so that the distances at which its bounds bite can be reported.
    #[serde(default)]
    pub filter: Option<FilterSettings>,
}

impl Node for SpotShadows {
    const NAME: &'static str = "spot_shadows";
    const SUMMARY: &'static str =
        "Publishes a view and a descriptor for each spot that has a tile of the atlas.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let capacity = placement::capacity(pass, &self.capacity, "/capacity", super::list::LARGEST_CAPACITY);
        let reverse = match &self.reverse {
            Some(expr) => pass.boolean(expr, "/reverse"),
            None => Some(false),
        };
        let filter = Filter::declare(self.filter.as_ref(), pass);
        let input = pass.data_with(&self.placement, "/placement", &placement::expected());
        let (capacity, reverse, filter, input) = (capacity?, reverse?, filter?, input?);
        let shape = DataShape::new().value("count", ValueType::U32).views(capacity);
        described::node(pass, &self.to, input, (shape, capacity), filter, Tiles { reverse })
    }
}

#[derive(Debug, PartialEq)]
struct Tiles {
    reverse: bool,
}

impl Describe for Tiles {
    fn describe(&self, entry: &Entry, told: &mut Told<'_>) {
        let Backing::Tile { x, y, side } = entry.backing else { return };
        let light = told.frame.lights.get(entry.light as usize);
        let border = BORDER / f64::from(side.max(1));
        let Some(spot) = light.and_then(|light| SpotView::new(light, border, self.reverse)) else {
            told.descriptor(Descriptor::default());
            return;
        };
        let texel = 2.0 * spot.half_width() / f64::from(side.max(1));
        told.bounded_in_perspective(entry.light, spot.position, [spot.near, spot.far], texel);
        let tile = Tile { x, y, size: side };
        let whole = (x, y, side) == (0, 0, told.atlas_side);
        told.view(spot.view(0, (!whole).then(|| tile.viewport())));
        told.descriptor(Descriptor {
            clip_from_world: spot.clip_from_world,
            rectangle: tile.scale_offset(told.atlas_side),
            reach: DVec4::new(0.0, 0.0, texel, 0.0),
            place: UVec2::new(0, side),
        });
    }
}
