//! Whether the places of resources are right: enough of them, not more than needed, fitting, and never shared by two
//! resources that are alive together.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use wgpu_types::{BufferUsages, TextureUsages};

use super::contents::extents;
use super::{FaultKind, Faults};
use crate::compiler::plan::{Physical, PhysicalBuffer, Plan, PlanOptions, PlannedResource};
use crate::language::{Lifetime, TextureShape};
use crate::pipeline::{Part, ResourceKind, Run, Usage};
use crate::work::ResourceHandle;

/// Where a resource is really used, and how.
struct Used {
    first: usize,
    last: usize,
    textures: TextureUsages,
    buffers: BufferUsages,
    highest_mip: u32,
    highest_layer: u32,
    highest_byte: u64,
}

/// Checks places, spans, usages and sums.
///
/// `spare` are the places of earlier frames that no pass reads, which are there all the same.
pub(super) fn check(plan: &Plan, options: &PlanOptions, spare: &BTreeSet<Physical>, faults: &mut Faults) {
    let used = used(plan);
    let mut handles: Vec<&ResourceHandle> = used.keys().collect();
    handles.sort_unstable();
    for handle in &handles {
        let name = &plan.pipeline.resource(**handle).name;
        if plan.resources.get(name).is_none_or(|planned| planned.handle != **handle) {
            faults.add(FaultKind::ResourceMissing, format!("\"{name}\" is used but not planned"));
        }
    }
    let mut tenants: BTreeMap<Physical, Vec<(usize, usize, &str)>> = BTreeMap::new();
    for (name, planned) in &plan.resources {
        let known =
            plan.pipeline.resources.get(planned.handle.index()).filter(|resource| resource.name == *name);
        let (Some(resource), Some(used)) = (known, used.get(&planned.handle)) else {
            faults.add(FaultKind::ResourceUnused, format!("\"{name}\" is planned, but no pass uses it"));
            continue;
        };
        if resource.lifetime() != planned.lifetime {
            faults.add(FaultKind::NameWrong, format!("\"{name}\" has another lifetime than the plan says"));
        }
        if (planned.first, planned.last) != (used.first, used.last) {
            let message = format!(
                "\"{name}\" is used from {} to {}, not from {} to {}",
                used.first, used.last, planned.first, planned.last
            );
            faults.add(FaultKind::SpanWrong, message);
        }
        check_place(plan, options, name, planned, used, faults);
        if matches!(planned.physical, Physical::Texture(_) | Physical::Buffer(_)) {
            tenants.entry(planned.physical).or_default().push((used.first, used.last, name));
        }
    }
    let conditional = conditional(plan);
    for (name, planned) in &plan.resources {
        if planned.conditional != conditional.contains(&planned.handle) {
            let message = format!("the plan is wrong about whether a toggle leaves \"{name}\" unwritten");
            faults.add(FaultKind::ToggleWrong, message);
        }
    }
    check_sharing(plan, options, &conditional, &mut tenants, spare, faults);
    check_sums(plan, options, spare, faults);
}

/// The last mip or layer of a run.
fn last(run: Run<u32>) -> u32 {
    u32::try_from(run.end().saturating_sub(1)).unwrap_or(u32::MAX)
}

fn used(plan: &Plan) -> HashMap<ResourceHandle, Used> {
    let mut used: HashMap<ResourceHandle, Used> = HashMap::new();
    for (at, planned) in plan.passes.iter().enumerate() {
        for one in &plan.pipeline.pass(planned.handle).uses {
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
            entry.highest_mip = entry.highest_mip.max(one.part.mip.map_or(0, last));
            entry.highest_layer = entry.highest_layer.max(one.part.layer.map_or(0, last));
            entry.highest_byte = entry.highest_byte.max(one.part.bytes.map_or(0, Run::end));
        }
    }
    used
}

/// What wgpu wants a texture, or a buffer, to be created with for a use.
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
        Usage::CopyDestination | Usage::CopyDestinationLoad => (T::COPY_DST, B::COPY_DST),
        Usage::HostRead | Usage::HostWrite => (T::empty(), B::empty()),
        _ if usage.is_attachment() => (T::RENDER_ATTACHMENT, B::empty()),
        _ => (T::empty(), B::empty()),
    }
}

