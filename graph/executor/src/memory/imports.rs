//! The host's own textures, and views of them; and its buffers.
//!
//! The host gives its textures again with each frame, and they may change: a swap chain has a handful. Views of
//! recently used textures are kept for a few frames, so that a recurring texture needs no new view. The host's textures
//! are not held longer than that.
//!
//! Objects that the host gives by handle stay until it gives others, even while the current plan does not import them
//! or imports them differently.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::marker::PhantomData;

use super::textures::view_descriptor;
use crate::objects::creation::Creation;
use umbragraph_compiler::{ImportDescriptor, Physical, Plan, TextureSize};
use umbragraph_pipeline::diagnostic::Diagnostic;
use umbragraph_pipeline::language::TextureShape;
use umbragraph_pipeline::work::{ResourceHandle, TextureView};

/// A texture of the host's, or a part of it, that is imported as a resource. A part is a mip level, an array layer or a
/// cube face. The import may have another format if the texture lists that format among its view formats.
///
/// Plans and frames take imports in the same form: `("detail", Import::mip(&texture, 2))`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Import<'a> {
    pub(crate) texture: &'a wgpu::Texture,
    pub(crate) part: Part,
}

/// The imported part of a texture. `None` imports all mip levels, all layers, or the format of the texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Part {
    mip: Option<u32>,
    layer: Option<u32>,
    pub(crate) format: Option<wgpu::TextureFormat>,
}

impl<'a> Import<'a> {
    /// Imports a texture with all of its mip levels and layers.
    pub fn new(texture: &'a wgpu::Texture) -> Self {
        Self { texture, part: Part::default() }
    }

    /// Imports one mip level; 0 is the largest.
    pub fn mip(texture: &'a wgpu::Texture, mip: u32) -> Self {
        Self { texture, part: Part { mip: Some(mip), ..Part::default() } }
    }

    /// Restricts the import to one layer of an array, or one face of a cube.
    #[must_use]
    pub fn layer(mut self, layer: u32) -> Self {
        self.part.layer = Some(layer);
        self
    }

    /// Sets the format of the view: the format of the texture with or without sRGB.
    #[must_use]
    pub fn format(mut self, format: wgpu::TextureFormat) -> Self {
        self.part.format = Some(format);
        self
    }

    /// Returns format, size and usages of the import, for [`PlanOptions`](umbragraph_compiler::PlanOptions).
    pub fn descriptor(&self) -> ImportDescriptor {
        let (texture, Part { mip, layer, format }) = (self.texture, self.part);
        let (width, height) = self.part.extent(texture);
        let size = TextureSize {
            width,
            height,
            layers: layer.map_or(texture.depth_or_array_layers(), |_| 1),
            mips: mip.map_or(texture.mip_level_count(), |_| 1),
            samples: texture.sample_count(),
        };
        ImportDescriptor::new(format.unwrap_or(texture.format()), size).usages(texture.usage())
    }
}

impl<'a> From<&'a wgpu::Texture> for Import<'a> {
    fn from(texture: &'a wgpu::Texture) -> Self {
        Self::new(texture)
    }
}

impl Part {
    pub(crate) fn mip(self) -> u32 {
        self.mip.unwrap_or(0)
    }

    pub(crate) fn layer(self) -> u32 {
        self.layer.unwrap_or(0)
    }

    /// Returns `true` if the import is only a part of the texture, or has another format.
    pub(crate) fn is_within(self) -> bool {
        self != Self::default()
    }

    /// The width and height of the first imported mip level, in texels.
    pub(crate) fn extent(self, texture: &wgpu::Texture) -> (u32, u32) {
        let at = |length: u32| length.checked_shr(self.mip()).unwrap_or(0).max(1);
        (at(texture.width()), at(texture.height()))
    }
}

/// The host's textures of a frame or of a plan, by the names of the imported resources. A list of names with textures,
/// or of names with [`Import`]s.
#[derive(Clone, Copy, Debug)]
pub struct FrameImports<'a>(List<'a>);

#[derive(Clone, Copy, Debug)]
enum List<'a> {
    Textures(&'a [(&'a str, &'a wgpu::Texture)]),
    Imports(&'a [(&'a str, Import<'a>)]),
}

impl<'a> FrameImports<'a> {
    /// The names and imports, in the order of the list.
    pub fn iter(self) -> impl ExactSizeIterator<Item = (&'a str, Import<'a>)> {
        let count = match self.0 {
            List::Textures(list) => list.len(),
            List::Imports(list) => list.len(),
        };
        (0..count).map(move |at| match self.0 {
            List::Textures(list) => (list[at].0, Import::new(list[at].1)),
            List::Imports(list) => list[at],
        })
    }

    fn find(self, name: &str) -> Option<Import<'a>> {
        self.iter().find(|(given, _)| *given == name).map(|(_, import)| import)
    }
}

