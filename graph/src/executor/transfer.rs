//! Copies to and from buffers, clears of buffers, and buffers of counts.
//!
//! Texels lie in a buffer row by row, layer by layer, each row at a multiple of 256 bytes, which is what WebGPU wants of
//! a copy. Where a toggle takes the writers of a source away, what stands in for it is copied.

use super::realize::copy_extent;
use super::resources::{Buffer, Resources, Texture};
use super::switches::Switches;
use crate::compiler::Plan;
use crate::work::{AttachmentTarget, BufferView, ResourceHandle, TransferEnd, TransferWork};

/// A buffer of counts, and what stands in for it.
pub(super) struct Counts {
    buffers: Vec<(ResourceHandle, Buffer)>,
    /// The first byte.
    pub(super) offset: u64,
}

impl Counts {
    /// The counts at a byte of a buffer.
    pub(super) fn new(resources: &Resources, plan: &Plan, resource: ResourceHandle, offset: u64) -> Self {
        let buffers = plan.pipeline.stand_ins(resource);
        let buffers = buffers.filter_map(|one| Some((one, resources.buffer(plan, one)?)));
        Self { buffers: buffers.collect(), offset }
    }

    /// The buffer in this frame.
    pub(super) fn buffer<'a>(
        &'a self,
        resources: &'a Resources,
        switches: &Switches,
    ) -> Option<&'a wgpu::Buffer> {
        let seen = self.buffers.first().map(|(resource, _)| switches.seen(*resource))?;
        self.buffers.iter().find(|(resource, _)| *resource == seen)?.1.get(resources)
    }
}

/// A transfer with everything that it needs on the device; of the source one for each that can stand in for it.
pub(super) struct Transfer {
    sources: Vec<(ResourceHandle, End)>,
    destination: End,
    extent: wgpu::Extent3d,
}

enum End {
    Buffer { buffer: Buffer, offset: u64, bytes: u64 },
    Texture { texture: Texture, target: AttachmentTarget, bytes_per_row: u32, rows: u32 },
}

impl End {
    fn new(resources: &Resources, plan: &Plan, end: TransferEnd) -> Option<Self> {
        match end {
            TransferEnd::Buffer(BufferView { resource, bytes }) => {
                let buffer = resources.buffer(plan, resource)?;
                let all = plan.resource(resource)?.bytes;
                let (offset, bytes) = bytes.map_or((0, all), |run| (run.first, run.count));
                Some(End::Buffer { buffer, offset, bytes })
            }
            TransferEnd::Texture(target) => {
                let format = plan.resource(target.resource)?.format?;
                let extent = copy_extent(plan, &target)?;
                let (width, height) = format.block_dimensions();
                let row = extent.width.div_ceil(width).checked_mul(format.block_copy_size(None)?)?;
                Some(End::Texture {
                    texture: resources.texture(plan, target.resource)?,
                    target,
                    bytes_per_row: row.checked_next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)?,
                    rows: extent.height.div_ceil(height),
                })
            }
        }
    }
}

impl Transfer {
    /// A transfer of a plan; `None` where one of the ends is not on the device.
    pub(super) fn new(resources: &Resources, plan: &Plan, work: &TransferWork) -> Option<Self> {
        let destination = End::new(resources, plan, work.destination)?;
        let named = |end: TransferEnd| match end {
            TransferEnd::Buffer(view) => view.resource,
            TransferEnd::Texture(target) => target.resource,
        };
        let with = |end: TransferEnd, resource: ResourceHandle| match end {
            TransferEnd::Buffer(view) => TransferEnd::Buffer(BufferView { resource, ..view }),
            TransferEnd::Texture(target) => TransferEnd::Texture(AttachmentTarget { resource, ..target }),
        };
        let mut sources = Vec::new();
        if let Some(source) = work.source {
            for one in plan.pipeline.stand_ins(named(source)) {
                sources.push((one, End::new(resources, plan, with(source, one))?));
            }
        }
        let texture = [work.source, Some(work.destination)].into_iter().flatten().find_map(|end| match end {
            TransferEnd::Texture(target) => Some(target),
            TransferEnd::Buffer(_) => None,
        });
        let extent = match texture {
            Some(target) => copy_extent(plan, &target)?,
            None => wgpu::Extent3d::default(),
        };
        Some(Self { sources, destination, extent })
    }

    /// Records it.
    pub(super) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        switches: &Switches,
    ) {
        let seen = self.sources.first().map(|(resource, _)| switches.seen(*resource));
        let source = self.sources.iter().find(|(resource, _)| Some(*resource) == seen).map(|(_, end)| end);
        match (source, &self.destination) {
            (None, End::Buffer { buffer, offset, bytes }) => {
                if let Some(buffer) = buffer.get(resources) {
                    encoder.clear_buffer(buffer, *offset, Some(*bytes));
                }
            }
            (Some(End::Buffer { buffer: from, offset: at, bytes }), End::Buffer { buffer, offset, .. }) => {
                if let (Some(from), Some(buffer)) = (from.get(resources), buffer.get(resources)) {
                    encoder.copy_buffer_to_buffer(from, *at, buffer, *offset, Some(*bytes));
                }
            }
            (
                Some(End::Buffer { buffer, offset, .. }),
                End::Texture { texture, target, bytes_per_row, rows },
            ) => {
                if let (Some(texture), Some(buffer)) = (texture.get(resources), buffer.get(resources)) {
                    let source = in_buffer(buffer, *offset, *bytes_per_row, *rows);
                    encoder.copy_buffer_to_texture(source, in_texture(texture, *target), self.extent);
                }
            }
            (
                Some(End::Texture { texture, target, bytes_per_row, rows }),
                End::Buffer { buffer, offset, .. },
            ) => {
                if let (Some(texture), Some(buffer)) = (texture.get(resources), buffer.get(resources)) {
                    let destination = in_buffer(buffer, *offset, *bytes_per_row, *rows);
                    encoder.copy_texture_to_buffer(in_texture(texture, *target), destination, self.extent);
                }
            }
            (None | Some(End::Texture { .. }), End::Texture { .. }) => {}
        }
    }
}

fn in_buffer(
    buffer: &wgpu::Buffer,
    offset: u64,
    bytes_per_row: u32,
    rows: u32,
) -> wgpu::TexelCopyBufferInfo<'_> {
    let layout = wgpu::TexelCopyBufferLayout {
        offset,
        bytes_per_row: Some(bytes_per_row),
        rows_per_image: Some(rows),
    };
    wgpu::TexelCopyBufferInfo { buffer, layout }
}

fn in_texture(texture: &wgpu::Texture, target: AttachmentTarget) -> wgpu::TexelCopyTextureInfo<'_> {
    wgpu::TexelCopyTextureInfo {
        texture,
        mip_level: target.mip,
        origin: wgpu::Origin3d { x: 0, y: 0, z: target.layer.unwrap_or(0) },
        aspect: wgpu::TextureAspect::All,
    }
}
