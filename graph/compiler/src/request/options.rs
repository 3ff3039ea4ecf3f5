//! Options of a plan: the caller's knowledge of a frame in advance.

use std::collections::BTreeMap;

use wgpu_types::{TextureFormat, TextureUsages};

use crate::request::objective::Objective;
use crate::request::texture_size::TextureSize;

/// The caller's options for planning a frame: viewport, imported textures, sizes from CPU passes, aliasing and
/// objective of the order.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlanOptions {
    /// The width and height of the rendered image in texels.
    pub viewport: [u32; 2],
    /// Descriptions of textures that the host owns, by resource name. A texture that is not listed is assumed to be as
    /// the pipeline declares it.
    pub imports: BTreeMap<String, ImportDescriptor>,
    /// The sizes that CPU passes publish with blackboard data, by `DATA.SIZE` (data name and size name). Sizes not
    /// listed keep their initial values.
    pub data_sizes: BTreeMap<String, u32>,
    /// Whether transient resources may share memory when their lifetimes do not overlap.
    pub aliasing: bool,
    /// Whether textures and buffers that outlive a frame can be copied from and to. A host can then save and restore
    /// their contents, and a plan that copies them out keeps their memory.
    pub copyable_state: bool,
    /// The objective by which the execution order of the passes is chosen.
    pub objective: Objective,
}

impl PlanOptions {
    /// Creates options for a viewport in texels, with no imports described, aliasing on, and passes in document order.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            viewport: [width, height],
            imports: BTreeMap::new(),
            data_sizes: BTreeMap::new(),
            aliasing: true,
            copyable_state: false,
            objective: Objective::Declaration,
        }
    }

    umbragraph_pipeline::setters! {
        /// Sets the viewport in texels.
        viewport: [u32; 2],
        /// Sets the sizes that CPU passes publish with blackboard data, by `DATA.SIZE` (data name and size name).
        data_sizes: BTreeMap<String, u32>,
        /// Sets whether transient resources may share memory.
        aliasing: bool,
        /// Sets whether textures and buffers that outlive a frame can be copied from and to.
        copyable_state: bool,
        /// Sets the objective by which the execution order of the passes is chosen.
        objective: Objective,
    }
}

/// A texture that the host owns: its format, its size and the usages that it was created with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ImportDescriptor {
    /// The texture format.
    pub format: TextureFormat,
    /// The size of the texture.
    pub size: TextureSize,
    /// The usages that the texture was created with.
    pub usages: TextureUsages,
}

impl ImportDescriptor {
    /// Describes a texture of a format and size that allows every usage.
    pub fn new(format: TextureFormat, size: TextureSize) -> Self {
        Self { format, size, usages: TextureUsages::all() }
    }

    /// Sets the usages that the texture was created with.
    #[must_use]
    pub fn usages(self, usages: TextureUsages) -> Self {
        Self { usages, ..self }
    }
}

impl PlanOptions {
    /// Returns the format and usages of each imported texture, by resource name.
    pub(crate) fn import_kinds(&self) -> BTreeMap<String, (TextureFormat, TextureUsages)> {
        let kind = |import: &ImportDescriptor| (import.format, import.usages);
        self.imports.iter().map(|(name, import)| (name.clone(), kind(import))).collect()
    }
}
