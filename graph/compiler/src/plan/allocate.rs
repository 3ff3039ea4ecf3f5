//! Gives every resource its place on the device.
//!
//! wgpu has no placed memory, so sharing means that one whole texture or buffer stands for several resources of its
//! class, one after the other. Which ones, `lifetime` decides; this file makes the physical resources and sums bytes.
//! For textures, whose classes have one size, the bytes are the bound; of buffers of different sizes more may be
//! needed, which is what was created beside the bound.
//!
//! Cost: linear in resources but for sorting them by name and by start.

use crate::memory::history;
use crate::memory::lifetime::{AllocationRequest, Assignment, assign, by_start};
use crate::memory::physical::{Physical, PhysicalBuffer, PhysicalTexture};
use crate::plan::planned::{Fixed, Plan, PlannedResource};
use crate::resources::resolved::{Descriptor, ResolvedResources, TextureProperties};
use crate::resources::view_shape;
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::ResourceKind;
use wgpu_types::TextureViewDimension;

/// The length in bytes that a debug label can reach before an ellipsis replaces further resource names.
const LABEL_BYTES: usize = 120;

/// Fills in the planned resources, physical textures and buffers, histories and byte sums of a plan.
pub(crate) fn allocate(plan: &mut Plan, resolved: &ResolvedResources<'_>) {
    (plan.bytes, plan.bytes_without_aliasing) = (0, 0);
    plan.textures.clear();
    plan.buffers.clear();
    let fixed = plan.fixed.clone();
    let Fixed { spans, conditional, aliasing, .. } = &*fixed;
    let pipeline = plan.pipeline.clone();
    let (mut wanted, mut requests) = (Vec::new(), Vec::new());
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
        wanted.push((handle, descriptor));
        requests.push(AllocationRequest { class, bytes: properties.bytes, first, last });
    }
    (plan.bytes_bound, plan.bytes_peak) = peak.finish();
    let Assignment { places, bytes } = assign(&requests);
    let mut created: Vec<Physical> = Vec::new();
    let mut physical = vec![Physical::Blackboard; pipeline.resources.len()];
    for at in by_start(&requests) {
        let ((handle, descriptor), place) = (wanted[at], places[at]);
        let name = &pipeline.resource(handle).name;
        if place == created.len() {
            plan.bytes += bytes[place];
            created.push(create(plan, descriptor, bytes[place]));
        }
        physical[handle.index()] = created[place];
        match created[place] {
            Physical::Texture(index) => append(&mut plan.textures[index].label, name),
            Physical::Buffer(index) => append(&mut plan.buffers[index].label, name),
            Physical::Imported | Physical::Blackboard => {}
        }
    }
    plan.histories = history::plan(resolved, &physical);
    let planned = pipeline.resource_handles().filter_map(|handle| {
        let (properties, (first, last)) = (resolved.get(handle)?, spans[handle.index()]?);
        let resource = pipeline.resource(handle);
        let lifetime = resource.lifetime();
        let texture = properties.texture();
        let physical = match resource.kind {
            ResourceKind::Data(_) => Physical::Blackboard,
            _ if lifetime == Lifetime::Imported => Physical::Imported,
            _ => physical[handle.index()],
        };
        let planned = PlannedResource {
            lifetime,
            first,
            last,
            physical,
            format: texture.map(|texture| texture.format),
            view_format: texture.and_then(|texture| texture.view_format),
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

/// Adds a physical texture or buffer with an empty label to the plan, and returns its index.
fn create(plan: &mut Plan, descriptor: Descriptor, bytes: u64) -> Physical {
    let label = String::new();
    match descriptor {
        Descriptor::Texture(TextureProperties { format, size, volume, usages, view_format, only_array }) => {
            let spare_layer = only_array && view_shape::of(size) != TextureViewDimension::D2Array;
            let texture =
                PhysicalTexture { label, format, size, volume, usages, view_format, spare_layer, bytes };
            plan.textures.push(texture);
            Physical::Texture(plan.textures.len() - 1)
        }
        Descriptor::Buffer { usages, .. } => {
            plan.buffers.push(PhysicalBuffer { label, bytes, usages });
            Physical::Buffer(plan.buffers.len() - 1)
        }
    }
}

/// A counter of the bytes alive at each pass.
struct Peak {
    /// For each compatibility class: positions in execution order, with the bytes that become alive there, or minus the
    /// bytes whose lifetime has ended.
    changes: Vec<Vec<(usize, i128)>>,
    /// For each position in execution order: the change of the bytes alive over all classes.
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

    /// Returns the sum of the peaks of all classes, and the peak over all classes together, in bytes.
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
