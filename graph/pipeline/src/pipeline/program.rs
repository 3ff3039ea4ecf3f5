//! Programs: a template with its axes chosen, in all the variants that the host's meshes can need.
//!
//! Variants of one program share one interface: its bindings are the union over the variants (a binding that a variant
//! does not use stays in the layout, so that bind groups fit every variant), and two variants that see one binding
//! differently are an error.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::pipeline::survey::EntryPoints;
use crate::work::{BoundSlot, SlotSource};
use umbragraph_shaders::{AxisValues, EntryPoint, ShaderModule, Stage, TypeLayout, VertexInput};
use umbragraph_text::diagnostic::{Diagnostic, codes};
use umbragraph_text::source::Span;
use wgpu_types::{BindingType, SamplerBindingType, TextureSampleType};

/// A shader template with chosen axis values, in all variants that mesh properties require.
#[derive(Clone, Debug)]
pub struct Program {
    /// The template's name.
    pub template: String,
    /// The axis values that the pipeline chose. All other axes have their defaults, except the axes in `from_target`.
    pub axes: AxisValues,
    /// The names of axes that follow the first color attachment of the pass, because the pipeline chose no value for
    /// them. Their value is `true` if the attachment's format has no `-srgb` suffix.
    pub from_target: Vec<String>,
    /// The variants; the first is the variant without any mesh property.
    pub variants: Vec<ProgramVariant>,
    /// The union of the variants' bindings, sorted by group and binding number.
    pub bindings: Vec<ProgramBinding>,
}

/// One variant of a program.
#[derive(Clone, Debug)]
pub struct ProgramVariant {
    /// The mesh properties that the variant is for, sorted.
    pub properties: Vec<String>,
    /// The shader module, validated by naga.
    pub module: Arc<ShaderModule>,
    /// The names of the entry points that the pass chooses, by stage.
    pub entry_points: EntryPoints,
}

/// One binding of a program.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramBinding {
    /// The index of the bind group.
    pub group: u32,
    /// The name of the binding in the shader.
    pub name: String,
    /// The WGSL type of the binding.
    pub type_name: String,
    /// The entry in the bind group layout; its visibility is the union over the variants.
    pub entry: wgpu_types::BindGroupLayoutEntry,
    /// The memory layout of a buffer's contents; `None` for textures and samplers.
    pub block: Option<TypeLayout>,
}

impl Program {
    /// Combines variants into one program.
    ///
    /// # Errors
    /// Returns a diagnostic for each binding that two variants declare differently.
    pub(super) fn new(
        template: String,
        axes: AxisValues,
        variants: Vec<ProgramVariant>,
        place: Span,
    ) -> Result<Self, Vec<Diagnostic>> {
        let mut union: BTreeMap<(u32, u32), (ProgramBinding, String)> = BTreeMap::new();
        let mut diagnostics = Vec::new();
        for variant in &variants {
            let label = if variant.properties.is_empty() {
                "the plain variant".to_owned()
            } else {
                variant.properties.join(" + ")
            };
            for binding in &variant.module.reflection.bindings {
                let new = ProgramBinding {
                    group: binding.group,
                    name: binding.name.clone(),
                    type_name: binding.type_name.clone(),
                    entry: binding.entry,
                    block: binding.block.clone(),
                };
                match union.get_mut(&(binding.group, binding.binding)) {
                    None => {
                        union.insert((binding.group, binding.binding), (new, label.clone()));
                    }
                    Some((known, first)) => {
                        if (&known.name, known.entry.ty, &known.block)
                            != (&new.name, new.entry.ty, &new.block)
                        {
                            let declared =
                                |one: &ProgramBinding| format!("\"{}: {}\"", one.name, one.type_name);
                            let (one, other) = (declared(known), declared(&new));
                            let (group, binding) = (binding.group, binding.binding);
                            let message = format!(
                                "binding {binding} of group {group} is {one} in {first} and {other} in {label}"
                            );
                            let help = format!(
                                "let the variants of {template} declare it alike, or at different bindings"
                            );
                            let diagnostic = Diagnostic::error(codes::VARIANT_INTERFACE, place, message);
                            diagnostics.push(diagnostic.help(help));
                        }
                        known.entry.visibility |= new.entry.visibility;
                    }
                }
            }
        }
        let bindings = union.into_values().map(|(binding, _)| binding).collect();
        if diagnostics.is_empty() {
            Ok(Self { template, axes, from_target: Vec::new(), variants, bindings })
        } else {
            Err(diagnostics)
        }
    }

