//! The plan: everything about a frame that is known before it, as a value.
//!
//! A [`Plan`] is made for one pipeline and one viewport: live passes in order, sizes, formats and usages, which
//! resources share a texture, what each attachment loads and stores, dispatch sizes and the bytes of constant blocks.
//! It is serialisable and the same from run to run. An executor realizes it; nothing in it knows a device.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;
use wgpu_types::{BufferUsages, TextureFormat, TextureUsages};

use super::cull::{self, CullReason, KeepReason};
use super::graph::Graph;
use super::lifetime::{Want, assign};
use super::size::{Size, Sizes, TextureSize};
use super::values::PackedBlock;
use super::{format, values};
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::expression::Value;
use crate::language::{Lifetime, TextureShape};
use crate::pipeline::{Part, Pipeline, ResourceKind, Usage, Use};
use crate::shader::{ScalarKind, Stage};
use crate::source::Sources;
use crate::work::{AttachmentTarget, Dispatch, Draw, LoadOperation, PassHandle, ResourceHandle, SlotSource, Work};

/// What the caller knows of a frame before it.
#[derive(Clone, Debug)]
pub struct PlanOptions {
    /// Width and height of the picture in texels.
    pub viewport: [u32; 2],
    /// The host's own textures by the name of the resource that stands for them. One that is not told is taken to be
    /// as the pipeline declares it.
    pub imports: BTreeMap<String, Import>,
    /// Whether transient resources may share memory.
    pub aliasing: bool,
}

impl PlanOptions {
    /// A viewport, no imports told, with aliasing.
    pub fn new(width: u32, height: u32) -> Self {
        Self { viewport: [width, height], imports: BTreeMap::new(), aliasing: true }
    }
}

/// A texture of the host's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Import {
    /// Its format.
    pub format: TextureFormat,
    /// Its size.
    pub size: TextureSize,
}

/// Everything about a frame that is known before it.
#[derive(Clone, Debug, Serialize)]
pub struct Plan {
    /// The pipeline's name.
    pub name: String,
    /// Width and height of the picture in texels.
    pub viewport: [u32; 2],
    /// The live passes in the order in which they run.
    pub passes: Vec<PlannedPass>,
    /// The culled passes by name, each with the reason.
    pub culled: BTreeMap<String, CullReason>,
    /// The resources that live passes use, by name.
    pub resources: BTreeMap<String, PlannedResource>,
    /// The textures to create.
    pub textures: Vec<PhysicalTexture>,
    /// The buffers to create.
    pub buffers: Vec<PhysicalBuffer>,
    /// Bytes of the transient and persistent resources if none shared memory.
    pub bytes_without_aliasing: u64,
    /// Bytes that are created.
    pub bytes: u64,
    /// The pipeline.
    #[serde(skip)]
    pub pipeline: Arc<Pipeline>,
}

/// A live pass.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedPass {
    /// Its name.
    pub name: String,
    /// Its node kind.
    pub kind: String,
    /// Why it is kept: the way to an output, in words.
    pub kept: Vec<String>,
    /// The color attachments.
    pub color: Vec<PlannedAttachment>,
    /// The depth attachment.
    pub depth: Option<PlannedAttachment>,
    /// The number of workgroups.
    pub workgroups: Option<[u32; 3]>,
    /// The shader variants: the template with what was chosen, and the hash of the text.
    pub variants: Vec<String>,
    /// The constant blocks.
    pub blocks: Vec<PackedBlock>,
    /// The pass.
    #[serde(skip)]
    pub handle: PassHandle,
}

/// What an attachment loads and stores.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedAttachment {
    /// The resource.
    pub resource: String,
    /// What is there before: `load`, `clear` or `discard`.
    pub load: LoadOperation<()>,
    /// What happens afterwards.
    pub store: StoreOperation,
    /// The handle.
    #[serde(skip)]
    pub target: AttachmentTarget,
}

