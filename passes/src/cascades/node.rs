//! The node kind `cascades`: settings, and what is published.
//!
//! Published, besides one view for each cascade: [`shape`], or with a placement descriptors.
//!
//! Elements from `count` on are zero: no distance lies before a far distance of zero.

use std::sync::Arc;

use glam::DVec4;
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::{BlackboardData, DataShape, ValueType};
use umbragraph_pipeline::language::{AnyExpr, Expr, Ref, Word};
use umbragraph_pipeline::node::Node;
use umbragraph_pipeline::pipeline::{LiveSettings, PassBuilder, Produced};
use umbragraph_pipeline::work::{CpuContext, CpuNode, CpuWork, Work};

use super::configuration::{Cascade, CascadeSet, Configuration};
use super::fit::FitShape;
use super::layout::Layout;
use super::snap::Snap;
use super::splits::{BlendOf, SplitScheme};
use super::{declare, light, placed};
use crate::importance;
use crate::lights::descriptor;
use crate::lights::filter::FilterSettings;
use crate::lights::missing::{self, NoBounds};
use crate::words::CAST_SHADOW;

/// Fits cascades of a directional light to the frame's camera, and publishes a view for each.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cascades {
    /// The name of the blackboard data to publish.
    pub to: Ref,
    /// The name of a directional light. By default the brightest that casts shadows; of equally bright ones the
    /// alphabetically first.
    pub light: Option<String>,
    /// The blackboard data that a `shadow_atlas` pass publishes. With this key the node fits the cascades of every
    /// directional light that has layers there. It then publishes descriptors (see [`crate::lights::descriptor`])
    /// instead of the values of one light.
    pub placement: Option<Ref>,
    /// With "placement", the number of layers of the texture array: the maximum number of cascades of all directional
    /// lights together. By default the number of cascades of one light.
    pub layers: Option<Expr>,
    /// The far distance of each cascade, in metres along the view axis, strictly increasing. The formulas of "splits"
    /// use the last one only.
    pub far: Expr,
    /// The rule for the far distances; by default "far" lists them.
    pub splits: Option<SplitSettings>,
    /// The width and height of each cascade's map, in texels: one number for all, or a list with one for each.
    pub resolution: Expr,
    /// The upper left texel of each cascade in a map that all cascades share, as a list of [x, y]. By default each
    /// cascade has its own layer.
    pub tiles: Option<Expr>,
    /// The width and height of the map, in texels. By default the smallest that holds all tiles, or with layers the
    /// largest resolution.
    pub map: Option<Expr>,
    /// Whether depth runs from 1 at the near plane to 0 at the far plane; false by default.
    pub reverse: Option<Expr>,
    /// The shape that encloses each slice of the view frustum; "sphere" by default.
    pub fit: Option<Word<FitShape>>,
    /// The grid to which the texels of each cascade are snapped; "world" by default.
    pub snap: Option<Word<Snap>>,
    /// Whether texels are as wide as they are high; true by default.
    pub square_texels: Option<Expr>,
    /// The border on each side of a cascade that its slice leaves free for filter taps, in texels; 2 by default.
    pub border: Option<Expr>,
    /// The world direction that points up in the map; [0, 1, 0] by default.
    pub up: Option<Expr>,
    /// The position of the near plane. "casters", the default, places it at the bounds of the casters; a number, so
    /// many metres from the slice towards the light. "scene" places near and far plane at the bounds of the scene, so
    /// that depth stays the same while the camera moves.
    #[schemars(with = "Option<AnyExpr>")]
    pub near_pull: Option<Expr>,
    /// The distance of the far plane from the slice, away from the light, in metres; 0 by default.
    pub far_extension: Option<Expr>,
    /// Whether cascades are narrowed to the bounds of the scene, which gives distant cascades smaller texels; false by
    /// default. Texels stay in place while the bounds do not change much.
    pub clip_to_scene: Option<Expr>,
    /// With "placement", the width of the shaders' shadow filter. A notice then reports the cascades in which the
    /// bounds in texels change the width.
    pub shadow_filter: Option<FilterSettings>,
    /// With "placement", the angular diameter of directional lights that declare none (unit: radians); 0 by default.
    pub light_size: Option<Expr>,
    /// The maximum number of frames, 1 to 64, that a change of shadow casters waits to be drawn into maps that a pass
    /// keeps ("redraw": "changed"). 1, the default, is no wait. Cascades with texels 2, 4 or 8 times as wide as those
    /// of the first cascade wait up to 2, 4 or 8 frames.
    pub cadence: Option<Expr>,
    /// The zone at the end of each cascade that blends into the next cascade. The next cascade covers this zone too.
    /// None by default.
    pub blend: Option<BlendSettings>,
}

