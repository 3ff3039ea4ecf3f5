//! A plan, instantiated: everything that its passes need on the device.
//!
//! One walk over the passes in their order. What the plan before had, and caches still have, is taken over; nothing of
//! that plan is changed, so that an attempt that fails leaves it as it was.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::pipelines::{Layouts, Pipelines};
use crate::binding::blocks;
use crate::binding::blocks::Blocks;
use crate::binding::draw::Stated;
use crate::binding::groups::{Bound, Group};
use crate::binding::host_groups::{HostGroups, HostLayout};
use crate::drawing::attachments::Attachments;
use crate::drawing::buffer_draw::InstantiatedDraw;
use crate::drawing::redraw;
use crate::drawing::redraw::Kept;
use crate::drawing::scroll::Scroll;
use crate::memory::histories::Histories;
use crate::memory::imports::Imports;
use crate::memory::resources::{Fallbacks, Resources};
use crate::memory::textures::Textures;
use crate::memory::transfer::{Counts, Transfer};
use crate::objects::creation::Creation;
use crate::objects::shared::Objects;

use umbragraph_compiler::{CpuPasses, Parameters, Physical, Plan, PlannedPass, Switches};
use umbragraph_pipeline::data::View;
use umbragraph_pipeline::diagnostic::Diagnostic;
use umbragraph_pipeline::draw::{HostInterface, MATERIAL_GROUP, OBJECT_GROUP, PropertySet};
use umbragraph_pipeline::expression::Value;
use umbragraph_pipeline::pipeline::{IndexRange, Pass, Program, Usage};
use umbragraph_pipeline::work::{
    AttachmentTarget, Byte, Color, Depth, Dispatch, Draw, Live, ResourceHandle, SceneDraw, SlotSource,
    TextureView, Work,
};

/// A plan with all of its objects on the device.
pub(crate) struct Instantiated {
    pub(crate) plan: Arc<Plan>,
    pub(crate) resources: Resources,
    pub(crate) blocks: Blocks,
    pub(crate) passes: Vec<InstantiatedPass>,
    /// The bind groups of the host's materials and objects.
    pub(crate) host_groups: Vec<HostGroups>,
    /// The host's mesh layouts, by the name of the geometry contract.
    pub(crate) interfaces: BTreeMap<String, HostInterface>,
    /// The mesh layouts that draw sources have declared for this plan and earlier ones.
    pub(crate) stated: Stated,
    /// For each pass, the views whose texels are kept from frame to frame; empty if the pass draws all views in every
    /// frame.
    pub(crate) kept: Vec<Kept>,
    /// For each pass, the indices of the passes whose kept views depend on its results.
    pub(crate) keepers: Vec<Vec<usize>>,
    /// The CPU passes with their published data and their state, and the states of the toggles in the frame.
    pub(crate) cpu_passes: CpuPasses,
    /// The current values of the live parameters.
    pub(crate) parameters: Parameters,
}

/// A pass with all of its objects on the device.
pub(crate) struct InstantiatedPass {
    pub(crate) work: InstantiatedWork,
    pub(crate) groups: Vec<Group>,
    /// The number of passes that are recorded as one render pass, including this one; 0 if an earlier pass records this
    /// one.
    pub(crate) merged: usize,
    /// The label of the render or compute pass; the names of all passes that share the render pass.
    pub(crate) label: String,
    pub(crate) constants: Constants,
}

/// The constants that a render pass sets besides pipelines and bind groups.
#[derive(Clone, Copy, Default)]
pub(crate) struct Constants {
    /// The stencil reference; `None` for a pass without stencil.
    pub(crate) reference: Option<Live<Byte>>,
    /// The blend constant; `None` if the pass sets none.
    pub(crate) blend: Option<Live<Color>>,
}

impl Constants {
    fn of(work: &Work) -> Self {
        let Work::Render(render) = work else { return Self::default() };
        let reference = render.stencil.as_ref().map(|stencil| stencil.reference);
        Self { reference, blend: render.blend_constant }
    }
}

