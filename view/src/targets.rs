//! The host's textures of a plan: the picture, which the window shows, and others, which are empty.

use eframe::egui;
use eframe::egui_wgpu::RenderState;
use umbragraph::executor::imported_texture;
use umbragraph::{Plan, wgpu};

/// Usages of the host's textures beside those of the plan.
pub(crate) const MORE: wgpu::TextureUsages = wgpu::TextureUsages::COPY_SRC
    .union(wgpu::TextureUsages::COPY_DST)
    .union(wgpu::TextureUsages::TEXTURE_BINDING);

/// The picture as egui knows it.
struct Picture {
    texture: wgpu::Texture,
    id: egui::TextureId,
}

/// The host's textures by the names of the resources that they stand for.
#[derive(Default)]
pub(crate) struct Targets {
    list: Vec<(String, wgpu::Texture)>,
    picture: Option<Picture>,
}

impl Targets {
    /// The textures as frames take them.
    pub(crate) fn imports(&self) -> Vec<(&str, &wgpu::Texture)> {
        self.list.iter().map(|(name, texture)| (name.as_str(), texture)).collect()
    }

    /// Forgets the textures, those of another plan. The picture is shown until there is a new one.
    pub(crate) fn clear(&mut self) {
        self.list.clear();
    }

    /// The picture, with its size in texels.
    pub(crate) fn shown(&self) -> Option<(egui::TextureId, [u32; 2])> {
        self.picture.as_ref().map(|one| (one.id, [one.texture.width(), one.texture.height()]))
    }

    /// The texture of the picture.
    pub(crate) fn picture(&self) -> Option<&wgpu::Texture> {
        self.picture.as_ref().map(|one| &one.texture)
    }

    /// Makes the host's textures of the plan, the picture in a size.
    pub(crate) fn fit(&mut self, state: &RenderState, plan: &Plan, [width, height]: [u32; 2]) {
        let picture = picture_of(plan);
        for (name, resource) in plan.imports() {
            let is_picture = picture == Some(name);
            let known = self.list.iter().position(|(known, _)| known == name);
            let fits = known.is_some_and(|at| {
                let texture = &self.list[at].1;
                (!is_picture || [texture.width(), texture.height()] == [width, height])
                    && Some(texture.format()) == resource.format
            });
            if fits {
                continue;
            }
            let Some(mut texture) = imported_texture(&state.device, plan, name, MORE) else { continue };
            if is_picture {
                texture = state.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(name),
                    size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: texture.format(),
                    usage: texture.usage(),
                    view_formats: &[texture.format().remove_srgb_suffix()],
                });
                self.show(state, &texture);
            }
            match known {
                Some(at) => self.list[at].1 = texture,
                None => self.list.push((name.to_owned(), texture)),
            }
        }
    }

    /// Gives egui the picture. Its texels are colors of a screen, whatever the format says.
    fn show(&mut self, state: &RenderState, texture: &wgpu::Texture) {
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(texture.format().remove_srgb_suffix()),
            usage: Some(wgpu::TextureUsages::TEXTURE_BINDING),
            ..Default::default()
        });
        let mut renderer = state.renderer.write();
        let filter = wgpu::FilterMode::Linear;
        let id = match &self.picture {
            Some(picture) => {
                renderer.update_egui_texture_from_wgpu_texture(&state.device, &view, filter, picture.id);
                picture.id
            }
            None => renderer.register_native_texture(&state.device, &view, filter),
        };
        self.picture = Some(Picture { texture: texture.clone(), id });
    }
}

/// The import that is the picture: the only one that passes write, or "target" among several.
pub(crate) fn picture_of(plan: &Plan) -> Option<&str> {
    let is_written = |handle| plan.passes.iter().any(|pass| plan.writes(pass.handle, handle));
    let mut written = plan.imports().filter(|(_, one)| is_written(one.handle)).map(|(name, _)| name);
    let first = written.next();
    let others: Vec<&str> = written.collect();
    if others.is_empty() { first } else { first.into_iter().chain(others).find(|name| *name == "target") }
}
