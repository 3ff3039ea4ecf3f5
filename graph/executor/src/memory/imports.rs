//! The host's own textures, and views of them; and its buffers.
//!
//! The host gives them again with each frame, and they may be others each time: a swap chain has a handful. Views are
//! kept for those that were seen in the last few frames, so that a texture that comes again needs no new one, and the
//! host's textures are not held on to for longer than that. Buffers stay until the host gives others.

use super::textures::view_descriptor;
use crate::objects::creation::Creation;
use umbragraph_compiler::{Physical, Plan};
use umbragraph_pipeline::diagnostic::Diagnostic;
use umbragraph_pipeline::work::{ResourceHandle, TextureView};

/// The part of a texture of the host's that stands for a resource: a mip level and those after it, a layer and those
/// after it, in another format if one is told, which the texture was created with as one of its view formats.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ImportPart {
    /// The mip level that is the resource's first.
    pub mip: u32,
    /// The layer that is the resource's first.
    pub layer: u32,
    /// The format that the resource has, where it is not the texture's.
    pub format: Option<wgpu::TextureFormat>,
}

impl ImportPart {
    /// A part from a mip level and a layer on, in the texture's format.
    pub fn new(mip: u32, layer: u32) -> Self {
        Self { mip, layer, format: None }
    }

    /// In another format.
    #[must_use]
    pub fn format(self, format: wgpu::TextureFormat) -> Self {
        Self { format: Some(format), ..self }
    }
}

/// A texture as a plan wants it of the host, by the name of the import, that the host can use for `more` besides; its
/// views may be sRGB or not. `None` where the plan imports no texture of this name.
pub fn imported_texture(
    device: &wgpu::Device,
    plan: &Plan,
    name: &str,
    more: wgpu::TextureUsages,
) -> Option<wgpu::Texture> {
    let resource = plan.resources.get(name).filter(|resource| resource.physical == Physical::Imported)?;
    let (format, size) = (resource.format?, resource.size?);
    Some(device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width: size.width, height: size.height, depth_or_array_layers: size.layers },
        mip_level_count: size.mips,
        sample_count: size.samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: resource.usages.unwrap_or(wgpu::TextureUsages::empty()) | more,
        view_formats: &[format.add_srgb_suffix(), format.remove_srgb_suffix()],
    }))
}

/// For how many frames a view is kept of a texture that the host does not give.
const KEPT_FRAMES: u64 = 4;

/// The host's own textures.
pub(crate) struct Imports {
    imports: Vec<Import>,
    views: Vec<ImportView>,
}

struct Import {
    resource: ResourceHandle,
    name: String,
    current: Option<wgpu::Texture>,
    buffer: Option<wgpu::Buffer>,
    part: Option<ImportPart>,
    /// The textures of the last few frames, with the frame that had them last.
    seen: Vec<(wgpu::Texture, u64)>,
}

struct ImportView {
    import: usize,
    view: TextureView,
    known: Vec<Known>,
    /// The position among the known ones in this frame.
    current: usize,
}

struct Known {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    used: u64,
}

/// Names one view of one of the host's textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ImportedView(usize);

/// Names one of the host's textures or buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ImportedTexture(usize);

impl Imports {
    /// The imports of a plan, none of them given yet.
    pub(crate) fn new(plan: &Plan) -> Self {
        let imported = plan.resources.iter().filter(|(_, resource)| resource.physical == Physical::Imported);
        let imports = imported.map(|(name, resource)| Import {
            resource: resource.handle,
            name: name.clone(),
            current: None,
            buffer: None,
            part: None,
            seen: Vec::new(),
        });
        Self { imports: imports.collect(), views: Vec::new() }
    }

    /// The import that stands for a resource.
    pub(crate) fn find(&self, resource: ResourceHandle) -> Option<ImportedTexture> {
        self.imports.iter().position(|import| import.resource == resource).map(ImportedTexture)
    }

    /// Asks for a view in each frame.
    pub(crate) fn want(&mut self, view: TextureView) -> Option<ImportedView> {
        let import = self.find(view.resource)?.0;
        let known = self.views.iter().position(|wanted| wanted.view == view);
        Some(ImportedView(known.unwrap_or_else(|| {
            self.views.push(ImportView { import, view, known: Vec::new(), current: 0 });
            self.views.len() - 1
        })))
    }

