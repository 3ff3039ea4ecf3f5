//! The picture of a plan: the imported texture that the command writes to a file and the viewer shows in its window.
//!
//! A pipeline may write several textures of the host, of any format and size. Only one of them can be a picture, and only
//! if its texels are colors of a screen. Both programs ask [`picture_of`], so that a document is rejected by both with
//! the same words, before a device would reject it.

use crate::Plan;
use crate::diagnostic::{Diagnostic, Place, codes};
use crate::low_level::language::Lifetime;
use crate::wgpu_types::TextureFormat;

/// The name of the picture: the imported texture that passes write, or "target" among several. Textures in `captures` do
/// not count.
///
/// # Errors
/// No such texture, or one whose format, size, layers or samples are not those of a picture.
pub fn picture_of<'a>(plan: &'a Plan, captures: &[String]) -> Result<&'a str, Diagnostic> {
    let is_written = |handle| plan.passes.iter().any(|pass| plan.writes(pass.handle, handle));
    let written: Vec<&str> = plan
        .resources
        .iter()
        .filter(|(name, resource)| resource.lifetime == Lifetime::Imported && !captures.contains(name))
        .filter(|(_, resource)| is_written(resource.handle))
        .map(|(name, _)| name.as_str())
        .collect();
    let chosen = match written.as_slice() {
        [one] => Some(*one),
        several => several.iter().copied().find(|name| *name == "target"),
    };
    let Some(name) = chosen else {
        let message = format!("the pipeline writes {} imported textures", written.len());
        return Err(Diagnostic::error(codes::PICTURE, Place::Nowhere, message)
            .help("a picture is made of the one imported texture that passes write, or of \"target\""));
    };
    let resource = &plan.resources[name];
    let place = Place::Span(plan.pipeline.resource(resource.handle).place);
    let (Some(format), Some(size)) = (resource.format, resource.size) else { return Ok(name) };
    if !matches!(format, TextureFormat::Rgba8Unorm | TextureFormat::Rgba8UnormSrgb) {
        return Err(Diagnostic::error(codes::PICTURE, place, format!("\"{name}\" is {format:?}"))
            .help("pictures are rgba8unorm or rgba8unorm-srgb"));
    }
    if [size.width, size.height] != plan.viewport || size.layers != 1 || size.samples != 1 {
        let message = format!(
            "\"{name}\" is {} by {} with {} layers and {} samples",
            size.width, size.height, size.layers, size.samples
        );
        return Err(Diagnostic::error(codes::PICTURE, place, message)
            .help("a picture has the size of the viewport, one layer and one sample"));
    }
    Ok(name)
}