pub(crate) enum InstantiatedWork {
    Transfer(Transfer),
    Compute {
        pipeline: wgpu::ComputePipeline,
        workgroups: [Live<u32>; 3],
        indirect: Option<Counts>,
    },
    Fullscreen {
        pipeline: wgpu::RenderPipeline,
        attachments: Attachments,
        /// The draw from vertex buffers; `None` draws one triangle without buffers.
        draw: Option<InstantiatedDraw>,
    },
    Scene {
        scene: InstantiatedScene,
        attachments: Attachments,
    },
    /// No device object: a CPU pass, or a pass whose objects cannot be created.
    Nothing,
}

/// The device objects of a pass that draws the host's meshes.
pub(crate) struct InstantiatedScene {
    /// The blackboard resource whose views are drawn.
    pub(crate) views: ResourceHandle,
    pub(crate) pipelines: Vec<(PropertySet, wgpu::RenderPipeline)>,
    /// The index of the materials in [`Instantiated::host_groups`]; `None` if shaders bind none, or the host binds its
    /// own groups.
    pub(crate) materials: Option<usize>,
    /// The index of the objects in [`Instantiated::host_groups`]; `None` if shaders bind none, or the host binds its
    /// own groups.
    pub(crate) objects: Option<usize>,
    /// The indices of the bind groups that the host creates and binds itself.
    pub(crate) own_groups: Vec<u32>,
    /// The pipeline that clears a view's texels, if views are kept.
    pub(crate) clear: Option<wgpu::RenderPipeline>,
    /// The copy that shifts the still visible texels of a moved view; `None` if scrolling is off or impossible.
    pub(crate) scroll: Option<Scroll>,
    /// The copy of a base texture that views are drawn over. The number is the index of the pass that keeps the base's
    /// views; `None` if no pass keeps them.
    pub(crate) over: Option<(Scroll, Option<usize>)>,
    /// The depth that `clear` writes to the texels of a view.
    pub(crate) clear_depth: Live<Depth>,
    /// Whether the shader reads the view's matrix `clip_from_world`, so that the bounds of meshes limit the texels that
    /// draws can cover.
    pub(crate) is_placed: bool,
}

/// Returns `true` if the block `view` of a scene draw's shader contains the matrix `clip_from_world`.
fn is_placed(plan: &Plan, scene: &SceneDraw) -> bool {
    let matrix = View::shape().values.iter().position(|value| value.name == "clip_from_world");
    let program = plan.pipeline.program(scene.program);
    let views = scene.bindings.iter().filter(|slot| matches!(slot.source, SlotSource::View));
    let mut layouts = views.filter_map(|slot| plan.pipeline.block_layout(program, slot));
    layouts.any(|layout| layout.runs.iter().any(|run| Some(run.value as usize) == matrix))
}

impl Instantiated {
    /// Instantiates a plan, and reuses textures and buffers of the plan `before` it.
    ///
    /// # Errors
    /// Uniform and storage blocks that need more bytes than a buffer of the device can have.
    pub(crate) fn new(
        creation: &mut Creation<'_>,
        limits: &wgpu::Limits,
        objects: &mut Objects,
        plan: Arc<Plan>,
        (interfaces, stated): (BTreeMap<String, HostInterface>, Stated),
        before: Option<&Self>,
    ) -> Result<Self, Diagnostic> {
        let blocks = Blocks::new(&plan, limits)?;
        let old = before.map(|before| (&*before.plan, &before.resources.textures));
        let textures = Textures::new(creation, &plan, old);
        let old = before.map(|before| (&before.resources.histories, &before.resources.textures));
        let histories = Histories::new(&plan, &textures, old);
        let resources = Resources { textures, imports: Imports::new(&plan), histories };
        let mut instantiated = Self {
            resources,
            blocks,
            passes: Vec::with_capacity(plan.passes.len()),
            host_groups: Vec::new(),
            interfaces,
            stated,
            kept: plan.passes.iter().map(|_| Kept::default()).collect(),
            keepers: redraw::keepers(&plan),
            cpu_passes: CpuPasses::new(plan.clone()),
            parameters: Parameters::new(plan.clone()),
            plan: plan.clone(),
        };
        for (at, planned) in plan.passes.iter().enumerate() {
            let pass = instantiated.pass(creation, objects, at, planned);
            instantiated.passes.push(pass);
        }
        instantiated.merge();
        Ok(instantiated)
    }