impl Default for FrameImports<'_> {
    fn default() -> Self {
        Self(List::Textures(&[]))
    }
}

/// Implements conversions from a slice, an array or a vector of names with textures or imports.
macro_rules! lists {
    ($($kind:ident: $item:ty),*) => {$(
        impl<'a> From<&'a [(&'a str, $item)]> for FrameImports<'a> {
            fn from(list: &'a [(&'a str, $item)]) -> Self {
                Self(List::$kind(list))
            }
        }

        impl<'a, const N: usize> From<&'a [(&'a str, $item); N]> for FrameImports<'a> {
            fn from(list: &'a [(&'a str, $item); N]) -> Self {
                Self(List::$kind(list))
            }
        }

        impl<'a> From<&'a Vec<(&'a str, $item)>> for FrameImports<'a> {
            fn from(list: &'a Vec<(&'a str, $item)>) -> Self {
                Self(List::$kind(list))
            }
        }
    )*};
}

lists!(Textures: &'a wgpu::Texture, Imports: Import<'a>);

/// The handle of a resource with the lifetime `imported`. Returned by [`Executor::import`](crate::Executor::import),
/// and taken by [`Executor::give`](crate::Executor::give).
#[derive(Debug)]
pub struct ImportHandle<T> {
    pub(crate) at: ImportedTexture,
    /// The identity of the set of imports that the handle belongs to.
    pub(crate) of: u64,
    pub(crate) kind: PhantomData<fn() -> T>,
}

impl<T> Clone for ImportHandle<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for ImportHandle<T> {}

/// A type of object that can be given for an import: [`wgpu::Texture`] or [`wgpu::Buffer`].
pub trait Importable {
    /// The argument type of [`Executor::give`](crate::Executor::give) for this type.
    type Given<'a>;
    #[doc(hidden)]
    const IS_TEXTURE: bool;
    #[doc(hidden)]
    fn given(given: Self::Given<'_>) -> Given;
}

impl Importable for wgpu::Texture {
    type Given<'a> = Import<'a>;
    const IS_TEXTURE: bool = true;

    fn given(given: Import<'_>) -> Given {
        Given(Kept::Texture(given.texture.clone(), given.part))
    }
}

impl Importable for wgpu::Buffer {
    type Given<'a> = &'a wgpu::Buffer;
    const IS_TEXTURE: bool = false;

    fn given(given: &wgpu::Buffer) -> Given {
        Given(Kept::Buffer(given.clone()))
    }
}

/// A texture or buffer that was passed to [`Executor::give`](crate::Executor::give).
#[derive(Clone, Debug)]
pub struct Given(pub(crate) Kept);

/// A texture with its imported part, or a buffer, that stays set until the host replaces it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Kept {
    Texture(wgpu::Texture, Part),
    Buffer(wgpu::Buffer),
}

impl Kept {
    /// The texture as an import; `None` for a buffer.
    pub(crate) fn import(&self) -> Option<Import<'_>> {
        match self {
            Self::Texture(texture, part) => Some(Import { texture, part: *part }),
            Self::Buffer(_) => None,
        }
    }

    /// The buffer; `None` for a texture.
    pub(crate) fn buffer(&self) -> Option<&wgpu::Buffer> {
        match self {
            Self::Texture(..) => None,
            Self::Buffer(buffer) => Some(buffer),
        }
    }
}

/// Creates a texture for the import `name`, with the size, format, view format and usages that the plan requires, and
/// the usages `more`. Returns `None` if the plan imports no texture of this name.
pub fn imported_texture(
    device: &wgpu::Device,
    plan: &Plan,
    name: &str,
    more: wgpu::TextureUsages,
) -> Option<wgpu::Texture> {
    let resource = plan.resources.get(name).filter(|resource| resource.physical == Physical::Imported)?;
    let (format, size) = (resource.format?, resource.size?);
    let shape = plan.pipeline.resource(resource.handle).texture().and_then(|one| one.view_dimension);
    let is_volume = shape == Some(TextureShape::D3);
    Some(device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: size.layers },
        mip_level_count: size.mips,
        sample_count: size.samples,
        dimension: if is_volume { wgpu::TextureDimension::D3 } else { wgpu::TextureDimension::D2 },
        format,
        usage: resource.usages.unwrap_or(wgpu::TextureUsages::empty()) | more,
        view_formats: resource.view_format.as_slice(),
    }))
}

/// Creates a buffer for the import `name`, with the size that the plan requires and the usages `usage`. Returns `None`
/// if the plan imports no buffer of this name.
pub fn imported_buffer(
    device: &wgpu::Device,
    plan: &Plan,
    name: &str,
    usage: wgpu::BufferUsages,
) -> Option<wgpu::Buffer> {
    let (_, resource) = plan.imports().find(|(known, one)| *known == name && one.format.is_none())?;
    Some(device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(name),
        size: resource.bytes,
        usage,
        mapped_at_creation: false,
    }))
}

