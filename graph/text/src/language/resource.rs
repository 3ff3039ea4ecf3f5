//! Declarations of textures and buffers.

use schemars::JsonSchema;
use serde::Deserialize;

use super::format_names::FormatName;
use super::{Expr, Word};

/// A resource: a texture or a buffer. Blackboard data needs no declaration: the pass that publishes it names it.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ResourceDeclaration {
    /// A texture.
    Texture(TextureDeclaration),
    /// A buffer.
    Buffer(BufferDeclaration),
}

/// A texture.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TextureDeclaration {
    /// A texture format of the WebGPU specification, or an expression that yields one; or several formats, of which the
    /// first that supports every usage is taken.
    pub format: FormatCandidates,
    /// Width and height in texels (rounded down to whole ones): a list of two, or another size such as "=viewport",
    /// "=maps" or "=maps / 2".
    pub size: Expr,
    /// The number of array layers.
    pub layers: Option<Expr>,
    /// The number of mip levels.
    pub mips: Option<Expr>,
    /// The number of samples of each texel: 1 or 4.
    pub samples: Option<Expr>,
    /// The view dimension of the whole texture; without it "2d" for one layer and "2d-array" for more.
    pub view_dimension: Option<TextureShape>,
    /// The lifetime of the texture.
    #[serde(default)]
    pub lifetime: Lifetime,
    /// Whether the host looks at it between frames: copies it, or binds it in shaders of its own. It then keeps what
    /// the frame leaves in it, in memory that it shares with no other, and the passes that write it are kept.
    #[serde(default)]
    pub exposed: bool,
    /// For a history: how many earlier frames can be read, 1 to 8, as `&NAME@-1`, `&NAME@-2` and so on; 1 without it.
    pub frames: Option<Expr>,
    /// For a history: what an earlier frame holds before there was one. A number for all channels or for depth, or red,
    /// green, blue and alpha.
    pub initial: Option<Expr>,
    /// A description for people.
    pub description: Option<String>,
}

/// A buffer.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BufferDeclaration {
    /// The size in bytes.
    pub size: Expr,
    /// The lifetime of the buffer.
    #[serde(default)]
    pub lifetime: Lifetime,
    /// Whether the host looks at it between frames: copies it, or binds it in shaders of its own. It then keeps what
    /// the frame leaves in it, in memory that it shares with no other, and the passes that write it are kept.
    #[serde(default)]
    pub exposed: bool,
    /// For a history: how many earlier frames can be read, 1 to 8, as `&NAME@-1`, `&NAME@-2` and so on; 1 without it.
    pub frames: Option<Expr>,
    /// For a history: the value of each four bytes of an earlier frame before there was one.
    pub initial: Option<WordValue>,
    /// A description for people.
    pub description: Option<String>,
}

/// The value of four bytes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WordValue {
    /// A floating-point number.
    F32(Expr),
    /// A whole number from 0.
    U32(Expr),
    /// A whole number.
    I32(Expr),
}

/// One format, or several in the order of preference.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum FormatCandidates {
    /// The format.
    One(#[schemars(with = "Word<FormatName>")] String),
    /// The candidates, the best first.
    Several(#[schemars(with = "Vec<FormatName>", length(min = 1))] Vec<String>),
}

impl FormatCandidates {
    /// The names in the order of preference.
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
        /// One layer.
        #[serde(rename = "2d")]
        D2,
        /// Layers.
        #[serde(rename = "2d-array")]
        D2Array,
        /// Six layers as the faces +X −X +Y −Y +Z −Z.
        #[serde(rename = "cube")]
        Cube,
        /// Six layers for each cube.
        #[serde(rename = "cube-array")]
        CubeArray,
        /// The layers are the depth of a volume.
        #[serde(rename = "3d")]
        D3,
    }
}

/// The lifetime of a resource.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, serde::Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Lifetime {
    /// Within one frame; its memory is shared with others whose lifetimes do not touch it.
    #[default]
    Transient,
    /// From frame to frame.
    Persistent,
    /// One for each frame, of which the last few can be read: `&NAME@-1` is that of the frame before.
    History,
    /// The host's own; what is written to it is what the pipeline is for.
    Imported,
}
