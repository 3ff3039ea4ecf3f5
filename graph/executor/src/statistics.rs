//! What an executor has created on the device.

/// The numbers of objects that an executor has created so far. They only grow; in a steady frame none of them does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Textures.
    pub textures: u64,
    /// Buffers, those for blocks included.
    pub buffers: u64,
    /// Bytes of these textures and buffers.
    pub bytes: u64,
    /// Views of the plan's textures.
    pub views: u64,
    /// Views of the host's textures.
    pub import_views: u64,
    /// Samplers.
    pub samplers: u64,
    /// Shader modules.
    pub shader_modules: u64,
    /// Bind group layouts and pipeline layouts.
    pub layouts: u64,
    /// Render and compute pipelines.
    pub pipelines: u64,
    /// Bind groups.
    pub bind_groups: u64,
}