    /// The state of the toggles in the frame.
    pub(crate) fn switches(&self) -> &Switches {
        self.cpu_passes.switches()
    }

    fn pass(
        &mut self,
        creation: &mut Creation<'_>,
        objects: &mut Objects,
        at: usize,
        planned: &PlannedPass,
    ) -> InstantiatedPass {
        let plan = self.plan.clone();
        let pass = plan.pipeline.pass(planned.handle);
        creation.begin_pass(pass);
        let instantiated = match (pass.work(), pass.work().program()) {
            (Work::Transfer(work), _) => {
                let transfer = Transfer::new(&self.resources, &plan, planned, work);
                transfer.map(|transfer| (InstantiatedWork::Transfer(transfer), Vec::new()))
            }
            (work, Some(program)) => {
                let program = plan.pipeline.program(program);
                let mut pipelines =
                    Pipelines { creation: &mut *creation, objects, plan: &plan, name: &pass.name, program };
                let host = work.scene().and_then(|scene| self.interfaces.get(&scene.geometry));
                let layouts = pipelines.layouts(work, host);
                let work = self.program_work(&mut pipelines, planned, pass, &layouts);
                let groups = self.groups(creation, objects, at, pass, program, &layouts);
                work.map(|work| (work, groups))
            }
            _ => None,
        };
        let (work, groups) = instantiated.unwrap_or((InstantiatedWork::Nothing, Vec::new()));
        let constants = Constants::of(pass.work());
        InstantiatedPass { work, groups, merged: 1, label: pass.name.clone(), constants }
    }

    fn program_work(
        &mut self,
        pipelines: &mut Pipelines<'_, '_>,
        planned: &PlannedPass,
        pass: &Pass,
        layouts: &Layouts,
    ) -> Option<InstantiatedWork> {
        let plan = self.plan.clone();
        match pass.work() {
            Work::Nothing | Work::Cpu(_) | Work::Transfer(_) => None,
            Work::Compute(compute) => {
                let mut workgroups = planned.workgroups.unwrap_or_default().map(Live::from);
                let mut indirect = None;
                match &compute.dispatch {
                    Dispatch::Indirect(counts) => {
                        indirect = Some(Counts::new(&self.resources, &plan, counts));
                    }
                    Dispatch::Workgroups(counts) => {
                        workgroups.iter_mut().zip(counts).for_each(|(to, from)| to.setting = from.setting);
                    }
                    Dispatch::Over { .. } => {}
                }
                Some(InstantiatedWork::Compute {
                    pipeline: pipelines.compute(layouts)?,
                    workgroups,
                    indirect,
                })
            }
            Work::Render(render) => {
                let attachments =
                    Attachments::new(pipelines.creation, &mut self.resources, &plan, planned, render)?;
                match &render.draw {
                    Draw::Fullscreen { .. } => {
                        let pipeline = pipelines.fullscreen(render, layouts)?;
                        Some(InstantiatedWork::Fullscreen { pipeline, attachments, draw: None })
                    }
                    Draw::Buffers(draw) => {
                        let pipeline = pipelines.buffers(render, draw, layouts)?;
                        let draw = Some(InstantiatedDraw::new(&self.resources, &plan, draw));
                        Some(InstantiatedWork::Fullscreen { pipeline, attachments, draw })
                    }
                    Draw::Scene(scene) => {
                        let interface = self.interfaces.get(&scene.geometry)?;
                        let made = pipelines.scene(render, scene, layouts, interface);
                        let fills = |index: &u32| interface.own_layout(*index).is_some();
                        let is_used = |index: &u32| layouts.group(*index).is_some();
                        let own_groups = [MATERIAL_GROUP, OBJECT_GROUP].into_iter();
                        let own_groups = own_groups.filter(|index| fills(index) && is_used(index)).collect();
                        let host = |index| {
                            let layout = host_layout(pipelines.program, layouts, index);
                            layout.filter(|_| !fills(&index))
                        };
                        let materials = host(MATERIAL_GROUP).map(HostGroups::materials);
                        let objects = host(OBJECT_GROUP).map(|layout| HostGroups::objects(layout, interface));
                        let mut place = |groups| position(&mut self.host_groups, groups);
                        let (materials, objects) = (materials.map(&mut place), objects.map(&mut place));
                        let attached = render.depth.as_ref().map(|depth| depth.to.target());
                        let mut bring = |from: AttachmentTarget| {
                            let (creation, objects) = (&mut *pipelines.creation, &mut *pipelines.objects);
                            Scroll::new(creation, objects, &self.resources, &plan, attached?, from)
                        };
                        let redraw = scene.redraw.as_ref();
                        let scrolls = redraw.is_some_and(|redraw| redraw.scroll);
                        let scroll = attached.filter(|_| scrolls).and_then(&mut bring);
                        let over = redraw
                            .and_then(|redraw| redraw.base.as_ref())
                            .and_then(|over| Some((bring(over.target())?, keeper(&plan, over.resource))));
                        let scene = InstantiatedScene {
                            views: scene.views.resource,
                            pipelines: made,
                            materials,
                            objects,
                            own_groups,
                            clear: pipelines.clear(render, scene),
                            scroll,
                            over,
                            clear_depth: scene
                                .redraw
                                .as_ref()
                                .map_or(Depth(0.0).into(), |redraw| redraw.clear),
                            is_placed: is_placed(&plan, scene),
                        };
                        Some(InstantiatedWork::Scene { scene, attachments })
                    }
                }
            }
        }
    }

