//! Mips, layers and bytes that a texture or a buffer does not have.
//!
//! A pass that uses such a subresource range has its diagnostic and is [set aside](set_aside) before there is a graph,
//! as if it had not been declared: what it meant to write would be missed elsewhere, and what it meant to read would be
//! said to be unwritten. Nothing is said of who writes or reads the resources that it uses.
//!
//! Cost: linear in accesses; sizes are looked at for resources of which a subresource range is used.

use std::collections::BTreeSet;

use crate::request::options::PlanOptions;
use crate::resources::resolved::sizes;
use crate::resources::size::{Size, Sizes};
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::language::TextureShape;
use umbragraph_pipeline::pipeline::{
    Access, History, Located as _, Pass, SubresourceRange, TypedPipeline, is_round,
};
use umbragraph_pipeline::source::Sources;
use umbragraph_pipeline::work::PassHandle;

/// Removes passes that access mip levels, layers or bytes that a resource does not have, and reports each such access.
pub fn set_aside(
    pipeline: &mut TypedPipeline,
    options: &PlanOptions,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) {
    let is_partial = |one: &Access| one.range != SubresourceRange::WHOLE;
    if !pipeline.passes.iter().flat_map(Pass::accesses).any(is_partial) {
        return;
    }
    // What is wrong with the sizes themselves is found again by the plan.
    let found = beyond(pipeline, &sizes(pipeline, options, sources));
    if found.is_empty() {
        return;
    }
    let broken: BTreeSet<PassHandle> = found.iter().map(|(pass, _)| *pass).collect();
    diagnostics.extend(found.into_iter().map(|(_, diagnostic)| diagnostic));
    let mut positions: Vec<Option<PassHandle>> = Vec::with_capacity(pipeline.passes.len());
    let mut kept = Vec::with_capacity(pipeline.passes.len());
    for (handle, pass) in pipeline.pass_handles().zip(std::mem::take(&mut pipeline.passes)) {
        if broken.contains(&handle) {
            positions.push(None);
            for one in pass.accesses() {
                pipeline.uncertain.insert(one.resource);
                let history = pipeline.resource(one.resource).history;
                pipeline.uncertain.extend(history.into_iter().flat_map(History::members));
            }
            pipeline.gaps.push(pass.name);
        } else {
            positions.push(Some(PassHandle::at(kept.len())));
            kept.push(pass);
        }
    }
    for pass in &mut kept {
        pass.after = pass.after.iter().filter_map(|before| positions[before.index()]).collect();
    }
    pipeline.passes = kept;
}

/// Returns a diagnostic, with the pass, for each access of mip levels, layers or bytes that a resource does not have.
/// Includes culled passes.
pub(crate) fn beyond(pipeline: &TypedPipeline, sizes: &Sizes<'_>) -> Vec<(PassHandle, Diagnostic)> {
    let mut found = Vec::new();
    for (handle, pass) in pipeline.pass_handles().zip(&pipeline.passes) {
        for one in pass.accesses().iter().filter(|one| one.range != SubresourceRange::WHOLE) {
            let bytes = bytes_beyond(pipeline, sizes, one).into_iter();
            let diagnostics = bytes.chain(subresources_beyond(pipeline, sizes, handle, one));
            found.extend(diagnostics.map(|diagnostic| (handle, diagnostic)));
        }
    }
    found
}

fn bytes_beyond(pipeline: &TypedPipeline, sizes: &Sizes<'_>, one: &Access) -> Option<Diagnostic> {
    let run = one.range.bytes?;
    let Size::Buffer(bytes) = sizes.of(one.resource)? else { return None };
    if run.end() <= bytes {
        return None;
    }
    let resource = pipeline.resource(one.resource);
    let (first, last) = (run.first, run.end() - 1);
    let message = format!("bytes {first} to {last} of \"{}\" are used, which has {bytes}", resource.name);
    let diagnostic = one.error(codes::ATTACHMENTS, message).related(resource.place, "declared here");
    Some(diagnostic.help("choose \"offset\" and \"size\" within the buffer, or make it larger"))
}

fn subresources_beyond(
    pipeline: &TypedPipeline,
    sizes: &Sizes<'_>,
    pass: PassHandle,
    one: &Access,
) -> Vec<Diagnostic> {
    let resource = pipeline.resource(one.resource);
    let (Some(texture), Some(size)) = (resource.texture(), sizes.texture(one.resource)) else {
        return Vec::new();
    };
    let volume = texture.view_dimension == Some(TextureShape::D3);
    // The layers of a volume are slices, fewer on each mip.
    let mip = one.range.mip.map_or(0, |run| run.first);
    let layers = if volume { (size.layers >> mip.min(31)).max(1) } else { size.layers };
    let runs = [("mip", one.range.mip, size.mips), ("layer", one.range.layer, layers)];
    let beyond = runs.into_iter().filter_map(|(what, run, count)| {
        let run = run.filter(|run| run.end() > u64::from(count))?;
        let (first, last) = (run.first, run.end() - 1);
        let message = match run.count {
            1 => format!("\"{}\" has no {what} {first}", resource.name),
            _ => format!("\"{}\" has no {what}s {first} to {last}", resource.name),
        };
        let round = pipeline.pass(pass).name.clone();
        let help = match (count, what) {
            (1, "layer") => format!(
                "it has one, layer 0: leave \"layer\" out, or give the texture \"layers\": {}",
                run.end()
            ),
            (1, _) => {
                format!("it has one, mip 0: leave \"mip\" out, or give the texture \"mips\": {}", run.end())
            }
            _ => format!("it has {count}, counted from 0: {what} 0 to {what} {}", count - 1),
        };
        let is_of_loop = round.split('.').any(is_round);
        let message = if is_of_loop { format!("{message}, in \"{round}\"") } else { message };
        Some(one.error(codes::ATTACHMENTS, message).related(resource.place, "declared here").help(help))
    });
    beyond.collect()
}
