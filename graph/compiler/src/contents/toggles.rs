//! Effects of toggles on a plan, which is one for all of their states.
//!
//! A pass that can be off, and an access that happens only without or only with a passthrough, have [`Condition`]s.
//! Seen from a reader in a frame in which it runs, another pass runs always, never, or [sometimes](Runs). Resources
//! whose first write can be off get memory of their own, so that what another resource left is never taken for
//! contents.
//!
//! Diagnostics: reads, and outputs, for which nothing is left in some state; fallbacks that do not fit.

use std::collections::BTreeMap;

use crate::contents::LiveResources;
use crate::contents::uninitialised;
use crate::graph::Graph;
use crate::regions::{Effort, Left, View, Write};
use crate::resources::resolved::Descriptor;
use umbragraph_pipeline::diagnostic::{Diagnostic, codes};
use umbragraph_pipeline::language::{Lifetime, TextureShape};
use umbragraph_pipeline::pipeline::{
    Access, Located as _, Pass, Passthrough, SubresourceRange, TypedPipeline, Usage,
};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle};

/// Returns the passthroughs of the resources that a pass writes: resource name to fallback name, with a version suffix
/// such as `@pass` if needed.
pub(crate) fn passthrough_names(pipeline: &TypedPipeline, pass: &Pass) -> BTreeMap<String, String> {
    let name = |handle: ResourceHandle| pipeline.resource(handle).name.clone();
    let written = pass.accesses().iter().filter(|one| one.usage.writes());
    let passthroughs =
        written.filter_map(|one| Some((one.resource, pipeline.passthroughs.get(&one.resource)?)));
    passthroughs
        .map(|(resource, passthrough)| {
            let version = match &passthrough.version {
                umbragraph_pipeline::pipeline::Version::WrittenBy(pass) => format!("@{pass}"),
                umbragraph_pipeline::pipeline::Version::Before => "@0".to_owned(),
                umbragraph_pipeline::pipeline::Version::Newest => String::new(),
            };
            (name(resource), format!("{}{version}", name(passthrough.fallback)))
        })
        .collect()
}

/// Returns for each transient resource, by index, whether a live pass with a toggle is the first to write some
/// subresource range. `false` for all other resources.
pub(crate) fn conditional(
    pipeline: &TypedPipeline,
    graph: &Graph,
    is_live: &dyn Fn(PassHandle) -> bool,
) -> Vec<bool> {
    let mut conditional = vec![false; pipeline.resources.len()];
    if pipeline.toggles.is_empty() {
        return conditional;
    }
    for resource in pipeline.resource_handles() {
        if pipeline.resource(resource).lifetime() == Lifetime::Transient {
            conditional[resource.index()] = uncovered(pipeline, graph, resource, is_live).next().is_some();
        }
    }
    conditional
}

/// Returns the live writes of a resource by passes with a toggle, unless an earlier write without a toggle contains the
/// same subresource range.
fn uncovered<'a>(
    pipeline: &'a TypedPipeline,
    graph: &'a Graph,
    resource: ResourceHandle,
    is_live: &'a dyn Fn(PassHandle) -> bool,
) -> impl Iterator<Item = (SubresourceRange, PassHandle)> + 'a {
    let mut always: Vec<SubresourceRange> = Vec::new();
    let live = graph.versions_of(resource).filter(|(_, writer)| is_live(*writer));
    live.filter(move |(range, writer)| {
        if pipeline.pass(*writer).condition.is_some() {
            return !always.iter().any(|below| below.contains(*range));
        }
        if !always.contains(range) {
            always.push(*range);
        }
        false
    })
}