    /// Returns the bind groups of a pass that the executor fills: all but those of the host's materials and objects.
    fn groups(
        &mut self,
        creation: &mut Creation<'_>,
        objects: &mut Objects,
        at: usize,
        pass: &Pass,
        program: &Program,
        layouts: &Layouts,
    ) -> Vec<Group> {
        let plan = self.plan.clone();
        let is_host = |index: u32| pass.work().scene().is_some() && index >= MATERIAL_GROUP;
        let mut groups = Vec::new();
        for (index, layout) in (0..).zip(&layouts.groups) {
            let Some(layout) = layout.as_ref().filter(|_| !is_host(index)) else { continue };
            let mut entries = Vec::new();
            for (position, slot) in blocks::slots(pass.work()).iter().enumerate() {
                if slot.group != index || program.binding_at(slot.group, slot.binding).is_none() {
                    continue;
                }
                let place = self.blocks.places(at).get(position).copied().flatten();
                let bound = match &slot.source {
                    SlotSource::Texture(texture) => {
                        let view = texture.view();
                        Bound::switched(Fallbacks::new(&plan, view.resource, |resource| {
                            let view = TextureView { resource, ..view };
                            self.resources.view(creation, &plan, view).map(Bound::View)
                        }))
                    }
                    SlotSource::Sampler(sampler) => {
                        Some(Bound::Sampler(objects.sampler(creation, &slot.name, *sampler)))
                    }
                    SlotSource::Buffer { buffer: named, usage } => {
                        Bound::switched(Fallbacks::new(&plan, named.resource, |resource| {
                            let buffer = self.resources.buffer(&plan, resource)?;
                            let planned = plan.resource(resource)?;
                            // What stands for it may be larger, and shaders can ask for the length. A storage buffer of
                            // the host's is bound to its end, which 0 stands for.
                            let is_whole = planned.physical == Physical::Imported && *usage != Usage::Uniform;
                            let all =
                                IndexRange { first: 0, count: if is_whole { 0 } else { planned.bytes } };
                            Some(Bound::Buffer(buffer, named.range.bytes.unwrap_or(all)))
                        }))
                    }
                    SlotSource::View => place.map(Bound::ViewBlock),
                    SlotSource::Data { .. } | SlotSource::Values(_) => place.map(Bound::Block),
                };
                entries.extend(bound.map(|bound| (slot.binding, bound)));
            }
            groups.push(Group::new(index, layout.clone(), entries));
        }
        groups
    }

