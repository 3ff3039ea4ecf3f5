//! Gives every resource its place on the device.
//!
//! wgpu has no placed memory, so sharing means that one whole texture or buffer stands for several resources of its
//! class, one after the other. Which ones, `lifetime` decides; this file makes the physical resources and sums bytes.
//!
//! Cost: linear in resources but for sorting them by name and by start.

use super::facts::{Descriptor, Facts};
use super::history;
use super::lifetime::{Want, assign};
use super::plan::{Fixed, Physical, PhysicalBuffer, PhysicalTexture, Plan, PlannedResource};
use crate::language::Lifetime;
use crate::pipeline::ResourceKind;
use crate::work::ResourceHandle;

/// The most bytes that a label grows to before the rest of its names is left out.
const LABEL_BYTES: usize = 120;

/// Fills the resources of a plan.
pub(super) fn allocate(plan: &mut Plan, facts: &Facts<'_>) {
    let fixed = plan.fixed.clone();
    let Fixed { spans, conditional, aliasing, .. } = &*fixed;
    let pipeline = plan.pipeline.clone();
    let (mut textures, mut buffers) = (Kind::default(), Kind::default());
    let mut peak = Peak::new(&facts.class_bytes, plan.passes.len());
    let end = plan.passes.len().saturating_sub(1);
    for handle in pipeline.resource_handles() {
        let Some(fact) = facts.get(handle) else { continue };
        // Earlier frames are there whether something reads them or not: each becomes the next one.
        let span = spans[handle.index()].or(pipeline.resource(handle).history.map(|_| (0, end)));
        let Some((first, last)) = span else { continue };
        let (Some(class), Some(descriptor)) = (fact.class, fact.descriptor) else { continue };
        plan.bytes_without_aliasing += fact.bytes;
        // What outlives the frame holds its bytes all the time.
        let lives = pipeline.resource(handle).lifetime() != Lifetime::Transient || !*aliasing;
        let (from, to) = if lives { (0, end) } else { (first, last) };
        peak.add(class, fact.bytes, from, to);
        let kind = if matches!(descriptor, Descriptor::Texture(_)) { &mut textures } else { &mut buffers };
        kind.handles.push(handle);
        kind.wants.push(Want { class, first, last });
    }
    (plan.bytes_bound, plan.bytes_peak) = peak.finish();
    let mut physical = vec![Physical::Host; pipeline.resources.len()];
    for (handle, index) in textures.assigned() {
        physical[handle.index()] = Physical::Texture(index);
        if let Some(texture) = facts.texture(handle) {
            let bytes = facts.get(handle).map_or(0, |fact| fact.bytes);
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
    for (handle, index) in buffers.assigned() {
        physical[handle.index()] = Physical::Buffer(index);
        let fact = facts.get(handle);
        if let Some(Descriptor::Buffer { usages, .. }) = fact.and_then(|fact| fact.descriptor) {
            let class = fact.and_then(|fact| fact.class);
            let bytes = class.map_or(0, |class| facts.class_bytes[class]);
            if index == plan.buffers.len() {
                plan.bytes += bytes;
                plan.buffers.push(PhysicalBuffer { label: String::new(), bytes, usages });
            }
            append(&mut plan.buffers[index].label, &pipeline.resource(handle).name);
        }
    }
    plan.histories = history::plan(facts, &physical);
    let planned = pipeline.resource_handles().filter_map(|handle| {
        let (fact, (first, last)) = (facts.get(handle)?, spans[handle.index()]?);
        let resource = pipeline.resource(handle);
        let lifetime = resource.lifetime();
        let texture = fact.texture();
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
            bytes: fact.bytes,
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
    wants: Vec<Want>,
}

impl Kind {
    /// Each with its physical resource, by the start of their lifetimes.
    fn assigned(&self) -> Vec<(ResourceHandle, usize)> {
        let assigned = assign(&self.wants);
        let mut by_start: Vec<usize> = (0..self.wants.len()).collect();
        by_start.sort_by_key(|at| (self.wants[*at].first, *at));
        by_start.into_iter().map(|at| (self.handles[at], assigned[at])).collect()
    }
}

/// Counts what is alive at each pass.
struct Peak {
    /// For each class the bytes of one, and at which positions its count changes.
    changes: Vec<(u64, Vec<(usize, i64)>)>,
    /// Bytes that begin or have ended at each position, over all classes.
    all: Vec<i128>,
}

impl Peak {
    fn new(classes: &[u64], passes: usize) -> Self {
        let changes = classes.iter().map(|bytes| (*bytes, Vec::new())).collect();
        Self { changes, all: vec![0; passes + 1] }
    }

    fn add(&mut self, class: usize, bytes: u64, first: usize, last: usize) {
        self.changes[class].1.extend([(first, 1), (last + 1, -1)]);
        self.all[first] += i128::from(bytes);
        self.all[last + 1] -= i128::from(bytes);
    }

    /// The sum over the classes of their peaks, and the peak over all together.
    fn finish(self) -> (u64, u64) {
        let mut bound = 0;
        for (bytes, mut changes) in self.changes {
            // At one position what ends comes first.
            changes.sort_unstable();
            let (mut count, mut most) = (0i64, 0i64);
            for (_, change) in changes {
                count += change;
                most = most.max(count);
            }
            bound += bytes * most.unsigned_abs();
        }
        let mut alive = 0i128;
        let peak = self.all.into_iter().map(|change| {
            alive += change;
            alive
        });
        (bound, u64::try_from(peak.max().unwrap_or(0)).unwrap_or(u64::MAX))
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