/// The rule for the far distances of the cascades.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SplitSettings {
    /// The split scheme; "explicit" by default.
    pub scheme: Option<Word<SplitScheme>>,
    /// The number of cascades, 1 to 8; by default the number of far distances. The scheme "explicit" uses only this
    /// many of the far distances.
    pub count: Option<Expr>,
    /// The near distance in the formulas, in metres along the view axis; by default that of the camera's near plane.
    pub near: Option<Expr>,
    /// The weight of the logarithmic part in the scheme "practical", 0 to 1; 0.5 by default.
    pub lambda: Option<Expr>,
}

/// The zone at the end of each cascade that blends into the next.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BlendSettings {
    /// The length of the zone as a fraction of the distance "of", from 0 (no blending) to 1.
    pub fraction: Expr,
    /// The distance that the fraction refers to; "far" by default.
    pub of: Option<Word<BlendOf>>,
}

impl Node for Cascades {
    const NAME: &'static str = "cascades";
    const SUMMARY: &'static str =
        "Fits cascades of a directional light to the camera, and publishes a view for each.";

    fn declare(&self, pass: &mut PassBuilder<'_>) -> Option<Produced> {
        let configuration = declare::configuration(self, pass)?;
        if let Some(placement) = &self.placement {
            return placed::declare(self, placement, configuration, pass);
        }
        let shape =
            shape(configuration.splits.count() as u32).view_extent(configuration.layout.map.to_array());
        let output = pass.publish(&self.to, "/to", shape)?;
        let node = RunCascades { settings: Arc::new(self.clone()), configuration };
        pass.produce(Work::Cpu(CpuWork::new(node, output, Vec::new())))
    }

    fn published() -> Vec<(&'static str, DataShape)> {
        vec![("", shape(1)), ("With `placement`", descriptor::shape(1))]
    }
}

/// The data that a fit of `count` cascades publishes, in metres unless stated otherwise. Arrays have an element for
/// each cascade.
pub fn shape(count: u32) -> DataShape {
    let matrices = ValueType::MAT4.array(count);
    let vectors = ValueType::VEC4.array(count);
    let numbers = ValueType::F32.array(count);
    DataShape::new()
        .value("clip_from_world", matrices, "world to the cascade's clip space, depth 0..1 (1..0 reversed)")
        .value("texture_from_world", matrices, "world to the map's uv (x, y) and clip depth (z)")
        .value("texture_scale_offset", vectors, "from the cascade's uv to the map's: scale x, y, offset x, y")
        .value("uv_bounds", vectors, "the map's uv that taps stay within: minimum u, v, maximum u, v")
        .value("far", numbers, "the far distance along the view axis")
        .value("blend_start", numbers, "where it begins to blend into the next; `far` where it does not")
        .value("texel_size", numbers, "metres for each texel, of the larger side")
        .value("depth_range", numbers, "metres between near and far plane: what clip depth 1 is worth")
        .value("resolution", numbers, "texels in x and in y")
        .value("count", ValueType::U32, "the cascades of this frame; 0 where everything is lit")
        .value("last_far", ValueType::F32, "the far distance of the last cascade of this frame")
        .value("near", ValueType::F32, "the camera's near plane")
        .value("map_size", ValueType::VEC2, "width and height of the map in texels")
        .value("direction_to_light", ValueType::VEC3, "unit vector; zero without a light")
        .value("light_color", ValueType::VEC3, "colour times intensity, lux")
        .value("light_intensity", ValueType::F32, "lux")
        .value("light_angular_diameter", ValueType::F32, "the angle under which the light is seen, radians")
        .views(count)
}

