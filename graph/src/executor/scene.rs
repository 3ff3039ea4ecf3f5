//! The host's draws: bind groups of materials and objects, and the pass that the host draws into.

use super::Statistics;
use super::pipelines::Layouts;
use crate::data::View;
use crate::draw::{DrawPass, DrawSource, HostInterface, HostSlotKind, PropertySet};
use crate::pipeline::Program;
use crate::work::DrawOrder;

const MATERIAL: u32 = 2;
const OBJECT: u32 = 3;

/// Bind groups 2 and 3 of a pass that draws the host's meshes.
pub(super) struct SceneGroups {
    material: Option<HostGroup>,
    object: Option<HostGroup>,
    /// The bind group of each material.
    materials: Vec<Option<wgpu::BindGroup>>,
    objects: Option<wgpu::BindGroup>,
    /// Bytes from object to object of each block of group 3, in the order of the bindings.
    strides: Vec<u32>,
    generation: Option<u64>,
}

struct HostGroup {
    layout: wgpu::BindGroupLayout,
    /// Binding and name.
    bindings: Vec<(u32, String)>,
}

impl HostGroup {
    /// The bind group of these resources, or `None` if the host lacks one of them.
    fn make(
        &self,
        device: &wgpu::Device,
        label: &str,
        resources: Option<Vec<wgpu::BindingResource<'_>>>,
        statistics: &mut Statistics,
    ) -> Option<wgpu::BindGroup> {
        let entries: Vec<wgpu::BindGroupEntry<'_>> = self
            .bindings
            .iter()
            .zip(resources?)
            .map(|((binding, _), resource)| wgpu::BindGroupEntry { binding: *binding, resource })
            .collect();
        statistics.bind_groups += 1;
        Some(device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout: &self.layout, entries: &entries }))
    }
}

impl SceneGroups {
    pub(super) fn new(program: &Program, layouts: &Layouts, interface: Option<&HostInterface>) -> Self {
        let group = |index: u32| {
            layouts.groups.get(index as usize).map(|layout| HostGroup {
                layout: layout.clone(),
                bindings: program
                    .bindings
                    .iter()
                    .filter(|binding| binding.group == index)
                    .map(|binding| (binding.entry.binding, binding.name.clone()))
                    .collect(),
            })
        };
        let blocks = program.bindings.iter().filter(|binding| binding.group == OBJECT && binding.block.is_some());
        let stride = |name: &str| {
            let slot = interface?.object.iter().find(|slot| slot.name == name)?;
            match slot.kind {
                HostSlotKind::Block { stride, .. } => Some(stride),
                HostSlotKind::Opaque(_) => None,
            }
        };
        Self {
            material: group(MATERIAL),
            object: group(OBJECT),
            materials: Vec::new(),
            objects: None,
            strides: blocks.map(|binding| stride(&binding.name).unwrap_or(0)).collect(),
            generation: None,
        }
    }

    /// Makes the bind groups of the host's materials and objects, where they are not those of the last record.
    pub(super) fn prepare(&mut self, device: &wgpu::Device, name: &str, source: &dyn DrawSource, statistics: &mut Statistics) {
        let generation = source.generation();
        if self.generation == Some(generation) {
            return;
        }
        self.generation = Some(generation);
        self.materials.clear();
        if let Some(group) = &self.material {
            for material in 0..source.material_count() {
                let resources = group.bindings.iter().map(|(_, name)| source.material(material, name)).collect();
                self.materials.push(group.make(device, name, resources, statistics));
            }
        }
        self.objects = self.object.as_ref().and_then(|group| {
            let resources = group.bindings.iter().map(|(_, name)| source.object(name)).collect();
            group.make(device, name, resources, statistics)
        });
    }
}

/// The render pass of one view, as the host sees it.
pub(super) struct ScenePass<'a> {
    pub(super) geometry: &'a str,
    pub(super) filter: &'a str,
    pub(super) view: &'a View,
    pub(super) order: DrawOrder,
    pub(super) pipelines: &'a [(PropertySet, wgpu::RenderPipeline)],
    pub(super) groups: &'a SceneGroups,
    pub(super) pass: &'a mut wgpu::RenderPass<'static>,
    pub(super) offsets: &'a mut Vec<u32>,
}

impl DrawPass for ScenePass<'_> {
    fn geometry(&self) -> &str {
        self.geometry
    }

    fn filter(&self) -> &str {
        self.filter
    }

    fn view(&self) -> &View {
        self.view
    }

    fn order(&self) -> DrawOrder {
        self.order
    }

    fn set_properties(&mut self, properties: PropertySet) -> bool {
        match self.pipelines.iter().find(|(set, _)| *set == properties) {
            Some((_, pipeline)) => {
                self.pass.set_pipeline(pipeline);
                true
            }
            None => false,
        }
    }

    fn set_material(&mut self, material: u32) {
        if let Some(Some(group)) = self.groups.materials.get(material as usize) {
            self.pass.set_bind_group(MATERIAL, group, &[]);
        }
    }

    fn set_object(&mut self, object: u32) {
        if let Some(group) = &self.groups.objects {
            self.offsets.clear();
            self.offsets.extend(self.groups.strides.iter().map(|stride| stride.saturating_mul(object)));
            self.pass.set_bind_group(OBJECT, group, self.offsets);
        }
    }

    fn render_pass(&mut self) -> &mut wgpu::RenderPass<'static> {
        self.pass
    }
}
