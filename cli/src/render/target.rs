//! The host's textures of a plan: the picture, and what captures are copied to.

use umbragraph::Plan;
use umbragraph::executor::imported_texture;

use crate::device::Graphics;

/// Creates a texture for each imported texture of the plan; the picture comes first.
pub(super) fn imports(graphics: &Graphics, plan: &Plan, picture: &str) -> Vec<(String, wgpu::Texture)> {
    let more =
        wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING;
    let texture = |name| imported_texture(&graphics.device, plan, name, more);
    let mut imported: Vec<_> =
        plan.resources.keys().filter_map(|name| Some((name.clone(), texture(name)?))).collect();
    imported.sort_by_key(|(name, _)| name != picture);
    imported
}
