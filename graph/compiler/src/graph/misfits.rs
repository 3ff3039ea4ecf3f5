//! Attachments whose textures have no format that such an attachment can have.

use umbragraph_pipeline::diagnostic::{Diagnostic, codes, list_of};
use umbragraph_pipeline::language::parse_format;
use umbragraph_pipeline::pipeline::{Located as _, TypedPipeline};
use umbragraph_pipeline::work::ResourceHandle;
use wgpu_types::TextureFormat;

/// Returns the depth and stencil attachments without such an aspect in any candidate format of their texture, each with
/// its diagnostic; one for each resource.
pub(crate) fn misfits(pipeline: &TypedPipeline) -> Vec<(ResourceHandle, Diagnostic)> {
    let mut found: Vec<(ResourceHandle, Diagnostic)> = Vec::new();
    for pass in &pipeline.passes {
        for one in pass.accesses().iter().filter(|one| one.usage.is_depth() || one.usage.is_stencil()) {
            let resource = pipeline.resource(one.resource);
            let stencil = one.usage.is_stencil();
            if found.iter().any(|(known, _)| *known == one.resource)
                || is_like(pipeline, one.resource, stencil)
            {
                continue;
            }
            let Some(texture) = resource.texture() else { continue };
            let formats = list_of(texture.format.names());
            let (what, example) = match stencil {
                true => ("stencil", "depth24plus-stencil8"),
                false => ("depth", "depth32float"),
            };
            let message = format!(
                "the {what} attachment of \"{}\" needs a format with {what}, and \"{}\" is {formats}",
                pass.name, resource.name
            );
            let others: Vec<String> = pipeline
                .resource_handles()
                .filter(|other| {
                    pipeline.resource(*other).texture().is_some() && is_like(pipeline, *other, stencil)
                })
                .map(|other| format!("\"&{}\"", pipeline.resource(other).name))
                .take(3)
                .collect();
            let help = match others.as_slice() {
                [] => format!("give it another format, such as {example}"),
                others => {
                    format!("textures with {what} are {}; or give it the format {example}", list_of(others))
                }
            };
            // A depth texture without stencil needs another format; a color texture is probably not meant at all.
            let diagnostic = match stencil && is_like(pipeline, one.resource, false) {
                true => resource
                    .error_at("/texture/format", codes::FORMAT_USAGE, message)
                    .related(one.place, "used here"),
                false => one.error(codes::FORMAT_USAGE, message).related(resource.place, "declared here"),
            };
            found.push((one.resource, diagnostic.help(help)));
        }
    }
    found
}

/// Returns the textures with depth or stencil that no pass writes. Where an attachment is a misfit, one of them may be
/// what it is meant to write.
pub(crate) fn unwritten(pipeline: &TypedPipeline) -> Vec<ResourceHandle> {
    let is_written = |resource: &ResourceHandle| pipeline.passes.iter().any(|pass| pass.writes(*resource));
    let textures = pipeline.resource_handles().filter(|one| pipeline.resource(*one).texture().is_some());
    textures.filter(|one| is_like(pipeline, *one, false) && !is_written(one)).collect()
}

/// Returns `true` if a candidate format of a texture has depth or stencil, or is not known. Also for other resources.
fn is_like(pipeline: &TypedPipeline, resource: ResourceHandle, stencil: bool) -> bool {
    let Some(texture) = pipeline.resource(resource).texture() else { return true };
    let fits = |format: TextureFormat| match stencil {
        true => format.has_stencil_aspect(),
        false => format.has_depth_aspect(),
    };
    texture.format.names().iter().any(|name| parse_format(name).is_none_or(fits))
}
