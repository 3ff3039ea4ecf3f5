//! Bind groups of what the module itself binds.
//!
//! A bind group is made at its first use with a buffer of the block pool, and again only when an imported texture that
//! it binds is another one. Groups that bind nothing are bound as empty groups, since a layout may have holes.

use super::Statistics;
use super::pipelines::Layouts;
use super::textures::Textures;
use super::uniforms::{self, PassPlaces};
use crate::compiler::{Physical, Plan};
use crate::work::{BoundSlot, Draw, SlotSource, Work};

/// The bind groups of one pass that the module fills.
pub(super) struct Groups {
    groups: Vec<Group>,
}

struct Group {
    index: u32,
    layout: wgpu::BindGroupLayout,
    /// Positions in the pass's slots.
    slots: Vec<usize>,
    /// Whether a texture of the host's own is among them.
    imports: bool,
    /// Whether the block `view` is among them.
    view: Option<usize>,
    /// For each buffer of the pool the bind group, with the generation of the imports.
    made: Vec<Option<(u64, wgpu::BindGroup)>>,
}

impl Groups {
    pub(super) fn new(plan: &Plan, work: &Work, layouts: &Layouts) -> Self {
        let is_scene = matches!(work, Work::Render(render) if matches!(render.draw, Draw::Scene(_)));
        let slots = uniforms::slots(work);
        let groups = layouts
            .groups
            .iter()
            .enumerate()
            .filter(|(index, _)| !(is_scene && *index >= 2))
            .map(|(index, layout)| {
                let own: Vec<usize> = (0..slots.len()).filter(|at| slots[*at].group == index as u32).collect();
                let imports = own.iter().any(|at| match &slots[*at].source {
                    SlotSource::Texture(view) => {
                        plan.resource(view.resource).is_some_and(|resource| resource.physical == Physical::Imported)
                    }
                    _ => false,
                });
                let view = own.iter().copied().find(|at| matches!(slots[*at].source, SlotSource::View(_)));
                Group { index: index as u32, layout: layout.clone(), slots: own, imports, view, made: Vec::new() }
            })
            .collect();
        Self { groups }
    }

    /// Makes what is missing for a buffer of the pool.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn prepare(
        &mut self,
        device: &wgpu::Device,
        plan: &Plan,
        name: &str,
        slots: &[BoundSlot],
        places: &PassPlaces,
        pool: Option<&(usize, wgpu::Buffer)>,
        textures: &mut Textures,
        statistics: &mut Statistics,
    ) {
        let pool_index = pool.map_or(0, |(index, _)| *index);
        for group in &mut self.groups {
            let generation = if group.imports { textures.generation } else { 0 };
            if group.made.len() <= pool_index {
                group.made.resize_with(pool_index + 1, || None);
            }
            if group.made[pool_index].as_ref().is_some_and(|(made, _)| *made == generation) {
                continue;
            }
            let mut owned: Vec<(u32, Owned)> = Vec::new();
            for at in &group.slots {
                let slot = &slots[*at];
                let resource = match &slot.source {
                    SlotSource::Texture(view) => textures.view(plan, *view, statistics).map(Owned::View),
                    SlotSource::Sampler(sampler) => Some(Owned::Sampler(textures.sampler(device, *sampler))),
                    SlotSource::Buffer(resource) => textures.buffer(plan, *resource).cloned().map(|buffer| Owned::Buffer(buffer, 0, None)),
                    _ => places.get(*at).copied().flatten().zip(pool).map(|(place, (_, buffer))| {
                        Owned::Buffer(buffer.clone(), place.offset, wgpu::BufferSize::new(place.size))
                    }),
                };
                owned.extend(resource.map(|resource| (slot.binding, resource)));
            }
            let entries: Vec<wgpu::BindGroupEntry<'_>> =
                owned.iter().map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.binding() }).collect();
            let made = device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(name), layout: &group.layout, entries: &entries });
            statistics.bind_groups += 1;
            group.made[pool_index] = Some((generation, made));
        }
    }

    /// The bind groups, each with its index and, where it holds the block `view`, the position of that slot.
    pub(super) fn made(&self, pool_index: usize) -> impl Iterator<Item = (u32, &wgpu::BindGroup, Option<usize>)> {
        self.groups.iter().filter_map(move |group| {
            let (_, made) = group.made.get(pool_index)?.as_ref()?;
            Some((group.index, made, group.view))
        })
    }
}

enum Owned {
    View(wgpu::TextureView),
    Sampler(wgpu::Sampler),
    Buffer(wgpu::Buffer, u64, Option<wgpu::BufferSize>),
}

impl Owned {
    fn binding(&self) -> wgpu::BindingResource<'_> {
        match self {
            Owned::View(view) => wgpu::BindingResource::TextureView(view),
            Owned::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
            Owned::Buffer(buffer, offset, size) => {
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: *offset, size: *size })
            }
        }
    }
}
