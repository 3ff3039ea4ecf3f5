//! The size of a texture.

/// The size of a texture: extent, array layers or depth, mip levels and samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
pub struct TextureSize {
    /// The width (unit: texels).
    pub width: u32,
    /// The height (unit: texels).
    pub height: u32,
    /// The number of array layers; for a 3D texture, the depth in texels.
    pub layers: u32,
    /// The number of mip levels.
    pub mips: u32,
    /// The number of samples per texel.
    pub samples: u32,
}

impl TextureSize {
    /// A 2D size from a width and a height in texels, with one layer, one mip level and one sample.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height, layers: 1, mips: 1, samples: 1 }
    }

    /// Sets the number of array layers, or the depth in texels of a 3D texture.
    #[must_use]
    pub const fn layers(self, layers: u32) -> Self {
        Self { layers, ..self }
    }

    /// Sets the number of mip levels.
    #[must_use]
    pub const fn mips(self, mips: u32) -> Self {
        Self { mips, ..self }
    }

    /// Sets the number of samples per texel.
    #[must_use]
    pub const fn samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }
}
