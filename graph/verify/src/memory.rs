//! Checks the placement of resources: as few objects as possible, compatible, and never shared by two resources that
//! are alive together.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use wgpu_types::{BufferUsages, TextureUsages};

use crate::regions::extents;
use crate::violation::{ViolationKind as Kind, Violations};
use umbragraph_compiler::{Physical, PhysicalBuffer, PhysicalTexture, Plan, PlanOptions, PlannedResource};
use umbragraph_pipeline::language::{Lifetime, TextureShape};
use umbragraph_pipeline::pipeline::{IndexRange, ResourceKind, SubresourceRange, Usage};
use umbragraph_pipeline::work::ResourceHandle;

/// The actual uses of a resource: its first and last position, usages and extents.
struct Used {
    first: usize,
    last: usize,
    textures: TextureUsages,
    buffers: BufferUsages,
    highest_mip: u32,
    highest_layer: u32,
    highest_byte: u64,
}

/// The state of the check of physical resources.
struct Memory<'a> {
    plan: &'a Plan,
    options: &'a PlanOptions,
    /// The physical resources of earlier history frames that no pass reads, which exist all the same.
    spare: &'a BTreeSet<Physical>,
    /// The transient resources that a toggle can leave unwritten.
    conditional: HashSet<ResourceHandle>,
    /// For each physical resource, the resources that share it: the positions of the first and last pass that uses
    /// each, and its name.
    aliases: BTreeMap<Physical, Vec<(usize, usize, &'a str)>>,
    violations: &'a mut Violations,
}

/// Checks the physical resources of a plan: placement, lifetimes, usages and sums of bytes.
///
/// `spare` are the physical resources of earlier history frames that no pass reads, which exist all the same.
pub(crate) fn check(
    plan: &Plan,
    options: &PlanOptions,
    spare: &BTreeSet<Physical>,
    violations: &mut Violations,
) {
    let used = used(plan);
    let mut handles: Vec<&ResourceHandle> = used.keys().collect();
    handles.sort_unstable();
    for handle in &handles {
        let name = &plan.pipeline.resource(**handle).name;
        if plan.resources.get(name).is_none_or(|planned| planned.handle != **handle) {
            violations.add(Kind::ResourceMissing, format!("\"{name}\" is used but not planned"));
        }
    }
    let (conditional, aliases) = (conditional(plan), BTreeMap::new());
    let mut memory = Memory { plan, options, spare, conditional, aliases, violations };
    for (name, planned) in &plan.resources {
        let known =
            plan.pipeline.resources.get(planned.handle.index()).filter(|resource| resource.name == *name);
        let (Some(resource), Some(used)) = (known, used.get(&planned.handle)) else {
            memory
                .violations
                .add(Kind::ResourceUnused, format!("\"{name}\" is planned, but no pass uses it"));
            continue;
        };
        if resource.lifetime() != planned.lifetime {
            memory
                .violations
                .add(Kind::NameWrong, format!("\"{name}\" has another lifetime than the plan says"));
        }
        if (planned.first, planned.last) != (used.first, used.last) {
            let message = format!(
                "\"{name}\" is used from {} to {}, not from {} to {}",
                used.first, used.last, planned.first, planned.last
            );
            memory.violations.add(Kind::SpanWrong, message);
        }
        memory.check_place(name, planned, used);
        if matches!(planned.physical, Physical::Texture(_) | Physical::Buffer(_)) {
            memory.aliases.entry(planned.physical).or_default().push((used.first, used.last, name));
        }
    }
    for (name, planned) in &plan.resources {
        if planned.conditional != memory.conditional.contains(&planned.handle) {
            let message = format!("the plan is wrong about whether a toggle leaves \"{name}\" unwritten");
            memory.violations.add(Kind::ToggleWrong, message);
        }
    }
    let bound = memory.check_sharing();
    memory.check_sums(bound);
}

