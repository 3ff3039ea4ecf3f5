//! The types of a [`Plan`]: everything about a frame that is known before it, as a value.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use serde::Serialize;
use wgpu_types::{TextureFormat, TextureUsages};

use crate::memory::history::PlannedHistory;
use crate::memory::physical::{Physical, PhysicalBuffer, PhysicalTexture};
use crate::request::objective::OrderReport;
use crate::request::texture_size::TextureSize;
use crate::resources::resolved::ResolvedResource;
use crate::schedule::cull::{CullReason, KeepReason, Kept};
use crate::values::packed::PackedBlock;
use crate::values::settings::{PlannedParameter, PlannedSetting};
use crate::work::copies::PlannedCopy;
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::TypedPipeline;
use umbragraph_pipeline::work::{AttachmentTarget, LoadOperation, PassHandle, ResourceHandle};

/// The plan of a frame: all that is known before the frame is recorded.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Plan {
    /// The name of the pipeline.
    pub name: String,
    /// The width and height of the rendered image in texels.
    pub viewport: [u32; 2],
    /// The live (not culled) passes in execution order.
    pub passes: Vec<PlannedPass>,
    /// The culled passes by name, each with the reason for culling.
    pub culled: BTreeMap<String, CullReason>,
    /// The draw filters of passes that draw the host's meshes, by geometry contract (the vertex inputs and bindings
    /// that the host provides).
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub filters: BTreeMap<String, BTreeSet<String>>,
    /// The planned resources that live passes use, by name.
    pub resources: BTreeMap<String, PlannedResource>,
    /// The history resources (readable in later frames), by the name of the resource that each frame writes.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub histories: BTreeMap<String, PlannedHistory>,
    /// The textures to create; [`Physical::Texture`] indexes this list.
    pub textures: Vec<PhysicalTexture>,
    /// The buffers to create; [`Physical::Buffer`] indexes this list.
    pub buffers: Vec<PhysicalBuffer>,
    /// The bytes that transient and persistent resources would need if none shared memory.
    pub bytes_without_aliasing: u64,
    /// The bytes of all created textures and buffers.
    pub bytes: u64,
    /// The lower bound on `bytes` for this pass order: the peak of live bytes in each compatibility class, summed. Only
    /// buffers of different sizes can keep `bytes` above this bound.
    pub bytes_bound: u64,
    /// The maximum number of bytes alive at once over all compatibility classes. wgpu may need more, since a texture or
    /// buffer cannot change its class.
    pub bytes_peak: u64,
    /// The sizes that blackboard data publishes, keyed `DATA.SIZE`, as given in `PlanOptions::data_sizes`; a size that
    /// is not listed has its initial value.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub data_sizes: BTreeMap<String, u32>,
    /// The toggles by name, each with its default state.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub toggles: BTreeMap<String, bool>,
    /// The parameters by name: whether each can change per frame, or the setting due to which a change needs a new
    /// plan.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, PlannedParameter>,
    /// The objective and method by which the pass order was chosen, with the bytes that the order needs.
    pub order: OrderReport,
    /// The pipeline that was planned.
    #[serde(skip)]
    pub pipeline: Arc<TypedPipeline>,
    /// The part of the plan that does not depend on sizes and is reused when sizes change.
    #[serde(skip)]
    pub(crate) fixed: Arc<Fixed>,
}

/// The part of a plan that does not depend on sizes.
#[derive(Debug)]
pub(crate) struct Fixed {
    /// The position of each pass in execution order, indexed by pass handle; `None` for a culled pass.
    pub(crate) positions: Vec<Option<usize>>,
    /// The positions of the first and last pass that access each resource, indexed by resource handle; `None` if
    /// unused.
    pub(crate) spans: Vec<Option<(usize, usize)>>,
    /// For each resource, indexed by handle: `true` if the first writer of some subresource range can be toggled off.
    pub(crate) conditional: Vec<bool>,
    /// The properties that each resource had when the plan was made, indexed by handle; `None` if unused.
    pub(crate) resolved: Vec<Option<ResolvedResource>>,
    /// The formats and usages of the imported textures, by resource name.
    pub(crate) import_kinds: BTreeMap<String, (TextureFormat, TextureUsages)>,
    /// Whether transient resources may share memory.
    pub(crate) aliasing: bool,
    /// Whether resources that outlive a frame can be copied from and to.
    pub(crate) copyable_state: bool,
}

