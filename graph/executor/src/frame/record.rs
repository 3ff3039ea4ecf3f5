//! Recording a frame: the plan's passes, one after the other, into the host's encoder.
//!
//! All missing objects are created first (none, in a steady frame); only then is anything recorded, so that a rejection
//! by the device leaves the encoder unchanged.
//!
//! Passes are labelled with their names, which wgpu makes debug groups on Vulkan, and not put into groups of the
//! encoder: wgpu has a command buffer for each pass, so such a group ends in another buffer than it begins in, which
//! crashes lavapipe of Mesa 22.3 at the next.

use super::input::Frame;
use super::scene::{Scene, common, covered};
use crate::binding::groups;
use crate::binding::host_groups::HostGroups;
use crate::drawing::attachments::{Attachments, Drawn};
use crate::drawing::redraw;
use crate::drawing::redraw::{Kept, NOTHING};
use crate::drawing::scroll::strips;
use crate::instance::instantiate::{Instantiated, InstantiatedPass, InstantiatedScene, InstantiatedWork};
use crate::measure::gpu_times::GpuTimes;
use crate::measure::statistics::PassCounts;
use crate::measure::times::Times;
use crate::memory::resources::Resources;
use crate::objects::creation::Creation;
use umbragraph_compiler::{Plan, PlannedPass};
use umbragraph_pipeline::data::{BlackboardData, View};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::work::{Redraw, SceneDraw};
use wgpu_profiler::GpuProfilerQuery;

/// Memory that all records reuse, and the counts and failures of the last record.
#[derive(Default)]
pub(crate) struct Scratch {
    offsets: Vec<u32>,
    drawn: Drawn,
    /// The draw counts of the last record, by pass index in the plan; zero for passes that draw no meshes.
    pub(crate) counts: Vec<PassCounts>,
    /// The indices of the passes whose draws failed in the last record, with the reasons.
    failed: Vec<(usize, String)>,
}

impl Scratch {
    /// Returns an error for each pass whose draws failed in the last record, and for each different reason.
    pub(crate) fn failures(&self, plan: &Plan) -> Diagnostics {
        let mut diagnostics = Diagnostics::new();
        for run in self.failed.chunk_by(|a, b| a == b) {
            let Some((at, reason)) = run.first() else { continue };
            let Some(planned) = plan.passes.get(*at) else { continue };
            let pass = plan.pipeline.pass(planned.handle);
            let message = format!("the host's draws of \"{}\" failed: {reason}", pass.name);
            let diagnostic =
                Diagnostic::error(codes::DRAW_FAILED, pass.place, message).pointer(&pass.pointer);
            let help = "what the pass had drawn is in the frame, as are all other passes; the next frame is possible";
            diagnostics.push(diagnostic.help(help));
        }
        diagnostics
    }
}

/// Rotates the histories, and creates the views and bind groups that a record needs and that do not exist yet. With
/// `is_again` the record is the last frame once more, and histories stay.
///
/// # Errors
/// Materials or objects that the host does not provide; textures of another device.
pub(crate) fn prepare(
    instantiated: &mut Instantiated,
    creation: &mut Creation<'_>,
    queue: &wgpu::Queue,
    frame: &Frame<'_>,
    blocks: Option<&wgpu::Buffer>,
    (record, is_again): (u64, bool),
) -> Result<(), Diagnostic> {
    let Resources { textures, histories, .. } = &mut instantiated.resources;
    histories.advance(&instantiated.plan, instantiated.cpu_passes.switches(), is_again);
    histories.prepare(creation, queue, textures);
    instantiated.resources.imports.set(creation, queue, frame.imports, record)?;
    let (resources, switches) = (&instantiated.resources, instantiated.cpu_passes.switches());
    for (planned, pass) in instantiated.plan.passes.iter().zip(&mut instantiated.passes) {
        if !switches.runs(&instantiated.plan, planned.handle) {
            continue;
        }
        for group in &mut pass.groups {
            group.prepare(creation, &planned.name, blocks, resources, switches, record);
        }
    }
    if let Some(source) = frame.draws {
        for groups in &mut instantiated.host_groups {
            groups.prepare(creation, source)?;
        }
    }
    Ok(())
}

/// Drops all bind groups and views of imports, and undoes the rotation of histories, after the preparation of a record
/// failed.
pub(crate) fn forget(instantiated: &mut Instantiated) {
    instantiated.resources.imports.forget_views();
    instantiated.resources.histories.retreat();
    instantiated.passes.iter_mut().flat_map(|pass| &mut pass.groups).for_each(groups::Group::forget);
    instantiated.host_groups.iter_mut().for_each(HostGroups::forget);
}

