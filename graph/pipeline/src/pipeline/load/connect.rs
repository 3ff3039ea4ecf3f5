//! What passes say of one another once all are declared: host data is laid out in the blocks that it is bound to.

use std::collections::{BTreeMap, BTreeSet};

use super::Shared;
use crate::data::ValueType;
use crate::diagnostic::{Diagnostic, codes, list_of};
use crate::pipeline::{Pass, ResourceKind, binding};
use crate::source::Span;
use crate::work::{BoundSlot, ProgramHandle, ResourceHandle, SlotSource, Work};

/// Lays host data out in the blocks that it is bound to, now that all of it is published.
pub(super) fn connect(passes: &mut [Pass], uncertain: &BTreeSet<ResourceHandle>, shared: &mut Shared) {
    let mut unpublished: BTreeMap<ResourceHandle, (Span, String)> = BTreeMap::new();
    for pass in passes.iter_mut() {
        for one in &pass.uses {
            if matches!(shared.resources[one.resource.index()].kind, ResourceKind::Data(None))
                && !uncertain.contains(&one.resource)
            {
                unpublished.entry(one.resource).or_insert((one.place, one.pointer.clone()));
            }
        }
        let Some((program, slots)) = slots_mut(&mut pass.work) else { continue };
        let program = &shared.programs.list[program.index()];
        for slot in slots {
            let Some(block) =
                program.binding_at(slot.group, slot.binding).and_then(|binding| binding.block.as_ref())
            else {
                continue;
            };
            let (shape, data_name, target, values) = match &mut slot.source {
                SlotSource::View(layout) => (crate::data::View::shape(), "view".to_owned(), layout, None),
                SlotSource::Data { resource, layout, values } => {
                    let known = &shared.resources[resource.index()];
                    let ResourceKind::Data(Some(shape)) = &known.kind else { continue };
                    (shape.clone(), known.name.clone(), layout, values.as_ref())
                }
                _ => continue,
            };
            match binding::match_block(block, &shape, &data_name, values) {
                Ok(layout) => *target = layout,
                Err(faults) => {
                    for fault in faults {
                        shared.diagnostics.push(
                            Diagnostic::error(
                                codes::BLOCK_MISMATCH,
                                slot.place,
                                format!("in \"{}\" of {}: {fault}", slot.name, program.template),
                            )
                            .pointer(&slot.pointer)
                            .help("members of a block take the published value of the same name and type"),
                        );
                    }
                }
            }
        }
    }
    check_expected(shared);
    for (resource, (place, pointer)) in unpublished {
        let name = shared.resources[resource.index()].name.clone();
        let published = shared
            .resources
            .iter()
            .filter(|resource| !matches!(resource.kind, ResourceKind::Data(None)))
            .map(|resource| resource.name.as_str());
        let message = format!("no pass publishes the data \"{name}\"");
        let written = (shared.sources.text(place) == format!("\"{name}\"")).then_some(place);
        let finding = Diagnostic::error(codes::NOT_PUBLISHED, place, message).pointer(pointer);
        let finding = finding.meant(&name, published, written, |_| {
            "a host pass, such as a cascade fit, has to publish it".to_owned()
        });
        shared.diagnostics.push(finding);
    }
}

/// Finds host data that lacks what a host pass reads of it.
fn check_expected(shared: &mut Shared) {
    for expected in std::mem::take(&mut shared.expected) {
        let resource = &shared.resources[expected.resource.index()];
        let ResourceKind::Data(Some(shape)) = &resource.kind else { continue };
        let fits = |published: ValueType, wanted: ValueType| {
            published.count.is_some() == wanted.count.is_some()
                && ValueType { count: wanted.count, ..published } == wanted
        };
        let lacks = |(name, wanted): &&(String, ValueType)| {
            !shape.find(name).is_some_and(|at| fits(shape.values[at].1, *wanted))
        };
        let missing: Vec<&str> =
            expected.values.iter().filter(lacks).map(|(name, _)| name.as_str()).collect();
        if missing.is_empty() {
            continue;
        }
        let message = format!("the data \"{}\" does not publish {}", resource.name, list_of(missing));
        let finding = Diagnostic::error(codes::DATA_SHAPE, expected.place, message)
            .related(resource.place, "it is published here")
            .help("name the data of a pass of the kind that is wanted here")
            .pointer(expected.pointer);
        shared.diagnostics.push(finding);
    }
}

pub(super) fn slots_mut(work: &mut Work) -> Option<(ProgramHandle, &mut Vec<BoundSlot>)> {
    match work {
        Work::Render(render) => Some(render.draw.bound_mut()),
        Work::Compute(compute) => Some((compute.program, &mut compute.bindings)),
        Work::Host(_) | Work::Transfer(_) => None,
    }
}