/// The number of frames after its last use for which a view of a host's texture is kept.
const KEPT_FRAMES: u64 = 4;

/// The host's textures and buffers that a plan imports, and views of these textures.
pub(crate) struct Imports {
    imports: Vec<Imported>,
    views: Vec<ImportView>,
    /// The objects that the host set with `Executor::give`, by resource name, including imports of earlier plans.
    kept: BTreeMap<String, Kept>,
    id: u64,
}

struct Imported {
    resource: ResourceHandle,
    name: String,
    is_texture: bool,
    current: Option<(wgpu::Texture, Part)>,
    buffer: Option<wgpu::Buffer>,
    /// The textures of the last few frames, with the number of the frame that last used them.
    seen: Vec<(wgpu::Texture, u64)>,
}

struct ImportView {
    import: usize,
    view: TextureView,
    known: Vec<Known>,
    /// The index in `known` of the view for the current frame.
    current: usize,
}

struct Known {
    texture: wgpu::Texture,
    part: Part,
    view: wgpu::TextureView,
    used: u64,
}

/// The index of a view of an imported texture in `Imports::views`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ImportedView(usize);

/// The index of an imported texture or buffer in `Imports::imports`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ImportedTexture(usize);

impl Imports {
    /// Creates the imports of a plan, still without textures or buffers.
    pub(crate) fn new(plan: &Plan) -> Self {
        let mut hasher = DefaultHasher::new();
        let imports = plan.imports().map(|(name, resource)| {
            (name, resource.format.is_some()).hash(&mut hasher);
            Imported {
                resource: resource.handle,
                name: name.to_owned(),
                is_texture: resource.format.is_some(),
                current: None,
                buffer: None,
                seen: Vec::new(),
            }
        });
        let imports = imports.collect();
        Self { imports, views: Vec::new(), kept: BTreeMap::new(), id: hasher.finish() }
    }

    /// A hash of the names and types of the imports. Handles are valid for all plans with the same hash.
    pub(crate) fn id(&self) -> u64 {
        self.id
    }

    /// Returns the import with a name, if it is a texture (`is_texture`) or a buffer as requested.
    pub(crate) fn named(&self, name: &str, is_texture: bool) -> Option<ImportedTexture> {
        let at = self.imports.iter().position(|one| one.name == name && one.is_texture == is_texture);
        at.map(ImportedTexture)
    }

    /// The resource name of an import.
    pub(crate) fn name(&self, import: ImportedTexture) -> Option<&str> {
        self.imports.get(import.0).map(|import| import.name.as_str())
    }

    /// The import of a resource.
    pub(crate) fn find(&self, resource: ResourceHandle) -> Option<ImportedTexture> {
        self.imports.iter().position(|import| import.resource == resource).map(ImportedTexture)
    }

    /// Registers a texture view that passes need in each frame; `None` if its resource is not imported.
    pub(crate) fn want(&mut self, view: TextureView) -> Option<ImportedView> {
        let import = self.find(view.resource)?.0;
        let known = self.views.iter().position(|wanted| wanted.view == view);
        Some(ImportedView(known.unwrap_or_else(|| {
            self.views.push(ImportView { import, view, known: Vec::new(), current: 0 });
            self.views.len() - 1
        })))
    }

    /// Returns the texture of an import for one frame: from the frame's own list, or else as set with `Executor::give`.
    pub(crate) fn of_frame<'a>(&'a self, name: &str, given: FrameImports<'a>) -> Option<Import<'a>> {
        given.find(name).or_else(|| self.kept.get(name)?.import())
    }