impl Memory<'_> {
    fn check_place(&mut self, name: &str, planned: &PlannedResource, used: &Used) {
        let kind = &self.plan.pipeline.resource(planned.handle).kind;
        let right = match (kind, planned.lifetime, planned.physical) {
            (ResourceKind::Data(_), _, Physical::Blackboard) => true,
            (ResourceKind::Data(_), ..) => false,
            (_, Lifetime::Imported, physical) => physical == Physical::Imported,
            (ResourceKind::Texture(_), _, Physical::Texture(_))
            | (ResourceKind::Buffer(_), _, Physical::Buffer(_)) => true,
            _ => false,
        };
        if !right {
            self.violations
                .add(Kind::PlaceWrong, format!("\"{name}\" cannot stand at {:?}", planned.physical));
            return;
        }
        let volume = matches!(kind, ResourceKind::Texture(texture) if texture.view_dimension == Some(TextureShape::D3));
        if let Some(size) = planned.size
            && (used.highest_mip >= size.mips || (!volume && used.highest_layer >= size.layers))
        {
            self.violations
                .add(Kind::SubresourceMissing, format!("\"{name}\" is used beyond its mips or layers"));
        }
        if matches!(kind, ResourceKind::Buffer(_)) && used.highest_byte > planned.bytes {
            self.violations.add(Kind::SubresourceMissing, format!("\"{name}\" is used beyond its bytes"));
        }
        // The place, and whether it is of the class and has the usages.
        let (place, found) = match planned.physical {
            Physical::Texture(index) => {
                let judge = |texture: &PhysicalTexture| {
                    let is_alike = planned.format == Some(texture.format)
                        && planned.size == Some(texture.size)
                        && texture.volume == volume;
                    (is_alike, texture.usages.contains(used.textures))
                };
                (format!("texture {index}"), self.plan.textures.get(index).map(judge))
            }
            Physical::Buffer(index) => {
                let judge = |buffer: &PhysicalBuffer| {
                    let is_alike =
                        planned.bytes <= buffer.bytes && class(planned.bytes) == class(buffer.bytes);
                    (is_alike, buffer.usages.contains(used.buffers))
                };
                (format!("buffer {index}"), self.plan.buffers.get(index).map(judge))
            }
            Physical::Imported => {
                let differs = self.options.imports.get(name).is_some_and(|told| {
                    planned.format != Some(told.format)
                        || planned.size != Some(told.size)
                        || !told.usages.contains(used.textures)
                });
                if differs {
                    let message = format!("\"{name}\" is used otherwise than the host's texture allows");
                    self.violations.add(Kind::ImportMisused, message);
                }
                return;
            }
            Physical::Blackboard => return,
        };
        let Some((is_alike, has_usages)) = found else {
            let message = format!("\"{name}\" stands at {place}, which is not there");
            return self.violations.add(Kind::PlaceMissing, message);
        };
        if !is_alike {
            let larger = if matches!(planned.physical, Physical::Buffer(_)) { ", or larger" } else { "" };
            let message = format!("\"{name}\" is not of the class of {place}{larger}");
            self.violations.add(Kind::CompatibilityMismatch, message);
        }
        if !has_usages {
            self.violations.add(Kind::UsageMissing, format!("{place} lacks a usage that \"{name}\" needs"));
        }
    }

    /// Checks the resources that share memory; returns the lower bound on bytes that no sharing can go below.
    fn check_sharing(&mut self) -> u64 {
        let plan = self.plan;
        for list in self.aliases.values_mut() {
            list.sort_unstable();
            for pair in list.windows(2) {
                let ((_, end, first), (start, _, second)) = (pair[0], pair[1]);
                if start <= end {
                    let message = format!("\"{first}\" and \"{second}\" share memory while both are alive");
                    self.violations.add(Kind::Overlap, message);
                }
            }
            let lasting = list.iter().find(|(.., name)| {
                plan.resources[*name].lifetime != Lifetime::Transient || !self.options.aliasing
            });
            if let (true, Some((.., name))) = (list.len() > 1, lasting) {
                self.violations
                    .add(Kind::SharedThoughLasting, format!("\"{name}\" shares memory, though it may not"));
            }
        }
        for list in self.aliases.values().filter(|list| list.len() > 1) {
            let first =
                list.iter().find(|(.., name)| self.conditional.contains(&plan.resources[*name].handle));
            if let Some((.., name)) = first {
                let message = format!("\"{name}\" shares memory, though a toggle can leave it unwritten");
                self.violations.add(Kind::SharedThoughConditional, message);
            }
        }
        let textures = (0..plan.textures.len()).map(Physical::Texture);
        for place in textures.chain((0..plan.buffers.len()).map(Physical::Buffer)) {
            if !self.aliases.contains_key(&place) && !self.spare.contains(&place) {
                self.violations.add(Kind::PhysicalUnused, format!("{place:?} stands for nothing"));
            }
        }
        self.check_buffer_bytes();
        self.check_minimal()
    }

    /// Checks that each physical buffer is as large as the largest resource that it holds.
    fn check_buffer_bytes(&mut self) {
        for (place, list) in &self.aliases {
            let Physical::Buffer(index) = place else { continue };
            let Some(buffer) = self.plan.buffers.get(*index) else { continue };
            let max = list.iter().map(|(.., name)| self.plan.resources[*name].bytes).max().unwrap_or(0);
            if buffer.bytes != max {
                let message = format!(
                    "buffer {index} has {} bytes, and the largest that it stands for {max}",
                    buffer.bytes
                );
                self.violations.add(Kind::CompatibilityMismatch, message);
            }
        }
    }

    /// Checks that no compatibility class has more physical resources than are alive at once; returns the lower bound
    /// on bytes.
    fn check_minimal(&mut self) -> u64 {
        let plan = self.plan;
        // Classes by what wgpu would be told at creation.
        let mut classes: BTreeMap<String, CompatibilityClass> = BTreeMap::new();
        let mut bound = 0u64;
        for (place, list) in &self.aliases {
            let class = match place {
                Physical::Texture(index) => plan.textures.get(*index).map(|one| {
                    let like = format!("{:?} {:?} {:?}", one.format, one.size, one.view_format);
                    (like, one.volume, one.usages.bits())
                }),
                Physical::Buffer(index) => {
                    let like = |one: &PhysicalBuffer| format!("up to 2^{} bytes", class(one.bytes));
                    plan.buffers.get(*index).map(|one| (like(one), false, one.usages.bits()))
                }
                _ => None,
            };
            let transient = list.iter().all(|(.., name)| {
                let planned = &plan.resources[*name];
                planned.lifetime == Lifetime::Transient && !self.conditional.contains(&planned.handle)
            });
            let bytes = |name: &str| plan.resources[name].bytes;
            let Some(class) = class.filter(|_| transient && self.options.aliasing) else {
                // What shares no memory takes its bytes whatever else there is.
                bound = list.iter().fold(bound, |bound, (.., name)| bound.saturating_add(bytes(name)));
                continue;
            };
            let class = classes.entry(format!("{class:?}")).or_default();
            class.created += 1;
            for (first, last, name) in list {
                class.add(*first, *last, bytes(name));
            }
        }
        for (name, mut class) in classes {
            let (peak, bytes) = class.peaks();
            bound = bound.saturating_add(bytes);
            if class.created > peak {
                let created = class.created;
                self.violations.add(
                    Kind::NotMinimal,
                    format!("{created} resources of the class {name} are created, {peak} are alive at once"),
                );
            }
        }
        bound
    }

    fn check_sums(&mut self, bound: u64) {
        let plan = self.plan;
        let created: u64 =
            plan.textures.iter().map(|one| one.bytes).chain(plan.buffers.iter().map(|one| one.bytes)).sum();
        let own = |planned: &&PlannedResource| {
            matches!(planned.physical, Physical::Texture(_) | Physical::Buffer(_))
        };
        let kept = self.spare.iter().filter_map(|place| match place {
            Physical::Texture(at) => plan.textures.get(*at).map(|texture| texture.bytes),
            Physical::Buffer(at) => plan.buffers.get(*at).map(|buffer| buffer.bytes),
            Physical::Imported | Physical::Blackboard => None,
        });
        let kept: u64 = kept.sum();
        let apart: u64 = kept + plan.resources.values().filter(own).map(|planned| planned.bytes).sum::<u64>();
        for (what, stated, right) in [
            ("bytes", plan.bytes, created),
            ("bytes_without_aliasing", plan.bytes_without_aliasing, apart),
            ("bytes_bound", plan.bytes_bound, bound.saturating_add(kept)),
        ] {
            if stated != right {
                self.violations.add(Kind::BytesWrong, format!("{what} is {stated}, but should be {right}"));
            }
        }
        let mut all = CompatibilityClass::default();
        for planned in plan.resources.values().filter(own) {
            let lasts = planned.lifetime != Lifetime::Transient || !self.options.aliasing;
            let (first, last) =
                if lasts { (0, plan.passes.len().saturating_sub(1)) } else { (planned.first, planned.last) };
            all.add(first, last, planned.bytes);
        }
        let peak = all.peaks().1.saturating_add(kept);
        if plan.bytes_peak != peak {
            self.violations
                .add(Kind::BytesWrong, format!("bytes_peak is {}, but should be {peak}", plan.bytes_peak));
        }
        // Sharing never costs bytes, and nothing goes below its bound.
        if created > apart || plan.bytes_bound > created || plan.bytes_bound < peak {
            let message = format!(
                "{created} bytes are created: not between the bound, {}, and what nothing shares, {apart}",
                plan.bytes_bound
            );
            self.violations.add(Kind::BytesWrong, message);
        }
        for texture in plan.textures.iter().filter(|texture| texture.bytes == 0) {
            self.violations.add(Kind::BytesWrong, format!("the texture \"{}\" has no bytes", texture.label));
        }
    }
}

