//! The work of passes, as data: the executor and the compiler interpret it, no pass touches the device itself.
//!
//! A node kind turns its settings into one [`Work`]. Render and compute work is pure data (attachments, programs,
//! bindings, sizes as expressions), so it can be checked, planned, compared and drawn without a GPU. CPU work is a
//! function from frame input to named data and views; it knows no GPU either.
//!
//! The accesses of a pass follow from its work ([`Work::accesses`]) and are declared nowhere else.

mod attachment;
mod binding;
mod compute;
mod cpu;
mod draw;
mod handle;
mod live;
mod transfer;

pub use attachment::{
    Attachment, AttachmentTarget, ColorAttachment, DepthAttachment, LoadOperation, RenderWork,
    StencilAttachment,
};
pub use binding::{
    Address, BlockLayout, BlockRun, BlockValues, BoundSlot, BoundTexture, Compare, Deferred, Filter, Sampler,
    SlotSource, TextureView,
};
pub use compute::{ComputeWork, Dispatch};
pub use cpu::{AnyCpuNode, CpuContext, CpuNode, CpuRun, CpuWork};
pub use draw::{BufferDraw, Draw, DrawCounts, DrawOrder, IndexStream, Redraw, SceneDraw, VertexStream};
pub use handle::{PassHandle, ProgramHandle, ResourceHandle};
pub(crate) use live::wrong_type;
pub use live::{Byte, Color, Depth, Live, LiveValue};
pub use transfer::{BufferRegion, TextureRegion, TransferEnd, TransferWork};

use crate::access::{SubresourceRange, Usage, Version};
use umbragraph_text::source::Span;

/// A range of a resource, such as some mip levels of a texture, that a setting of a pass names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subresource {
    /// The texture, buffer or blackboard data.
    pub resource: ResourceHandle,
    /// The mip levels, layers and aspect of a texture, or the bytes of a buffer.
    pub range: SubresourceRange,
    /// The version of the resource that is read; unused for accesses that only write.
    pub version: Version,
    /// The place of the setting in the document.
    pub place: Span,
    /// The JSON pointer of the setting.
    pub pointer: String,
}

impl Subresource {
    /// The attachment that the range names. The mip level is 0 if the range names none; the layer is `None` if the
    /// range names none, and each view then names its own layer.
    pub fn target(&self) -> AttachmentTarget {
        let (mip, layer) = (self.range.mip.map_or(0, |run| run.first), self.range.layer.map(|run| run.first));
        AttachmentTarget { resource: self.resource, mip, layer }
    }

    /// The offset of the range in a buffer, in bytes; 0 if the range is the whole buffer.
    pub fn offset(&self) -> u64 {
        self.range.bytes.map_or(0, |run| run.first)
    }
}

/// The work that a pass does in a frame.
#[derive(Clone, Debug)]
pub enum Work {
    /// No work, for a pass that is assembled in code from its accesses only.
    Nothing,
    /// Computes data and views on the CPU.
    Cpu(CpuWork),
    /// Draws into attachments.
    Render(Box<RenderWork>),
    /// Dispatches a compute shader.
    Compute(Box<ComputeWork>),
    /// Copies texels or bytes, or clears a buffer.
    Transfer(Box<TransferWork>),
}

impl Work {
    /// The shader program and its bindings; `None` for work without a shader.
    pub fn bound(&self) -> Option<(ProgramHandle, &[BoundSlot])> {
        match self {
            Work::Render(render) => Some(render.draw.bound()),
            Work::Compute(compute) => Some((compute.program, &compute.bindings)),
            Work::Nothing | Work::Cpu(_) | Work::Transfer(_) => None,
        }
    }

    /// The shader program; `None` for work without a shader.
    pub fn program(&self) -> Option<ProgramHandle> {
        Some(self.bound()?.0)
    }

    /// The draws of the host's meshes; `None` for other work.
    pub fn scene(&self) -> Option<&SceneDraw> {
        match self {
            Work::Render(render) => match &render.draw {
                Draw::Scene(scene) => Some(scene),
                Draw::Fullscreen { .. } | Draw::Buffers(_) => None,
            },
            _ => None,
        }
    }

    /// The subresources that the work accesses, each with its usage, in the order in which the accesses happen.
    pub fn accesses(&self) -> Vec<(&Subresource, Usage)> {
        let mut all = Vec::new();
        match self {
            Work::Nothing => {}
            Work::Cpu(cpu) => {
                all.extend(cpu.inputs.iter().map(|input| (input, Usage::BlackboardRead)));
                all.push((&cpu.output, Usage::BlackboardWrite));
            }
            Work::Render(render) => {
                match &render.draw {
                    Draw::Fullscreen { bindings, .. } => all.extend(bound(bindings)),
                    Draw::Buffers(draw) => {
                        all.extend(bound(&draw.bindings));
                        all.extend(draw.vertices.iter().map(|stream| (&stream.buffer, Usage::Vertex)));
                        all.extend(draw.indices.iter().map(|indices| (&indices.buffer, Usage::Index)));
                        if let DrawCounts::Indirect(counts) = &draw.counts {
                            all.push((counts, Usage::Indirect));
                        }
                    }
                    Draw::Scene(scene) => {
                        all.push((&scene.views, Usage::BlackboardRead));
                        let over = scene.redraw.iter().filter_map(|redraw| redraw.base.as_ref());
                        all.extend(over.map(|texture| (texture, Usage::CopySource)));
                        all.extend(bound(&scene.bindings));
                    }
                }
                for color in &render.color {
                    all.push((&color.to, color.usage()));
                    all.extend(color.resolve.iter().map(|to| (to, Usage::ResolveTarget)));
                }
                all.extend(render.depth.iter().map(|depth| (&depth.to, depth.usage())));
                all.extend(render.stencil.iter().map(|stencil| (&stencil.to, stencil.usage())));
            }
            Work::Compute(compute) => {
                all.extend(bound(&compute.bindings));
                if let Dispatch::Indirect(counts) = &compute.dispatch {
                    all.push((counts, Usage::Indirect));
                }
            }
            Work::Transfer(transfer) => {
                all.extend(transfer.source.iter().map(|end| (end.subresource(), Usage::CopySource)));
                all.push((transfer.destination.subresource(), transfer.written));
            }
        }
        all
    }
}

fn bound(slots: &[BoundSlot]) -> impl Iterator<Item = (&Subresource, Usage)> {
    slots.iter().filter_map(|slot| match &slot.source {
        SlotSource::Texture(bound) => Some((&bound.texture, bound.usage)),
        SlotSource::Buffer { buffer, usage } => Some((buffer, *usage)),
        SlotSource::Data { data, .. } => Some((data, Usage::BlackboardRead)),
        SlotSource::Sampler(_) | SlotSource::View | SlotSource::Values(_) => None,
    })
}
