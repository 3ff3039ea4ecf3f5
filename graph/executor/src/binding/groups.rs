//! Bind groups of the module's own resources.
//!
//! A plan's instantiation fixes the bindings of a group, with four exceptions: the buffer of blocks, which differs for
//! each record in flight; views of the host's own textures; the copies of histories, which rotate; and resources that
//! toggles replace. A group is made for a new combination of these, and kept while the combination recurs.

use super::blocks::Place;
use crate::memory::histories::Turn;
use crate::memory::imports::ImportedView;
use crate::memory::resources::{Buffer, Fallbacks, Resources, Viewed};
use crate::objects::creation::Creation;
use umbragraph_compiler::Switches;
use umbragraph_pipeline::pipeline::IndexRange;
use umbragraph_pipeline::work::ResourceHandle;

/// The number of records after which an unused bind group is dropped.
const KEPT_RECORDS: u64 = 256;

/// One bind group of a pass.
pub(crate) struct Group {
    index: u32,
    layout: wgpu::BindGroupLayout,
    entries: Vec<(u32, Bound)>,
    has_blocks: bool,
    imports: Vec<ImportedView>,
    /// The resource that each switchable binding has in the current record.
    chosen: Vec<ResourceHandle>,
    /// The indices of the histories whose frames are bound.
    histories: Vec<usize>,
    /// The block `view`, selected by a dynamic offset.
    view: Option<Place>,
    made: Vec<Made>,
    /// The index of the bind group for the current record among the created ones.
    current: usize,
}

/// The resource of a binding.
pub(crate) enum Bound {
    View(Viewed),
    Sampler(wgpu::Sampler),
    /// A byte range of a buffer.
    Buffer(Buffer, IndexRange<u64>),
    Block(Place),
    /// The blocks `view`, one for each view.
    ViewBlock(Place),
    /// One of several resources, selected by the toggles that switch the writers of the first one.
    Switched(Fallbacks<Bound>),
}

impl Bound {
    /// Creates the binding of a resource and its fallbacks. A resource without fallbacks is bound directly.
    pub(crate) fn switched(mut all: Fallbacks<Bound>) -> Option<Self> {
        if all.0.len() > 1 { Some(Bound::Switched(all)) } else { all.0.pop().map(|(_, bound)| bound) }
    }

    /// The binding that the toggles select.
    fn choose(&self, switches: &Switches) -> Option<&(ResourceHandle, Bound)> {
        let Bound::Switched(all) = self else { return None };
        all.seen(switches)
    }

    /// All alternatives of the binding.
    fn alternatives(&self) -> impl Iterator<Item = &Bound> {
        let (one, all) = match self {
            Bound::Switched(all) => (None, all.0.as_slice()),
            one => (Some(one), [].as_slice()),
        };
        one.into_iter().chain(all.iter().map(|(_, bound)| bound))
    }

    /// The frame of a history that is bound; `None` if the binding is no history.
    fn turn(&self) -> Option<Turn> {
        match self {
            Bound::View(view) => view.turn(),
            Bound::Buffer(buffer, _) => buffer.turn(),
            _ => None,
        }
    }
}

struct Made {
    /// The buffer of blocks.
    blocks: Option<wgpu::Buffer>,
    chosen: Vec<ResourceHandle>,
    imports: Vec<wgpu::TextureView>,
    /// The number of places by which each history had advanced.
    moved: Vec<usize>,
    group: wgpu::BindGroup,
    used: u64,
}

impl Made {
    fn fits(&self, blocks: Option<&wgpu::Buffer>, group: &Group, resources: &Resources) -> bool {
        let imports = self.imports.iter().zip(&group.imports);
        let moved = self.moved.iter().zip(&group.histories);
        self.blocks.as_ref() == blocks
            && self.chosen == group.chosen
            && imports.into_iter().all(|(made, wanted)| resources.imports.view(*wanted) == Some(made))
            && moved.into_iter().all(|(made, history)| resources.histories.moved(*history) == *made)
    }
}

