//! Images, and how they are sampled.

use umbragraph_pipeline::wgpu_types::{AddressMode, FilterMode, MipmapFilterMode};

/// The sampling of a texture. The default, for files without a sampler, repeats and interpolates texels and mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// The address mode along u.
    pub wrap_u: AddressMode,
    /// The address mode along v.
    pub wrap_v: AddressMode,
    /// The filter for a texel that covers more than a pixel.
    pub magnify: FilterMode,
    /// The filter for a pixel that covers more than a texel.
    pub minify: FilterMode,
    /// The filter between mip levels; `None` if the file uses the base level only.
    pub mipmap: Option<MipmapFilterMode>,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            wrap_u: AddressMode::Repeat,
            wrap_v: AddressMode::Repeat,
            magnify: FilterMode::Linear,
            minify: FilterMode::Linear,
            mipmap: Some(MipmapFilterMode::Linear),
        }
    }
}

/// A decoded picture.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// Texels across, at least 1.
    pub width: u32,
    /// Texels down, at least 1.
    pub height: u32,
    /// Four bytes for each texel: red, green, blue (sRGB-encoded) and alpha (linear, not premultiplied); row 0 on top.
    pub rgba: Vec<u8>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({:?}, {}x{})", self.name, self.width, self.height)
    }
}

/// An image together with the way to sample it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Texture {
    /// The index of the image in [`Scene::images`](crate::Scene::images).
    pub image: usize,
    /// Its sampler.
    pub sampler: Sampler,
}