/// Records the passes of the plan that toggles do not switch off, in the plan's order.
pub(crate) fn record(
    instantiated: &mut Instantiated,
    encoder: &mut wgpu::CommandEncoder,
    frame: &Frame<'_>,
    record: u64,
    scratch: &mut Scratch,
    times: &mut Times,
    gpu_times: &GpuTimes,
) {
    instantiated.resources.histories.record(encoder);
    scratch.counts.clear();
    scratch.failed.clear();
    scratch.counts.resize(instantiated.plan.passes.len(), PassCounts::default());
    let mut all_kept = std::mem::take(&mut instantiated.kept);
    // Empty after a host that panicked within a record.
    all_kept.resize_with(instantiated.plan.passes.len(), Kept::default);
    let taken = &mut *instantiated;
    let instantiated = &*taken;
    let resources = &instantiated.resources;
    for (at, (planned, pass)) in instantiated.plan.passes.iter().zip(&instantiated.passes).enumerate() {
        // Passes of one render pass have the same toggle.
        if !instantiated.switches().runs(&instantiated.plan, planned.handle) {
            continue;
        }
        let start = times.now();
        match &pass.work {
            InstantiatedWork::Nothing => continue,
            InstantiatedWork::Transfer(transfer) => {
                let query = gpu_times.between(&planned.name, encoder);
                // Passes of wgpu have labels; copies and clears have none.
                encoder.push_debug_group(&planned.name);
                transfer.record(encoder, resources, instantiated.switches());
                encoder.pop_debug_group();
                gpu_times.end(encoder, query);
            }
            InstantiatedWork::Compute { pipeline, workgroups: [x, y, z], indirect } => {
                let query = gpu_times.pass(&planned.name, encoder);
                let timestamp_writes =
                    query.as_ref().and_then(GpuProfilerQuery::compute_pass_timestamp_writes);
                let descriptor = wgpu::ComputePassDescriptor { label: Some(&pass.label), timestamp_writes };
                let mut compute = encoder.begin_compute_pass(&descriptor);
                compute.set_pipeline(pipeline);
                groups::bind_compute(&pass.groups, &mut compute);
                match indirect {
                    None => compute.dispatch_workgroups(x.value, y.value, z.value),
                    Some(counts) => {
                        if let Some(buffer) = counts.buffer(resources, instantiated.switches()) {
                            compute.dispatch_workgroups_indirect(buffer, counts.offset);
                        }
                    }
                }
                drop(compute);
                gpu_times.end(encoder, query);
            }
            InstantiatedWork::Fullscreen { attachments, .. }
            | InstantiatedWork::Scene { attachments, .. } => {
                // What another pass begins, that pass records.
                if pass.merged == 0 {
                    continue;
                }
                let (name, label) = (&planned.name, &pass.label);
                let mut recording =
                    Recording { instantiated, frame, scratch, attachments, gpu_times, name, label };
                let clear = match &pass.work {
                    InstantiatedWork::Scene { scene, .. } => scene.clear.as_ref(),
                    _ => None,
                };
                if let Some(clear) = clear {
                    let mut kept = std::mem::take(&mut all_kept[at]);
                    recording.changed(encoder, at, clear, &mut kept, &all_kept, record);
                    all_kept[at] = kept;
                } else if attachments.is_flat() {
                    recording.flat(encoder, at, pass.merged);
                } else {
                    recording.layered(encoder, at, pass);
                }
            }
        }
        times.add(at, start);
    }
    taken.kept = all_kept;
}

/// The recording of one pass, or of several passes that share one render pass.
struct Recording<'a> {
    instantiated: &'a Instantiated,
    frame: &'a Frame<'a>,
    scratch: &'a mut Scratch,
    attachments: &'a Attachments,
    gpu_times: &'a GpuTimes,
    /// The name of the first of the recorded passes.
    name: &'a str,
    label: &'a str,
}