/// Reports imported resources that nothing writes in some toggle state, although a pass with a toggle writes them
/// without loading. Writes that load are exempt, because they keep the contents of the host.
pub(crate) fn check_outputs(live: LiveResources<'_, '_>, diagnostics: &mut Vec<Diagnostic>) {
    let LiveResources { resolved, graph, is_live } = live;
    let pipeline = resolved.pipeline;
    if pipeline.toggles.is_empty() {
        return;
    }
    for resource in pipeline.resource_handles() {
        let known = pipeline.resource(resource);
        if known.lifetime() != Lifetime::Imported || pipeline.uncertain.contains(&resource) {
            continue;
        }
        let list: Vec<_> = graph.versions_of(resource).filter(|(_, writer)| is_live(*writer)).collect();
        let condition = |pass: PassHandle| pipeline.pass(pass).condition;
        let mut effort = Effort::default();
        for (range, writer) in &list {
            if effort.is_used_up() {
                break;
            }
            let Some(own) = condition(*writer) else { continue };
            let mut written = pipeline.pass(*writer).writes_of(resource);
            let fresh = written.find(|one| one.range == *range && !one.usage.reads());
            let mut view = View::new(*range, &[own.opposite()], &mut effort);
            for (other, pass) in &list {
                if view.is_covered() {
                    break;
                }
                let condition = condition(*pass);
                view.cover(Write { range: *other, condition, writer: (), passes_on: false });
            }
            let open = Left::Boxes(view.open());
            let is_open = |one: &&Access| uninitialised::existing(resolved, one, &open).is_some();
            if let Some(one) = fresh.filter(is_open) {
                let toggle = &pipeline.toggles[own.toggle];
                let state = if own.on { "off" } else { "on" };
                let message =
                    format!("nothing writes \"{}\" while \"{}\" is {state}", known.name, toggle.name);
                let help =
                    "let a pass without a toggle write it too, or one with the opposite toggle (\"!name\")";
                let diagnostic = one.error(codes::TOGGLED_AWAY, message).help(help);
                diagnostics.push(diagnostic.related(known.place, "declared here"));
                break;
            }
        }
    }
}

/// Reports fallbacks of passthroughs that differ from their resource in samples, dimension or layers, or are smaller
/// buffers. Format and size must also match if the resource is copied.
pub(crate) fn check_passthroughs(live: LiveResources<'_, '_>, diagnostics: &mut Vec<Diagnostic>) {
    let LiveResources { resolved, is_live, .. } = live;
    let pipeline = resolved.pipeline;
    if pipeline.passthroughs.is_empty() {
        return;
    }
    let mut copied = vec![false; pipeline.resources.len()];
    let live = pipeline.pass_handles().filter(|pass| is_live(*pass));
    for one in live.flat_map(|pass| pipeline.pass(pass).accesses()) {
        copied[one.resource.index()] |= one.usage == Usage::CopySource;
    }
    for (resource, passthrough) in &pipeline.passthroughs {
        let descriptor = |handle| resolved.get(handle).and_then(|resource| resource.descriptor);
        let (Some(own), Some(other)) = (descriptor(*resource), descriptor(passthrough.fallback)) else {
            continue;
        };
        let error = match (own, other) {
            (Descriptor::Texture(a), Descriptor::Texture(b)) => {
                let shape =
                    |handle| pipeline.resource(handle).texture().and_then(|texture| texture.view_dimension);
                let (own_shape, other_shape) = (shape(*resource), shape(passthrough.fallback));
                let shape = own_shape.unwrap_or(TextureShape::D2) != other_shape.unwrap_or(TextureShape::D2);
                let extent = |size: crate::request::texture_size::TextureSize| {
                    [size.width, size.height, size.layers, size.mips]
                };
                if a.size.samples != b.size.samples {
                    Some(format!("have {} and {} samples", a.size.samples, b.size.samples))
                } else if shape {
                    Some("are seen in different dimensions".to_owned())
                } else if a.size.layers != b.size.layers {
                    Some(format!("have {} and {} layers", a.size.layers, b.size.layers))
                } else if copied[resource.index()] && (a.format, extent(a.size)) != (b.format, extent(b.size))
                {
                    Some("differ in format or size, and are copied".to_owned())
                } else {
                    None
                }
            }
            (Descriptor::Buffer { bytes: a, .. }, Descriptor::Buffer { bytes: b, .. }) => {
                (b < a).then(|| format!("have {a} and {b} bytes"))
            }
            _ => None,
        };
        if let Some(error) = error {
            diagnostics.push(misfit(pipeline, *resource, passthrough, &error));
        }
    }
}

fn misfit(
    pipeline: &TypedPipeline,
    resource: ResourceHandle,
    passthrough: &Passthrough,
    error: &str,
) -> Diagnostic {
    let (own, other) = (pipeline.resource(resource), pipeline.resource(passthrough.fallback));
    let message = format!("\"{}\" and \"{}\" {error}", own.name, other.name);
    passthrough
        .error(codes::PASSTHROUGH, message)
        .related(own.place, "the resource with the passthrough")
        .related(other.place, "the fallback")
        .help("a fallback has the dimension, layers and samples of the resource that it replaces, and is no smaller a buffer")
}
