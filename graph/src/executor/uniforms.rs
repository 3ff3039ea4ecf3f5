//! The blocks of one record: where they lie, and buffers that records in flight do not share.
//!
//! All blocks that the module fills (host data, views, constants) lie in one buffer, each at a place that is fixed when
//! the plan is realized; a pass that draws several views has its `view` block that many times, chosen by a dynamic
//! offset. A record packs all of them into one staging vector and uploads it with one `write_buffer`.
//!
//! `write_buffer` takes effect before the whole submission, so two records in one submission need two buffers. Each
//! record therefore takes a buffer from a pool; the encoder gives it back when the GPU is done with the submission, or
//! when the encoder is dropped without one. The pool grows to the number of records in flight and stays there.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::Statistics;
use crate::compiler::Plan;
use crate::data::HostData;
use crate::pipeline::ResourceKind;
use crate::work::{BlockLayout, BoundSlot, Draw, ResourceHandle, SlotSource, Work};

/// A block in the buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) offset: u64,
    pub(super) size: u64,
}

/// The place of each module-filled slot of one pass, in the order of its slots; `None` for other slots.
pub(super) type PassPlaces = Vec<Option<Place>>;

pub(super) struct Uniforms {
    size: u64,
    stride: u64,
    places: Vec<PassPlaces>,
    staging: Vec<u8>,
    view_data: HostData,
    pool: Vec<(wgpu::Buffer, Arc<AtomicBool>)>,
}

/// Gives a buffer of the pool back, whichever way the encoder ends.
struct GiveBack(Arc<AtomicBool>);

impl Drop for GiveBack {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Release);
    }
}

impl Uniforms {
    pub(super) fn new(device: &wgpu::Device, plan: &Plan) -> Self {
        let limits = device.limits();
        let stride =
            u64::from(limits.min_uniform_buffer_offset_alignment.max(limits.min_storage_buffer_offset_alignment)).max(16);
        let mut size = 0;
        let mut take = |bytes: u64, count: u64| {
            let place = Place { offset: size, size: bytes };
            size += bytes.next_multiple_of(stride) * count;
            Some(place)
        };
        let mut staging: Vec<(u64, Vec<u8>)> = Vec::new();
        let mut places = Vec::new();
        for planned in &plan.passes {
            let pass = plan.pipeline.pass(planned.handle);
            let views = maximum_views(plan, &pass.work).max(1);
            let mut own = Vec::new();
            for slot in slots(&pass.work) {
                let place = match &slot.source {
                    SlotSource::Data { layout, .. } => take(u64::from(layout.size), 1),
                    SlotSource::View(layout) => take(u64::from(layout.size), views),
                    SlotSource::Values(values) => take(u64::from(values.layout.size()), 1),
                    _ => None,
                };
                let block = planned.blocks.iter().find(|block| (block.group, block.binding) == (slot.group, slot.binding));
                if let (Some(place), Some(block)) = (place, block) {
                    staging.push((place.offset, block.bytes.clone()));
                }
                own.push(place);
            }
            places.push(own);
        }
        let mut bytes = vec![0; size as usize];
        for (offset, block) in staging {
            bytes[offset as usize..offset as usize + block.len()].copy_from_slice(&block);
        }
        Self { size, stride, places, staging: bytes, view_data: HostData::new(crate::data::View::shape()), pool: Vec::new() }
    }

    /// The places of a pass's slots.
    pub(super) fn places(&self, pass: usize) -> &PassPlaces {
        &self.places[pass]
    }

    /// The dynamic offset of a view's block.
    pub(super) fn view_offset(&self, place: Place, view: usize) -> u32 {
        (place.size.next_multiple_of(self.stride) * view as u64) as u32
    }

    /// Takes a buffer from the pool for one record; `None` if no pass has a block.
    pub(super) fn take(
        &mut self,
        device: &wgpu::Device,
        encoder: &wgpu::CommandEncoder,
        statistics: &mut Statistics,
    ) -> Option<(usize, wgpu::Buffer)> {
        if self.size == 0 {
            return None;
        }
        let free = self.pool.iter().position(|(_, busy)| !busy.load(Ordering::Acquire));
        let index = free.unwrap_or_else(|| {
            statistics.buffers += 1;
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("umbragraph blocks"),
                size: self.size,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            self.pool.push((buffer, Arc::new(AtomicBool::new(false))));
            self.pool.len() - 1
        });
        let (buffer, busy) = &self.pool[index];
        busy.store(true, Ordering::Release);
        let give_back = GiveBack(busy.clone());
        encoder.on_submitted_work_done(move || drop(give_back));
        Some((index, buffer.clone()))
    }

    /// Packs the blocks of one record and uploads them.
    pub(super) fn upload(&mut self, queue: &wgpu::Queue, buffer: &wgpu::Buffer, plan: &Plan, data: &[Option<HostData>]) {
        let of = |handle: ResourceHandle| data.get(handle.index()).and_then(Option::as_ref);
        for (at, planned) in plan.passes.iter().enumerate() {
            let work = &plan.pipeline.pass(planned.handle).work;
            for (slot, place) in slots(work).iter().zip(&self.places[at]) {
                let Some(place) = place else { continue };
                match &slot.source {
                    SlotSource::Data { resource, layout, .. } => {
                        if let Some(data) = of(*resource) {
                            pack(layout, data, &mut self.staging, place.offset);
                        }
                    }
                    SlotSource::View(layout) => {
                        let views = scene_views(work).and_then(of).map(HostData::views).unwrap_or_default();
                        for (index, view) in views.iter().enumerate() {
                            view.publish(&mut self.view_data);
                            let offset = place.offset + place.size.next_multiple_of(self.stride) * index as u64;
                            pack(layout, &self.view_data, &mut self.staging, offset);
                        }
                    }
                    _ => {}
                }
            }
        }
        queue.write_buffer(buffer, 0, &self.staging);
    }
}

fn pack(layout: &BlockLayout, data: &HostData, staging: &mut [u8], offset: u64) {
    let offset = offset as usize;
    if let Some(block) = staging.get_mut(offset..offset + layout.size as usize) {
        layout.pack(data, block);
    }
}

/// The slots of a pass.
pub(super) fn slots(work: &Work) -> &[BoundSlot] {
    match work {
        Work::Render(render) => match &render.draw {
            Draw::Fullscreen { bindings, .. } => bindings,
            Draw::Scene(scene) => &scene.bindings,
        },
        Work::Compute(compute) => &compute.bindings,
        Work::Host(_) | Work::Copy(_) => &[],
    }
}

fn scene_views(work: &Work) -> Option<ResourceHandle> {
    match work {
        Work::Render(render) => match &render.draw {
            Draw::Scene(scene) => Some(scene.views),
            Draw::Fullscreen { .. } => None,
        },
        _ => None,
    }
}

fn maximum_views(plan: &Plan, work: &Work) -> u64 {
    scene_views(work).map_or(1, |views| match &plan.pipeline.resource(views).kind {
        ResourceKind::Data(Some(shape)) => u64::from(shape.maximum_views),
        _ => 1,
    })
}