    /// Joins neighbouring passes that the plan groups into one render pass.
    fn merge(&mut self) {
        let mut passes = self.passes.as_mut_slice();
        for run in self.plan.passes.chunk_by(|a, b| a.group == b.group) {
            let (run, rest) = passes.split_at_mut(run.len().min(passes.len()));
            passes = rest;
            if let Some((leader, followers)) =
                run.split_first_mut().filter(|(_, followers)| !followers.is_empty())
            {
                join(leader, followers);
            }
        }
    }
}

impl InstantiatedPass {
    /// Updates constants, workgroup counts, draw counts and clear values of the pass from the live values of the frame.
    pub(crate) fn update(&mut self, values: &[Value]) {
        self.constants.reference.iter_mut().for_each(|reference| reference.update(values));
        self.constants.blend.iter_mut().for_each(|blend| blend.update(values));
        match &mut self.work {
            InstantiatedWork::Compute { workgroups, .. } => {
                workgroups.iter_mut().for_each(|count| count.update(values));
            }
            InstantiatedWork::Fullscreen { attachments, draw, .. } => {
                attachments.update(values);
                draw.iter_mut().for_each(|draw| draw.update(values));
            }
            InstantiatedWork::Scene { attachments, scene } => {
                attachments.update(values);
                scene.clear_depth.update(values);
            }
            InstantiatedWork::Transfer(_) | InstantiatedWork::Nothing => {}
        }
    }
}

impl InstantiatedWork {
    /// The attachments of a pass that is recorded as exactly one render pass; `None` for other passes.
    fn flat_attachments(&mut self) -> Option<&mut Attachments> {
        match self {
            InstantiatedWork::Fullscreen { attachments, .. }
            | InstantiatedWork::Scene { attachments, .. } => {
                Some(attachments).filter(|attachments| attachments.is_flat())
            }
            _ => None,
        }
    }
}

/// Merges `followers` into the render pass of `leader`, unless one of these passes is not exactly one render pass.
fn join(leader: &mut InstantiatedPass, followers: &mut [InstantiatedPass]) {
    let Some(attachments) = leader.work.flat_attachments() else { return };
    if followers.iter_mut().any(|follower| follower.work.flat_attachments().is_none()) {
        return;
    }
    for follower in followers.iter_mut() {
        if let Some(own) = follower.work.flat_attachments() {
            attachments.end_like(own);
        }
        follower.merged = 0;
        leader.label.push_str(" + ");
        leader.label.push_str(&follower.label);
    }
    leader.merged = 1 + followers.len();
}

/// Returns the index of the pass that keeps views in a depth texture from frame to frame; `None` if there is none.
fn keeper(plan: &Plan, texture: ResourceHandle) -> Option<usize> {
    let mut works = plan.passes.iter().map(|planned| plan.pipeline.pass(planned.handle).work());
    works.position(|work| redraw::kept(work).is_some_and(|(.., depth)| depth == texture))
}

/// Returns the index of equal bind groups in the list, after adding them if they are missing.
fn position(list: &mut Vec<HostGroups>, new: HostGroups) -> usize {
    list.iter().position(|known| known.is_alike(&new)).unwrap_or_else(|| {
        list.push(new);
        list.len() - 1
    })
}

/// Returns the layout and the binding names of a host's bind group in a program; `None` if the program has no bindings
/// in it.
fn host_layout(program: &Program, layouts: &Layouts, index: u32) -> Option<HostLayout> {
    let bindings = program.bindings.iter().filter(|binding| binding.group == index);
    let bindings = bindings.map(|binding| (binding.entry.binding, binding.name.clone())).collect();
    Some(HostLayout { layout: layouts.group(index)?.clone(), bindings })
}