    /// Sets the host's textures of a frame, and creates the registered views that do not exist yet.
    ///
    /// # Errors
    /// A texture of another device.
    pub(crate) fn set(
        &mut self,
        creation: &mut Creation<'_>,
        queue: &wgpu::Queue,
        given: FrameImports<'_>,
        frame: u64,
    ) -> Result<(), Diagnostic> {
        let Self { imports, views, kept, .. } = self;
        for imported in imports.iter_mut() {
            let import = given.find(&imported.name).or_else(|| kept.get(&imported.name)?.import());
            if let Some(Import { texture, .. }) = import {
                imported.seen.retain(|(_, used)| used + KEPT_FRAMES >= frame);
                match imported.seen.iter_mut().find(|(seen, _)| seen == texture) {
                    Some((_, used)) => *used = frame,
                    None => {
                        if let Some(error) = creation.import_error(queue, &imported.name, texture) {
                            return Err(error);
                        }
                        imported.seen.push((texture.clone(), frame));
                    }
                }
            }
            let is_same = match (&imported.current, import) {
                (Some((texture, part)), Some(import)) => texture == import.texture && *part == import.part,
                (current, import) => current.is_none() && import.is_none(),
            };
            if !is_same {
                imported.current = import.map(|import| (import.texture.clone(), import.part));
            }
        }
        for wanted in views {
            let Imported { name, current: Some((texture, part)), .. } = &imports[wanted.import] else {
                continue;
            };
            wanted.known.retain(|known| known.used + KEPT_FRAMES >= frame);
            let at = wanted.known.iter().position(|known| known.texture == *texture && known.part == *part);
            wanted.current = at.unwrap_or_else(|| {
                let mut descriptor = view_descriptor(name, texture, wanted.view);
                descriptor.base_mip_level += part.mip();
                descriptor.base_array_layer += part.layer();
                descriptor.format = descriptor.format.or(part.format);
                let view = creation.import_view(texture, &descriptor);
                wanted.known.push(Known { texture: texture.clone(), part: *part, view, used: frame });
                wanted.known.len() - 1
            });
            wanted.known[wanted.current].used = frame;
        }
        Ok(())
    }

    /// Forgets all views, since some of them may have been rejected.
    pub(crate) fn forget_views(&mut self) {
        for wanted in &mut self.views {
            wanted.known.clear();
        }
    }

    /// The texture view of the current frame; `None` if the host has set no texture.
    pub(crate) fn view(&self, view: ImportedView) -> Option<&wgpu::TextureView> {
        let wanted = self.views.get(view.0)?;
        wanted.known.get(wanted.current).map(|known| &known.view)
    }

    /// Sets the texture or buffer of an import until the host replaces it. Returns `true` if it is a buffer and differs
    /// from the previous one.
    pub(crate) fn keep(&mut self, import: ImportedTexture, given: Kept) -> bool {
        let Some(imported) = self.imports.get_mut(import.0) else { return false };
        let is_other = given.buffer().is_some() && imported.buffer.as_ref() != given.buffer();
        if is_other {
            imported.buffer = given.buffer().cloned();
        }
        match self.kept.get_mut(&imported.name) {
            Some(kept) if *kept == given => {}
            Some(kept) => *kept = given,
            None => {
                self.kept.insert(imported.name.clone(), given);
            }
        }
        is_other
    }

    /// The imported buffers, with their names, that were not set with `Executor::give`; the draw source provides them.
    pub(crate) fn open_buffers(&self) -> impl Iterator<Item = (ImportedTexture, &str)> {
        let is_open = |import: &Imported| !import.is_texture && self.kept_buffer(&import.name).is_none();
        let open = self.imports.iter().enumerate().filter(move |(_, import)| is_open(import));
        open.map(|(at, import)| (ImportedTexture(at), import.name.as_str()))
    }

    /// Sets the buffer that the draw source provides for an import, or removes it with `None`. Returns `true` if it
    /// differs from the previous one.
    pub(crate) fn provide(&mut self, import: ImportedTexture, buffer: Option<&wgpu::Buffer>) -> bool {
        let Some(imported) = self.imports.get_mut(import.0) else { return false };
        let is_other = imported.buffer.as_ref() != buffer;
        if is_other {
            imported.buffer = buffer.cloned();
        }
        is_other
    }

    /// Moves the objects that were set with `Executor::give` from the imports of the previous plan. A buffer is used
    /// only if `fits` returns `true` for its resource name.
    pub(crate) fn go_on_from(&mut self, before: &mut Self, fits: impl Fn(&str, &wgpu::Buffer) -> bool) {
        self.kept = std::mem::take(&mut before.kept);
        for import in &mut self.imports {
            let buffer = self.kept.get(&import.name).and_then(Kept::buffer);
            import.buffer = buffer.filter(|buffer| fits(&import.name, buffer)).cloned();
        }
    }

    /// The buffer that was set with `Executor::give` for a resource name, even if the plan cannot use it.
    pub(crate) fn kept_buffer(&self, name: &str) -> Option<&wgpu::Buffer> {
        self.kept.get(name)?.buffer()
    }

    /// The host's buffer of an imported resource; `None` if the host has provided none.
    pub(crate) fn buffer_of(&self, resource: ResourceHandle) -> Option<&wgpu::Buffer> {
        self.buffer(self.find(resource)?)
    }

    /// The host's buffer of an import; `None` if the host has provided none.
    pub(crate) fn buffer(&self, buffer: ImportedTexture) -> Option<&wgpu::Buffer> {
        self.imports.get(buffer.0)?.buffer.as_ref()
    }

    /// The host's texture of an import in the current frame; `None` if the host has given none.
    pub(crate) fn texture(&self, texture: ImportedTexture) -> Option<&wgpu::Texture> {
        self.imports.get(texture.0)?.current.as_ref().map(|(texture, _)| texture)
    }
}