fn check_place(
    plan: &Plan,
    options: &PlanOptions,
    name: &str,
    planned: &PlannedResource,
    used: &Used,
    faults: &mut Faults,
) {
    let kind = &plan.pipeline.resource(planned.handle).kind;
    let right = match (kind, planned.lifetime, planned.physical) {
        (ResourceKind::Data(_), _, Physical::Host) => true,
        (ResourceKind::Data(_), ..) => false,
        (_, Lifetime::Imported, physical) => physical == Physical::Imported,
        (ResourceKind::Texture(_), _, Physical::Texture(_))
        | (ResourceKind::Buffer(_), _, Physical::Buffer(_)) => true,
        _ => false,
    };
    if !right {
        faults.add(FaultKind::PlaceWrong, format!("\"{name}\" cannot stand at {:?}", planned.physical));
        return;
    }
    if let Some(size) = planned.size {
        let volume = matches!(kind, ResourceKind::Texture(texture) if texture.view == Some(TextureShape::D3));
        if used.highest_mip >= size.mips || (!volume && used.highest_layer >= size.layers) {
            faults.add(FaultKind::PartMissing, format!("\"{name}\" is used beyond its mips or layers"));
        }
    }
    if matches!(kind, ResourceKind::Buffer(_)) && used.highest_byte > planned.bytes {
        faults.add(FaultKind::PartMissing, format!("\"{name}\" is used beyond its bytes"));
    }
    match planned.physical {
        Physical::Texture(index) => match plan.textures.get(index) {
            None => faults.add(
                FaultKind::PlaceMissing,
                format!("\"{name}\" stands at texture {index}, which is not there"),
            ),
            Some(texture) => {
                let volume = matches!(kind, ResourceKind::Texture(declared) if declared.view == Some(TextureShape::D3));
                if planned.format != Some(texture.format)
                    || planned.size != Some(texture.size)
                    || texture.volume != volume
                {
                    faults.add(
                        FaultKind::ClassMismatch,
                        format!("\"{name}\" is not of the class of texture {index}"),
                    );
                }
                if !texture.usages.contains(used.textures) {
                    faults.add(
                        FaultKind::UsageMissing,
                        format!("texture {index} lacks a usage that \"{name}\" needs"),
                    );
                }
            }
        },
        Physical::Buffer(index) => match plan.buffers.get(index) {
            None => faults.add(
                FaultKind::PlaceMissing,
                format!("\"{name}\" stands at buffer {index}, which is not there"),
            ),
            Some(buffer) => {
                let class = |bytes: u64| (0..64).find(|power| bytes <= 1u64 << power);
                if planned.bytes > buffer.bytes || class(planned.bytes) != class(buffer.bytes) {
                    faults.add(
                        FaultKind::ClassMismatch,
                        format!("\"{name}\" is not of the class of buffer {index}"),
                    );
                }
                if !buffer.usages.contains(used.buffers) {
                    faults.add(
                        FaultKind::UsageMissing,
                        format!("buffer {index} lacks a usage that \"{name}\" needs"),
                    );
                }
            }
        },
        Physical::Imported => {
            let allowed = options.import_usages.get(name).copied().unwrap_or(TextureUsages::all());
            let told = options.imports.get(name);
            let differs = told
                .is_some_and(|told| planned.format != Some(told.format) || planned.size != Some(told.size));
            if !allowed.contains(used.textures) || differs {
                faults.add(
                    FaultKind::ImportMisused,
                    format!("\"{name}\" is used otherwise than the host's texture allows"),
                );
            }
        }
        Physical::Host => {}
    }
}

/// The transient resources of which some part is first written by a pass that can be off.
fn conditional(plan: &Plan) -> HashSet<ResourceHandle> {
    let mut always: HashMap<ResourceHandle, Vec<Part>> = HashMap::new();
    let mut conditional = HashSet::new();
    for planned in &plan.passes {
        let pass = plan.pipeline.pass(planned.handle);
        for one in pass.uses.iter().filter(|one| one.usage.writes()) {
            let written = always.entry(one.resource).or_default();
            let covers = |below: &Part| {
                extents(*below).into_iter().zip(extents(one.part)).all(|(below, own)| match (below, own) {
                    (None, _) => true,
                    (Some(below), Some(own)) => below.0 <= own.0 && own.1 <= below.1,
                    (Some(_), None) => false,
                })
            };
            if plan.pipeline.resource(one.resource).lifetime() != Lifetime::Transient {
                continue;
            }
            if pass.condition.is_none() {
                written.push(one.part);
            } else if !written.iter().any(covers) {
                conditional.insert(one.resource);
            }
        }
    }
    conditional
}

