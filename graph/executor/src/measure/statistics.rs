//! Statistics of an executor: created objects, and the draws of the last record.

/// The numbers of objects that an executor has created so far, including [prepared](crate::PreparedPlan) ones. They
/// only grow. The first records make buffers for blocks and bind groups; a steady frame makes nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
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

impl std::ops::AddAssign for Statistics {
    fn add_assign(&mut self, other: Self) {
        self.textures += other.textures;
        self.buffers += other.buffers;
        self.bytes += other.bytes;
        self.views += other.views;
        self.import_views += other.import_views;
        self.samplers += other.samplers;
        self.shader_modules += other.shader_modules;
        self.layouts += other.layouts;
        self.pipelines += other.pipelines;
        self.bind_groups += other.bind_groups;
    }
}

/// The counts of one record for a pass that draws the host's meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct PassCounts {
    /// The views that were drawn, entirely or only in newly visible strips.
    pub views: u64,
    /// The views that were not drawn, since their texels were unchanged.
    pub kept: u64,
    /// The number of objects that the host bound: one for each of its draws.
    pub draws: u64,
    /// Texels in which draws were issued: the views, clipped to the host's bounds.
    pub texels: u64,
}

impl std::ops::AddAssign for PassCounts {
    fn add_assign(&mut self, other: Self) {
        self.views += other.views;
        self.kept += other.kept;
        self.draws += other.draws;
        self.texels += other.texels;
    }
}
