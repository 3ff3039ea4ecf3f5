//! The common part of the nodes that describe shadows: views and descriptors of the placed lights, and reports of
//! filter bounds that apply.
//!
//! A backing implements [`DescribeShadows`] for one placed light; [`node`] makes a CPU node of it.

use std::fmt::Debug;
use std::sync::Arc;

use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::{BlackboardData, DataShape, View};
use umbragraph_pipeline::diagnostic::codes;
use umbragraph_pipeline::frame::FrameInput;
use umbragraph_pipeline::language::{Expr, Ref};
use umbragraph_pipeline::pipeline::{Evaluate, LiveSettings, PassBuilder, Produced};
use umbragraph_pipeline::work::{CpuContext, CpuNode, CpuWork, Subresource, Work};

use super::descriptor::{self, Descriptor};
use super::filter::{Bounded, Filter, FilterSettings, receivers};
use super::missing::NoBounds;
use super::placement::{self, Entry};
use super::word;
use crate::importance::Eye;

/// The largest value of "cadence": the number of frames that a change of shadow casters may wait to be drawn.
const MAX_CADENCE: u32 = 64;

/// The settings that the node kinds `spot_shadows` and `cube_shadows` have in common.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct DescribedSettings {
    /// The name of the blackboard data to publish.
    pub to: Ref,
    /// The blackboard data that a `shadow_atlas` pass publishes.
    pub placement: Ref,
    /// Whether depth runs from 1 at the near plane to 0 at the far plane; false by default.
    pub reverse: Option<Expr>,
    /// The width of the shaders' shadow filter. With this key, a notice reports the distances at which the bounds in
    /// texels change the width.
    pub shadow_filter: Option<FilterSettings>,
    /// The radius of lights that declare none, in metres; 0 by default.
    pub light_size: Option<Expr>,
    /// The maximum number of frames, 1 to 64, that a change of shadow casters waits to be drawn into maps that a pass
    /// keeps ("redraw": "changed"). 1, the default, is no wait. Less important lights wait longer: up to 1, 2, 4, 8 and
    /// so on.
    pub cadence: Option<Expr>,
}

/// The live settings of a node that publishes shadow descriptors: their values can change from frame to frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LiveShadows {
    pub(crate) filter: Option<FilterSettings>,
    pub(crate) light_size: Option<Expr>,
    pub(crate) cadence: Option<Expr>,
}

impl LiveShadows {
    /// Evaluates the filter, the size of lights that declare none, and the largest cadence in frames. Returns `None`
    /// after a diagnostic.
    fn evaluate(&self, pass: &mut impl Evaluate) -> Option<(Option<Filter>, f64, u32)> {
        let filter = Filter::declare(self.filter.as_ref(), pass);
        let light_size = pass.number_or(&self.light_size, "/light_size", 0.0);
        let cadence = cadence(pass, &self.cadence);
        Some((filter?, light_size?, cadence?))
    }
}

/// Evaluates "cadence", a number of frames from 1 to [`MAX_CADENCE`], by default 1; returns `None` after a diagnostic.
pub(crate) fn cadence(pass: &mut impl Evaluate, setting: &Option<Expr>) -> Option<u32> {
    let cadence = pass.count_or(setting, "/cadence", 1)?;
    if (1..=MAX_CADENCE).contains(&cadence) {
        return Some(cadence);
    }
    let message = format!("what changed cannot wait for {cadence} frames");
    pass.reject(codes::OUT_OF_BOUNDS, "/cadence", message, format!("write a number from 1 to {MAX_CADENCE}"))
}

impl DescribedSettings {
    /// Declares the node. From the `further` settings and from whether depth is reversed, `describe` makes the shape of
    /// the published data and the implementation for the backing.
    pub(crate) fn declare<T, D: DescribeShadows>(
        &self,
        pass: &mut PassBuilder<'_>,
        further: Option<T>,
        describe: impl FnOnce(T, bool) -> (DataShape, D),
    ) -> Option<Produced> {
        let reverse = pass.boolean_or(&self.reverse, "/reverse", false);
        let live = LiveShadows {
            filter: self.shadow_filter.clone(),
            light_size: self.light_size.clone(),
            cadence: self.cadence.clone(),
        };
        let input = pass.data_with(&self.placement, "/placement", &placement::expected());
        let further = further.zip(reverse).map(|(further, reverse)| describe(further, reverse));
        node(pass, &self.to, input, further, live)
    }
}

/// Describes the shadow maps of lights with one kind of backing: atlas tiles, cubes or layers.
pub(crate) trait DescribeShadows: Clone + Debug + PartialEq + Send + Sync + 'static {
    /// Adds the views and descriptors of a placed light to the output; ignores lights with another backing.
    fn describe(&self, entry: &Entry, output: &mut ShadowOutput<'_>);
    /// The finding that a frame has no bounds although this backing needs them; `None` if nothing is missing.
    fn lacks(&self, _frame: &FrameInput) -> Option<NoBounds> {
        None
    }
    /// Evaluates the live settings of this backing again; returns `None` after a diagnostic.
    fn update(&mut self, _settings: &mut LiveSettings<'_>) -> Option<()> {
        Some(())
    }
}

