//! Declarations of textures and buffers.

use schemars::JsonSchema;
use serde::Deserialize;

use super::format_names::FormatName;
use super::{Expr, Word};

/// A resource: a texture or a buffer. Blackboard data is not declared here, but by the pass that publishes it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ResourceDeclaration {
    /// A texture.
    Texture(TextureDeclaration),
    /// A buffer.
    Buffer(BufferDeclaration),
}

/// The declaration of a texture.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TextureDeclaration {
    /// A texture format of the WebGPU specification, or an expression that yields one. Of a list of formats, the first
    /// that supports every use is taken.
    pub format: FormatCandidates,
    /// Width and height in texels (rounded down to whole ones): a list of two, or another size such as "=viewport",
    /// "=maps" or "=maps / 2".
    pub size: Expr,
    /// The number of array layers, or the depth of a volume in texels; 1 by default.
    pub layers: Option<Expr>,
    /// The number of mip levels; 1 by default.
    pub mips: Option<Expr>,
    /// The number of samples of each texel: 1 or 4, 1 by default.
    pub samples: Option<Expr>,
    /// The view dimension of the texture with all layers. By default it is "2d" for one layer and "2d-array" for more.
    pub view_dimension: Option<TextureShape>,
    /// The lifetime of the texture's contents; "transient" by default.
    #[serde(default)]
    pub lifetime: Lifetime,
    /// Whether the host reads the texture between frames, by copying it or binding it in its own shaders. Such a
    /// texture keeps its contents after the frame, in memory shared with no other resource, and passes that write it
    /// are not culled.
    #[serde(default)]
    pub exposed: bool,
    /// For a history: the number of earlier frames that can be read, 1 to 8, as `&NAME@-1`, `&NAME@-2` and so on. The
    /// default is 1.
    pub frames: Option<Expr>,
    /// For a history: the contents of an earlier frame that does not exist yet. A number for all channels or for depth,
    /// or red, green, blue and alpha.
    pub initial: Option<Expr>,
    /// A description for people.
    pub description: Option<String>,
}

/// The declaration of a buffer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BufferDeclaration {
    /// The size in bytes.
    pub size: Expr,
    /// The lifetime of the buffer's contents; "transient" by default.
    #[serde(default)]
    pub lifetime: Lifetime,
    /// Whether the host reads the buffer between frames, by copying it or binding it in its own shaders. Such a buffer
    /// keeps its contents after the frame, in memory shared with no other resource, and passes that write it are not
    /// culled.
    #[serde(default)]
    pub exposed: bool,
    /// For a history: the number of earlier frames that can be read, 1 to 8, as `&NAME@-1`, `&NAME@-2` and so on. The
    /// default is 1.
    pub frames: Option<Expr>,
    /// For a history: the value of each four bytes of an earlier frame that does not exist yet.
    pub initial: Option<WordValue>,
    /// A description for people.
    pub description: Option<String>,
}

/// A value of four bytes, which is repeated to fill a buffer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WordValue {
    /// A floating-point number.
    F32(Expr),
    /// An unsigned integer.
    U32(Expr),
    /// A signed integer.
    I32(Expr),
}

/// One texture format, or several in the order of preference.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FormatCandidates {
    /// A single format.
    One(#[schemars(with = "Word<FormatName>")] String),
    /// The candidate formats, the preferred one first.
    Several(#[schemars(with = "Vec<FormatName>", length(min = 1))] Vec<String>),
}

impl FormatCandidates {
    /// The names of the candidate formats in the order of preference.
    pub fn names(&self) -> &[String] {
        match self {
            FormatCandidates::One(name) => std::slice::from_ref(name),
            FormatCandidates::Several(names) => names,
        }
    }
}

crate::webgpu_words! {
    /// The view dimension of a texture.
    TextureShape = wgpu_types::TextureViewDimension {
        /// A single layer.
        #[serde(rename = "2d")]
        D2,
        /// An array of layers.
        #[serde(rename = "2d-array")]
        D2Array,
        /// Six layers as the faces +X −X +Y −Y +Z −Z.
        #[serde(rename = "cube")]
        Cube,
        /// An array of cubes, with six layers for each.
        #[serde(rename = "cube-array")]
        CubeArray,
        /// The layers are the depth of a volume.
        #[serde(rename = "3d")]
        D3,
    }
}

/// The lifetime of a resource's contents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Lifetime {
    /// The contents last within one frame. Memory is shared with other resources whose lifetimes do not overlap.
    #[default]
    Transient,
    /// The contents are kept from frame to frame.
    Persistent,
    /// Each frame has its own copy, and a few earlier ones can be read: `&NAME@-1` is that of the previous frame.
    History,
    /// The host application creates and owns the resource. Writing the resource is an output of the pipeline.
    Imported,
}