/// Returns the index of the last mip or layer of a range.
fn last(run: IndexRange<u32>) -> u32 {
    u32::try_from(run.end().saturating_sub(1)).unwrap_or(u32::MAX)
}

fn used(plan: &Plan) -> HashMap<ResourceHandle, Used> {
    let mut used: HashMap<ResourceHandle, Used> = HashMap::new();
    for (at, planned) in plan.passes.iter().enumerate() {
        for one in plan.pipeline.pass(planned.handle).accesses() {
            let entry = used.entry(one.resource).or_insert(Used {
                first: at,
                last: at,
                textures: TextureUsages::empty(),
                buffers: BufferUsages::empty(),
                highest_mip: 0,
                highest_layer: 0,
                highest_byte: 0,
            });
            entry.last = at;
            entry.textures |= needed(one.usage).0;
            entry.buffers |= needed(one.usage).1;
            entry.highest_mip = entry.highest_mip.max(one.range.mip.map_or(0, last));
            entry.highest_layer = entry.highest_layer.max(one.range.layer.map_or(0, last));
            entry.highest_byte = entry.highest_byte.max(one.range.bytes.map_or(0, IndexRange::end));
        }
    }
    used
}

/// Returns the usages that a texture and a buffer must be created with for an access.
fn needed(usage: Usage) -> (TextureUsages, BufferUsages) {
    use BufferUsages as B;
    use TextureUsages as T;
    match usage {
        Usage::Sampled => (T::TEXTURE_BINDING, B::empty()),
        Usage::Uniform => (T::empty(), B::UNIFORM),
        Usage::StorageRead | Usage::StorageWrite | Usage::StorageReplace | Usage::StorageReadWrite => {
            (T::STORAGE_BINDING, B::STORAGE)
        }
        Usage::Vertex => (T::empty(), B::VERTEX),
        Usage::Index => (T::empty(), B::INDEX),
        Usage::Indirect => (T::empty(), B::INDIRECT),
        Usage::CopySource => (T::COPY_SRC, B::COPY_SRC),
        Usage::CopyDestination | Usage::CopyDestinationLoad | Usage::CopyDestinationRows => {
            (T::COPY_DST, B::COPY_DST)
        }
        Usage::BlackboardRead | Usage::BlackboardWrite => (T::empty(), B::empty()),
        _ if usage.is_attachment() => (T::RENDER_ATTACHMENT, B::empty()),
        _ => (T::empty(), B::empty()),
    }
}