/// The views, descriptors and filter reports of one frame, filled light by light.
pub(crate) struct ShadowOutput<'a> {
    pub(crate) frame: &'a FrameInput,
    /// The side of the shadow atlas, in texels.
    pub(crate) atlas_side: u32,
    pub(crate) filter: Option<Filter>,
    /// The size of lights that declare none: a radius in metres, or an angular diameter in radians.
    pub(crate) light_size: f64,
    /// The number of frames that a change of casters may wait to be drawn, for the current light. `longest` is the
    /// maximum for all lights.
    pub(crate) cadence: u32,
    pub(crate) longest: u32,
    data: &'a mut BlackboardData,
    /// The descriptors of the frame so far. A default descriptor stands for a map without shadows.
    pub(crate) descriptors: &'a mut Vec<Descriptor>,
    /// The lights and places at which the filter's bounds in texels change its width.
    pub(crate) bounded: &'a mut Bounded,
}

impl ShadowOutput<'_> {
    /// Adds a view to draw; views beyond the declared maximum are left out.
    pub(crate) fn view(&mut self, view: View) {
        if self.data.views().len() < self.data.shape().max_views as usize {
            self.data.push_view_every(view, self.cadence);
        }
    }

    /// Records the distances at which the filter's bounds change its width, for a light with perspective shadow maps.
    /// `range` has the distances of the near and far plane, `texel` is the width of a texel at 1 m, `size` the light's
    /// radius, all in metres.
    pub(crate) fn bounded_in_perspective(
        &mut self,
        light: u32,
        position: DVec3,
        range: [f64; 2],
        texel: f64,
        size: f64,
    ) {
        let Some(filter) = self.filter else { return };
        let (nearest, farthest) = receivers(position, range[0], range[1], &self.frame.scene_bounds);
        self.bounded
            .add(light, filter.in_perspective(texel, [nearest, farthest], size).into_iter().flatten());
    }
}

/// Buffers that each frame reuses.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    descriptors: Vec<Descriptor>,
    bounded: Bounded,
}

#[derive(Clone, Debug, PartialEq)]
struct Run<D> {
    describe: D,
    live: Arc<LiveShadows>,
    filter: Option<Filter>,
    light_size: f64,
    cadence: u32,
}

/// Declares the CPU node that publishes views and descriptors of one backing for the placed lights. Returns `None`
/// after a diagnostic.
pub(crate) fn node(
    pass: &mut PassBuilder<'_>,
    to: &Ref,
    placement: Option<Subresource>,
    further: Option<(DataShape, impl DescribeShadows)>,
    live: LiveShadows,
) -> Option<Produced> {
    let evaluated = pass.live(|pass| live.evaluate(pass));
    let ((shape, describe), placement, (filter, light_size, cadence)) = (further?, placement?, evaluated?);
    let output = pass.publish(to, "/to", shape)?;
    let node = Run { describe, live: Arc::new(live), filter, light_size, cadence };
    pass.produce(Work::Cpu(CpuWork::new(node, output, vec![placement])))
}

impl<D: DescribeShadows> CpuNode for Run<D> {
    type State = Memory;

    fn run(&self, memory: &mut Memory, context: &CpuContext<'_>, data: &mut BlackboardData) {
        let Memory { descriptors, bounded } = memory;
        descriptors.clear();
        bounded.clear();
        let Some(placement) = context.inputs.first() else { return };
        let mut output = ShadowOutput {
            frame: context.frame,
            atlas_side: word(placement, "atlas_side"),
            filter: self.filter,
            light_size: self.light_size,
            cadence: 1,
            longest: self.cadence,
            data,
            descriptors,
            bounded,
        };
        let eye = Eye::new(&context.frame.camera).filter(|_| self.cadence > 1);
        for entry in placement::entries(placement) {
            let light = context.frame.lights.get(entry.light as usize);
            let importance = eye.as_ref().zip(light).map(|(eye, light)| eye.importance(light));
            output.cadence = importance.map_or(1, |importance| importance.cadence(self.cadence));
            self.describe.describe(&entry, &mut output);
        }
        let lacks = (!descriptors.is_empty()).then(|| self.describe.lacks(context.frame)).flatten();
        descriptor::publish(data, descriptors);
        bounded.report(self.filter, context.frame, lacks, data);
    }

    fn update(&mut self, settings: &mut LiveSettings<'_>) -> Option<()> {
        (self.filter, self.light_size, self.cadence) = self.live.evaluate(settings)?;
        self.describe.update(settings)
    }
}
