//! The host's textures of a plan: the picture, and what captures are copied to.

use umbragraph::Plan;
use umbragraph::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph::executor::imported_texture;
use umbragraph::low_level::language::Lifetime;

use crate::device::Graphics;

/// The name of the imported texture that is the picture: the one that passes write, or "target" among several.
pub(super) fn picture_of(plan: &Plan, captures: &[String]) -> Result<String, Diagnostics> {
    let written: Vec<&String> = plan
        .resources
        .iter()
        .filter(|(name, resource)| resource.lifetime == Lifetime::Imported && !captures.contains(name))
        .filter(|(_, resource)| plan.passes.iter().any(|pass| plan.writes(pass.handle, resource.handle)))
        .map(|(name, _)| name)
        .collect();
    let chosen = match written.as_slice() {
        [one] => Some(*one),
        several => several.iter().copied().find(|name| *name == "target"),
    };
    let reject = |place: Place, message: String, help: &str| {
        Err(Diagnostic::error(codes::PICTURE, place, message).help(help).into())
    };
    let Some(name) = chosen else {
        let message = format!("the pipeline writes {} imported textures", written.len());
        return reject(
            Place::Nowhere,
            message,
            "a picture is made of the one imported texture that passes write, or of \"target\"",
        );
    };
    let resource = &plan.resources[name];
    let place = Place::Span(plan.pipeline.resource(resource.handle).place);
    let (Some(format), Some(size)) = (resource.format, resource.size) else { return Ok(name.clone()) };
    if !matches!(format, wgpu::TextureFormat::Rgba8Unorm | wgpu::TextureFormat::Rgba8UnormSrgb) {
        return reject(
            place,
            format!("\"{name}\" is {format:?}"),
            "pictures are rgba8unorm or rgba8unorm-srgb",
        );
    }
    if [size.width, size.height] != plan.viewport || size.layers != 1 || size.samples != 1 {
        let message = format!(
            "\"{name}\" is {} by {} with {} layers and {} samples",
            size.width, size.height, size.layers, size.samples
        );
        return reject(place, message, "a picture has the size of the viewport, one layer and one sample");
    }
    Ok(name.clone())
}

/// A texture for each import of the plan; the picture first.
pub(super) fn imports(graphics: &Graphics, plan: &Plan, picture: &str) -> Vec<(String, wgpu::Texture)> {
    let more =
        wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = |name| imported_texture(&graphics.device, plan, name, more);
    let mut imported: Vec<_> =
        plan.resources.keys().filter_map(|name| Some((name.clone(), texture(name)?))).collect();
    imported.sort_by_key(|(name, _)| name != picture);
    imported
}
