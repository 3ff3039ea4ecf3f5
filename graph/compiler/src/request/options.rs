//! Options of a plan: the caller's knowledge of a frame in advance.

use std::collections::BTreeMap;

use wgpu_types::{TextureFormat, TextureUsages};

use crate::request::objective::Objective;
use crate::request::texture_size::TextureSize;

/// The caller's knowledge of a frame in advance: viewport, imports, objective.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlanOptions {
    /// Width and height of the picture in texels.
    pub viewport: [u32; 2],
    /// The host's own textures by the name of the resource that stands for them. One that is not told is taken to be
    /// as the pipeline declares it.
    pub imports: BTreeMap<String, ImportDescriptor>,
    /// The sizes that blackboard data publishes, as `DATA.SIZE`, where they are other than their initial values.
    pub data_sizes: BTreeMap<String, u32>,
    /// Whether transient resources may share memory.
    pub aliasing: bool,
    /// The objective of the order of the passes.
    pub objective: Objective,
}

impl PlanOptions {
    /// A viewport, no imports told, with aliasing, in the order of the document.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            viewport: [width, height],
            imports: BTreeMap::new(),
            data_sizes: BTreeMap::new(),
            aliasing: true,
            objective: Objective::Declaration,
        }
    }

    umbragraph_pipeline::setters! {
        /// Sets the viewport in texels.
        viewport: [u32; 2],
        /// Sets the sizes that blackboard data publishes.
        data_sizes: BTreeMap<String, u32>,
        /// Whether transient resources may share memory.
        aliasing: bool,
        /// Sets the objective by which passes are ordered.
        objective: Objective,
    }
}

/// A texture of the host's own: its format, its size and the usages that it was created with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ImportDescriptor {
    /// Its format.
    pub format: TextureFormat,
    /// Its size.
    pub size: TextureSize,
    /// Its usages; all without it.
    pub usages: TextureUsages,
}

impl ImportDescriptor {
    /// A texture of a format and a size, which allows every usage.
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
    /// The formats and usages of the host's own textures.
    pub(crate) fn import_kinds(&self) -> BTreeMap<String, (TextureFormat, TextureUsages)> {
        let kind = |import: &ImportDescriptor| (import.format, import.usages);
        self.imports.iter().map(|(name, import)| (name.clone(), kind(import))).collect()
    }
}
