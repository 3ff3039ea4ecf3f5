//! The blocks of one record: where they lie in a buffer, and their bytes.
//!
//! All blocks that the module fills (blackboard data, views, constants) lie in one buffer, each at an offset that is
//! fixed when the plan is instantiated. A pass that draws several views has one `view` block for each, selected by a
//! dynamic offset. A record packs all blocks into one staging vector and uploads the used part: there is room for the
//! maximum number of views, but a frame has few. The vector contains the constants from the start.
//!
//! A uniform block is padded to whole 16 bytes, which some devices want; a storage block is exactly as long as its
//! values, since a shader can ask for the length of an array at its end.
//!
//! Limits: the blocks of a plan together have less than 4 GiB, since dynamic offsets are 32 bits wide.

use std::ops::Range;

use umbragraph_compiler::CpuPasses;
use umbragraph_compiler::{PackedBlock, Plan, PlannedPass};
use umbragraph_pipeline::data::{BlackboardData, View};
use umbragraph_pipeline::diagnostic::{Diagnostic, Place as DiagnosticPlace, codes};
use umbragraph_pipeline::pipeline::ResourceKind;
use umbragraph_pipeline::work::{BlockLayout, BoundSlot, ResourceHandle, SlotSource, Work};

/// The byte range of a uniform or storage block in the buffer of blocks; for the block `view`, the range of the first
/// view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) offset: u64,
    pub(crate) size: u64,
    /// Bytes from one view's block to the next.
    pub(crate) stride: u64,
}

impl Place {
    /// The dynamic offset, in bytes, of the block of a view.
    pub(crate) fn view_offset(self, view: usize) -> u32 {
        u32::try_from(self.stride * view as u64).unwrap_or(0)
    }
}

/// The uniform and storage blocks of all passes of a plan, and their layout in one buffer.
pub(crate) struct Blocks {
    /// The size of the buffer, in bytes.
    pub(crate) size: u64,
    /// The block of each slot, by pass of the plan; `None` if the executor does not fill the slot.
    places: Vec<Vec<Option<Place>>>,
    /// The byte offsets of blackboard data in each block, parallel to `places`.
    layouts: Vec<Vec<Option<BlockLayout>>>,
    staging: Vec<u8>,
    /// The byte ranges of `staging` that the frame being recorded uses, in ascending order.
    used: Vec<Range<u64>>,
    view: BlackboardData,
}

/// The gap between two uploads, in bytes, up to which one joint upload is cheaper than two.
const SMALL_GAP: u64 = 16 << 10;

impl Blocks {
    /// Lays out the blocks of a plan.
    ///
    /// # Errors
    /// Blocks that need more bytes than a buffer of the device can have.
    pub(crate) fn new(plan: &Plan, limits: &wgpu::Limits) -> Result<Self, Diagnostic> {
        let alignment =
            limits.min_uniform_buffer_offset_alignment.max(limits.min_storage_buffer_offset_alignment);
        let alignment = u64::from(alignment).max(16);
        let mut size = 0u64;
        let place_of = |pass: &PlannedPass| -> Vec<Option<Place>> {
            let work = plan.pipeline.pass(pass.handle).work();
            let place = |slot: &BoundSlot| {
                let bytes = block_bytes(plan, work, slot)?;
                let count = if matches!(slot.source, SlotSource::View) { max_views(plan, work) } else { 1 };
                let stride = bytes.next_multiple_of(alignment);
                let place = Place { offset: size, size: bytes, stride };
                size = size.saturating_add(stride.saturating_mul(count));
                Some(place)
            };
            slots(work).iter().map(place).collect()
        };
        let places: Vec<_> = plan.passes.iter().map(place_of).collect();
        let layouts = plan.passes.iter().map(|planned| {
            let work = plan.pipeline.pass(planned.handle).work();
            let program = work.program().map(|program| plan.pipeline.program(program));
            slots(work).iter().map(|slot| plan.pipeline.block_layout(program?, slot)).collect()
        });
        let allowed = limits.max_buffer_size.min(u64::from(u32::MAX));
        if size > allowed {
            let message =
                format!("the blocks of \"{}\" have {size} bytes; the device allows {allowed}", plan.name);
            let diagnostic = Diagnostic::error(codes::DEVICE_LIMIT, DiagnosticPlace::Nowhere, message);
            return Err(diagnostic.help("let CPU passes publish fewer views or values"));
        }
        let mut blocks = Self {
            size,
            layouts: layouts.collect(),
            places,
            staging: vec![0; usize::try_from(size).unwrap_or(0)],
            used: Vec::new(),
            view: BlackboardData::new(View::shape()),
        };
        for (pass, planned) in plan.passes.iter().enumerate() {
            planned.blocks.iter().for_each(|block| blocks.replace(plan, pass, block));
        }
        Ok(blocks)
    }