impl Group {
    pub(crate) fn new(index: u32, layout: wgpu::BindGroupLayout, entries: Vec<(u32, Bound)>) -> Self {
        let all = || entries.iter().flat_map(|(_, bound)| bound.alternatives());
        let has_blocks = all().any(|bound| matches!(bound, Bound::Block(_) | Bound::ViewBlock(_)));
        let view = all().find_map(|bound| match bound {
            Bound::ViewBlock(place) => Some(*place),
            _ => None,
        });
        let imports = all().filter_map(|bound| match bound {
            Bound::View(Viewed::Imported(view)) => Some(*view),
            _ => None,
        });
        let imports = imports.collect();
        let mut histories: Vec<usize> = all().filter_map(Bound::turn).map(|turn| turn.history).collect();
        histories.sort_unstable();
        histories.dedup();
        let (chosen, made) = (Vec::new(), Vec::new());
        Self { index, layout, entries, has_blocks, imports, chosen, histories, view, made, current: 0 }
    }

    /// Creates the bind group for a record, unless it exists.
    pub(crate) fn prepare(
        &mut self,
        creation: &mut Creation<'_>,
        label: &str,
        blocks: Option<&wgpu::Buffer>,
        resources: &Resources,
        switches: &Switches,
        record: u64,
    ) {
        self.chosen.clear();
        let chosen = self.entries.iter().filter_map(|(_, bound)| bound.choose(switches));
        self.chosen.extend(chosen.map(|(resource, _)| *resource));
        let blocks = blocks.filter(|_| self.has_blocks);
        let found = self.made.iter().position(|made| made.fits(blocks, self, resources));
        self.current = found.unwrap_or_else(|| {
            self.made.retain(|made| made.used + KEPT_RECORDS >= record);
            let made = self.make(creation, label, blocks, resources, switches, record);
            self.made.push(made);
            self.made.len() - 1
        });
        self.made[self.current].used = record;
    }

    fn make(
        &self,
        creation: &mut Creation<'_>,
        label: &str,
        blocks: Option<&wgpu::Buffer>,
        resources: &Resources,
        switches: &Switches,
        record: u64,
    ) -> Made {
        let block = |place: &Place| {
            Some(wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer: blocks?,
                offset: place.offset,
                size: wgpu::BufferSize::new(place.size),
            }))
        };
        let entries = self.entries.iter().filter_map(|(binding, bound)| {
            let bound = bound.choose(switches).map_or(bound, |(_, chosen)| chosen);
            let resource = match bound {
                Bound::Switched(_) => return None,
                Bound::View(view) => wgpu::BindingResource::TextureView(view.get(resources)?),
                Bound::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
                Bound::Buffer(buffer, bytes) => wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: buffer.get(resources)?,
                    offset: bytes.first,
                    size: wgpu::BufferSize::new(bytes.count),
                }),
                Bound::Block(place) | Bound::ViewBlock(place) => block(place)?,
            };
            Some(wgpu::BindGroupEntry { binding: *binding, resource })
        });
        let entries: Vec<_> = entries.collect();
        let group = creation.bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout: &self.layout,
            entries: &entries,
        });
        let imports = self.imports.iter().filter_map(|view| resources.imports.view(*view).cloned());
        let moved = self.histories.iter().map(|history| resources.histories.moved(*history));
        Made {
            blocks: blocks.cloned(),
            chosen: self.chosen.clone(),
            imports: imports.collect(),
            moved: moved.collect(),
            group,
            used: record,
        }
    }

    /// Drops all created bind groups, since some may have been rejected by the device.
    pub(crate) fn forget(&mut self) {
        self.made.clear();
    }

    /// The index of the bind group, the bind group of the current record, and the dynamic offset of a view in bytes.
    fn bound(&self, view: usize) -> Option<(u32, &wgpu::BindGroup, Option<u32>)> {
        let made = self.made.get(self.current)?;
        Some((self.index, &made.group, self.view.map(|place| place.view_offset(view))))
    }
}

/// Sets the bind groups of a pass in a render pass, for the view at an index.
pub(crate) fn bind_render(groups: &[Group], pass: &mut wgpu::RenderPass<'_>, view: usize) {
    for (index, group, offset) in groups.iter().filter_map(|group| group.bound(view)) {
        pass.set_bind_group(index, group, offset.as_slice());
    }
}

/// Sets the bind groups of a pass in a compute pass.
pub(crate) fn bind_compute(groups: &[Group], pass: &mut wgpu::ComputePass<'_>) {
    for (index, group, offset) in groups.iter().filter_map(|group| group.bound(0)) {
        pass.set_bind_group(index, group, offset.as_slice());
    }
}
