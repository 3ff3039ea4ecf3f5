//! A host's storage held against the programs that draw it.

use std::collections::BTreeSet;

use crate::pipeline::configuration::TypedPipeline;
use crate::pipeline::located::Located as _;
use crate::pipeline::pass::Pass;
use crate::pipeline::program::{Program, ProgramBinding};
use umbragraph_shaders::{Member, TypeLayout, VertexInput};
use umbragraph_text::diagnostic::{Diagnostic, Related, codes, list_of, suggested_name};
use wgpu_types::BindingType;

use crate::draw::*;

/// Compares a host's storage with the requirements of the programs that draw its meshes. Diagnostics are placed at the
/// passes.
///
/// Reports vertex inputs and bindings that the host lacks, members of another type or at another offset, and undeclared
/// filters.
pub fn check_host(pipeline: &TypedPipeline, geometry: &str, host: &HostInterface) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    let drawing = || {
        let drawing = pipeline.passes.iter().filter_map(|pass| Some((pass, pass.work().scene()?)));
        drawing.filter(|(_, scene)| scene.geometry == geometry)
    };
    if let Some((first, _)) = drawing().next() {
        let filters: BTreeSet<&str> = drawing().map(|(_, scene)| scene.filter.as_str()).collect();
        if host.filters == HostFilters::Unstated {
            let words: Vec<String> = filters.iter().map(|word| format!("\"{word}\"")).collect();
            let message = format!(
                "the host of \"{geometry}\" does not say which filters it tells apart; the pipeline draws {}",
                words.join(", ")
            );
            let help = "state them with HostInterface::filters, and draw in each pass what DrawPass::filter names; \
                or HostInterface::any_filter, if all passes draw the same";
            diagnostics.push(first.error(codes::UNKNOWN_FILTER, message).help(help));
        }
        for message in host.misplaced_attributes() {
            let help = "an attribute lies within the stride of its buffer, at a multiple of 4 bytes";
            diagnostics.push(first.error(codes::HOST_INTERFACE, message).help(help));
        }
    }
    for pass in &pipeline.passes {
        if let Some(scene) = pass.work().scene().filter(|scene| scene.geometry == geometry) {
            check_program(pipeline.program(scene.program), pass, geometry, host, &mut diagnostics);
        }
    }
    diagnostics
}

/// Reports hosts that were registered under a misspelt geometry: the pipeline draws a geometry of a similar name that
/// has no host.
pub(crate) fn misspelt_hosts(pipeline: &TypedPipeline) -> Vec<Diagnostic> {
    let unknown = |name: &&String| !pipeline.geometry.contains_key(*name);
    let unknown: Vec<&str> = pipeline.hosts.keys().filter(unknown).map(String::as_str).collect();
    let mut seen = BTreeSet::new();
    let mut diagnostics = Vec::new();
    for pass in &pipeline.passes {
        let Some(geometry) = pass.work().scene().map(|scene| scene.geometry.as_str()) else { continue };
        if pipeline.hosts.contains_key(geometry) || !seen.insert(geometry) {
            continue;
        }
        if let Some(host) = suggested_name(geometry, unknown.iter().copied()) {
            let message = format!("no host stores the geometry \"{geometry}\"; one is stated for \"{host}\"");
            let help = format!("state the host for \"{geometry}\"");
            diagnostics.push(pass.error(codes::HOST_INTERFACE, message).help(help));
        }
    }
    diagnostics
}

