//! Physical resources: the textures and buffers of a plan.

use serde::Serialize;
use wgpu_types::{BufferUsages, TextureFormat, TextureUsages};

use crate::request::texture_size::TextureSize;

/// The physical resource that holds a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Physical {
    /// A texture of the plan.
    Texture(usize),
    /// A buffer of the plan.
    Buffer(usize),
    /// The host's own.
    Imported,
    /// Blackboard data, on the CPU.
    Blackboard,
}

/// A texture to create.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicalTexture {
    /// The names of the resources that it stands for, in the order of their lifetimes; a long list is cut.
    pub label: String,
    /// The format.
    pub format: TextureFormat,
    /// The size.
    pub size: TextureSize,
    /// Whether it is a volume.
    pub volume: bool,
    /// The usages.
    pub usages: TextureUsages,
    /// The other format in which passes see it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_format: Option<TextureFormat>,
    /// Whether it is created with a layer more, so that OpenGL binds it as an array; the layer is in no count.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub spare_layer: bool,
    /// Its bytes, all mips, layers and samples.
    pub bytes: u64,
}

/// A buffer to create.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysicalBuffer {
    /// The names of the resources that it stands for; a long list is cut.
    pub label: String,
    /// Its size.
    pub bytes: u64,
    /// The usages.
    pub usages: BufferUsages,
}
