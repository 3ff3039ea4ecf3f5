//! Views whose texels are kept from frame to frame.
//!
//! A pass that draws changed views ([`Redraw`]) records each drawn view, with the host's revision of the draws in its
//! filter. A later view is skipped while it equals the recorded one at its place, matrices included, and the revision
//! is the same. If only the revision differs, the view waits for its turn, at most as many frames as the cadence; turns
//! are staggered by the views' positions. Drawing over a view removes its record.
//!
//! The render pass clears a view that covers its layer alone. For any other view a triangle clears the texels, at the
//! depth of its viewport.
//!
//! The records belong to the textures of one plan: another plan draws everything again. A changed live parameter
//! redraws the passes whose settings it changes, and passes whose data, textures or buffers depend on it. Nothing is
//! allocated once there was room for as many views.
//!
//! Limits: the views of a pass do not overlap, and no other pass writes the texture. Other blackboard data and values
//! that the shader reads are not compared.

use super::scroll;
use crate::objects::creation::Creation;
use crate::objects::shared::{Objects, RenderKey};
use std::collections::HashMap;
use umbragraph_compiler::Plan;
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::work::{BoundSlot, Redraw, ResourceHandle, SceneDraw, SlotSource, Work};

/// The key of this shader module in the module cache, in place of a hash.
const CLEAR_KEY: [u8; 32] = *b"executor: clears a tile of depth";

const CLEAR: &str = "@vertex fn cover(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return vec4<f32>(f32((index << 1u) & 2u) * 2.0 - 1.0, f32(index & 2u) * 2.0 - 1.0, 0.0, 1.0);
}
";

/// The revision and generation of the host that a view was drawn with; `None` if the host declares none.
pub(crate) type Stamp = Option<(u64, u64)>;

/// The stamp of a view that contains no draw of its filter. It stays equal when the host's revision changes.
pub(crate) const NOTHING: Stamp = Some((u64::MAX, u64::MAX));

/// The views that a pass has drawn and whose texels are unchanged since.
#[derive(Default)]
pub(crate) struct Kept {
    views: Vec<KeptView>,
}

struct KeptView {
    view: View,
    texels: Texels,
    stamp: Stamp,
    /// The number of the record that drew the view.
    record: u64,
}

/// The texels of a view: the index of its layer, and x, y, width and height in texels.
pub(crate) type Texels = (usize, [u32; 4]);

impl Kept {
    /// Returns `true` if a view has to be drawn in a record. A view of which only the stamp differs is drawn in one of
    /// `every` records. `position` is the view's index.
    pub(crate) fn is_due(&self, view: &View, stamp: Stamp, position: usize, every: u32, record: u64) -> bool {
        let Some(kept) = self.views.iter().find(|kept| kept.view == *view) else { return true };
        let is_same = stamp.is_some() && stamp == kept.stamp;
        let every = u64::from(every.max(1));
        let turn = (record + position as u64).is_multiple_of(every) || record - kept.record >= every;
        !is_same && turn
    }

    /// Returns the texels by which a view moved since it was drawn; `None` if anything else changed.
    pub(crate) fn moved(&self, view: &View, texels: Texels, stamp: Stamp) -> Option<[i32; 2]> {
        let is_same = |kept: &&KeptView| kept.texels == texels && kept.stamp == stamp;
        let kept = self.views.iter().find(is_same).filter(|_| stamp.is_some())?;
        let (_, [_, _, width, height]) = texels;
        scroll::moved(&kept.view, view, [width, height])
    }

    /// The number of the record that drew a view; `None` if the view has changed since.
    pub(crate) fn record_of(&self, view: &View) -> Option<u64> {
        self.views.iter().find(|kept| kept.view == *view).map(|kept| kept.record)
    }

    /// The number of the last record that drew a kept view into any of these texels; `None` if no kept view covers
    /// them.
    pub(crate) fn latest(&self, texels: Texels) -> Option<u64> {
        let within = self.views.iter().filter(|kept| overlap(kept.texels, texels));
        within.map(|kept| kept.record).max()
    }

    /// Forgets all kept views, so that the next record draws them.
    pub(crate) fn forget(&mut self) {
        self.views.clear();
    }

    /// Notes that a record drew a view, and drops the kept views whose texels it overwrote.
    pub(crate) fn note(&mut self, view: View, texels: Texels, stamp: Stamp, record: u64) {
        self.views.retain(|kept| !overlap(kept.texels, texels));
        self.views.push(KeptView { view, texels, stamp, record });
    }
}

/// The draws of a pass that keeps views, its redraw settings, and its depth texture.
pub(crate) fn kept(work: &Work) -> Option<(&SceneDraw, &Redraw, ResourceHandle)> {
    let Work::Render(render) = work else { return None };
    let scene = work.scene()?;
    Some((scene, scene.redraw.as_ref()?, render.depth.as_ref()?.to.resource))
}

