//! Work that draws: its attachments, what is loaded and what is stored.

use serde::Serialize;

use crate::access::usage::Usage;
use crate::work::Subresource;
use crate::work::draw::Draw;
use crate::work::handle::ResourceHandle;
use crate::work::live::{Byte, Color, Depth, Live};

/// The work of a pass that draws into attachments.
#[derive(Clone, Debug)]
pub struct RenderWork {
    /// The color attachments; the index of each is its `@location` in the fragment shader.
    pub color: Vec<ColorAttachment>,
    /// The depth attachment; `None` if there is none.
    pub depth: Option<DepthAttachment>,
    /// The stencil attachment, of the same texture, mip level and layer as the depth attachment; `None` if there is
    /// none.
    pub stencil: Option<StencilAttachment>,
    /// The geometry that is drawn, with its shader and bindings.
    pub draw: Draw,
    /// The constant color of the blend equations; `None` if the pass sets none.
    pub blend_constant: Option<Live<Color>>,
}

impl RenderWork {
    /// All attachments in the order color, depth, stencil.
    pub fn attachments(&self) -> impl Iterator<Item = Attachment<'_>> {
        let color = self.color.iter().map(|one| Attachment::new(&one.to, one.usage(), one.load, one.discard));
        let depth = self.depth.iter().map(|one| Attachment::new(&one.to, one.usage(), one.load, one.discard));
        let stencil =
            self.stencil.iter().map(|one| Attachment::new(&one.to, one.usage(), one.load, one.discard));
        color.chain(depth).chain(stencil)
    }
}

/// The properties that color, depth and stencil attachments have in common.
#[derive(Clone, Copy, Debug)]
pub struct Attachment<'a> {
    /// The subresource that is drawn into.
    pub to: &'a Subresource,
    /// The usage of the texture as an attachment.
    pub usage: Usage,
    /// The load operation at the start of the pass, without the clear value.
    pub load: LoadOperation<()>,
    /// Whether the contents are discarded after the pass.
    pub discard: bool,
}

impl<'a> Attachment<'a> {
    fn new<T>(to: &'a Subresource, usage: Usage, load: LoadOperation<T>, discard: bool) -> Self {
        Self { to, usage, load: load.map(|_| ()), discard }
    }
}

/// The mip level and layer of a texture that a pass draws into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct AttachmentTarget {
    /// The texture that is drawn into.
    pub resource: ResourceHandle,
    /// The index of the mip level.
    pub mip: u32,
    /// The index of the layer; `None` if each view names its own layer.
    pub layer: Option<u32>,
}

/// A color attachment of a render pass.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorAttachment {
    /// The subresource that is drawn into.
    pub to: Subresource,
    /// The load operation at the start of the pass, with the clear color.
    pub load: LoadOperation<Live<Color>>,
    /// The blend state; `None` for no blending.
    pub blend: Option<wgpu_types::BlendState>,
    /// The color channels that are written.
    pub write_mask: wgpu_types::ColorWrites,
    /// The format of the attachment's view; `None` for the texture's own format.
    pub format: Option<wgpu_types::TextureFormat>,
    /// The target that the samples are resolved into; `None` for no resolve.
    pub resolve: Option<Subresource>,
    /// Whether the contents are discarded after the pass.
    pub discard: bool,
}

impl ColorAttachment {
    /// The usage of the texture that follows from the load operation.
    pub fn usage(&self) -> Usage {
        match self.load {
            LoadOperation::Load => Usage::ColorAttachmentLoad,
            LoadOperation::Clear(_) | LoadOperation::Discard => Usage::ColorAttachment,
        }
    }
}

/// A depth attachment of a render pass.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthAttachment {
    /// The subresource that is drawn into.
    pub to: Subresource,
    /// The load operation at the start of the pass, with the clear depth.
    pub load: LoadOperation<Live<Depth>>,
    /// Whether the pass writes depth.
    pub write: bool,
    /// The comparison that a fragment's depth must pass.
    pub compare: wgpu_types::CompareFunction,
    /// The rasteriser's depth bias per unit of depth slope. A positive bias points away from the viewer if depth grows
    /// with distance.
    pub slope_bias: f32,
    /// Whether the contents are discarded after the pass.
    pub discard: bool,
}

impl DepthAttachment {
    /// The usage of the texture that follows from the load operation and from `write`.
    pub fn usage(&self) -> Usage {
        match (self.load, self.write) {
            (LoadOperation::Load, false) => Usage::DepthAttachmentReadOnly,
            (LoadOperation::Load, true) => Usage::DepthAttachmentLoad,
            _ => Usage::DepthAttachment,
        }
    }
}

/// A stencil attachment of a render pass.
#[derive(Clone, Debug, PartialEq)]
pub struct StencilAttachment {
    /// The subresource that is drawn into.
    pub to: Subresource,
    /// The load operation at the start of the pass, with the clear value.
    pub load: LoadOperation<Live<Byte>>,
    /// The stencil comparisons, operations and masks.
    pub state: wgpu_types::StencilState,
    /// The reference value of stencil comparisons and of the replace operation.
    pub reference: Live<Byte>,
    /// Whether the contents are discarded after the pass.
    pub discard: bool,
}

impl StencilAttachment {
    /// The usage of the texture that follows from the load operation and from `state`.
    pub fn usage(&self) -> Usage {
        match self.load {
            LoadOperation::Load if self.state.is_read_only(None) => Usage::StencilAttachmentReadOnly,
            LoadOperation::Load => Usage::StencilAttachmentLoad,
            _ => Usage::StencilAttachment,
        }
    }
}

/// The load operation of an attachment: the contents at the start of the pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LoadOperation<T> {
    /// Keeps the earlier contents.
    Load,
    /// Fills the attachment with one value.
    Clear(T),
    /// Leaves the contents undefined; the pass writes every texel.
    Discard,
}

impl<T> LoadOperation<T> {
    /// Converts the clear value with `clear`; the other operations stay the same.
    pub fn map<U>(self, clear: impl FnOnce(T) -> U) -> LoadOperation<U> {
        match self {
            LoadOperation::Load => LoadOperation::Load,
            LoadOperation::Clear(value) => LoadOperation::Clear(clear(value)),
            LoadOperation::Discard => LoadOperation::Discard,
        }
    }
}
