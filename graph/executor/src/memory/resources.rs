//! Device objects of a plan's resources: the plan's own, those that the host gives, and copies of histories.

use super::histories::{Histories, Turn};
use super::imports::{ImportedTexture, ImportedView, Imports};
use super::textures::Textures;
use crate::objects::creation::Creation;
use umbragraph_compiler::{Physical, Plan, Switches};
use umbragraph_pipeline::work::{ResourceHandle, TextureView};

/// The textures and buffers of a plan and of the host, and the rotation of histories.
pub(crate) struct Resources {
    pub(crate) textures: Textures,
    pub(crate) imports: Imports,
    pub(crate) histories: Histories,
}

/// The object of a resource: an object of the plan, or one that the host gives with each frame.
pub(crate) enum Standing<T, I = ImportedTexture> {
    Own(T),
    Imported(I),
    /// The object of each copy of a history.
    Turning(Turn, Vec<T>),
}

/// A view of a texture of the plan, or of the one that the host gives with each frame.
pub(crate) type Viewed = Standing<wgpu::TextureView, ImportedView>;

/// A texture of the plan, or the one that the host gives with each frame.
pub(crate) type Texture = Standing<wgpu::Texture>;

/// A buffer of the plan, or one of the host's.
pub(crate) type Buffer = Standing<wgpu::Buffer>;

/// The objects of a resource and of each of its fallbacks; toggles choose among them.
pub(crate) struct Fallbacks<T>(pub(crate) Vec<(ResourceHandle, T)>);

impl<T> Fallbacks<T> {
    /// Calls `make` for a resource and each of its fallbacks; leaves out `None`.
    pub(crate) fn new(
        plan: &Plan,
        resource: ResourceHandle,
        mut make: impl FnMut(ResourceHandle) -> Option<T>,
    ) -> Self {
        let all = plan.pipeline.fallbacks(resource);
        Self(all.filter_map(|one| Some((one, make(one)?))).collect())
    }

    /// Returns the resource that readers use in this frame, and its object.
    pub(crate) fn seen(&self, switches: &Switches) -> Option<&(ResourceHandle, T)> {
        let seen = switches.seen(self.0.first()?.0);
        self.0.iter().find(|(resource, _)| *resource == seen)
    }
}

impl Resources {
    /// Returns a view of the texture of a resource, created if it does not exist yet; `None` if the resource has no
    /// texture.
    pub(crate) fn view(
        &mut self,
        creation: &mut Creation<'_>,
        plan: &Plan,
        view: TextureView,
    ) -> Option<Viewed> {
        let label = &plan.pipeline.resource(view.resource).name;
        let Self { textures, imports, histories } = self;
        let own = |place| match place {
            Physical::Texture(index) => textures.view(creation, label, index, view),
            _ => None,
        };
        standing(histories, plan, view.resource, own, || imports.want(view))
    }

    /// Returns the texture of a resource; `None` if the resource has no texture.
    pub(crate) fn texture(&self, plan: &Plan, resource: ResourceHandle) -> Option<Texture> {
        let own = |place| match place {
            Physical::Texture(index) => self.textures.texture(index).cloned(),
            _ => None,
        };
        let is_texture = plan.resource(resource).is_some_and(|planned| planned.format.is_some());
        standing(&self.histories, plan, resource, own, || self.imports.find(resource).filter(|_| is_texture))
    }

    /// Returns the buffer of a resource; `None` if the resource has no buffer on the device.
    pub(crate) fn buffer(&self, plan: &Plan, resource: ResourceHandle) -> Option<Buffer> {
        let own = |place| match place {
            Physical::Buffer(index) => self.textures.buffer(index).cloned(),
            _ => None,
        };
        standing(&self.histories, plan, resource, own, || self.imports.find(resource))
    }

    /// Returns the texture or buffer of the plan that held a resource in the last record; `None` if the plan does not
    /// use the resource.
    pub(crate) fn physical(&self, plan: &Plan, name: &str) -> Option<Physical> {
        let planned = plan.resources.get(name)?;
        match self.histories.turn(plan, planned.handle) {
            Some(turn) => self.histories.places(turn).get(self.histories.position(turn)).copied(),
            None => Some(planned.physical),
        }
    }
}

/// Returns the object of a resource: all copies of a history, an object of the plan from `own`, or an import from
/// `imported`.
fn standing<T, I>(
    histories: &Histories,
    plan: &Plan,
    resource: ResourceHandle,
    mut own: impl FnMut(Physical) -> Option<T>,
    imported: impl FnOnce() -> Option<I>,
) -> Option<Standing<T, I>> {
    if let Some(turn) = histories.turn(plan, resource) {
        let copies = histories.places(turn).iter().map(|place| own(*place));
        return Some(Standing::Turning(turn, copies.collect::<Option<_>>()?));
    }
    match plan.resource(resource)?.physical {
        Physical::Imported => imported().map(Standing::Imported),
        place => own(place).map(Standing::Own),
    }
}

impl<T, I: Copy> Standing<T, I> {
    fn in_frame<'a>(
        &'a self,
        resources: &'a Resources,
        imported: impl FnOnce(&'a Imports, I) -> Option<&'a T>,
    ) -> Option<&'a T> {
        match self {
            Self::Own(object) => Some(object),
            Self::Imported(import) => imported(&resources.imports, *import),
            Self::Turning(turn, copies) => copies.get(resources.histories.position(*turn)),
        }
    }

    /// The frame of a history; `None` if the resource is no history.
    pub(crate) fn turn(&self) -> Option<Turn> {
        match self {
            Self::Own(_) | Self::Imported(_) => None,
            Self::Turning(turn, _) => Some(*turn),
        }
    }
}

impl Viewed {
    /// The view in the current frame; `None` if the host has given no texture.
    pub(crate) fn get<'a>(&'a self, resources: &'a Resources) -> Option<&'a wgpu::TextureView> {
        self.in_frame(resources, Imports::view)
    }
}

impl Texture {
    /// The texture in the current frame; `None` if the host has given none.
    pub(crate) fn get<'a>(&'a self, resources: &'a Resources) -> Option<&'a wgpu::Texture> {
        self.in_frame(resources, Imports::texture)
    }
}

impl Buffer {
    /// The buffer in the current frame; `None` if the host has given none.
    pub(crate) fn get<'a>(&'a self, resources: &'a Resources) -> Option<&'a wgpu::Buffer> {
        self.in_frame(resources, Imports::buffer)
    }
}
