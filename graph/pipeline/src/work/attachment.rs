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
    /// The color attachments in the order of the fragment shader's locations.
    pub color: Vec<ColorAttachment>,
    /// The depth attachment; `None` if there is none.
    pub depth: Option<DepthAttachment>,
    /// The stencil attachment, of the same texture, mip level and layer as the depth attachment; `None` if there is
    /// none.
    pub stencil: Option<StencilAttachment>,
    /// The geometry that is drawn, with its shader and bindings.
    pub draw: Draw,
    /// The constant color of the blend equations; `None` if none is set.
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

/// The common properties of attachments of all kinds.
#[derive(Clone, Copy, Debug)]
pub struct Attachment<'a> {
    /// The subresource that is drawn into.
    pub to: &'a Subresource,
    /// The usage of the texture.
    pub usage: Usage,
    /// The load operation, without the clear value.
    pub load: LoadOperation<()>,
    /// Whether the contents are discarded after the pass.
    pub discard: bool,
}

impl<'a> Attachment<'a> {
    fn new<T>(to: &'a Subresource, usage: Usage, load: LoadOperation<T>, discard: bool) -> Self {
        Self { to, usage, load: load.map(|_| ()), discard }
    }
}

/// The part of a texture that is attached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct AttachmentTarget {
    /// The texture.
    pub resource: ResourceHandle,
    /// The mip level.
    pub mip: u32,
    /// The layer: a fixed one, or `None` for the layer that each view names.
    pub layer: Option<u32>,
}

/// A color attachment.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorAttachment {
    /// The subresource that is drawn into.
    pub to: Subresource,
    /// The load operation.
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

/// A depth attachment.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthAttachment {
    /// The subresource that is drawn into.
    pub to: Subresource,
    /// The load operation.
    pub load: LoadOperation<Live<Depth>>,
    /// Whether depth is written.
    pub write: bool,
    /// The depth comparison.
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

/// A stencil attachment.
#[derive(Clone, Debug, PartialEq)]
pub struct StencilAttachment {
    /// The subresource that is drawn into.
    pub to: Subresource,
    /// The load operation.
    pub load: LoadOperation<Live<Byte>>,
    /// The stencil comparisons, operations and masks.
    pub state: wgpu_types::StencilState,
    /// The reference value for comparisons and writes.
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

/// The load operation of an attachment.
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
