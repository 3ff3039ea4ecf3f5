//! The node kind `spot_shadows`: a view and a descriptor for each spot that has a tile of the atlas.
//!
//! The view is the perspective of [`crate::views::spot`], widened by a border of texels for filters.
//!
//! Limits: a spot that has no view leaves a descriptor that shadows nothing.

use glam::{DVec2, DVec4, UVec2};
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::DataShape;
use umbragraph_pipeline::language::Expr;
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{PassBuilder, Produced};

use super::described::{DescribeShadows, DescribedSettings, ShadowOutput};
use super::descriptor::{self, Descriptor};
use super::filter::Filter;
use super::placement::{self, Backing, Entry};
use crate::atlas::Tile;
use crate::views::depth_coefficients;
use crate::views::spot::SpotView;

/// Publishes a view and a shadow descriptor for each spot light with a tile of the atlas.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpotShadows {
    /// The maximum number of spot lights with shadows; further lights with tiles have no shadows.
    pub capacity: Expr,
    /// The settings that `spot_shadows` and `cube_shadows` have in common.
    #[serde(flatten)]
    pub described: DescribedSettings,
}

impl Node for SpotShadows {
    const NAME: &'static str = "spot_shadows";
    const SUMMARY: &'static str =
        "Publishes a view and a descriptor for each spot that has a tile of the atlas.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let capacity = placement::capacity(pass, &self.capacity, "/capacity", placement::MAX_CAPACITY);
        self.described.declare(pass, capacity, |capacity, reverse| {
            (descriptor::shape(capacity).views(capacity), Tiles { reverse })
        })
    }

    fn published() -> Vec<(&'static str, DataShape)> {
        vec![("", descriptor::shape(1))]
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Tiles {
    reverse: bool,
}

impl DescribeShadows for Tiles {
    fn describe(&self, entry: &Entry, output: &mut ShadowOutput<'_>) {
        let Backing::Tile(tile) = entry.backing else { return };
        let Tile { x, y, size: side } = tile;
        let light = output.frame.lights.get(entry.light as usize);
        let border = border(output.filter, side) / f64::from(side.max(1));
        let Some((light, spot)) =
            light.and_then(|light| Some((light, SpotView::new(light, border, self.reverse)?)))
        else {
            output.descriptors.push(Descriptor::default());
            return;
        };
        let half_side = 0.5 * f64::from(side);
        let texel = spot.half_width() / half_side.max(0.5);
        let size = descriptor::light_size(light, output.light_size, spot.far);
        output.bounded_in_perspective(entry.light, spot.position, [spot.near, spot.far], texel, size);
        let whole = (x, y, side) == (0, 0, output.atlas_side);
        output.view(spot.view(0, (!whole).then(|| tile.viewport())));
        let scale = half_side / spot.half_width();
        let depth = depth_coefficients(spot.near, spot.far, self.reverse);
        output.descriptors.push(Descriptor {
            axes: descriptor::rows(&spot.view_from_world),
            texels: DVec4::new(scale, -scale, f64::from(x) + half_side, f64::from(y) + half_side),
            bounds: descriptor::square(x, y, side),
            depth: depth.extend(texel).extend(size),
            reach: DVec2::new(spot.far, spot.near),
            place: UVec2::new(0, side),
        });
    }
}

/// The border around the cone on each side of a tile, in texels: the reach of the filter plus 1, at most an eighth of
/// the tile. Filter taps beyond it read the tile's edge.
fn border(filter: Option<Filter>, side: u32) -> f64 {
    (filter.map_or(0.0, Filter::reach) + 1.0).min(f64::from(side) / 8.0)
}
