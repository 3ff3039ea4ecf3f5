//! Copies, clears of buffers, and buffers of counts.
//!
//! The plan defines the copies. If a toggle removes the writers of a source, its fallback is copied.

use super::resources::{Buffer, Fallbacks, Resources, Texture};
use umbragraph_compiler::Switches;
use umbragraph_compiler::{Plan, PlannedCopy, PlannedPass, TexelOrigin, TexelRows};
use umbragraph_pipeline::work::{ResourceHandle, Subresource, TransferWork};

/// A buffer of indirect arguments, vertices or indices, and its fallbacks, which toggles select.
pub(crate) struct Counts {
    buffers: Fallbacks<Buffer>,
    /// The byte offset of the arguments in the buffer.
    pub(crate) offset: u64,
}

impl Counts {
    /// Creates the buffer of indirect arguments, vertices or indices from its resource.
    pub(crate) fn new(resources: &Resources, plan: &Plan, named: &Subresource) -> Self {
        let buffers = Fallbacks::new(plan, named.resource, |one| resources.buffer(plan, one));
        Self { buffers, offset: named.offset() }
    }

    /// The buffer that toggles select in the current frame; `None` if the host has not given it.
    pub(crate) fn buffer<'a>(
        &'a self,
        resources: &'a Resources,
        switches: &Switches,
    ) -> Option<&'a wgpu::Buffer> {
        self.buffers.seen(switches)?.1.get(resources)
    }
}

/// The copies and clears of a transfer pass, with their textures and buffers on the device.
pub(crate) struct Transfer {
    source: Option<Fallbacks<End>>,
    destination: End,
    copies: Vec<PlannedCopy>,
}

enum End {
    Buffer(Buffer),
    Texture(Texture),
}

impl End {
    fn new(resources: &Resources, plan: &Plan, resource: ResourceHandle) -> Option<Self> {
        let texture = resources.texture(plan, resource).map(End::Texture);
        texture.or_else(|| resources.buffer(plan, resource).map(End::Buffer))
    }

    fn buffer<'a>(&'a self, resources: &'a Resources) -> Option<&'a wgpu::Buffer> {
        match self {
            End::Buffer(buffer) => buffer.get(resources),
            End::Texture(_) => None,
        }
    }

    fn texture<'a>(&'a self, resources: &'a Resources) -> Option<&'a wgpu::Texture> {
        match self {
            End::Texture(texture) => texture.get(resources),
            End::Buffer(_) => None,
        }
    }
}

impl Transfer {
    /// Creates the transfer of a planned pass; `None` if its destination has no texture or buffer on the device.
    pub(crate) fn new(
        resources: &Resources,
        plan: &Plan,
        planned: &PlannedPass,
        work: &TransferWork,
    ) -> Option<Self> {
        let destination = End::new(resources, plan, work.destination.subresource().resource)?;
        let source = work.source.as_ref().map(|source| source.subresource().resource);
        let end = |one| End::new(resources, plan, one);
        let source = source.map(|source| Fallbacks::new(plan, source, end));
        Some(Self { source, destination, copies: planned.copies.clone() })
    }

    /// Records the copies and clears; one whose texture or buffer is missing is skipped.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        switches: &Switches,
    ) {
        let source = self.source.as_ref().and_then(|source| source.seen(switches)).map(|(_, end)| end);
        for copy in &self.copies {
            // What the host has not given this frame is neither copied nor filled.
            let _: Option<()> = self.one(encoder, resources, source, copy);
        }
    }

    fn one(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        resources: &Resources,
        source: Option<&End>,
        copy: &PlannedCopy,
    ) -> Option<()> {
        let destination = &self.destination;
        match copy {
            PlannedCopy::Clear { offset, bytes } => {
                encoder.clear_buffer(destination.buffer(resources)?, *offset, Some(*bytes));
            }
            PlannedCopy::Bytes { from, to, bytes } => {
                let (source, destination) = (source?.buffer(resources)?, destination.buffer(resources)?);
                encoder.copy_buffer_to_buffer(source, *from, destination, *to, Some(*bytes));
            }
            PlannedCopy::Texels { from, to, extent } => {
                let (source, destination) = (source?.texture(resources)?, destination.texture(resources)?);
                // wgpu 30 panics where the layers of one copy were last used in more than one way.
                let is_layered = source.dimension() != wgpu::TextureDimension::D3;
                let [width, height, layers] = *extent;
                let (count, extent) = if is_layered { (layers, [width, height, 1]) } else { (1, *extent) };
                for layer in 0..count {
                    let beside = |origin: &TexelOrigin| {
                        let [x, y, z] = origin.at;
                        TexelOrigin { at: [x, y, z + layer], ..*origin }
                    };
                    let (from, to) = (beside(from), beside(to));
                    let (source, destination) = (in_texture(source, &from), in_texture(destination, &to));
                    encoder.copy_texture_to_texture(source, destination, size(extent));
                }
            }
            PlannedCopy::Upload { from, to, extent } => {
                let source = in_buffer(source?.buffer(resources)?, from);
                let destination = in_texture(destination.texture(resources)?, to);
                encoder.copy_buffer_to_texture(source, destination, size(*extent));
            }
            PlannedCopy::Download { from, to, extent } => {
                let source = in_texture(source?.texture(resources)?, from);
                let destination = in_buffer(destination.buffer(resources)?, to);
                encoder.copy_texture_to_buffer(source, destination, size(*extent));
            }
        }
        Some(())
    }
}

fn size([width, height, depth_or_array_layers]: [u32; 3]) -> wgpu::Extent3d {
    wgpu::Extent3d { width, height, depth_or_array_layers }
}

fn in_buffer<'a>(buffer: &'a wgpu::Buffer, rows: &TexelRows) -> wgpu::TexelCopyBufferInfo<'a> {
    let layout = wgpu::TexelCopyBufferLayout {
        offset: rows.offset,
        bytes_per_row: Some(rows.bytes_per_row),
        rows_per_image: Some(rows.rows_per_image),
    };
    wgpu::TexelCopyBufferInfo { buffer, layout }
}

fn in_texture<'a>(texture: &'a wgpu::Texture, origin: &TexelOrigin) -> wgpu::TexelCopyTextureInfo<'a> {
    let [x, y, z] = origin.at;
    let (origin, mip_level, aspect) = (wgpu::Origin3d { x, y, z }, origin.mip, origin.aspect.into());
    wgpu::TexelCopyTextureInfo { texture, mip_level, origin, aspect }
}
