//! [`Options`]: what a pipeline is planned with.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::compiler::{Import, Objective, PlanOptions};
use crate::wgpu_types;

/// What a pipeline is planned with: the size of the picture, values of parameters and features, what the host's own
/// textures are.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Options {
    pub(super) plan: PlanOptions,
    pub(super) preset: Option<String>,
    pub(super) parameters: Vec<(String, String)>,
    pub(super) features: Vec<(String, String)>,
    pub(super) exposed: BTreeSet<String>,
}

/// A value of a parameter or a feature: a number, a boolean, a word, a list of numbers.
pub trait Setting {
    /// The value as JSON.
    fn json(&self) -> String;
}

impl<T: Serialize> Setting for T {
    fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

impl Options {
    /// A picture of a width and a height in texels, with the values that the pipeline says.
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            plan: PlanOptions::new(width, height),
            preset: None,
            parameters: Vec::new(),
            features: Vec::new(),
            exposed: BTreeSet::new(),
        }
    }

    /// With a preset of the pipeline. What is set beside it counts over it.
    #[must_use]
    pub fn preset(mut self, name: impl Into<String>) -> Self {
        self.preset = Some(name.into());
        self
    }

    /// With a value of a parameter.
    #[must_use]
    pub fn set(mut self, parameter: impl Into<String>, value: impl Setting) -> Self {
        self.parameters.push((parameter.into(), value.json()));
        self
    }

    /// With a value of a feature: on or off, or a word.
    #[must_use]
    pub fn feature(mut self, feature: impl Into<String>, value: impl Setting) -> Self {
        self.features.push((feature.into(), value.json()));
        self
    }

    /// With a texture or buffer that the host looks at between frames (`Executor::texture`, `Executor::buffer`), as if the
    /// pipeline said that it is `exposed`: it shares memory with no other then.
    #[must_use]
    pub fn expose(mut self, resource: impl Into<String>) -> Self {
        self.exposed.insert(resource.into());
        self
    }

    /// With the format and the size of a texture of the host's own, where they are not as the pipeline declares them.
    #[must_use]
    pub fn import(mut self, resource: impl Into<String>, import: Import) -> Self {
        self.plan.imports.insert(resource.into(), import);
        self
    }

    /// With the format, the size and the usages of a texture of the host's own.
    #[cfg(feature = "gpu")]
    #[must_use]
    pub fn import_texture(self, resource: impl Into<String>, texture: &crate::wgpu::Texture) -> Self {
        let (resource, (import, usages)) = (resource.into(), import_of(texture));
        self.import(resource.clone(), import).import_usages(resource, usages)
    }

    /// With the usages that a texture of the host's own was created with; without it everything is allowed.
    #[must_use]
    pub fn import_usages(mut self, resource: impl Into<String>, usages: wgpu_types::TextureUsages) -> Self {
        self.plan.import_usages.insert(resource.into(), usages);
        self
    }

    /// With sizes that CPU passes want (`Executor::wanted_sizes`).
    #[must_use]
    pub fn data_sizes(mut self, sizes: BTreeMap<String, u32>) -> Self {
        self.plan.data_sizes = sizes;
        self
    }

    /// Whether transient resources may share memory; they may without it.
    #[must_use]
    pub fn aliasing(mut self, may: bool) -> Self {
        self.plan.aliasing = may;
        self
    }

    /// With an objective of the order of the passes.
    #[must_use]
    pub fn objective(mut self, objective: Objective) -> Self {
        self.plan.objective = objective;
        self
    }
}

/// What a texture of the host's own is.
#[cfg(feature = "gpu")]
pub(super) fn import_of(texture: &crate::wgpu::Texture) -> (Import, wgpu_types::TextureUsages) {
    let size = texture.size();
    let size = crate::compiler::TextureSize {
        width: size.width,
        height: size.height,
        layers: size.depth_or_array_layers,
        mips: texture.mip_level_count(),
        samples: texture.sample_count(),
    };
    (Import::new(texture.format(), size), texture.usage())
}
