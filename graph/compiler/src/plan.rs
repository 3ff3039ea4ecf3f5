//! The plan: everything about a frame that is known before it, as a value.
//!
//! A [`Plan`] is made for one pipeline and one viewport: live passes in order, sizes, formats and usages, which
//! resources share a texture, what each attachment loads and stores, dispatch sizes and the bytes of constant blocks.
//! It is serialisable and the same from run to run. An executor instantiates it; nothing in it knows a device.
//!
//! Steps, each in a file of its own: what is kept (`cull`), what each resource is (`resolved`), the order (`order`),
//! load and store operations (`attachments`), dispatches and blocks (`pass_sizes`), which resources share memory
//! (`allocate`). Planning again for another size (`resize`) repeats only the steps that sizes change.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::Serialize;
use wgpu_types::{BufferUsages, TextureFormat, TextureUsages};

use super::allocate;
use super::copies::PlannedCopy;
use super::cull::{self, CullReason, KeepReason};
use super::device_rules;
use super::graph::Graph;
use super::history::PlannedHistory;
use super::merge::Merger;
use super::order::{self, Objective, OrderReport};
use super::planner::Planner;
use super::resolved_resources::{ResolvedResource, ResolvedResources};
use super::size::TextureSize;
use super::toggles;
use super::uninitialised;
use super::values::PackedBlock;
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::language::Lifetime;
use crate::pipeline::{Pipeline, Usage};
use crate::source::Sources;
use crate::work::{AttachmentTarget, LoadOperation, PassHandle, ResourceHandle};

/// The caller's knowledge of a frame in advance: viewport, imports, objective.
#[derive(Clone, Debug)]
pub struct PlanOptions {
    /// Width and height of the picture in texels.
    pub viewport: [u32; 2],
    /// The host's own textures by the name of the resource that stands for them. One that is not told is taken to be
    /// as the pipeline declares it.
    pub imports: BTreeMap<String, Import>,
    /// The usages that the host's own textures were created with, by the name of the resource. One that is not told is
    /// taken to allow everything.
    pub import_usages: BTreeMap<String, TextureUsages>,
    /// The sizes that blackboard data publishes, as `DATA.SIZE`, where they are other than their initial values.
    pub data_sizes: BTreeMap<String, u32>,
    /// Whether transient resources may share memory.
    pub aliasing: bool,
    /// The objective of the order of the passes.
    pub objective: Objective,
}

impl PlanOptions {
    /// A viewport, no imports told, with aliasing, in the order of the document.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            viewport: [width, height],
            imports: BTreeMap::new(),
            import_usages: BTreeMap::new(),
            data_sizes: BTreeMap::new(),
            aliasing: true,
            objective: Objective::Declaration,
        }
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
    /// The histories, by the name of the resource that each frame writes.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub histories: BTreeMap<String, PlannedHistory>,
    /// The textures to create.
    pub textures: Vec<PhysicalTexture>,
    /// The buffers to create.
    pub buffers: Vec<PhysicalBuffer>,
    /// Bytes of the transient and persistent resources if none shared memory.
    pub bytes_without_aliasing: u64,
    /// Bytes that are created.
    pub bytes: u64,
    /// Fewer bytes this order cannot do with: for each class of resources that can stand for one another the maximum
    /// number of bytes that are alive at once, summed. Only buffers of different sizes can keep `bytes` above it.
    pub bytes_bound: u64,
    /// The maximum number of bytes that are alive at once over all classes together. No program of wgpu reaches it,
    /// since memory never changes its class.
    pub bytes_peak: u64,
    /// The sizes that blackboard data publishes, as `DATA.SIZE`, where they are other than their initial values.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub data_sizes: BTreeMap<String, u32>,
    /// The toggles with their states where the host says nothing.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub toggles: BTreeMap<String, bool>,
    /// How the order was chosen.
    pub order: OrderReport,
    /// The pipeline.
    #[serde(skip)]
    pub pipeline: Arc<Pipeline>,
    /// The portion of a plan that planning for another size reuses.
    #[serde(skip)]
    pub(super) fixed: Arc<Fixed>,
}

/// The portion of a plan that does not depend on sizes.
#[derive(Debug)]
pub(super) struct Fixed {
    /// For each pass of the pipeline its position among the live ones.
    pub(super) positions: Vec<Option<usize>>,
    /// For each resource the positions of its first and its last access.
    pub(super) spans: Vec<Option<(usize, usize)>>,
    /// For each resource whether some subresource range of it is first written by a pass that can be off.
    pub(super) conditional: Vec<bool>,
    /// The description of each resource when the plan was made.
    pub(super) resolved: Vec<Option<ResolvedResource>>,
    /// The formats of the host's own textures.
    pub(super) import_formats: BTreeMap<String, TextureFormat>,
    /// The usages of the host's own textures.
    pub(super) import_usages: BTreeMap<String, TextureUsages>,
    /// Whether transient resources may share memory.
    pub(super) aliasing: bool,
}