/// A live (not culled) pass.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct PlannedPass {
    /// The name of the pass.
    pub name: String,
    /// The name of the node kind that made the pass.
    pub kind: String,
    /// The toggle that must be on for the pass to run, or off if the name has a "!" prefix; `None` if it always runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub toggle: Option<String>,
    /// The fallback that readers get in frames in which this pass is off, by the name of the replaced resource.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub passthrough: BTreeMap<String, String>,
    /// The reason for keeping the pass: the first step of the path to an output. [`Plan::why_kept`] gives the full
    /// path.
    pub kept: Kept,
    /// The color attachments in the order of their slots.
    pub color: Vec<PlannedAttachment>,
    /// The depth attachment, if the pass has one.
    pub depth: Option<PlannedAttachment>,
    /// The stencil attachment, if the pass has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stencil: Option<PlannedAttachment>,
    /// The number of the render pass group. Neighbouring passes with the same number can be recorded as one render
    /// pass. They have the same attachments, all but the first load them, and no other resource that one of them writes
    /// is shared.
    pub group: usize,
    /// The workgroup counts in x, y and z of a compute pass; `None` for other passes and indirect dispatches.
    pub workgroups: Option<[u32; 3]>,
    /// The copies and clears of a transfer pass, in recording order; empty for other passes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub copies: Vec<PlannedCopy>,
    /// A description of each shader variant: template name, axis values, the first 8 hexadecimal digits of the hash of
    /// the WGSL, and the pipeline constants.
    pub variants: Vec<String>,
    /// The constant blocks of the pass with their packed bytes.
    pub blocks: Vec<PackedBlock>,
    /// The settings that are re-evaluated when a live (per-frame) parameter changes.
    #[serde(skip)]
    pub live: Vec<PlannedSetting>,
    /// The handle of the pass in the pipeline.
    #[serde(skip)]
    pub handle: PassHandle,
    /// The reason for keeping the pass, with handles in place of names.
    #[serde(skip)]
    pub reason: KeepReason,
}

impl PlannedPass {
    /// Returns all attachments: color, then depth, then stencil.
    pub fn attachments(&self) -> impl Iterator<Item = &PlannedAttachment> {
        self.color.iter().chain(&self.depth).chain(&self.stencil)
    }
}

/// An attachment of a planned pass with its load and store operations.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PlannedAttachment {
    /// The name of the attached resource.
    pub resource: String,
    /// The load operation: `load`, `clear` or `discard`.
    #[serde(serialize_with = "load_word")]
    pub load: LoadOperation<()>,
    /// The store operation: `store` or `discard`.
    pub store: StoreOperation,
    /// Whether the attachment never leaves the pass: not loaded, not stored and used nowhere else. A tiling GPU needs
    /// no memory for such an attachment.
    pub transient_attachment: bool,
    /// The handle of the attached texture, with its mip level and layer.
    #[serde(skip)]
    pub target: AttachmentTarget,
}

/// Serializes a load operation as `load`, `clear` or `discard`, without the clear value.
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
    /// The result is stored, because a later pass, a later frame or the host needs it.
    Store,
    /// The result is discarded, because nothing needs it any more.
    Discard,
}

/// A resource that live passes use.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PlannedResource {
    /// The lifetime of the resource: transient, persistent or imported, for example.
    pub lifetime: Lifetime,
    /// The position in execution order of the first pass that uses the resource.
    pub first: usize,
    /// The position in execution order of the last pass that uses the resource.
    pub last: usize,
    /// The physical texture, buffer or import that holds the resource.
    pub physical: Physical,
    /// The texture format; `None` unless the resource is a texture.
    pub format: Option<TextureFormat>,
    /// The second format in which passes view the texture; `None` if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_format: Option<TextureFormat>,
    /// The texture size; `None` unless the resource is a texture.
    pub size: Option<TextureSize>,
    /// The texture usages that the accesses of the live passes need; `None` unless the resource is a texture.
    pub usages: Option<TextureUsages>,
    /// The size in bytes; 0 for blackboard data (CPU data passed between passes).
    pub bytes: u64,
    /// Whether a toggle can switch off the first writer, so that the resource has memory of its own.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub conditional: bool,
    /// The handle of the resource in the pipeline.
    #[serde(skip)]
    pub handle: ResourceHandle,
}

impl Plan {
    /// Returns the planned resource for a handle; `None` if no live pass uses it.
    pub fn resource(&self, handle: ResourceHandle) -> Option<&PlannedResource> {
        self.resources.get(&self.pipeline.resource(handle).name)
    }

    /// Returns the host's own textures and buffers that live passes use, by name.
    pub fn imports(&self) -> impl Iterator<Item = (&str, &PlannedResource)> {
        let imported = self.resources.iter().filter(|(_, one)| one.physical == Physical::Imported);
        imported.map(|(name, one)| (name.as_str(), one))
    }

    /// Returns the planned pass for a handle; `None` if the pass is culled.
    pub fn pass(&self, handle: PassHandle) -> Option<&PlannedPass> {
        self.passes.get(self.position(handle)?)
    }

    /// Returns the position of a pass in execution order; `None` if the pass is culled.
    pub fn position(&self, handle: PassHandle) -> Option<usize> {
        self.fixed.positions.get(handle.index()).copied().flatten()
    }

    /// Returns `true` if the pass writes the resource.
    pub fn writes(&self, pass: PassHandle, resource: ResourceHandle) -> bool {
        self.pipeline.pass(pass).writes(resource)
    }
}
