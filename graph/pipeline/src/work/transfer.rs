//! Work that copies texels or bytes, or clears a buffer.

use crate::access::{IndexRange, Usage};
use crate::work::Subresource;
use crate::work::binding::Deferred;

/// The work of a pass that copies texels or bytes, or clears a buffer.
#[derive(Clone, Debug)]
pub struct TransferWork {
    /// The source of the copy; `None` if the destination is a buffer that is filled with zeros.
    pub source: Option<TransferEnd>,
    /// The destination of the copy, or the buffer that is cleared.
    pub destination: TransferEnd,
    /// The usage of the destination, which determines whether earlier contents are kept.
    pub written: Usage,
    /// The width and height of the copied region, in texels; `None` for the size of the mip level.
    pub extent: Option<[Deferred; 2]>,
}

/// The source or the destination of a transfer.
#[derive(Clone, Debug)]
pub enum TransferEnd {
    /// Bytes of a buffer.
    Buffer(BufferRegion),
    /// Texels of a texture.
    Texture(TextureRegion),
}

impl TransferEnd {
    /// The subresource that is copied from or to.
    pub fn subresource(&self) -> &Subresource {
        match self {
            TransferEnd::Buffer(region) => &region.buffer,
            TransferEnd::Texture(region) => &region.texture,
        }
    }
}

/// A range of a buffer for a transfer: bytes, or texels stored row by row, layer by layer, mip level by mip level.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BufferRegion {
    /// The buffer and the range of its bytes.
    pub buffer: Subresource,
    /// Distance between rows of texels, a multiple of 256 (unit: bytes); `None` for the smallest possible.
    pub bytes_per_row: Option<u32>,
    /// Distance between layers (unit: rows of texel blocks); `None` for the smallest possible.
    pub rows_per_image: Option<u32>,
}

/// The texels of a texture that a transfer reads or writes.
#[derive(Clone, Debug)]
pub struct TextureRegion {
    /// The texture with its mip levels (`None`: the first) and its layers or slices (`None`: all).
    pub texture: Subresource,
    /// The texel at which the region begins, from the left and from the top; `None` for the top left corner.
    pub origin: Option<[Deferred; 2]>,
}

impl TextureRegion {
    /// The mip levels of the region; level 0 if the range names none.
    pub fn mip(&self) -> IndexRange<u32> {
        self.texture.range.mip.unwrap_or(IndexRange::one(0))
    }
}