fn check_sharing(
    plan: &Plan,
    options: &PlanOptions,
    conditional: &HashSet<ResourceHandle>,
    tenants: &mut BTreeMap<Physical, Vec<(usize, usize, &str)>>,
    spare: &BTreeSet<Physical>,
    faults: &mut Faults,
) {
    for list in tenants.values_mut() {
        list.sort_unstable();
        for pair in list.windows(2) {
            let ((_, end, first), (start, _, second)) = (pair[0], pair[1]);
            if start <= end {
                faults.add(
                    FaultKind::Overlap,
                    format!("\"{first}\" and \"{second}\" share memory while both are alive"),
                );
            }
        }
        let lasting = list
            .iter()
            .find(|(.., name)| plan.resources[*name].lifetime != Lifetime::Transient || !options.aliasing);
        if let (true, Some((.., name))) = (list.len() > 1, lasting) {
            faults
                .add(FaultKind::SharedThoughLasting, format!("\"{name}\" shares memory, though it may not"));
        }
    }
    for list in tenants.values().filter(|list| list.len() > 1) {
        let first = list.iter().find(|(.., name)| conditional.contains(&plan.resources[*name].handle));
        if let Some((.., name)) = first {
            faults.add(
                FaultKind::SharedThoughConditional,
                format!("\"{name}\" shares memory, though a toggle can leave it unwritten"),
            );
        }
    }
    let textures = (0..plan.textures.len()).map(Physical::Texture);
    for place in textures.chain((0..plan.buffers.len()).map(Physical::Buffer)) {
        if !tenants.contains_key(&place) && !spare.contains(&place) {
            faults.add(FaultKind::PhysicalUnused, format!("{place:?} stands for nothing"));
        }
    }
    check_buffer_bytes(plan, options, conditional, tenants, faults);
    check_minimal(plan, options, conditional, tenants, faults);
}

/// A buffer is as large as the largest resource of its class: of those with its usages that round up to the same power
/// of two. What shares no memory is as large as it is.
fn check_buffer_bytes(
    plan: &Plan,
    options: &PlanOptions,
    conditional: &HashSet<ResourceHandle>,
    tenants: &BTreeMap<Physical, Vec<(usize, usize, &str)>>,
    faults: &mut Faults,
) {
    let mut largest: HashMap<(u32, u32), (u64, Vec<usize>)> = HashMap::new();
    for (place, list) in tenants {
        let Physical::Buffer(index) = place else { continue };
        let Some(buffer) = plan.buffers.get(*index) else { continue };
        let most = list.iter().map(|(.., name)| plan.resources[*name].bytes).max().unwrap_or(0);
        let shares = options.aliasing
            && list.iter().all(|(.., name)| {
                let planned = &plan.resources[*name];
                planned.lifetime == Lifetime::Transient && !conditional.contains(&planned.handle)
            });
        if shares {
            let class = (buffer.usages.bits(), u64::BITS - most.saturating_sub(1).leading_zeros());
            let entry = largest.entry(class).or_default();
            entry.0 = entry.0.max(most);
            entry.1.push(*index);
        } else if buffer.bytes != most {
            wrong_bytes(plan, *index, most, faults);
        }
    }
    let mut classes: Vec<_> = largest.into_iter().collect();
    classes.sort_unstable();
    for (_, (most, list)) in classes {
        for index in list.into_iter().filter(|index| plan.buffers[*index].bytes != most) {
            wrong_bytes(plan, index, most, faults);
        }
    }
}

fn wrong_bytes(plan: &Plan, index: usize, right: u64, faults: &mut Faults) {
    let bytes = plan.buffers[index].bytes;
    faults.add(
        FaultKind::ClassMismatch,
        format!("buffer {index} has {bytes} bytes, and the largest of its class {right}"),
    );
}