fn check_program(
    program: &Program,
    pass: &Pass,
    geometry: &str,
    host: &HostInterface,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let mut report = |message: String| {
        // Passes that draw with one template have one error in common.
        if let Some(known) = diagnostics.iter_mut().find(|known| known.message == message) {
            let also =
                Related { place: pass.place.into(), message: "this pass draws with it too".to_owned() };
            if known.pointer != pass.pointer && !known.related.contains(&also) {
                known.related.push(also);
            }
            return;
        }
        let help = "change the host's interface, or the template";
        diagnostics.push(pass.error(codes::HOST_INTERFACE, message).help(help));
    };
    let template = &program.template;
    for set in &host.property_sets {
        let variant = program.variant(&host.property_names(*set));
        for VertexInput { name, .. } in variant.vertex_inputs() {
            if host.attribute(*set, name).is_none() {
                let properties = host.property_names(*set);
                let of = if host.vertex_buffers_of.iter().any(|(own, _)| own == set) {
                    format!(" of meshes with the properties {}", list_of(properties))
                } else {
                    String::new()
                };
                report(format!(
                    "the host has no vertex attribute \"{name}\"{of}, which {template} reads (geometry \"{geometry}\")"
                ));
            }
        }
    }
    for binding in program.bindings.iter().filter(|binding| binding.group >= MATERIAL_GROUP) {
        let slots = if binding.group == MATERIAL_GROUP { &host.material } else { &host.object };
        let ProgramBinding { name, group, type_name: declared, entry: wanted, .. } = binding;
        let slot = slots.iter().find(|slot| slot.name == *name).map(|slot| &slot.kind);
        if let Some(entries) = host.own_layout(*group) {
            let number = wanted.binding;
            match entries.iter().find(|entry| entry.binding == number) {
                None => report(format!(
                    "the host's layout of group {group} has no binding {number}, which is \"{name}\" in {template}"
                )),
                Some(entry) if !fits(&entry.ty, &wanted.ty) => report(format!(
                    "binding {number} of the host's layout of group {group} is not {declared}, which {template} wants as \"{name}\""
                )),
                Some(entry) if !entry.visibility.contains(wanted.visibility) => report(format!(
                    "binding {number} of the host's layout of group {group} is not visible to {:?}, where {template} \
                     reads \"{name}\"",
                    wanted.visibility
                )),
                Some(_) => {}
            }
            if slot.is_none() {
                continue;
            }
        }
        match (slot, &binding.block) {
            (None, _) => report(format!("the host has no \"{name}\" for group {group} of {template}")),
            (Some(HostResourceKind::Opaque(type_name)), None) if type_name == declared => {}
            (
                Some(HostResourceKind::Block { members, size, .. }),
                Some(layout @ TypeLayout::Struct { members: wanted, .. }),
            ) => {
                compare_members((name, members), (template, wanted), &mut report);
                let wanted = layout.size();
                if *size < wanted {
                    report(format!(
                        "the host's block \"{name}\" has {size} bytes, {template} wants {wanted}"
                    ));
                }
            }
            (
                Some(HostResourceKind::Array { members, stride }),
                Some(TypeLayout::Array { element, count: None, stride: wanted_stride }),
            ) if matches!(**element, TypeLayout::Struct { .. }) => {
                if let TypeLayout::Struct { members: wanted, .. } = &**element {
                    compare_members((name, members), (template, wanted), &mut report);
                }
                if stride != wanted_stride {
                    report(format!(
                        "elements of the host's array \"{name}\" lie {stride} bytes apart, in {template} {wanted_stride}"
                    ));
                }
            }
            (Some(_), _) => {
                report(format!("\"{name}\" of the host is not {declared}, which {template} wants"));
            }
        }
    }
}

/// Compares the members of a host's block or array element with those that a template reads.
fn compare_members(
    (name, members): (&str, &[HostMember]),
    (template, wanted): (&str, &[Member]),
    report: &mut dyn FnMut(String),
) {
    for Member { name: member, offset, layout } in wanted {
        let Some(have) = members.iter().find(|have| have.name == *member) else {
            report(format!("the host's block \"{name}\" has no \"{member}\", which {template} reads"));
            continue;
        };
        let (have_type, wanted_type) = (have.value_type.to_string(), layout.spelling());
        if have_type != wanted_type {
            report(format!("\"{name}.{member}\" is {have_type} on the host and {wanted_type} in {template}"));
        } else if have.offset != *offset || have.size > layout.size() {
            report(format!(
                "\"{name}.{member}\" lies at byte {} on the host and at byte {offset} in {template}",
                have.offset
            ));
        }
    }
}

/// Returns `true` if a binding of a host's own layout is compatible with the binding that a shader declares.
fn fits(have: &BindingType, want: &BindingType) -> bool {
    use wgpu_types::{SamplerBindingType as S, TextureSampleType as T};
    match (have, want) {
        (
            BindingType::Buffer { ty: have, min_binding_size: room, .. },
            BindingType::Buffer { ty: want, min_binding_size: need, .. },
        ) => have == want && room.is_none_or(|room| need.is_none_or(|need| room >= need)),
        (
            BindingType::Texture { sample_type: have, view_dimension: a, multisampled: m },
            BindingType::Texture { sample_type: want, view_dimension: b, multisampled: n },
        ) => {
            let is_float = |kind: &T| matches!(kind, T::Float { .. });
            let is_filtered = T::Float { filterable: true };
            let alike = have == want || (is_float(have) && is_float(want) && *want != is_filtered);
            alike && (a, m) == (b, n)
        }
        (BindingType::Sampler(have), BindingType::Sampler(want)) => {
            (*have == S::Comparison) == (*want == S::Comparison)
        }
        _ => have == want,
    }
}