    /// The blocks of the pass at an index of the plan, one entry per slot.
    pub(crate) fn places(&self, pass: usize) -> &[Option<Place>] {
        self.places.get(pass).map(Vec::as_slice).unwrap_or_default()
    }

    /// Replaces the constants in a block of the pass at an index of the plan.
    pub(crate) fn replace(&mut self, plan: &Plan, pass: usize, block: &PackedBlock) {
        let Some((planned, places)) = plan.passes.get(pass).zip(self.places.get(pass)) else { return };
        let slots = slots(plan.pipeline.pass(planned.handle).work());
        let at = slots.iter().position(|slot| (slot.group, slot.binding) == (block.group, block.binding));
        let place = at.and_then(|at| places.get(at).copied().flatten());
        if let Some(bytes) = place.and_then(|place| range(&mut self.staging, place.offset, place.size)) {
            bytes.iter_mut().zip(&block.bytes).for_each(|(to, from)| *to = *from);
        }
    }

    /// Packs the blocks of one record. Returns the byte offset in the buffer and the bytes of each upload.
    pub(crate) fn pack(&mut self, plan: &Plan, cpu_passes: &CpuPasses) -> impl Iterator<Item = (u64, &[u8])> {
        let of = |handle: ResourceHandle| cpu_passes.seen(handle);
        self.used.clear();
        for ((planned, places), layouts) in plan.passes.iter().zip(&self.places).zip(&self.layouts) {
            if !cpu_passes.switches().runs(plan, planned.handle) {
                continue;
            }
            let work = plan.pipeline.pass(planned.handle).work();
            for ((slot, place), layout) in slots(work).iter().zip(places).zip(layouts) {
                let Some(place) = place else { continue };
                let count = match &slot.source {
                    SlotSource::View => {
                        let views = scene_views(work).and_then(of).map(BlackboardData::views);
                        views.map_or(1, |views| views.len().max(1) as u64)
                    }
                    _ => 1,
                };
                let end = place.offset + place.stride * (count - 1) + place.size;
                match self.used.last_mut() {
                    Some(last) if place.offset <= last.end + SMALL_GAP => last.end = last.end.max(end),
                    _ => self.used.push(place.offset..end),
                }
                let Some(layout) = layout else { continue };
                match &slot.source {
                    SlotSource::Data { data, .. } => {
                        if let (Some(data), Some(block)) =
                            (of(data.resource), range(&mut self.staging, place.offset, place.size))
                        {
                            layout.pack(data, block);
                        }
                    }
                    SlotSource::View => {
                        let views =
                            scene_views(work).and_then(of).map(BlackboardData::views).unwrap_or_default();
                        for (at, view) in views.iter().enumerate() {
                            view.publish(&mut self.view);
                            let offset = place.offset + place.stride * at as u64;
                            if let Some(block) = range(&mut self.staging, offset, place.size) {
                                layout.pack(&self.view, block);
                            }
                        }
                    }
                    _ => {}
                }
            }
        }
        let staging = &self.staging;
        self.used.iter().filter_map(move |bytes| {
            let range = usize::try_from(bytes.start).ok()?..usize::try_from(bytes.end).ok()?;
            Some((bytes.start, staging.get(range)?))
        })
    }
}

/// The binding slots of a pass that the executor fills; empty for a pass without a shader.
pub(crate) fn slots(work: &Work) -> &[BoundSlot] {
    work.bound().map_or(&[], |(_, slots)| slots)
}

/// The blackboard resource whose views a pass draws; `None` if it draws no meshes.
fn scene_views(work: &Work) -> Option<ResourceHandle> {
    work.scene().map(|scene| scene.views.resource)
}

fn max_views(plan: &Plan, work: &Work) -> u64 {
    let views = scene_views(work).map(|views| &plan.pipeline.resource(views).kind);
    match views {
        Some(ResourceKind::Data(Some(shape))) => u64::from(shape.max_views).max(1),
        _ => 1,
    }
}

/// Returns the size in bytes of the block that is bound to a slot; `None` if the executor fills no block for the slot.
fn block_bytes(plan: &Plan, work: &Work, slot: &BoundSlot) -> Option<u64> {
    let program = plan.pipeline.program(work.program()?);
    let binding = program.binding_at(slot.group, slot.binding);
    let bytes = u64::from(plan.pipeline.block_bytes(program, slot)?);
    Some(match binding.map(|binding| binding.entry.ty) {
        Some(wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Storage { .. }, .. }) => {
            bytes.next_multiple_of(4)
        }
        _ => bytes.next_multiple_of(16),
    })
}

fn range(bytes: &mut [u8], offset: u64, size: u64) -> Option<&mut [u8]> {
    let start = usize::try_from(offset).ok()?;
    bytes.get_mut(start..start.checked_add(usize::try_from(size).ok()?)?)
}