/// What happens to an attachment after a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum StoreOperation {
    /// It is kept, because something later needs it.
    Store,
    /// It is not needed any more.
    Discard,
}

/// A resource that live passes use.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedResource {
    /// How long it lives.
    pub lifetime: Lifetime,
    /// The first pass that uses it, as its position in the order.
    pub first: usize,
    /// The last pass that uses it.
    pub last: usize,
    /// What stands for it on the device.
    pub physical: Physical,
    /// The format, of a texture.
    pub format: Option<TextureFormat>,
    /// The size, of a texture.
    pub size: Option<TextureSize>,
    /// The handle.
    #[serde(skip)]
    pub handle: ResourceHandle,
}

/// What stands for a resource on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Physical {
    /// A texture of the plan.
    Texture(usize),
    /// A buffer of the plan.
    Buffer(usize),
    /// The host's own.
    Imported,
    /// Data on the CPU.
    Host,
}

/// A texture to create.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicalTexture {
    /// The names of the resources that it stands for, in the order of their lifetimes.
    pub label: String,
    /// The format.
    pub format: TextureFormat,
    /// The size.
    pub size: TextureSize,
    /// Whether it is a volume.
    pub volume: bool,
    /// The usages.
    pub usages: TextureUsages,
    /// Its bytes, all mips, layers and samples.
    pub bytes: u64,
}

/// A buffer to create.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicalBuffer {
    /// The names of the resources that it stands for.
    pub label: String,
    /// Its size.
    pub bytes: u64,
    /// The usages.
    pub usages: BufferUsages,
}

/// Plans a frame.
///
/// Findings: impossible sizes, formats that do not support their uses, attachments that do not fit together or the
/// shader's outputs, impossible dispatches, values that do not fit their block. `None` after an error.
pub fn plan(
    pipeline: &Arc<Pipeline>,
    graph: &Graph,
    options: &PlanOptions,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Option<Plan> {
    let before = diagnostics.error_count();
    let kept = cull::keep(pipeline, graph);
    let order: Vec<PassHandle> = graph.order.iter().copied().filter(|pass| kept[pass.index()].is_some()).collect();
    if order.is_empty() && !pipeline.passes.is_empty() && pipeline.uncertain.is_empty() {
        diagnostics.push(no_output(pipeline));
    }
    let imported = pipeline
        .resources
        .iter()
        .map(|resource| {
            let told = options.imports.get(&resource.name).filter(|_| resource.lifetime() == Lifetime::Imported);
            told.map(|import| import.size)
        })
        .collect();
    let planner = Planner {
        pipeline,
        options,
        order: &order,
        sizes: Sizes::new(pipeline, sources, options.viewport, imported),
        users: users(pipeline, &order),
    };
    let mut findings = Vec::new();
    let resources = planner.resources(&mut findings);
    let passes: Vec<PlannedPass> =
        order.iter().enumerate().map(|(at, pass)| planner.pass(at, *pass, &kept, &resources, &mut findings)).collect();
    // Sizes of what is declared are checked even where nothing live uses it.
    for handle in pipeline.resource_handles() {
        planner.sizes.of(handle);
    }
    let Planner { sizes, .. } = planner;
    diagnostics.extend(sizes.into_findings());
    diagnostics.extend(findings);
    if diagnostics.error_count() > before {
        return None;
    }
    let mut plan = Plan {
        name: pipeline.name.clone(),
        viewport: options.viewport,
        passes,
        culled: pipeline
            .pass_handles()
            .filter(|pass| kept[pass.index()].is_none())
            .map(|pass| (pipeline.pass(pass).name.clone(), cull::cull_reason(pipeline, graph, pass)))
            .collect(),
        resources: BTreeMap::new(),
        textures: Vec::new(),
        buffers: Vec::new(),
        bytes_without_aliasing: 0,
        bytes: 0,
        pipeline: pipeline.clone(),
    };
    place(&mut plan, pipeline, resources, options.aliasing);
    Some(plan)
}

/// A resource with everything known but its place.
struct Sized {
    handle: ResourceHandle,
    first: usize,
    last: usize,
    texture: Option<(TextureFormat, TextureSize, bool, TextureUsages)>,
    buffer: Option<(u64, BufferUsages)>,
}

struct Planner<'a> {
    pipeline: &'a Pipeline,
    options: &'a PlanOptions,
    order: &'a [PassHandle],
    sizes: Sizes<'a>,
    /// For each resource its live uses with their position in the order.
    users: Vec<Vec<(usize, &'a Use)>>,
}

fn users<'a>(pipeline: &'a Pipeline, order: &[PassHandle]) -> Vec<Vec<(usize, &'a Use)>> {
    let mut users = vec![Vec::new(); pipeline.resources.len()];
    for (at, pass) in order.iter().enumerate() {
        for one in &pipeline.pass(*pass).uses {
            users[one.resource.index()].push((at, one));
        }
    }
    users
}