/// For each pass of a plan, the indices of the view-keeping passes that depend on its results, directly or through
/// other passes. A view-keeping pass depends on itself too. Its views are not counted, since views are compared, nor is
/// its base texture, whose draws are recorded.
pub(crate) fn keepers(plan: &Plan) -> Vec<Vec<usize>> {
    let pipeline = &plan.pipeline;
    let base =
        |resource: ResourceHandle| pipeline.resource(resource).history.map_or(resource, |history| history.of);
    let mut writers: HashMap<ResourceHandle, Vec<usize>> = HashMap::new();
    for (at, planned) in plan.passes.iter().enumerate() {
        for one in pipeline.pass(planned.handle).accesses().iter().filter(|one| one.usage.writes()) {
            writers.entry(base(one.resource)).or_default().push(at);
        }
    }
    let mut keepers = vec![Vec::new(); plan.passes.len()];
    for (keeper, planned) in plan.passes.iter().enumerate() {
        let Some((scene, redraw, depth)) = kept(pipeline.pass(planned.handle).work()) else { continue };
        let below = redraw.base.as_ref().map(|over| over.resource);
        let is_view = |slot: &BoundSlot| !matches!(&slot.source, SlotSource::Data { data, .. } if data.resource == scene.views.resource);
        let views = Some(scene.views.resource).filter(|_| scene.bindings.iter().all(is_view));
        let own = [Some(depth), below, views];
        let (mut seen, mut stack) = (vec![false; plan.passes.len()], vec![keeper]);
        while let Some(at) = stack.pop() {
            if std::mem::replace(&mut seen[at], true) {
                continue;
            }
            keepers[at].push(keeper);
            let reads = pipeline.pass(plan.passes[at].handle).accesses().iter();
            let reads =
                reads.filter(|one| one.usage.reads() && !(at == keeper && own.contains(&Some(one.resource))));
            stack.extend(reads.filter_map(|one| writers.get(&base(one.resource))).flatten());
        }
    }
    keepers
}

fn overlap((layer, a): Texels, (other, b): Texels) -> bool {
    let meet = |a: u32, length: u32, b: u32, other: u32| {
        u64::from(a) < u64::from(b) + u64::from(other) && u64::from(b) < u64::from(a) + u64::from(length)
    };
    layer == other && meet(a[0], a[2], b[0], b[2]) && meet(a[1], a[3], b[1], b[3])
}

/// Creates the pipeline that sets the depth of a view's texels.
pub(crate) fn clear_pipeline(
    creation: &mut Creation<'_>,
    objects: &mut Objects,
    format: wgpu::TextureFormat,
    samples: u32,
) -> wgpu::RenderPipeline {
    let label = "clear a view";
    let layout = objects.pipeline_layout(creation, label, Vec::new());
    let module = objects.built_in(creation, label, CLEAR_KEY, CLEAR);
    let key = RenderKey::depth_alone(layout, module, "cover", None, format, samples);
    objects.render_pipeline(creation, label, key)
}

/// Sets the depth of the rectangle of x, y, width and height in texels.
pub(crate) fn clear(
    pass: &mut wgpu::RenderPass<'static>,
    pipeline: &wgpu::RenderPipeline,
    [x, y, width, height]: [u32; 4],
    depth: f32,
) {
    pass.set_viewport(x as f32, y as f32, width as f32, height as f32, depth, depth);
    pass.set_scissor_rect(x, y, width, height);
    pass.set_pipeline(pipeline);
    pass.draw(0..3, 0..1);
}

#[cfg(test)]
mod tests {
    use umbragraph_test_support::random::Random;

    use super::*;

    fn view(layer: u32, viewport: [u32; 4], matrix: u32) -> View {
        View::new(
            glam::DMat4::from_translation(glam::DVec3::X * f64::from(matrix)),
            glam::DMat4::IDENTITY,
            glam::DVec3::ZERO,
            glam::DVec3::NEG_Z,
        )
        .layer(layer)
        .viewport(Some(viewport))
    }

    /// Checks for each texel that its last draw was of the same view, and no older than the cadence allows.
    #[test]
    fn no_texel_is_of_another_view_or_older_than_the_cadence() {
        let mut left = 0;
        for run in 0..1000 {
            let mut random = Random(run);
            let longest = 1_u32 << random.below(4);
            let (mut kept, mut texels) = (Kept::default(), [[None; 64]; 2]);
            let (mut revision, mut changes) = (0, Vec::new());
            let mut matrices = [0; 4];
            for record in 0..32 {
                revision += u64::from(!random.one_in(3));
                changes.push(revision);
                matrices[random.below(4)] += random.below(8) as u32 / 7;
                // Quarters of two layers, or one tile across the quarters of one.
                let is_one = random.one_in(9);
                let tiles = if is_one { vec![(0, [2, 2, 4, 4])] } else { quarters(random.below(16) as u32) };
                for (position, (layer, area)) in tiles.into_iter().enumerate() {
                    // What matters changes.
                    let every = longest >> (random.below(2) as u32).min(longest.ilog2());
                    let view = view(layer, area, matrices[position]);
                    let stamp = (!random.one_in(99)).then_some((revision, 0));
                    let inside = |at: usize| {
                        let (x, y) = (at as u32 % 8, at as u32 / 8);
                        (area[0]..area[0] + area[2]).contains(&x) && (area[1]..area[1] + area[3]).contains(&y)
                    };
                    if kept.is_due(&view, stamp, position, every, record) {
                        kept.note(view, (layer as usize, area), stamp, record);
                        for at in (0..64).filter(|at| inside(*at)) {
                            texels[layer as usize][at] = Some((view, revision));
                        }
                    } else {
                        left += 1;
                    }
                    let oldest = changes[changes.len().saturating_sub(longest as usize)];
                    for at in (0..64).filter(|at| inside(*at)) {
                        let (drawn, revision) = texels[layer as usize][at].expect("a texel that was drawn");
                        assert_eq!(drawn, view, "run {run}, record {record}");
                        assert!(revision >= oldest, "run {run}, record {record}: {revision} before {oldest}");
                    }
                }
            }
        }
        assert!(left > 10_000, "{left} views were left as they were");
    }

    fn quarters(present: u32) -> Vec<(u32, [u32; 4])> {
        let quarters = (0..4).filter(|at| present >> at & 1 == 1);
        quarters.map(|at| (at % 2, [at % 2 * 4, at / 2 * 4, 4, 4])).collect()
    }
}
