//! The size of a texture.

/// The size of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
pub struct TextureSize {
    /// In texels.
    pub width: u32,
    /// In texels.
    pub height: u32,
    /// Array layers; for a volume its depth.
    pub layers: u32,
    /// Mip levels.
    pub mips: u32,
    /// Samples of each texel.
    pub samples: u32,
}