    /// Takes the host's textures of a frame.
    ///
    /// # Errors
    /// A texture of another device.
    pub(crate) fn set(
        &mut self,
        creation: &mut Creation<'_>,
        queue: &wgpu::Queue,
        given: &[(&str, &wgpu::Texture)],
        frame: u64,
    ) -> Result<(), Diagnostic> {
        for import in &mut self.imports {
            let texture = given.iter().find(|(name, _)| *name == import.name).map(|(_, texture)| *texture);
            if let Some(texture) = texture {
                import.seen.retain(|(_, used)| used + KEPT_FRAMES >= frame);
                match import.seen.iter_mut().find(|(seen, _)| seen == texture) {
                    Some((_, used)) => *used = frame,
                    None => {
                        if let Some(error) = creation.import_error(queue, &import.name, texture) {
                            return Err(error);
                        }
                        import.seen.push((texture.clone(), frame));
                    }
                }
            }
            if import.current.as_ref() != texture {
                import.current = texture.cloned();
            }
        }
        for wanted in &mut self.views {
            let Import { name, current: Some(texture), part, .. } = &self.imports[wanted.import] else {
                continue;
            };
            wanted.known.retain(|known| known.used + KEPT_FRAMES >= frame);
            let at = wanted.known.iter().position(|known| known.texture == *texture);
            wanted.current = at.unwrap_or_else(|| {
                let mut descriptor = view_descriptor(name, texture, wanted.view);
                if let Some(part) = part {
                    descriptor.base_mip_level += part.mip;
                    descriptor.base_array_layer += part.layer;
                    descriptor.format = descriptor.format.or(part.format);
                }
                let view = creation.import_view(texture, &descriptor);
                wanted.known.push(Known { texture: texture.clone(), view, used: frame });
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

    /// The view in this frame.
    pub(crate) fn view(&self, view: ImportedView) -> Option<&wgpu::TextureView> {
        let wanted = self.views.get(view.0)?;
        wanted.known.get(wanted.current).map(|known| &known.view)
    }

    /// Takes a buffer of the host's, for a resource of the plan. Whether it is another than before.
    pub(crate) fn set_buffer(&mut self, resource: ResourceHandle, buffer: &wgpu::Buffer) -> bool {
        let Some(ImportedTexture(at)) = self.find(resource) else { return false };
        let is_other = self.imports[at].buffer.as_ref() != Some(buffer);
        if is_other {
            self.imports[at].buffer = Some(buffer.clone());
        }
        is_other
    }

    /// Lets a part of the host's textures stand for a resource of the plan.
    pub(crate) fn set_part(&mut self, resource: ResourceHandle, part: Option<ImportPart>) {
        let Some(ImportedTexture(at)) = self.find(resource) else { return };
        if self.imports[at].part != part {
            self.imports[at].part = part;
            self.views.iter_mut().filter(|view| view.import == at).for_each(|view| view.known.clear());
        }
    }

    /// The part of the host's textures that stands for a resource.
    pub(crate) fn part(&self, resource: ResourceHandle) -> Option<ImportPart> {
        self.imports[self.find(resource)?.0].part
    }

    /// Takes over the parts and the buffers that another plan was given, where `fits` says of their names that they are right here.
    pub(crate) fn go_on_from(&mut self, before: &Self, fits: impl Fn(&str, &wgpu::Buffer) -> bool) {
        for import in &mut self.imports {
            let known = before.imports.iter().find(|known| known.name == import.name);
            import.part = known.and_then(|known| known.part);
            let buffer = known.and_then(|known| known.buffer.clone());
            import.buffer = buffer.filter(|buffer| fits(&import.name, buffer));
        }
    }

    /// The buffer that stands for a resource.
    pub(crate) fn buffer_of(&self, resource: ResourceHandle) -> Option<&wgpu::Buffer> {
        self.buffer(self.find(resource)?)
    }

    /// The buffer.
    pub(crate) fn buffer(&self, buffer: ImportedTexture) -> Option<&wgpu::Buffer> {
        self.imports.get(buffer.0)?.buffer.as_ref()
    }

    /// The texture in this frame.
    pub(crate) fn texture(&self, texture: ImportedTexture) -> Option<&wgpu::Texture> {
        self.imports.get(texture.0)?.current.as_ref()
    }
}
