//! Work that copies texels or bytes, or clears a buffer.

use crate::access::{IndexRange, Usage};
use crate::work::Subresource;
use crate::work::binding::Deferred;

/// Copying texels or bytes, or clearing a buffer.
#[derive(Clone, Debug)]
pub struct TransferWork {
    /// The source; without it the destination, a buffer, is filled with zeros.
    pub source: Option<TransferEnd>,
    /// The destination.
    pub destination: TransferEnd,
    /// The usage of the destination, which tells whether earlier contents stay.
    pub written: Usage,
    /// The width and height of the texels that are copied; all of a mip level without it.
    pub extent: Option<[Deferred; 2]>,
}

/// One end of a transfer.
#[derive(Clone, Debug)]
pub enum TransferEnd {
    /// Bytes of a buffer.
    Buffer(BufferRegion),
    /// Texels of a texture.
    Texture(TextureRegion),
}

impl TransferEnd {
    /// The part that is copied from or to.
    pub fn subresource(&self) -> &Subresource {
        match self {
            TransferEnd::Buffer(region) => &region.buffer,
            TransferEnd::Texture(region) => &region.texture,
        }
    }
}

/// Bytes of a buffer, or texels in it: row by row, layer by layer, mip level by mip level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BufferRegion {
    /// The bytes.
    pub buffer: Subresource,
    /// Distance between rows of texels, a multiple of 256 (unit: bytes); without it the smallest possible.
    pub bytes_per_row: Option<u32>,
    /// Distance between layers (unit: rows of texel blocks); without it the smallest possible.
    pub rows_per_image: Option<u32>,
}

/// Texels of a texture.
#[derive(Clone, Debug)]
pub struct TextureRegion {
    /// The mip levels (the first if unset) and the layers or slices (all if unset) of the texture.
    pub texture: Subresource,
    /// The texel with which it begins, from the left and from the top; the first without it.
    pub origin: Option<[Deferred; 2]>,
}

impl TextureRegion {
    /// The mip levels.
    pub fn mip(&self) -> IndexRange<u32> {
        self.texture.range.mip.unwrap_or(IndexRange::one(0))
    }
}