impl Planner<'_> {
    fn resources(&self, findings: &mut Vec<Diagnostic>) -> BTreeMap<ResourceHandle, Sized> {
        let mut resources = BTreeMap::new();
        for handle in self.pipeline.resource_handles() {
            let resource = self.pipeline.resource(handle);
            let uses = &self.users[handle.index()];
            let (Some((first, _)), Some((last, _))) = (uses.first(), uses.last()) else { continue };
            let mut sized = Sized { handle, first: *first, last: *last, texture: None, buffer: None };
            match (&resource.kind, self.sizes.of(handle)) {
                (ResourceKind::Texture(texture), Some(Size::Texture(size))) => {
                    self.check_parts(handle, size, findings);
                    let usages = uses.iter().map(|(_, one)| one.usage.texture_usages()).fold(TextureUsages::empty(), |a, b| a | b);
                    let told = self.options.imports.get(&resource.name).filter(|_| texture.lifetime == Lifetime::Imported);
                    let passes: Vec<PassHandle> = {
                        let mut passes: Vec<_> = uses.iter().map(|(at, _)| self.order[*at]).collect();
                        passes.dedup();
                        passes
                    };
                    let chosen = match told {
                        Some(import) => Some(import.format),
                        None => {
                            let wants = format::wants(self.pipeline, handle, &passes);
                            format::choose(self.pipeline, resource, texture, &wants, size.samples)
                                .map_err(|finding| findings.push(*finding))
                                .ok()
                        }
                    };
                    let volume = texture.view == Some(TextureShape::D3);
                    sized.texture = chosen.map(|format| (format, size, volume, usages));
                }
                (ResourceKind::Buffer(_), Some(Size::Buffer(bytes))) => {
                    let usages = uses.iter().map(|(_, one)| one.usage.buffer_usages()).fold(BufferUsages::empty(), |a, b| a | b);
                    sized.buffer = Some((bytes, usages));
                }
                _ => {}
            }
            resources.insert(handle, sized);
        }
        resources
    }

    /// Finds uses of mips and layers that a texture does not have.
    fn check_parts(&self, handle: ResourceHandle, size: TextureSize, findings: &mut Vec<Diagnostic>) {
        let name = &self.pipeline.resource(handle).name;
        for (_, one) in &self.users[handle.index()] {
            for (what, at, count) in [("mip", one.part.mip, size.mips), ("layer", one.part.layer, size.layers)] {
                if let Some(at) = at.filter(|at| *at >= count) {
                    findings.push(
                        Diagnostic::error(codes::ATTACHMENTS, one.place, format!("\"{name}\" has no {what} {at}"))
                            .pointer(&one.pointer)
                            .help(format!("it has {count}, counted from 0")),
                    );
                }
            }
        }
    }

    fn pass(
        &self,
        at: usize,
        handle: PassHandle,
        kept: &[Option<KeepReason>],
        resources: &BTreeMap<ResourceHandle, Sized>,
        findings: &mut Vec<Diagnostic>,
    ) -> PlannedPass {
        let pass = self.pipeline.pass(handle);
        let mut planned = PlannedPass {
            name: pass.name.clone(),
            kind: pass.kind.clone(),
            kept: self.reasons(handle, kept),
            color: Vec::new(),
            depth: None,
            workgroups: None,
            variants: Vec::new(),
            blocks: Vec::new(),
            handle,
        };
        if let Some((program, slots)) = format::slots(self.pipeline, handle) {
            planned.variants = program
                .variants
                .iter()
                .map(|variant| {
                    let hash: String = variant.module.hash[..4].iter().map(|byte| format!("{byte:02x}")).collect();
                    format!("{} [{}] {hash}", program.template, crate::shader::describe(&variant.module.axes))
                })
                .collect();
            for slot in slots {
                if let SlotSource::Values { layout, values } = &slot.source
                    && let Some(bytes) = values::pack(layout, values, &self.sizes, findings)
                {
                    planned.blocks.push(PackedBlock { group: slot.group, binding: slot.binding, bytes });
                }
            }
        }
        match &pass.work {
            Work::Render(render) => {
                for color in &render.color {
                    planned.color.push(self.attachment(at, color.target, load_kind(&color.load)));
                }
                if let Some(depth) = &render.depth {
                    planned.depth = Some(self.attachment(at, depth.target, load_kind(&depth.load)));
                }
                self.check_attachments(handle, &planned, resources, findings);
            }
            Work::Compute(compute) => planned.workgroups = self.workgroups(compute, handle, findings),
            Work::Host(_) | Work::Copy(_) => {}
        }
        planned
    }

    fn attachment(&self, at: usize, target: AttachmentTarget, load: LoadOperation<()>) -> PlannedAttachment {
        let resource = self.pipeline.resource(target.resource);
        let part = Part { mip: Some(target.mip), layer: target.layer };
        let mut store = if resource.lifetime() == Lifetime::Transient { StoreOperation::Discard } else { StoreOperation::Store };
        for (_, later) in self.users[target.resource.index()].iter().filter(|(position, _)| *position > at) {
            if !later.part.overlaps(part) {
                continue;
            }
            if later.usage.reads() {
                store = StoreOperation::Store;
                break;
            }
            if later.part.contains(part) && later.usage.is_attachment() {
                store = StoreOperation::Discard;
                break;
            }
        }
        PlannedAttachment { resource: resource.name.clone(), load, store, target }
    }

    /// The way from a pass to an output, in words.
    fn reasons(&self, handle: PassHandle, kept: &[Option<KeepReason>]) -> Vec<String> {
        let mut words = Vec::new();
        let mut at = handle;
        while let Some(reason) = kept[at.index()] {
            match reason {
                KeepReason::SideEffect => words.push("it has a side effect".to_owned()),
                KeepReason::Output(resource) => words.push(format!("writes the output {}", self.pipeline.resource(resource).name)),
                KeepReason::ReadBy(reader, resource) => {
                    words.push(format!(
                        "{} reads {}",
                        self.pipeline.pass(reader).name,
                        self.pipeline.resource(resource).name
                    ));
                    at = reader;
                    continue;
                }
            }
            break;
        }
        words
    }

    fn check_attachments(
        &self,
        handle: PassHandle,
        planned: &PlannedPass,
        resources: &BTreeMap<ResourceHandle, Sized>,
        findings: &mut Vec<Diagnostic>,
    ) {
        let pass = self.pipeline.pass(handle);
        let Work::Render(render) = &pass.work else { return };
        let place = |resource: ResourceHandle| {
            pass.uses.iter().find(|one| one.resource == resource && one.usage.is_attachment()).map_or(
                (pass.place, pass.pointer.clone()),
                |one| (one.place, one.pointer.clone()),
            )
        };
        let mut first: Option<(&PlannedAttachment, [u32; 3])> = None;
        for attachment in planned.color.iter().chain(&planned.depth) {
            let Some((_, size, ..)) = resources.get(&attachment.target.resource).and_then(|sized| sized.texture) else { return };
            let mip = attachment.target.mip;
            let own = [(size.width >> mip).max(1), (size.height >> mip).max(1), size.samples];
            match first {
                None => first = Some((attachment, own)),
                Some((other, wanted)) if wanted != own => {
                    let (place, pointer) = place(attachment.target.resource);
                    let words = |size: [u32; 3]| format!("{} by {} with {} samples", size[0], size[1], size[2]);
                    findings.push(
                        Diagnostic::error(
                            codes::ATTACHMENTS,
                            place,
                            format!(
                                "\"{}\" is {}, but \"{}\" of the same pass is {}",
                                attachment.resource,
                                words(own),
                                other.resource,
                                words(wanted)
                            ),
                        )
                        .pointer(pointer)
                        .help("attachments of one pass have one size and sample count"),
                    );
                }
                Some(_) => {}
            }
        }
        if let Draw::Scene(scene) = &render.draw
            && let ResourceKind::Data(Some(shape)) = &self.pipeline.resource(scene.views).kind
        {
            for attachment in planned.color.iter().chain(&planned.depth).filter(|attachment| attachment.target.layer.is_none()) {
                let Some((_, size, ..)) = resources.get(&attachment.target.resource).and_then(|sized| sized.texture) else { continue };
                if size.layers > 1 && size.layers < shape.maximum_views {
                    let (place, pointer) = place(attachment.target.resource);
                    findings.push(
                        Diagnostic::error(
                            codes::ATTACHMENTS,
                            place,
                            format!("\"{}\" has {} layers for {} views", attachment.resource, size.layers, shape.maximum_views),
                        )
                        .pointer(pointer)
                        .help("give the texture a layer for each view"),
                    );
                }
            }
        }
        let program = match &render.draw {
            Draw::Fullscreen { program, .. } => *program,
            Draw::Scene(scene) => scene.program,
        };
        let program = self.pipeline.program(program);
        for variant in &program.variants {
            let Some(fragment) = variant.entry_point(Stage::Fragment) else {
                if !planned.color.is_empty() {
                    findings.push(self.output_mismatch(handle, &program.template, "has no fragment stage to write color attachments"));
                    return;
                }
                continue;
            };
            for (location, attachment) in planned.color.iter().enumerate() {
                let Some((format, ..)) = resources.get(&attachment.target.resource).and_then(|sized| sized.texture) else { continue };
                let wanted = match format.sample_type(None, None) {
                    Some(wgpu_types::TextureSampleType::Uint) => ScalarKind::Uint,
                    Some(wgpu_types::TextureSampleType::Sint) => ScalarKind::Sint,
                    _ => ScalarKind::Float,
                };
                let output = fragment.outputs.iter().find(|output| output.location as usize == location);
                let fault = match output {
                    None => format!("writes no @location({location}), which \"{}\" wants", attachment.resource),
                    Some(output) if output.kind != wanted => {
                        format!("writes another type to @location({location}) than \"{}\" has", attachment.resource)
                    }
                    Some(_) => continue,
                };
                findings.push(self.output_mismatch(handle, &program.template, &fault));
                return;
            }
            if let Some(output) = fragment.outputs.iter().find(|output| output.location as usize >= planned.color.len()) {
                let fault = format!("writes @location({}), for which the pass has no color attachment", output.location);
                findings.push(self.output_mismatch(handle, &program.template, &fault));
                return;
            }
        }
    }

    fn output_mismatch(&self, handle: PassHandle, template: &str, fault: &str) -> Diagnostic {
        let pass = self.pipeline.pass(handle);
        Diagnostic::error(codes::ATTACHMENTS, pass.place, format!("{template} {fault}"))
            .pointer(&pass.pointer)
            .help("the outputs of the fragment shader and the color attachments match one to one")
    }

    fn workgroups(
        &self,
        compute: &crate::work::ComputeWork,
        handle: PassHandle,
        findings: &mut Vec<Diagnostic>,
    ) -> Option<[u32; 3]> {
        let pass = self.pipeline.pass(handle);
        let limit = self.pipeline.profile.limits.max_compute_workgroups_per_dimension;
        let counts = match &compute.dispatch {
            Dispatch::Over { resource, mip } => {
                let size = self.sizes.texture(*resource)?;
                let entry = self.pipeline.program(compute.program).variants[0].entry_point(Stage::Compute)?;
                let [x, y, z] = entry.workgroup_size.map(|side| side.max(1));
                [
                    (size.width >> mip).max(1).div_ceil(x),
                    (size.height >> mip).max(1).div_ceil(y),
                    size.layers.div_ceil(z),
                ]
            }
            Dispatch::Workgroups(expressions) => {
                let mut counts = [0; 3];
                for (count, deferred) in counts.iter_mut().zip(expressions) {
                    match self.sizes.value(&deferred.expression, deferred.place, &deferred.pointer)? {
                        Value::Number(number) if number.fract() == 0.0 && (0.0..=f64::from(limit)).contains(&number) => {
                            *count = number as u32;
                        }
                        other => {
                            findings.push(
                                Diagnostic::error(codes::DISPATCH, deferred.place, format!("{other} is no workgroup count"))
                                    .pointer(&deferred.pointer)
                                    .help(format!("whole numbers from 0 to {limit} are possible; ceil() rounds up")),
                            );
                            return None;
                        }
                    }
                }
                counts
            }
        };
        if counts.iter().any(|count| *count > limit) {
            findings.push(
                Diagnostic::error(codes::DISPATCH, pass.place, format!("{counts:?} workgroups are too many"))
                    .pointer(&pass.pointer)
                    .help(format!("the profile {} allows {limit} in each direction", self.pipeline.profile.name)),
            );
            return None;
        }
        Some(counts)
    }
}

