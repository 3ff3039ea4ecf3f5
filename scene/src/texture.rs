//! Images, and how they are sampled.

/// What lies beyond the edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texel at the edge.
    ClampToEdge,
    /// The texture again, mirrored every second time.
    MirroredRepeat,
}

/// How texels become a colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Filter {
    /// The nearest texel.
    Nearest,
    /// A mix of the texels around.
    #[default]
    Linear,
}

/// How a texture is sampled. The default (where the file says nothing) repeats and mixes texels and mip levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Across.
    pub wrap_u: Wrap,
    /// Down.
    pub wrap_v: Wrap,
    /// Where a texel covers more than a pixel.
    pub magnify: Filter,
    /// Where a pixel covers more than a texel.
    pub minify: Filter,
    /// Between mip levels; `None` where the file asks for the base level only.
    pub mipmap: Option<Filter>,
}

impl Default for Sampler {
    fn default() -> Self {
        Self {
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
            magnify: Filter::Linear,
            minify: Filter::Linear,
            mipmap: Some(Filter::Linear),
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
    /// How it is sampled.
    pub sampler: Sampler,
}