/// In each class as many physical resources as are alive at once.
fn check_minimal(
    plan: &Plan,
    options: &PlanOptions,
    conditional: &HashSet<ResourceHandle>,
    tenants: &BTreeMap<Physical, Vec<(usize, usize, &str)>>,
    faults: &mut Faults,
) {
    // Classes by what wgpu would be told at creation.
    let mut classes: HashMap<String, (usize, Vec<(usize, bool)>)> = HashMap::new();
    for (place, list) in tenants {
        let class = match place {
            Physical::Texture(index) => plan
                .textures
                .get(*index)
                .map(|one| (format!("{:?} {:?}", one.format, one.size), one.volume, one.usages.bits())),
            Physical::Buffer(index) => {
                let class = |bytes: u64| u64::BITS - bytes.saturating_sub(1).leading_zeros();
                let class = |one: &PhysicalBuffer| format!("up to 2^{} bytes", class(one.bytes));
                plan.buffers.get(*index).map(|one| (class(one), false, one.usages.bits()))
            }
            _ => None,
        };
        let transient = list.iter().all(|(.., name)| {
            let planned = &plan.resources[*name];
            planned.lifetime == Lifetime::Transient && !conditional.contains(&planned.handle)
        });
        let Some(class) = class.filter(|_| transient && options.aliasing) else { continue };
        let (count, events) = classes.entry(format!("{class:?}")).or_default();
        *count += 1;
        for (first, last, _) in list {
            // At one position what begins is counted before what ends: touching lifetimes are both alive.
            events.extend([(2 * first, true), (2 * last + 1, false)]);
        }
    }
    let mut names: Vec<_> = classes.into_iter().collect();
    names.sort_unstable();
    for (class, (count, mut events)) in names {
        events.sort_unstable();
        let (mut alive, mut peak) = (0usize, 0usize);
        for (_, begins) in events {
            alive = if begins { alive + 1 } else { alive.saturating_sub(1) };
            peak = peak.max(alive);
        }
        if count > peak {
            faults.add(
                FaultKind::NotMinimal,
                format!("{count} resources of the class {class} are created, {peak} are alive at once"),
            );
        }
    }
}

fn check_sums(plan: &Plan, options: &PlanOptions, spare: &BTreeSet<Physical>, faults: &mut Faults) {
    let created: u64 =
        plan.textures.iter().map(|one| one.bytes).chain(plan.buffers.iter().map(|one| one.bytes)).sum();
    let own =
        |planned: &&PlannedResource| matches!(planned.physical, Physical::Texture(_) | Physical::Buffer(_));
    let kept = spare.iter().filter_map(|place| match place {
        Physical::Texture(at) => plan.textures.get(*at).map(|texture| texture.bytes),
        Physical::Buffer(at) => plan.buffers.get(*at).map(|buffer| buffer.bytes),
        Physical::Imported | Physical::Host => None,
    });
    let kept: u64 = kept.sum();
    let apart: u64 = kept + plan.resources.values().filter(own).map(|planned| planned.bytes).sum::<u64>();
    for (what, stated, right) in
        [("bytes", plan.bytes, created), ("bytes_without_aliasing", plan.bytes_without_aliasing, apart)]
    {
        if stated != right {
            faults.add(FaultKind::BytesWrong, format!("{what} is {stated}, but should be {right}"));
        }
    }
    // Aliasing meets its bound, and the bound is at least what is alive at once.
    let mut alive = vec![0i128; plan.passes.len() + 1];
    for planned in plan.resources.values().filter(own) {
        let lasts = planned.lifetime != Lifetime::Transient || !options.aliasing;
        let (first, last) =
            if lasts { (0, plan.passes.len().saturating_sub(1)) } else { (planned.first, planned.last) };
        if let Some(begin) = alive.get_mut(first) {
            *begin += i128::from(planned.bytes);
        }
        if let Some(end) = alive.get_mut(last + 1) {
            *end -= i128::from(planned.bytes);
        }
    }
    let mut sum = 0;
    let peak = alive.into_iter().map(|change| {
        sum += change;
        sum
    });
    let peak = peak.max().unwrap_or(0) + i128::from(kept);
    if i128::from(plan.bytes_peak) != peak {
        faults.add(FaultKind::BytesWrong, format!("bytes_peak is {}, but should be {peak}", plan.bytes_peak));
    }
    if plan.bytes_bound != plan.bytes || i128::from(plan.bytes_bound) < peak {
        faults.add(
            FaultKind::BytesWrong,
            format!("bytes_bound is {}, but {created} bytes are created", plan.bytes_bound),
        );
    }
    for texture in plan.textures.iter().filter(|texture| texture.bytes == 0) {
        faults.add(FaultKind::BytesWrong, format!("the texture \"{}\" has no bytes", texture.label));
    }
}
