//! What the resources of a plan are on the device, whoever owns them, and whichever frame they belong to.

use super::creation::Creation;
use super::histories::{Histories, Turn};
use super::imports::{ImportedTexture, ImportedView, Imports};
use super::textures::Textures;
use crate::compiler::{Physical, Plan};
use crate::work::{ResourceHandle, TextureView};

/// The textures and buffers of a plan and those of the host.
pub(super) struct Resources {
    pub(super) textures: Textures,
    pub(super) imports: Imports,
    pub(super) histories: Histories,
}

/// A view of a texture of the plan, or of the one that the host gives with each frame.
pub(super) enum Viewed {
    Own(wgpu::TextureView),
    Imported(ImportedView),
    /// A view of each copy of a history.
    Turning(Turn, Vec<wgpu::TextureView>),
}

/// A texture of the plan, or the one that the host gives with each frame.
pub(super) enum Texture {
    Own(wgpu::Texture),
    Imported(ImportedTexture),
    /// Each copy of a history.
    Turning(Turn, Vec<wgpu::Texture>),
}

/// A buffer of the plan, or one of the host's.
pub(super) enum Buffer {
    Own(wgpu::Buffer),
    Imported(ImportedTexture),
    /// Each copy of a history.
    Turning(Turn, Vec<wgpu::Buffer>),
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
        if let Some(turn) = self.histories.turn(plan, view.resource) {
            let (textures, places) = (&mut self.textures, self.histories.places(turn));
            let views = places.iter().map(|place| match place {
                Physical::Texture(index) => textures.view(creation, label, *index, view),
                _ => None,
            });
            return Some(Viewed::Turning(turn, views.collect::<Option<_>>()?));
        }
        match plan.resource(view.resource)?.physical {
            Physical::Texture(index) => self.textures.view(creation, label, index, view).map(Viewed::Own),
            Physical::Imported => self.imports.want(view).map(Viewed::Imported),
            _ => None,
        }
    }

    /// A texture.
    pub(super) fn texture(&self, plan: &Plan, resource: ResourceHandle) -> Option<Texture> {
        if let Some(turn) = self.histories.turn(plan, resource) {
            let copies = self.histories.places(turn).iter().map(|place| match place {
                Physical::Texture(index) => self.textures.texture(*index).cloned(),
                _ => None,
            });
            return Some(Texture::Turning(turn, copies.collect::<Option<_>>()?));
        }
        match plan.resource(resource)?.physical {
            Physical::Texture(index) => self.textures.texture(index).cloned().map(Texture::Own),
            Physical::Imported if plan.resource(resource)?.format.is_some() => {
                self.imports.find(resource).map(Texture::Imported)
            }
            _ => None,
        }
    }

    /// A buffer.
    pub(super) fn buffer(&self, plan: &Plan, resource: ResourceHandle) -> Option<Buffer> {
        if let Some(turn) = self.histories.turn(plan, resource) {
            let copies = self.histories.places(turn).iter().map(|place| match place {
                Physical::Buffer(index) => self.textures.buffer(*index).cloned(),
                _ => None,
            });
            return Some(Buffer::Turning(turn, copies.collect::<Option<_>>()?));
        }
        match plan.resource(resource)?.physical {
            Physical::Buffer(index) => self.textures.buffer(index).cloned().map(Buffer::Own),
            Physical::Imported => self.imports.find(resource).map(Buffer::Imported),
            _ => None,
        }
    }

    /// The object on the device that held a resource in the last record.
    pub(super) fn physical(&self, plan: &Plan, name: &str) -> Option<Physical> {
        let planned = plan.resources.get(name)?;
        match self.histories.turn(plan, planned.handle) {
            Some(turn) => self.histories.places(turn).get(self.histories.position(turn)).copied(),
            None => Some(planned.physical),
        }
    }
}

impl Viewed {
    /// The view in this frame.
    pub(super) fn get<'a>(&'a self, resources: &'a Resources) -> Option<&'a wgpu::TextureView> {
        match self {
            Viewed::Own(view) => Some(view),
            Viewed::Imported(view) => resources.imports.view(*view),
            Viewed::Turning(turn, views) => views.get(resources.histories.position(*turn)),
        }
    }
}

impl Texture {
    /// The texture in this frame.
    pub(super) fn get<'a>(&'a self, resources: &'a Resources) -> Option<&'a wgpu::Texture> {
        match self {
            Texture::Own(texture) => Some(texture),
            Texture::Imported(texture) => resources.imports.texture(*texture),
            Texture::Turning(turn, copies) => copies.get(resources.histories.position(*turn)),
        }
    }
}

impl Buffer {
    /// The buffer in this frame.
    pub(super) fn get<'a>(&'a self, resources: &'a Resources) -> Option<&'a wgpu::Buffer> {
        match self {
            Buffer::Own(buffer) => Some(buffer),
            Buffer::Imported(buffer) => resources.imports.buffer(*buffer),
            Buffer::Turning(turn, copies) => copies.get(resources.histories.position(*turn)),
        }
    }

    /// The frame of a history that it stands for.
    pub(super) fn turn(&self) -> Option<Turn> {
        match self {
            Buffer::Own(_) | Buffer::Imported(_) => None,
            Buffer::Turning(turn, _) => Some(*turn),
        }
    }
}
