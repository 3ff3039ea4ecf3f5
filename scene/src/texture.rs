//! Images, and how they are sampled.

use umbragraph_pipeline::wgpu_types::{AddressMode, FilterMode, MipmapFilterMode};

/// The sampling state of a texture. The default, used for textures without a sampler, repeats the image and filters
/// texels and mip levels linearly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// The address mode of the texture coordinate u.
    pub wrap_u: AddressMode,
    /// The address mode of the texture coordinate v.
    pub wrap_v: AddressMode,
    /// The magnification filter, used if a texel covers more than one pixel.
    pub magnify: FilterMode,
    /// The minification filter, used if a pixel covers more than one texel.
    pub minify: FilterMode,
    /// The filter between mip levels; `None` if only the base level is sampled.
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

/// A decoded image with 8 bits per channel.
#[derive(Clone, PartialEq, Eq)]
pub struct Image {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// The width in texels, at least 1.
    pub width: u32,
    /// The height in texels, at least 1.
    pub height: u32,
    /// Four bytes for each texel, rows from the top: red, green, blue and alpha (not premultiplied). Colours are
    /// sRGB-encoded; other data, such as normals, is linear.
    pub rgba: Vec<u8>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({:?}, {}x{})", self.name, self.width, self.height)
    }
}

/// An image and the address modes and filters with which it is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Texture {
    /// The index of the image in [`Scene::images`](crate::Scene::images).
    pub image: usize,
    /// The address modes and filters.
    pub sampler: Sampler,
}
