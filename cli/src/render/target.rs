//! The host's textures and buffers of a plan: the picture, and what captures are copied to.

use umbragraph::Plan;
use umbragraph::executor::{imported_buffer, imported_texture};

use crate::device::Graphics;

/// Creates a texture for each imported texture of the plan; the picture comes first.
pub(super) fn imports(graphics: &Graphics, plan: &Plan, picture: &str) -> Vec<(String, wgpu::Texture)> {
    let usages =
        wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = |name| {
        let samples = plan.resources.get(name)?.size?.samples;
        // A texture of several samples has to be an attachment.
        let more = if samples > 1 { usages | wgpu::TextureUsages::RENDER_ATTACHMENT } else { usages };
        imported_texture(&graphics.device, plan, name, more)
    };
    let mut imported: Vec<_> =
        plan.resources.keys().filter_map(|name| Some((name.clone(), texture(name)?))).collect();
    imported.sort_by_key(|(name, _)| name != picture);
    imported
}

/// Creates the buffers of the named imports that are buffers.
pub(super) fn buffers(graphics: &Graphics, plan: &Plan, names: &[String]) -> Vec<(String, wgpu::Buffer)> {
    let usages = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let buffer = |name: &String| imported_buffer(&graphics.device, plan, name, usages);
    names.iter().filter_map(|name| Some((name.clone(), buffer(name)?))).collect()
}
