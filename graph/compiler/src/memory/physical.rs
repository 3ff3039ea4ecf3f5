//! Physical resources: the textures and buffers of a plan.

use serde::Serialize;
use wgpu_types::{BufferUsages, TextureFormat, TextureUsages};

use crate::request::texture_size::TextureSize;

/// The physical texture, buffer or import that holds a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Physical {
    /// A texture that the plan creates, by its index in `Plan::textures`.
    Texture(usize),
    /// A buffer that the plan creates, by its index in `Plan::buffers`.
    Buffer(usize),
    /// A texture or buffer that the host owns.
    Imported,
    /// Blackboard data: CPU data passed between passes.
    Blackboard,
}

/// A texture that the plan creates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicalTexture {
    /// The debug label: names of the resources that use the texture, ordered by lifetime; a long list is truncated.
    pub label: String,
    /// The texture format.
    pub format: TextureFormat,
    /// The size of the texture.
    pub size: TextureSize,
    /// Whether the texture is 3D.
    pub volume: bool,
    /// The usages to create the texture with.
    pub usages: TextureUsages,
    /// The second format in which passes view the texture; `None` if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_format: Option<TextureFormat>,
    /// Whether one more layer is created so that OpenGL binds the texture as an array. No layer count includes this
    /// layer.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub spare_layer: bool,
    /// The size in bytes, including all mip levels, layers and samples.
    pub bytes: u64,
}

/// A buffer that the plan creates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicalBuffer {
    /// The debug label: names of the resources that use the buffer; a long list is truncated.
    pub label: String,
    /// The size in bytes.
    pub bytes: u64,
    /// The usages to create the buffer with.
    pub usages: BufferUsages,
}
