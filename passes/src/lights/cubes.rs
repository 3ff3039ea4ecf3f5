//! The node kind `cube_shadows`: six views and a descriptor for each point light that has a cube.
//!
//! The views are those of [`crate::views::cube`], which mirror what they show: fronts become backs, so casters are drawn
//! without culling. Face f of slot s is layer 6·s + f of the array. A shader finds the depth of a point from the distance
//! along the axis of its face alone ([`depth_coefficients`]).
//!
//! Limits: a light that has no views leaves a descriptor that shadows nothing.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DMat4, DVec2, UVec2};
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
use crate::views::cube::{CubeViews, Face};

/// Publishes six views and a descriptor for each point light that has a cube.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CubeShadows {
    /// The host data to publish.
    pub to: String,
    /// What a `shadow_atlas` publishes.
    pub placement: String,
    /// The most point lights.
    pub capacity: Expr,
    /// The width and height of each face, in texels.
    pub side: Expr,
    /// Whether depth runs from 1 at the near plane to 0 at the far plane; false without it.
    #[serde(default)]
    pub reverse: Option<Expr>,
    /// The filter that shaders use, so that the distances at which its bounds bite can be reported.
    #[serde(default)]
    pub filter: Option<FilterSettings>,
}

impl Node for CubeShadows {
    const NAME: &'static str = "cube_shadows";
    const SUMMARY: &'static str =
        "Publishes six views and a descriptor for each point light that has a cube.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let capacity = placement::capacity(pass, &self.capacity, "/capacity", placement::LARGEST_CUBES);
        let side = placement::capacity(pass, &self.side, "/side", crate::cascades::layout::LARGEST_SIDE);
        let reverse = match &self.reverse {
            Some(expr) => pass.boolean(expr, "/reverse"),
            None => Some(false),
        };
        let filter = Filter::declare(self.filter.as_ref(), pass);
        let input = pass.data_with(&self.placement, "/placement", &placement::expected());
        let (capacity, side, reverse, filter, input) = (capacity?, side?, reverse?, filter?, input?);
        let shape = DataShape::new().value("count", ValueType::U32).views(6 * capacity).views_choose_layers();
        let output = pass.publish(&self.to, "/to", descriptor::shape(shape, capacity))?;
        let node = RunCubeShadows { side, reverse, filter, state: Mutex::default() };
        Some(pass.produce(Work::Host(HostWork { node: Arc::new(node), output, inputs: vec![input] })))
    }
}

#[derive(Debug)]
struct RunCubeShadows {
    side: u32,
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

impl HostNode for RunCubeShadows {
    fn run(&self, context: &HostContext<'_>, data: &mut HostData) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let State { descriptors, bounded } = &mut *state;
        descriptors.clear();
        bounded.clear();
        let Some(placement) = context.inputs.first() else { return };
        for entry in placement::entries(placement) {
            let Backing::Cube { slot } = entry.backing else { continue };
            let light = context.frame.lights.get(entry.light as usize);
            let Some(cube) = light.and_then(|light| CubeViews::new(light, self.reverse)) else {
                descriptors.push(Descriptor::default());
                continue;
            };
            for face in Face::ALL {
                data.push_view(cube.view(face, 6 * slot + face as u32, None));
            }
            let texel = 2.0 * cube.half_width / f64::from(self.side);
            if let Some(filter) = self.filter {
                let (nearest, farthest) =
                    receivers(cube.position, cube.near, cube.far, &context.frame.scene_bounds);
                bounded
                    .add(entry.light, filter.in_perspective(texel, nearest, farthest).into_iter().flatten());
            }
            let coefficients = depth_coefficients(cube.near, cube.far, self.reverse);
            descriptors.push(Descriptor {
                clip_from_world: DMat4::ZERO,
                rectangle: cube.position.extend(cube.far),
                reach: coefficients.extend(texel).extend(cube.near),
                place: UVec2::new(slot, self.side),
            });
        }
        descriptor::publish(data, descriptors);
        bounded.report(self.filter, context.frame, data);
    }
}

/// Two numbers a and b: the depth of a point at a distance along the axis of its face is a + b / distance.
pub fn depth_coefficients(near: f64, far: f64, reverse: bool) -> DVec2 {
    let (near, far) = if reverse { (far, near) } else { (near, far) };
    DVec2::new(far, -near * far) / (far - near)
}