#[derive(Clone, Debug, PartialEq)]
struct RunCascades {
    settings: Arc<Cascades>,
    configuration: Configuration,
}

/// Whether the last notices report missing bounds, a light that casts no shadows, and a name that no light has.
type Said = (bool, bool, bool);

impl CpuNode for RunCascades {
    type State = Said;

    fn run(&self, said: &mut Said, context: &CpuContext<'_>, data: &mut BlackboardData) {
        let mut set = CascadeSet::default();
        let chosen = light::choose(&context.frame.lights, self.configuration.light.as_deref());
        let dark = chosen.map(|(_, light)| light).filter(|light| !light.has(CAST_SHADOW));
        let is_lit = chosen.is_some() && dark.is_none() && context.frame.camera.check().is_none();
        let lacking = is_lit.then(|| self.configuration.lacks_bounds(context.frame)).flatten();
        let unnamed = self.configuration.light.as_deref().filter(|_| chosen.is_none());
        let says = (lacking.is_some(), dark.is_some(), unnamed.is_some());
        if std::mem::replace(said, says) != says {
            let dark = dark.map(|light| missing::casting_light([light].into_iter()));
            let unnamed = unnamed.map(|name| missing::named_light(name, &context.frame.lights));
            data.set_notices(lacking.map(NoBounds::notice).into_iter().chain(dark).chain(unnamed).collect());
        }
        if let Some((at, light)) = chosen {
            data.read_light(at);
            set = self.configuration.fit_light(light, context.frame);
            data.set_vec3("direction_to_light", (-light.direction).as_vec3());
            data.set_vec3("light_color", light::radiance(light));
            data.set_f32("light_intensity", light.intensity);
            let is_angle = (0.0..=std::f32::consts::PI).contains(&light.angular_diameter);
            data.set_f32("light_angular_diameter", if is_angle { light.angular_diameter } else { 0.0 });
        }
        publish(&self.configuration, &set, data);
        if context.frame.camera.check().is_none() {
            let (near, _) = context.frame.camera.projection.depth_range();
            data.set_f32("near", bounded(near));
        }
    }

    fn update(&mut self, settings: &mut LiveSettings<'_>) -> Option<()> {
        declare::update(&mut self.configuration, &self.settings, settings)
    }
}

fn publish(configuration: &Configuration, set: &CascadeSet, data: &mut BlackboardData) {
    let layout = &configuration.layout;
    let numbers = |value: fn(&Cascade) -> f64| set.iter().map(move |cascade| bounded(value(cascade)));
    let vectors =
        |value: fn(&Layout, usize) -> DVec4| (0..set.count()).map(move |at| value(layout, at).as_vec4());
    data.set_matrices("clip_from_world", set.iter().map(|cascade| cascade.view.clip_from_world));
    data.set_matrices("texture_from_world", set.iter().map(|cascade| cascade.texture_from_world));
    data.set_vec4s("texture_scale_offset", vectors(Layout::scale_offset));
    data.set_vec4s("uv_bounds", vectors(Layout::uv_bounds));
    data.set_f32s("far", numbers(|cascade| cascade.slice.far));
    data.set_f32s("blend_start", numbers(|cascade| cascade.slice.blend_start));
    data.set_f32s("texel_size", numbers(|cascade| cascade.texel_size));
    data.set_f32s("depth_range", numbers(|cascade| cascade.depth_range));
    data.set_f32s("resolution", layout.tiles.iter().map(|tile| tile.resolution as f32).take(set.count()));
    data.set_u32("count", set.count() as u32);
    data.set_f32("last_far", set.iter().last().map_or(0.0, |cascade| bounded(cascade.slice.far)));
    data.set_f32s("map_size", layout.map.as_vec2().to_array());
    let first = set.iter().next().map_or(1.0, |cascade| cascade.texel_size);
    for cascade in set.iter() {
        let cadence = importance::cadence(cascade.texel_size / first, configuration.cadence);
        data.push_view_every(cascade.view, cadence);
    }
}

/// Rounds a value to 32 bits, limited to the finite range of `f32`.
fn bounded(value: f64) -> f32 {
    value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}