impl PlanOptions {
    /// The formats of the host's own textures.
    pub(super) fn import_formats(&self) -> BTreeMap<String, TextureFormat> {
        self.imports.iter().map(|(name, import)| (name.clone(), import.format)).collect()
    }
}

/// A live pass.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedPass {
    /// Its name.
    pub name: String,
    /// Its node kind.
    pub kind: String,
    /// The toggle with which it runs, or with "!" in front the one without which it runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub toggle: Option<String>,
    /// The fallbacks that readers see in a frame without it, by the resource that they replace.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub passthrough: BTreeMap<String, String>,
    /// Why it is kept: the first step of the way to an output. [`Plan::why_kept`] gives the whole way.
    pub kept: Kept,
    /// The color attachments.
    pub color: Vec<PlannedAttachment>,
    /// The depth attachment.
    pub depth: Option<PlannedAttachment>,
    /// The stencil attachment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stencil: Option<PlannedAttachment>,
    /// Neighbouring passes with one number can be recorded as one render pass: they have the same attachments, the
    /// later ones load, and nothing but those attachments connects them.
    pub group: usize,
    /// The number of workgroups.
    pub workgroups: Option<[u32; 3]>,
    /// The copies or clears, in their order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub copies: Vec<PlannedCopy>,
    /// The shader variants: the template with what was chosen, the hash of the text, and the pipeline constants.
    pub variants: Vec<String>,
    /// The constant blocks.
    pub blocks: Vec<PackedBlock>,
    /// The pass.
    #[serde(skip)]
    pub handle: PassHandle,
    /// Why it is kept, by handles.
    #[serde(skip)]
    pub reason: KeepReason,
}

impl PlannedPass {
    /// All attachments: color, depth, stencil.
    pub fn attachments(&self) -> impl Iterator<Item = &PlannedAttachment> {
        self.color.iter().chain(&self.depth).chain(&self.stencil)
    }
}

/// Why a pass is kept, by names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kept {
    /// It says that it has a side effect.
    SideEffect,
    /// It writes a resource that outlives the frame.
    Output(String),
    /// A kept pass reads what it writes.
    ReadBy {
        /// The reader.
        pass: String,
        /// The resource that it reads.
        resource: String,
    },
    /// A kept pass reads what it writes some frames later.
    ReadLater {
        /// The reader.
        pass: String,
        /// The earlier frame that it reads.
        resource: String,
    },
    /// A kept pass reads what it may write: the resource has more writers of different subresource ranges, or with
    /// different toggles, than are told apart.
    MayBeReadBy {
        /// The reader.
        pass: String,
        /// The resource that it reads.
        resource: String,
    },
    /// It may leave something in a resource that outlives the frame, which has more such writers than are told apart.
    MayBeLeft(String),
}

/// The load and store operations of an attachment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedAttachment {
    /// The resource.
    pub resource: String,
    /// The load operation: `load`, `clear` or `discard`.
    #[serde(serialize_with = "load_word")]
    pub load: LoadOperation<()>,
    /// The store operation.
    pub store: StoreOperation,
    /// Whether nothing of it ever leaves the pass: it is not loaded, not stored and used nowhere else. A tiling device
    /// needs no memory for it.
    pub transient_attachment: bool,
    /// The handle.
    #[serde(skip)]
    pub target: AttachmentTarget,
}

/// The word alone: what is cleared to is the pass's.
fn load_word<S: serde::Serializer>(load: &LoadOperation<()>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(match load {
        LoadOperation::Load => "load",
        LoadOperation::Clear(()) => "clear",
        LoadOperation::Discard => "discard",
    })
}

/// The store operation of an attachment.
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
    /// Its lifetime.
    pub lifetime: Lifetime,
    /// The first pass that uses it, as its position in the order.
    pub first: usize,
    /// The last pass that uses it.
    pub last: usize,
    /// The physical resource that holds it.
    pub physical: Physical,
    /// The format, of a texture.
    pub format: Option<TextureFormat>,
    /// The size, of a texture.
    pub size: Option<TextureSize>,
    /// The usages that its uses need, of a texture.
    pub usages: Option<TextureUsages>,
    /// Its bytes; 0 for blackboard data.
    pub bytes: u64,
    /// Whether a toggle can switch off what writes it first, so that it has memory of its own.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub conditional: bool,
    /// The handle.
    #[serde(skip)]
    pub handle: ResourceHandle,
}