    /// The shader module of the variant for meshes without any property.
    pub fn plain(&self) -> &ShaderModule {
        &self.variants[0].module
    }

    /// Returns the binding with this name, or `None` if there is none.
    pub fn binding(&self, name: &str) -> Option<&ProgramBinding> {
        self.bindings.iter().find(|binding| binding.name == name)
    }

    /// Returns the binding with this bind group and binding number, or `None` if there is none.
    pub fn binding_at(&self, group: u32, binding: u32) -> Option<&ProgramBinding> {
        self.bindings.iter().find(|known| known.group == group && known.entry.binding == binding)
    }

    /// The type of a binding in the layout of a bind group with these slots. Nearest samplers, and textures that only
    /// nearest samplers read, become non-filtering.
    pub fn bound_type(&self, binding: &ProgramBinding, slots: &[BoundSlot]) -> BindingType {
        let place = (binding.group, binding.entry.binding);
        let is_nearest = |(group, binding): (u32, u32)| {
            let slot = slots.iter().find(|slot| (slot.group, slot.binding) == (group, binding));
            matches!(slot.map(|slot| &slot.source), Some(SlotSource::Sampler(sampler)) if sampler.is_nearest())
        };
        let entry_points = self.variants.iter().flat_map(|one| &one.module.reflection.entry_points);
        let mut pairs = entry_points.flat_map(|entry| &entry.sampling_pairs);
        match binding.entry.ty {
            BindingType::Sampler(SamplerBindingType::Filtering) if is_nearest(place) => {
                BindingType::Sampler(SamplerBindingType::NonFiltering)
            }
            BindingType::Texture {
                sample_type: TextureSampleType::Float { filterable: true },
                view_dimension,
                multisampled,
            } if pairs.all(|(texture, sampler)| *texture != place || is_nearest(*sampler)) => {
                let sample_type = TextureSampleType::Float { filterable: false };
                BindingType::Texture { sample_type, view_dimension, multisampled }
            }
            declared => declared,
        }
    }

    /// Returns `true` if a full-screen pass is certain to write every texel with every variant.
    pub fn covers(&self) -> bool {
        let covers =
            |variant: &ProgramVariant, stage| variant.entry_point(stage).is_some_and(|entry| entry.covers);
        self.variants.iter().all(|one| covers(one, Stage::Vertex) && covers(one, Stage::Fragment))
    }

    /// The variant for a mesh with these properties; properties for which the program has no variants are ignored.
    pub fn variant(&self, properties: &[&str]) -> &ProgramVariant {
        let known = |name: &str| {
            self.variants.iter().any(|variant| variant.properties.iter().any(|known| known == name))
        };
        let mut wanted: Vec<&str> = properties.iter().copied().filter(|name| known(name)).collect();
        wanted.sort_unstable();
        self.variants.iter().find(|variant| variant.properties == wanted).unwrap_or(&self.variants[0])
    }
}

impl ProgramVariant {
    /// The vertex attributes that the variant's vertex stage reads.
    pub fn vertex_inputs(&self) -> &[VertexInput] {
        self.entry_point(Stage::Vertex).map_or(&[], |entry| &entry.inputs)
    }

    /// The entry point of a stage: the one that the pass names, or else the first. `None` if there is none.
    pub fn entry_point(&self, stage: Stage) -> Option<&EntryPoint> {
        let named = self.entry_points.get(&stage);
        let is_meant = |entry: &&EntryPoint| named.is_none_or(|name| *name == entry.name);
        self.module.reflection.entry_points.iter().filter(|entry| entry.stage == stage).find(is_meant)
    }
}
