//! What the resources of a plan are on the device, whoever owns them.

use super::creation::Creation;
use super::imports::{ImportedTexture, ImportedView, Imports};
use super::textures::Textures;
use crate::compiler::{Physical, Plan};
use crate::work::{ResourceHandle, TextureView};

/// The textures and buffers of a plan and those of the host.
pub(super) struct Resources {
    pub(super) textures: Textures,
    pub(super) imports: Imports,
}

/// A view of a texture of the plan, or of the one that the host gives with each frame.
pub(super) enum Viewed {
    Own(wgpu::TextureView),
    Imported(ImportedView),
}

/// A texture of the plan, or the one that the host gives with each frame.
pub(super) enum Texture {
    Own(wgpu::Texture),
    Imported(ImportedTexture),
}

impl Resources {
    /// A view of a texture.
    pub(super) fn view(
        &mut self,
        creation: &mut Creation<'_>,
        plan: &Plan,
        view: TextureView,
    ) -> Option<Viewed> {
        let label = &plan.pipeline.resource(view.resource).name;
        match plan.resource(view.resource)?.physical {
            Physical::Texture(index) => self.textures.view(creation, label, index, view).map(Viewed::Own),
            Physical::Imported => self.imports.want(view).map(Viewed::Imported),
            _ => None,
        }
    }

    /// A texture.
    pub(super) fn texture(&self, plan: &Plan, resource: ResourceHandle) -> Option<Texture> {
        match plan.resource(resource)?.physical {
            Physical::Texture(index) => self.textures.texture(index).cloned().map(Texture::Own),
            Physical::Imported => self.imports.find(resource).map(Texture::Imported),
            _ => None,
        }
    }

    /// A buffer.
    pub(super) fn buffer(&self, plan: &Plan, resource: ResourceHandle) -> Option<&wgpu::Buffer> {
        match plan.resource(resource)?.physical {
            Physical::Buffer(index) => self.textures.buffer(index),
            _ => None,
        }
    }
}

impl Viewed {
    /// The view in this frame.
    pub(super) fn get<'a>(&'a self, imports: &'a Imports) -> Option<&'a wgpu::TextureView> {
        match self {
            Viewed::Own(view) => Some(view),
            Viewed::Imported(view) => imports.view(*view),
        }
    }
}

impl Texture {
    /// The texture in this frame.
    pub(super) fn get<'a>(&'a self, imports: &'a Imports) -> Option<&'a wgpu::Texture> {
        match self {
            Texture::Own(texture) => Some(texture),
            Texture::Imported(texture) => imports.texture(*texture),
        }
    }
}