fn load_kind<T>(load: &LoadOperation<T>) -> LoadOperation<()> {
    match load {
        LoadOperation::Load => LoadOperation::Load,
        LoadOperation::Clear(_) => LoadOperation::Clear(()),
        LoadOperation::Discard => LoadOperation::Discard,
    }
}

fn no_output(pipeline: &Pipeline) -> Diagnostic {
    let place = pipeline.passes[0].place;
    Diagnostic::error(codes::NO_OUTPUT, place, format!("nothing comes out of \"{}\": every pass is culled", pipeline.name))
        .pointer("/passes")
        .help("let a pass write a resource with \"lifetime\": \"imported\", or give one \"side_effect\": true")
}

/// The bytes of a texture: all mips, layers and samples.
pub(super) fn texture_bytes(format: TextureFormat, size: TextureSize, volume: bool) -> u64 {
    let (block_width, block_height) = format.block_dimensions();
    let block = u64::from(format.block_copy_size(None).or_else(|| format.block_copy_size(Some(wgpu_types::TextureAspect::DepthOnly))).unwrap_or(4));
    (0..size.mips)
        .map(|mip| {
            let side = |length: u32, block: u32| u64::from((length >> mip).max(1).div_ceil(block));
            let layers = if volume { (size.layers >> mip).max(1) } else { size.layers };
            side(size.width, block_width) * side(size.height, block_height) * u64::from(layers) * block
        })
        .sum::<u64>()
        * u64::from(size.samples)
}