impl Recording<'_> {
    /// Records one render pass with all draws of `count` passes, from the pass with index `first` on.
    fn flat(&mut self, encoder: &mut wgpu::CommandEncoder, first: usize, count: usize) {
        let resources = &self.instantiated.resources;
        self.scratch.drawn.reset(self.attachments);
        let query = self.gpu_times.pass(self.name, encoder);
        let drawn = &mut self.scratch.drawn;
        let begun = self.attachments.begin(encoder, resources, self.label, query.as_ref(), 0, drawn);
        let Some(mut render_pass) = begun else { return self.gpu_times.end(encoder, query) };
        let passes = self.instantiated.plan.passes.iter().zip(&self.instantiated.passes);
        for (at, (planned, pass)) in passes.enumerate().skip(first).take(count) {
            if count > 1 {
                render_pass.push_debug_group(&planned.name);
            }
            set_constants(pass, &mut render_pass);
            match &pass.work {
                InstantiatedWork::Fullscreen { pipeline, attachments, draw } => {
                    let [width, height] = attachments.extent;
                    render_pass.set_viewport(0.0, 0.0, width as f32, height as f32, 0.0, 1.0);
                    render_pass.set_scissor_rect(0, 0, width, height);
                    render_pass.set_pipeline(pipeline);
                    groups::bind_render(&pass.groups, &mut render_pass, 0);
                    match draw {
                        Some(draw) => {
                            draw.record(resources, self.instantiated.switches(), &mut render_pass);
                        }
                        None => render_pass.draw(0..3, 0..1),
                    }
                }
                InstantiatedWork::Scene { scene, .. } => {
                    let views = views_of(self.instantiated, scene);
                    self.draw((at, scene), (0, views), None, &mut render_pass);
                }
                _ => {}
            }
            if count > 1 {
                render_pass.pop_debug_group();
            }
        }
        drop(render_pass);
        self.gpu_times.end(encoder, query);
    }

    /// Records a render pass for each run of consecutive views that draw into the same layer. Then clears the layers
    /// that no view draws into, unless the pass loads them.
    fn layered(&mut self, encoder: &mut wgpu::CommandEncoder, at: usize, pass: &InstantiatedPass) {
        let resources = &self.instantiated.resources;
        self.scratch.drawn.reset(self.attachments);
        if let InstantiatedWork::Scene { scene, .. } = &pass.work {
            let mut first = 0;
            for run in views_of(self.instantiated, scene).chunk_by(|a, b| a.layer == b.layer) {
                let layer = run.first().map_or(0, |view| view.layer);
                let drawn = &mut self.scratch.drawn;
                let query = self.gpu_times.pass(self.name, encoder);
                if let Some(mut render_pass) =
                    self.attachments.begin(encoder, resources, self.label, query.as_ref(), layer, drawn)
                {
                    set_constants(pass, &mut render_pass);
                    self.draw((at, scene), (first, run), None, &mut render_pass);
                }
                self.gpu_times.end(encoder, query);
                first += run.len();
            }
        }
        self.attachments.clear_rest(encoder, resources, self.label, &self.scratch.drawn);
    }

    /// Redraws the changed views of a pass; the texels of unchanged views stay as they are. Consecutive changed views
    /// of a layer share a render pass, unless a copy of texels comes between them. `others` holds the kept views of
    /// other passes, by pass index.
    fn changed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        at: usize,
        clear: &wgpu::RenderPipeline,
        kept: &mut Kept,
        others: &[Kept],
        record: u64,
    ) {
        let Some(pass) = self.instantiated.passes.get(at) else { return };
        let (Some(source), InstantiatedWork::Scene { scene, .. }) = (self.frame.draws, &pass.work) else {
            return;
        };
        let Some(planned) = self.instantiated.plan.passes.get(at) else { return };
        let Some(SceneDraw { redraw: Some(Redraw { every, .. }), filter, .. }) =
            scene_draw(self.instantiated, planned)
        else {
            return;
        };
        let (depth, attachments, resources) =
            (f32::from(scene.clear_depth.value), self.attachments, &self.instantiated.resources);
        let revised = source.revision(filter).map(|revision| (revision, source.generation()));
        let bounds = self.frame.input.filter_bounds.iter().find(|(known, _)| known == filter);
        let bounds = bounds.filter(|_| scene.is_placed);
        let cadences = self.instantiated.cpu_passes.seen(scene.views).map(BlackboardData::cadences);
        let every_of = |at: usize| {
            let said = every.get(at).or(every.last()).copied().unwrap_or(1);
            said.max(cadences.and_then(|cadences| cadences.get(at)).copied().unwrap_or(1))
        };
        let mut first = 0;
        let whole = [0, 0, attachments.extent[0], attachments.extent[1]];
        for run in views_of(self.instantiated, scene).chunk_by(|a, b| a.layer == b.layer) {
            let is_whole = run.len() == 1 && run.iter().all(|view| attachments.texels(view).1 == whole);
            let mut begun: Option<(Option<wgpu::RenderPass<'static>>, _)> = None;
            for (position, view) in (first..).zip(run) {
                let texels = attachments.texels(view);
                let (layer, area) = texels;
                if area[2] == 0 || area[3] == 0 {
                    continue;
                }
                let is_empty = bounds.is_some_and(|(_, bounds)| covered(bounds, view, area).is_none());
                let stamp = if is_empty { NOTHING } else { revised };
                let is_older = scene.over.as_ref().is_some_and(|(_, keeper)| {
                    let below = keeper.and_then(|at| others.get(at)?.latest(texels));
                    below.is_none_or(|below| kept.record_of(view).is_none_or(|own| own < below))
                });
                if !is_older && !kept.is_due(view, stamp, at + position, every_of(position), record) {
                    self.scratch.counts[at].kept += 1;
                    continue;
                }
                let scrolled = scene.scroll.as_ref().zip(kept.moved(view, texels, stamp));
                let over = scene.over.as_ref().map(|(over, _)| over);
                if scrolled.is_some_and(|(_, by)| by == [0, 0]) {
                    kept.note(*view, texels, stamp, record);
                    self.scratch.counts[at].kept += 1;
                    continue;
                }
                if let Some(brings) = scrolled.map(|(scroll, _)| scroll).or(over) {
                    if let Some((render_pass, query)) = begun.take() {
                        drop(render_pass);
                        self.gpu_times.end(encoder, query);
                    }
                    brings.copy(encoder, resources, layer);
                }
                let load = if is_whole && scrolled.is_none() && over.is_none() {
                    wgpu::LoadOp::Clear(depth)
                } else {
                    wgpu::LoadOp::Load
                };
                let (render_pass, _) = begun.get_or_insert_with(|| {
                    let query = self.gpu_times.pass(self.name, encoder);
                    (
                        attachments.begin_depth(
                            encoder,
                            resources,
                            self.label,
                            query.as_ref(),
                            view.layer,
                            load,
                        ),
                        query,
                    )
                });
                let Some(render_pass) = render_pass else { continue };
                let one = (position, std::slice::from_ref(view));
                if let Some((scroll, by)) = scrolled {
                    scroll.draw(render_pass, area, by);
                    for strip in strips(area, by) {
                        redraw::clear(render_pass, clear, strip, depth);
                        self.draw((at, scene), one, Some(strip), render_pass);
                    }
                } else {
                    if let Some(over) = over {
                        over.draw(render_pass, area, [0, 0]);
                    } else if !is_whole {
                        redraw::clear(render_pass, clear, area, depth);
                    }
                    self.draw((at, scene), one, Some(area), render_pass);
                }
                self.scratch.counts[at].views += 1;
                kept.note(*view, texels, stamp, record);
            }
            if let Some((render_pass, query)) = begun {
                drop(render_pass);
                self.gpu_times.end(encoder, query);
            }
            first += run.len();
        }
    }

    /// Lets the host draw views of the pass with index `at`; `first` is the index of the first of these views. `within`
    /// restricts the draws to a rectangle of texels (x, y, width, height), and the caller then counts the views; `None`
    /// draws entire views.
    fn draw(
        &mut self,
        (at, instantiated): (usize, &InstantiatedScene),
        (first, views): (usize, &[View]),
        within: Option<[u32; 4]>,
        render_pass: &mut wgpu::RenderPass<'static>,
    ) {
        let Some(source) = self.frame.draws else { return };
        let passes = self.instantiated.plan.passes.get(at).zip(self.instantiated.passes.get(at));
        let Some((planned, pass)) = passes else { return };
        let Some(work) = scene_draw(self.instantiated, planned) else { return };
        let host_groups = |at: Option<usize>| self.instantiated.host_groups.get(at?);
        let scene = Scene {
            work,
            instantiated,
            groups: &pass.groups,
            materials: host_groups(instantiated.materials),
            objects: host_groups(instantiated.objects),
            attachments: self.attachments,
        };
        let bounds = self.frame.input.filter_bounds.iter().find(|(known, _)| *known == work.filter);
        let bounds = bounds.filter(|_| instantiated.is_placed);
        for (position, view) in (first..).zip(views) {
            let (_, texels) = self.attachments.texels(view);
            let texels = bounds.map_or(Some(texels), |(_, bounds)| covered(bounds, view, texels));
            let texels =
                texels.and_then(|texels| within.map_or(Some(texels), |within| common(texels, within)));
            let Some(texels) = texels else { continue };
            let offsets = &mut self.scratch.offsets;
            let drawn = scene.draw(source, view, (position, texels), render_pass, offsets);
            let drawn = drawn.unwrap_or_else(|reason| {
                self.scratch.failed.push((at, reason));
                PassCounts::default()
            });
            let views = u64::from(within.is_none());
            self.scratch.counts[at] += PassCounts { views, ..drawn };
        }
    }
}

fn scene_draw<'a>(instantiated: &'a Instantiated, planned: &PlannedPass) -> Option<&'a SceneDraw> {
    instantiated.plan.pipeline.pass(planned.handle).work().scene()
}

fn views_of<'a>(instantiated: &'a Instantiated, scene: &InstantiatedScene) -> &'a [View] {
    instantiated.cpu_passes.seen(scene.views).map(BlackboardData::views).unwrap_or_default()
}

/// Sets the stencil reference and the blend constant of a render pass, if the pass declares them.
fn set_constants(pass: &InstantiatedPass, render_pass: &mut wgpu::RenderPass<'static>) {
    if let Some(reference) = pass.constants.reference {
        render_pass.set_stencil_reference(reference.value.into());
    }
    if let Some(blend) = pass.constants.blend {
        render_pass.set_blend_constant(blend.value.into());
    }
}
