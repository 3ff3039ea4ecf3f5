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
    /// The pipeline's name.
    pub name: String,
    /// Width and height of the picture in texels.
    pub viewport: [u32; 2],
    /// The live passes in the order in which they run.
    pub passes: Vec<PlannedPass>,
    /// The culled passes by name, each with the reason.
    pub culled: BTreeMap<String, CullReason>,
    /// The filters of draws of the host's meshes, by geometry: the host draws for each what it stands for.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub filters: BTreeMap<String, BTreeSet<String>>,
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
    /// The parameters: which can change from frame to frame, and what makes the others structural.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, PlannedParameter>,
    /// The objective and method of the order, with its bytes.
    pub order: OrderReport,
    /// The pipeline.
    #[serde(skip)]
    pub pipeline: Arc<TypedPipeline>,
    /// The portion of a plan that planning for another size reuses.
    #[serde(skip)]
    pub(crate) fixed: Arc<Fixed>,
}

/// The portion of a plan that does not depend on sizes.
#[derive(Debug)]
pub(crate) struct Fixed {
    /// The position of each pass among the live ones.
    pub(crate) positions: Vec<Option<usize>>,
    /// The positions of the first and last access of each resource.
    pub(crate) spans: Vec<Option<(usize, usize)>>,
    /// Whether a pass that can be off is the first to write some subresource range, for each resource.
    pub(crate) conditional: Vec<bool>,
    /// The description of each resource when the plan was made.
    pub(crate) resolved: Vec<Option<ResolvedResource>>,
    /// The formats and usages of the host's own textures.
    pub(crate) import_kinds: BTreeMap<String, (TextureFormat, TextureUsages)>,
    /// Whether transient resources may share memory.
    pub(crate) aliasing: bool,
}

/// A live pass.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
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
    /// The settings that are evaluated again when a live parameter changes.
    #[serde(skip)]
    pub live: Vec<PlannedSetting>,
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

/// The load and store operations of an attachment.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
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
#[non_exhaustive]
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
    /// The other format in which passes see it, of a texture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_format: Option<TextureFormat>,
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

impl Plan {
    /// The planned form of a resource.
    pub fn resource(&self, handle: ResourceHandle) -> Option<&PlannedResource> {
        self.resources.get(&self.pipeline.resource(handle).name)
    }

    /// The host's own textures and buffers that the plan uses, by name. One of the pipeline that no live pass uses is
    /// none of them.
    pub fn imports(&self) -> impl Iterator<Item = (&str, &PlannedResource)> {
        let imported = self.resources.iter().filter(|(_, one)| one.physical == Physical::Imported);
        imported.map(|(name, one)| (name.as_str(), one))
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
        self.pipeline.pass(pass).writes(resource)
    }
}
