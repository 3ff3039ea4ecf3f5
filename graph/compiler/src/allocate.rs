//! Gives every resource its place on the device.
//!
//! wgpu has no placed memory, so sharing means that one whole texture or buffer stands for several resources of its
//! class, one after the other. Which ones, `lifetime` decides; this file makes the physical resources and sums bytes.
//! For textures, whose classes have one size, the bytes are the bound; of buffers of different sizes more may be needed,
//! which is what was created beside the bound.
//!
//! Cost: linear in resources but for sorting them by name and by start.

use super::history;
use super::lifetime::{AllocationRequest, Assignment, assign};
use super::physical::{Physical, PhysicalBuffer, PhysicalTexture};
use super::planned::{Fixed, Plan, PlannedResource};
use super::resolved_resources::{Descriptor, ResolvedResources};
use crate::language::Lifetime;
use crate::pipeline::ResourceKind;
use crate::work::ResourceHandle;

/// The maximum number of bytes that a label grows to before the rest of its names is left out.
const LABEL_BYTES: usize = 120;

/// Fills the resources of a plan.
pub(super) fn allocate(plan: &mut Plan, resolved: &ResolvedResources<'_>) {
    (plan.bytes, plan.bytes_without_aliasing) = (0, 0);
    plan.textures.clear();
    plan.buffers.clear();
    let fixed = plan.fixed.clone();
    let Fixed { spans, conditional, aliasing, .. } = &*fixed;
    let pipeline = plan.pipeline.clone();
    let (mut textures, mut buffers) = (Kind::default(), Kind::default());
    let mut peak = Peak::new(resolved.classes, plan.passes.len());
    let end = plan.passes.len().saturating_sub(1);
    for handle in pipeline.resource_handles() {
        let Some(properties) = resolved.get(handle) else { continue };
        // Earlier frames are there whether something reads them or not: each becomes the next one.
        let span = spans[handle.index()].or(pipeline.resource(handle).history.map(|_| (0, end)));
        let Some((first, last)) = span else { continue };
        let (Some(class), Some(descriptor)) = (properties.class, properties.descriptor) else { continue };
        plan.bytes_without_aliasing += properties.bytes;
        // What outlives the frame holds its bytes all the time.
        let lives = pipeline.resource(handle).lifetime() != Lifetime::Transient || !*aliasing;
        let (from, to) = if lives { (0, end) } else { (first, last) };
        peak.add(class, properties.bytes, from, to);
        let kind = if matches!(descriptor, Descriptor::Texture(_)) { &mut textures } else { &mut buffers };
        kind.handles.push(handle);
        kind.requests.push(AllocationRequest { class, bytes: properties.bytes, first, last });
    }
    (plan.bytes_bound, plan.bytes_peak) = peak.finish();
    let mut physical = vec![Physical::Host; pipeline.resources.len()];
    for (handle, index, bytes) in textures.assigned() {
        physical[handle.index()] = Physical::Texture(index);
        if let Some(texture) = resolved.texture(handle) {
            if index == plan.textures.len() {
                plan.bytes += bytes;
                let (format, size) = (texture.format, texture.size);
                let (volume, usages) = (texture.volume, texture.usages);
                plan.textures.push(PhysicalTexture {
                    label: String::new(),
                    format,
                    size,
                    volume,
                    usages,
                    view_format: texture.view_format,
                    bytes,
                });
            }
            append(&mut plan.textures[index].label, &pipeline.resource(handle).name);
        }
    }
    for (handle, index, bytes) in buffers.assigned() {
        physical[handle.index()] = Physical::Buffer(index);
        let properties = resolved.get(handle);
        if let Some(Descriptor::Buffer { usages, .. }) =
            properties.and_then(|properties| properties.descriptor)
        {
            if index == plan.buffers.len() {
                plan.bytes += bytes;
                plan.buffers.push(PhysicalBuffer { label: String::new(), bytes, usages });
            }
            append(&mut plan.buffers[index].label, &pipeline.resource(handle).name);
        }
    }
    plan.histories = history::plan(resolved, &physical);
    let planned = pipeline.resource_handles().filter_map(|handle| {
        let (properties, (first, last)) = (resolved.get(handle)?, spans[handle.index()]?);
        let resource = pipeline.resource(handle);
        let lifetime = resource.lifetime();
        let texture = properties.texture();
        let physical = match resource.kind {
            ResourceKind::Data(_) => Physical::Host,
            _ if lifetime == Lifetime::Imported => Physical::Imported,
            _ => physical[handle.index()],
        };
        let planned = PlannedResource {
            lifetime,
            first,
            last,
            physical,
            format: texture.map(|texture| texture.format),
            size: texture.map(|texture| texture.size),
            usages: texture.map(|texture| texture.usages),
            bytes: properties.bytes,
            conditional: conditional[handle.index()],
            handle,
        };
        Some((resource.name.clone(), planned))
    });
    plan.resources = planned.collect();
}

/// The textures, or the buffers, that want a place.
#[derive(Default)]
struct Kind {
    handles: Vec<ResourceHandle>,
    requests: Vec<AllocationRequest>,
}

impl Kind {
    /// Each with its physical resource and the bytes of that, by the start of their lifetimes.
    fn assigned(&self) -> Vec<(ResourceHandle, usize, u64)> {
        let Assignment { places, bytes } = assign(&self.requests);
        let mut by_start: Vec<usize> = (0..self.requests.len()).collect();
        by_start.sort_by_key(|at| (self.requests[*at].first, *at));
        by_start.into_iter().map(|at| (self.handles[at], places[at], bytes[places[at]])).collect()
    }
}

/// Counts the bytes that are alive at each pass.
struct Peak {
    /// For each class at which positions how many bytes begin, or have ended.
    changes: Vec<Vec<(usize, i128)>>,
    /// The same over all classes, by position.
    all: Vec<i128>,
}

impl Peak {
    fn new(classes: usize, passes: usize) -> Self {
        Self { changes: vec![Vec::new(); classes], all: vec![0; passes + 1] }
    }

    fn add(&mut self, class: usize, bytes: u64, first: usize, last: usize) {
        let bytes = i128::from(bytes);
        self.changes[class].extend([(first, bytes), (last + 1, -bytes)]);
        self.all[first] += bytes;
        self.all[last + 1] -= bytes;
    }

    /// The sum over the classes of their peaks, and the peak over all together.
    fn finish(self) -> (u64, u64) {
        let peak = |changes: &mut dyn Iterator<Item = i128>| {
            let (mut alive, mut max) = (0i128, 0i128);
            for change in changes {
                alive += change;
                max = max.max(alive);
            }
            u64::try_from(max).unwrap_or(u64::MAX)
        };
        let bound = self.changes.into_iter().fold(0u64, |bound, mut changes| {
            // At one position what ends comes first.
            changes.sort_unstable();
            bound.saturating_add(peak(&mut changes.into_iter().map(|(_, change)| change)))
        });
        (bound, peak(&mut self.all.into_iter()))
    }
}

fn append(label: &mut String, name: &str) {
    match label.len() {
        0 => label.push_str(name),
        length if length + name.len() < LABEL_BYTES => {
            label.push_str(" / ");
            label.push_str(name);
        }
        _ if !label.ends_with('…') => label.push_str(" / …"),
        _ => {}
    }
}