/// Returns the transient resources with a subresource range whose first writer a toggle can switch off.
fn conditional(plan: &Plan) -> HashSet<ResourceHandle> {
    let mut always: HashMap<ResourceHandle, Vec<SubresourceRange>> = HashMap::new();
    let mut conditional = HashSet::new();
    for planned in &plan.passes {
        let pass = plan.pipeline.pass(planned.handle);
        for one in pass.accesses().iter().filter(|one| one.usage.writes()) {
            let written = always.entry(one.resource).or_default();
            let covers = |below: &SubresourceRange| {
                extents(*below).into_iter().zip(extents(one.range)).all(|(below, own)| match (below, own) {
                    (None, _) => true,
                    (Some(below), Some(own)) => below.0 <= own.0 && own.1 <= below.1,
                    (Some(_), None) => false,
                })
            };
            if plan.pipeline.resource(one.resource).lifetime() != Lifetime::Transient {
                continue;
            }
            if pass.condition.is_none() {
                written.push(one.range);
            } else if !written.iter().any(covers) {
                conditional.insert(one.resource);
            }
        }
    }
    conditional
}

/// Returns the size class of a buffer: the exponent of the next power of two of its bytes.
fn class(bytes: u64) -> u32 {
    u64::BITS - bytes.saturating_sub(1).leading_zeros()
}

/// The resources of one compatibility class, which may share memory.
#[derive(Default)]
struct CompatibilityClass {
    /// The number of physical resources in the class.
    created: usize,
    /// The starts (`true`) and ends (`false`) of lifetimes with their bytes. A lifetime starts at twice its first
    /// position and ends just after twice its last, so that touching lifetimes overlap.
    events: Vec<(usize, bool, u64)>,
}

impl CompatibilityClass {
    /// Adds a resource that is alive from position `first` to position `last` in execution order.
    fn add(&mut self, first: usize, last: usize, bytes: u64) {
        self.events.extend([(2 * first, true, bytes), (2 * last + 1, false, bytes)]);
    }

    /// Returns the maximum number of resources alive at once, and the maximum number of bytes alive at once.
    fn peaks(&mut self) -> (usize, u64) {
        self.events.sort_unstable();
        let (mut alive, mut max) = ((0usize, 0u64), (0, 0));
        for (_, begins, bytes) in &self.events {
            alive = if *begins {
                (alive.0 + 1, alive.1.saturating_add(*bytes))
            } else {
                (alive.0.saturating_sub(1), alive.1.saturating_sub(*bytes))
            };
            max = (max.0.max(alive.0), max.1.max(alive.1));
        }
        max
    }
}
