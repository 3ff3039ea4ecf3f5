//! The node kind `spot_shadows`: a view and a descriptor for each spot that has a tile of the atlas.
//!
//! The view is the perspective of [`crate::views::spot`], widened by a border of texels for filters.
//!
//! Limits: a spot that has no view leaves a descriptor that shadows nothing.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec4, UVec2};
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_graph::data::{DataShape, HostData, ValueType};
use umbragraph_graph::language::Expr;
use umbragraph_graph::node::Node;
use umbragraph_graph::pipeline::{PassBuilder, Produced};
use umbragraph_graph::work::{HostContext, HostNode, HostWork, Work};

use super::descriptor::{self, Descriptor};
use super::filter::{Bounded, Filter, FilterSettings, receivers};
use super::placement::{self, Backing};
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
        let shape =
            descriptor::shape(DataShape::new().value("count", ValueType::U32).views(capacity), capacity);
        let output = pass.publish(&self.to, "/to", shape)?;
        let node = RunSpotShadows { reverse, filter, state: Mutex::default() };
        Some(pass.produce(Work::Host(HostWork { node: Arc::new(node), output, inputs: vec![input] })))
    }
}

#[derive(Debug)]
struct RunSpotShadows {
    reverse: bool,
    filter: Option<Filter>,
    state: Mutex<State>,
}

/// Memory that is used again in each frame.
#[derive(Debug, Default)]
struct State {
    descriptors: Vec<Descriptor>,
    bounded: Bounded,
}

impl HostNode for RunSpotShadows {
    fn run(&self, context: &HostContext<'_>, data: &mut HostData) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let State { descriptors, bounded } = &mut *state;
        descriptors.clear();
        bounded.clear();
        let Some(placement) = context.inputs.first() else { return };
        let atlas = placement::atlas_side(placement);
        for entry in placement::entries(placement) {
            let Backing::Tile { x, y, side } = entry.backing else { continue };
            let light = context.frame.lights.get(entry.light as usize);
            let border = BORDER / f64::from(side.max(1));
            let Some(spot) = light.and_then(|light| SpotView::new(light, border, self.reverse)) else {
                descriptors.push(Descriptor::default());
                continue;
            };
            let texel = 2.0 * spot.half_width() / f64::from(side.max(1));
            if let Some(filter) = self.filter {
                let (nearest, farthest) =
                    receivers(spot.position, spot.near, spot.far, &context.frame.scene_bounds);
                bounded
                    .add(entry.light, filter.in_perspective(texel, nearest, farthest).into_iter().flatten());
            }
            let tile = Tile { x, y, size: side };
            let whole = (x, y, side) == (0, 0, atlas);
            data.push_view(spot.view(0, (!whole).then(|| tile.viewport())));
            descriptors.push(Descriptor {
                clip_from_world: spot.clip_from_world,
                rectangle: tile.scale_offset(atlas),
                reach: DVec4::new(0.0, 0.0, texel, 0.0),
                place: UVec2::new(0, side),
            });
        }
        descriptor::publish(data, descriptors);
        bounded.report(self.filter, context.frame, data);
    }
}
