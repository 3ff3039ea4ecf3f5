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

/// The most frames that what casters did can wait for.
const MAX_CADENCE: u32 = 64;

/// The settings of a node that describes lights of one position.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
pub struct DescribedSettings {
    /// The blackboard data to publish.
    pub to: Ref,
    /// The blackboard data of a `shadow_atlas`.
    pub placement: Ref,
    /// Whether depth runs from 1 at the near plane to 0 at the far plane; false without it.
    pub reverse: Option<Expr>,
    /// The filter that shaders use, so that the distances at which its bounds bite can be reported.
    pub shadow_filter: Option<FilterSettings>,
    /// The radius of lights that say none, in metres; 0 without it.
    pub light_size: Option<Expr>,
    /// The most frames that what casters did waits for, in maps that a pass keeps ("redraw": "changed"): 1, so that
    /// nothing waits, without it. The maps of lights that matter less wait for 1, 2, 4, 8 and so on.
    pub cadence: Option<Expr>,
}

/// The settings of a node that describes lights which are live.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LiveShadows {
    pub(crate) filter: Option<FilterSettings>,
    pub(crate) light_size: Option<Expr>,
    pub(crate) cadence: Option<Expr>,
}

impl LiveShadows {
    /// The filter, the size of lights that say none, and the longest cadence.
    fn evaluate(&self, pass: &mut impl Evaluate) -> Option<(Option<Filter>, f64, u32)> {
        let filter = Filter::declare(self.filter.as_ref(), pass);
        let light_size = pass.number_or(&self.light_size, "/light_size", 0.0);
        let cadence = cadence(pass, &self.cadence);
        Some((filter?, light_size?, cadence?))
    }
}

/// The longest cadence, from 1.
pub(crate) fn cadence(pass: &mut impl Evaluate, setting: &Option<Expr>) -> Option<u32> {
    let cadence = pass.count_or(setting, "/cadence", 1)?;
    if (1..=MAX_CADENCE).contains(&cadence) {
        return Some(cadence);
    }
    let message = format!("what changed cannot wait for {cadence} frames");
    pass.reject(codes::OUT_OF_BOUNDS, "/cadence", message, format!("write a number from 1 to {MAX_CADENCE}"))
}

impl DescribedSettings {
    /// Declares the node; `describe` makes what is published and the backing of further
    /// settings and of whether depth is reversed.
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

/// The description of the lights of one backing.
pub(crate) trait DescribeShadows: Clone + Debug + PartialEq + Send + Sync + 'static {
    /// Describes a placed light of this backing; ignores lights of other backings.
    fn describe(&self, entry: &Entry, output: &mut ShadowOutput<'_>);
    /// Whether a frame with lights of this backing lacks bounds.
    fn lacks(&self, _frame: &FrameInput) -> Option<NoBounds> {
        None
    }
    /// Takes over live settings of its own; `None` after a diagnostic.
    fn update(&mut self, _settings: &mut LiveSettings<'_>) -> Option<()> {
        Some(())
    }
}

/// The output for one frame.
pub(crate) struct ShadowOutput<'a> {
    pub(crate) frame: &'a FrameInput,
    /// The side of the atlas, in texels.
    pub(crate) atlas_side: u32,
    pub(crate) filter: Option<Filter>,
    /// The size of lights without one.
    pub(crate) light_size: f64,
    /// The number of frames after which the light's maps are drawn again; and the largest of all lights.
    pub(crate) cadence: u32,
    pub(crate) longest: u32,
    data: &'a mut BlackboardData,
    /// One descriptor after another; the default one shadows nothing.
    pub(crate) descriptors: &'a mut Vec<Descriptor>,
    /// The places where the bounds of the filter apply.
    pub(crate) bounded: &'a mut Bounded,
}

impl ShadowOutput<'_> {
    /// Adds a map to draw; maps beyond the capacity are left out, as their descriptors are.
    pub(crate) fn view(&mut self, view: View) {
        if self.data.views().len() < self.data.shape().max_views as usize {
            self.data.push_view_every(view, self.cadence);
        }
    }

    /// Notes where the bounds of the filter bite for a light at a position whose maps are perspectives between two
    /// distances, with texels of a width at a distance of one metre; `size` is the radius of the light.
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

/// Memory that is used again in each frame.
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

/// The node that publishes the descriptors of one backing for the lights of a placement.
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