/// Gives every resource its place on the device.
fn place(plan: &mut Plan, pipeline: &Pipeline, resources: BTreeMap<ResourceHandle, Sized>, aliasing: bool) {
    type TextureClass = (String, TextureSize, bool, u32, Option<ResourceHandle>);
    let mut texture_wants: Vec<(ResourceHandle, Want<TextureClass>)> = Vec::new();
    let mut buffer_wants: Vec<(ResourceHandle, Want<(u64, u32, Option<ResourceHandle>)>)> = Vec::new();
    for sized in resources.values() {
        let resource = pipeline.resource(sized.handle);
        let lifetime = resource.lifetime();
        if lifetime == Lifetime::Imported {
            continue;
        }
        // What outlives the frame, or may not share, is a class of its own.
        let alone = (lifetime != Lifetime::Transient || !aliasing).then_some(sized.handle);
        let (first, last) = (sized.first, sized.last);
        if let Some((format, size, volume, usages)) = sized.texture {
            plan.bytes_without_aliasing += texture_bytes(format, size, volume);
            let class = (format::format_name(format), size, volume, usages.bits(), alone);
            texture_wants.push((sized.handle, Want { class, first, last }));
        }
        if let Some((bytes, usages)) = sized.buffer {
            plan.bytes_without_aliasing += bytes;
            buffer_wants.push((sized.handle, Want { class: (bytes, usages.bits(), alone), first, last }));
        }
    }
    let wants: Vec<_> = texture_wants.iter().map(|(_, want)| want.clone()).collect();
    let mut physical: BTreeMap<ResourceHandle, Physical> = BTreeMap::new();
    let append = |label: &mut String, name: &str| {
        if !label.is_empty() {
            label.push_str(" / ");
        }
        label.push_str(name);
    };
    let assigned = assign(&wants);
    let mut by_start: Vec<usize> = (0..wants.len()).collect();
    by_start.sort_by_key(|at| (wants[*at].first, *at));
    for at in by_start {
        let handle = texture_wants[at].0;
        physical.insert(handle, Physical::Texture(assigned[at]));
        if assigned[at] == plan.textures.len()
            && let Some((format, size, volume, usages)) = resources[&handle].texture
        {
            let bytes = texture_bytes(format, size, volume);
            plan.bytes += bytes;
            plan.textures.push(PhysicalTexture { label: String::new(), format, size, volume, usages, bytes });
        }
        append(&mut plan.textures[assigned[at]].label, &pipeline.resource(handle).name);
    }
    let wants: Vec<_> = buffer_wants.iter().map(|(_, want)| *want).collect();
    let assigned = assign(&wants);
    let mut by_start: Vec<usize> = (0..wants.len()).collect();
    by_start.sort_by_key(|at| (wants[*at].first, *at));
    for at in by_start {
        let handle = buffer_wants[at].0;
        physical.insert(handle, Physical::Buffer(assigned[at]));
        if assigned[at] == plan.buffers.len()
            && let Some((bytes, usages)) = resources[&handle].buffer
        {
            plan.bytes += bytes;
            plan.buffers.push(PhysicalBuffer { label: String::new(), bytes, usages });
        }
        append(&mut plan.buffers[assigned[at]].label, &pipeline.resource(handle).name);
    }
    for sized in resources.into_values() {
        let resource = pipeline.resource(sized.handle);
        let lifetime = resource.lifetime();
        let physical = match resource.kind {
            ResourceKind::Data(_) => Physical::Host,
            _ if lifetime == Lifetime::Imported => Physical::Imported,
            _ => physical.get(&sized.handle).copied().unwrap_or(Physical::Host),
        };
        plan.resources.insert(
            resource.name.clone(),
            PlannedResource {
                lifetime,
                first: sized.first,
                last: sized.last,
                physical,
                format: sized.texture.map(|(format, ..)| format),
                size: sized.texture.map(|(_, size, ..)| size),
                handle: sized.handle,
            },
        );
    }
}

impl Plan {
    /// What stands for a resource.
    pub fn resource(&self, handle: ResourceHandle) -> Option<&PlannedResource> {
        self.resources.get(&self.pipeline.resource(handle).name)
    }

    /// Whether the usage of a resource by a pass writes it.
    pub fn writes(&self, pass: PassHandle, resource: ResourceHandle) -> bool {
        self.pipeline.pass(pass).uses.iter().any(|one| one.resource == resource && one.usage != Usage::HostRead && one.usage.writes())
    }
}
