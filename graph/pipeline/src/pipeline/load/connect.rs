//! Relations between passes once all are declared: blackboard data fits the blocks that it is bound to.

use std::collections::{BTreeMap, BTreeSet};

use crate::data::ValueType;
use crate::pipeline::builder::binding::block_layout;
use crate::pipeline::located::Located as _;
use crate::pipeline::pass::Pass;
use crate::pipeline::resource::ResourceKind;
use crate::pipeline::state::shared::Shared;
use crate::work::{ResourceHandle, SlotSource};
use umbragraph_text::diagnostic::{Diagnostic, codes, list_of};
use umbragraph_text::source::Span;

/// Reports blackboard data that does not fit the blocks that it is bound to, and data that no pass publishes.
pub(super) fn connect(passes: &[Pass], uncertain: &BTreeSet<ResourceHandle>, shared: &mut Shared) {
    let mut unpublished: BTreeMap<ResourceHandle, (Span, String)> = BTreeMap::new();
    for pass in passes {
        for one in pass.accesses() {
            if matches!(shared.resources[one.resource.index()].kind, ResourceKind::Data(None))
                && !uncertain.contains(&one.resource)
            {
                unpublished.entry(one.resource).or_insert((one.place, one.pointer.clone()));
            }
        }
        let Some((program, slots)) = pass.work().bound() else { continue };
        let program = &shared.programs.list[program.index()];
        for slot in slots {
            let Some(Err(errors)) = block_layout(program, slot, &shared.resources) else { continue };
            for error in errors {
                let message = format!("in \"{}\" of {}: {error}", slot.name, program.template);
                let help = "members of a block take the published value of the same name, type and number: publish \
                            as many as the shader declares, or let the shader (its axis) have as many as are published";
                let data = match &slot.source {
                    SlotSource::Data { data, .. } => Some(&shared.resources[data.resource.index()]),
                    _ => None,
                };
                let label = format!("\"{}\" is published here", data.map_or("", |data| data.name.as_str()));
                let diagnostic = slot.error(codes::BLOCK_MISMATCH, message).help(help);
                let declared = program.plain().variable(&slot.name);
                let diagnostic = diagnostic.labelled(data.map(|data| data.place), label);
                shared.diagnostics.push(diagnostic.labelled(declared, "the block of the shader"));
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
        let is_reference = shared.sources.text(place) == format!("\"&{name}\"");
        let written = is_reference.then(|| place.inside(2..2 + name.len()));
        let diagnostic = Diagnostic::error(codes::NOT_PUBLISHED, place, message).pointer(pointer);
        let diagnostic = diagnostic.suggest(&name, published, written, |_| {
            "a CPU pass, such as a camera, has to publish it".to_owned()
        });
        shared.diagnostics.push(diagnostic);
    }
}

/// Reports blackboard data that lacks values which a CPU pass expects.
fn check_expected(shared: &mut Shared) {
    for expected in std::mem::take(&mut shared.expected) {
        let resource = &shared.resources[expected.resource.index()];
        let ResourceKind::Data(Some(shape)) = &resource.kind else { continue };
        let fits = |published: ValueType, wanted: ValueType| {
            published.count.is_some() == wanted.count.is_some()
                && ValueType { count: wanted.count, ..published } == wanted
        };
        let lacks = |(name, wanted): &&(String, ValueType)| {
            !shape.find(name).is_some_and(|at| fits(shape.values[at].value_type, *wanted))
        };
        let missing: Vec<&str> =
            expected.values.iter().filter(lacks).map(|(name, _)| name.as_str()).collect();
        if missing.is_empty() {
            continue;
        }
        let message = format!("the data \"{}\" does not publish {}", resource.name, list_of(missing));
        let diagnostic = Diagnostic::error(codes::DATA_SHAPE, expected.place, message)
            .related(resource.place, "it is published here")
            .help("name the data of a pass of the kind that is wanted here")
            .pointer(expected.pointer);
        shared.diagnostics.push(diagnostic);
    }
}