/// The physical resource that holds a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
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
    /// The names of the resources that it stands for, in the order of their lifetimes; a long list is cut.
    pub label: String,
    /// The format.
    pub format: TextureFormat,
    /// The size.
    pub size: TextureSize,
    /// Whether it is a volume.
    pub volume: bool,
    /// The usages.
    pub usages: TextureUsages,
    /// The other format in which passes see it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_format: Option<TextureFormat>,
    /// Its bytes, all mips, layers and samples.
    pub bytes: u64,
}

/// A buffer to create.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicalBuffer {
    /// The names of the resources that it stands for; a long list is cut.
    pub label: String,
    /// Its size.
    pub bytes: u64,
    /// The usages.
    pub usages: BufferUsages,
}

/// Plans a frame.
///
/// Diagnostics: impossible sizes, formats that do not support their usages, attachments that do not fit together or the
/// shader's outputs, impossible dispatches, values that do not fit their block, imports used beyond their usage.
/// `None` after an error.
pub fn plan(
    pipeline: &Arc<Pipeline>,
    graph: &Graph,
    options: &PlanOptions,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Option<Plan> {
    let before = diagnostics.error_count();
    let kept = cull::keep(pipeline, graph);
    let mut live: Vec<PassHandle> =
        graph.order.iter().copied().filter(|pass| kept[pass.index()].is_some()).collect();
    if live.is_empty() && !pipeline.passes.is_empty() && pipeline.uncertain.is_empty() {
        diagnostics.push(no_output(pipeline));
    }
    let mut own_diagnostics = Vec::new();
    let conditional = toggles::conditional(pipeline, graph, &live);
    let resolved =
        ResolvedResources::new(pipeline, options, sources, &live, &conditional, &mut own_diagnostics);
    toggles::check_passthroughs(pipeline, &resolved, &live, &mut own_diagnostics);
    toggles::check_outputs(&resolved, graph, &live, &mut own_diagnostics);
    uninitialised::check(&resolved, graph, |pass| kept[pass.index()].is_some(), &mut own_diagnostics);
    let report = order::choose(pipeline, graph, &resolved, options.objective, &mut live);
    let planner = Planner::new(pipeline, &resolved, &live);
    let mut passes: Vec<PlannedPass> = Vec::with_capacity(live.len());
    let mut merger = Merger::new(pipeline, &resolved);
    for (at, handle) in live.iter().enumerate() {
        let Some(reason) = kept[handle.index()] else { continue };
        let mut planned = planner.pass(at, *handle, reason, &mut own_diagnostics);
        let joins = merger.push(*handle);
        planned.group = passes.last().map_or(0, |last| last.group + usize::from(!joins));
        passes.push(planned);
    }
    resolved.check_all_sizes();
    diagnostics.extend(resolved.take_diagnostics());
    diagnostics.extend(own_diagnostics);
    if diagnostics.error_count() > before {
        return None;
    }
    let culled = pipeline.pass_handles().filter(|pass| kept[pass.index()].is_none());
    let mut positions = vec![None; pipeline.passes.len()];
    for (at, pass) in passes.iter().enumerate() {
        positions[pass.handle.index()] = Some(at);
    }
    let mut plan = Plan {
        name: pipeline.name.clone(),
        viewport: options.viewport,
        culled: culled
            .map(|pass| (pipeline.pass(pass).name.clone(), cull::cull_reason(pipeline, graph, &kept, pass)))
            .collect(),
        resources: BTreeMap::new(),
        histories: BTreeMap::new(),
        textures: Vec::new(),
        buffers: Vec::new(),
        bytes_without_aliasing: 0,
        bytes: 0,
        bytes_bound: 0,
        bytes_peak: 0,
        data_sizes: options.data_sizes.clone(),
        toggles: pipeline.toggles.iter().map(|one| (one.name.clone(), one.default)).collect(),
        order: report,
        pipeline: pipeline.clone(),
        passes,
        fixed: Arc::new(Fixed {
            positions,
            spans: planner.spans(),
            conditional,
            resolved: resolved.list.clone(),
            import_formats: options.import_formats(),
            import_usages: options.import_usages.clone(),
            aliasing: options.aliasing,
        }),
    };
    allocate::allocate(&mut plan, &resolved);
    let broken = device_rules::check(&plan);
    let fine = broken.is_empty();
    diagnostics.extend(broken);
    fine.then_some(plan)
}

fn no_output(pipeline: &Pipeline) -> Diagnostic {
    let place = pipeline.passes[0].place;
    let message = format!("nothing comes out of \"{}\": every pass is culled", pipeline.name);
    Diagnostic::error(codes::NO_OUTPUT, place, message).pointer("/passes").help(
        "let a pass write a resource with \"lifetime\": \"imported\", or give one \"side_effect\": true",
    )
}

impl Plan {
    /// The planned form of a resource.
    pub fn resource(&self, handle: ResourceHandle) -> Option<&PlannedResource> {
        self.resources.get(&self.pipeline.resource(handle).name)
    }

    /// A live pass.
    pub fn pass(&self, handle: PassHandle) -> Option<&PlannedPass> {
        self.passes.get(self.position(handle)?)
    }

    /// The position of a pass among the live ones; `None` for a culled pass.
    pub fn position(&self, handle: PassHandle) -> Option<usize> {
        self.fixed.positions.get(handle.index()).copied().flatten()
    }

    /// Whether the usage of a resource by a pass writes it.
    pub fn writes(&self, pass: PassHandle, resource: ResourceHandle) -> bool {
        self.pipeline
            .pass(pass)
            .accesses()
            .iter()
            .any(|one| one.resource == resource && one.usage != Usage::BlackboardRead && one.usage.writes())
    }

    /// The way from a live pass to an output, in words; empty for a culled pass.
    pub fn why_kept(&self, pass: PassHandle) -> Vec<String> {
        self.why_kept_within(pass, usize::MAX)
    }

    /// The first steps of that way.
    pub fn why_kept_within(&self, pass: PassHandle, steps: usize) -> Vec<String> {
        let resource = |handle: ResourceHandle| &self.pipeline.resource(handle).name;
        let mut words = Vec::new();
        let mut next = self.pass(pass);
        while let Some(planned) = next {
            let (step, then) = match planned.reason {
                KeepReason::SideEffect => ("it has a side effect".to_owned(), None),
                KeepReason::Output(handle) => (format!("writes the output {}", resource(handle)), None),
                KeepReason::ReadBy(reader, handle) => (
                    format!("{} reads {}", self.pipeline.pass(reader).name, resource(handle)),
                    self.pass(reader),
                ),
                KeepReason::MayBeReadBy(reader, handle) => (
                    format!(
                        "{} reads {}, perhaps nothing of it: it has more writers of different subresource ranges, or with \
                         different toggles, than are told apart",
                        self.pipeline.pass(reader).name,
                        resource(handle)
                    ),
                    self.pass(reader),
                ),
                KeepReason::MayBeLeft(handle) => (
                    format!(
                        "something of it may be left in {}, which has more writers of different subresource ranges, or with \
                         different toggles, than are told apart",
                        resource(handle)
                    ),
                    None,
                ),
                KeepReason::ReadLater(reader, handle) => {
                    let back = self.pipeline.resource(handle).history.map_or(1, |history| history.back);
                    let when = if back == 1 {
                        "in the next frame".to_owned()
                    } else {
                        format!("{back} frames later")
                    };
                    let reader_name = &self.pipeline.pass(reader).name;
                    (format!("{reader_name} reads {} {when}", resource(handle)), self.pass(reader))
                }
            };
            words.push(step);
            // A way has no cycle; the limit only bounds what a plan changed by hand can do.
            next = then.filter(|_| words.len() < steps && words.len() <= self.passes.len());
        }
        words
    }

    /// Why a pass is culled, and those of its readers in turn, in words; empty for a live pass.
    pub fn why_culled(&self, pass: &str) -> Vec<String> {
        self.why_culled_within(pass, usize::MAX)
    }

    /// The first steps of that way.
    pub fn why_culled_within(&self, pass: &str, steps: usize) -> Vec<String> {
        let mut words = Vec::new();
        let mut next = Some(pass.to_owned());
        let mut seen = BTreeSet::new();
        // Culled passes that read one another over frames lead back to where they began.
        while let Some(name) = next.take().filter(|name| words.len() < steps && seen.insert(name.clone())) {
            match self.culled.get(&name) {
                Some(CullReason::WritesNothing) => {
                    words.push(format!("{name} writes nothing and has no side effect"));
                }
                Some(CullReason::NothingReads(resources)) => {
                    words.push(format!("nothing reads what {name} writes: {}", resources.join(", ")));
                }
                Some(CullReason::OnlyCulledRead(readers)) => {
                    words.push(format!("only culled passes read what {name} writes: {}", readers.join(", ")));
                    next = readers.first().cloned();
                }
                None => {}
            }
        }
        words
    }
}
