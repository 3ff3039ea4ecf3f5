//! Resolved properties of each resource, whatever the order of the passes: its size, format, usages and class.
//!
//! Two resources of one class can stand for one another on a device: the same format, size, layers, mips, samples,
//! dimension and usages, or, for buffers, the same usages and the same size class: the next power of two of their
//! bytes. A buffer is as large as the largest that it stands for; what is bound of it is as long as the resource, since
//! a shader can ask for the length. What outlives the frame is a class of its own, and so is what a toggle can leave
//! without its first write.
//!
//! Diagnostics: subresources that a texture does not have, formats that do not support their usages, imports used
//! beyond the usage that the host created them with.
//!
//! Cost: linear in resources and accesses.

use rustc_hash::FxHashMap;
use wgpu_types::{BufferUsages, TextureFormat, TextureUsages};

use crate::request::options::{ImportDescriptor, PlanOptions};
use crate::request::texture_size::TextureSize;
use crate::resources::format;
use crate::resources::size::{Size, Sizes};
use crate::resources::texture_bytes::texture_bytes;
use crate::resources::{texture_rules, view_shape};
use umbragraph_pipeline::diagnostic::{Diagnostic, codes};
use umbragraph_pipeline::language::{Lifetime, TextureShape};
use umbragraph_pipeline::pipeline::{Located as _, Resource, ResourceKind, TypedPipeline};
use umbragraph_pipeline::source::Sources;
use umbragraph_pipeline::work::{PassHandle, ResourceHandle, Work};

/// The properties of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct TextureProperties {
    pub(crate) format: TextureFormat,
    pub(crate) size: TextureSize,
    pub(crate) volume: bool,
    pub(crate) usages: TextureUsages,
    /// The second format in which passes view the texture, which differs only in `-srgb`; `None` if there is none.
    pub(crate) view_format: Option<TextureFormat>,
    /// Whether the texture must be bound as an array by a target (OpenGL) that gives each texture one fixed view
    /// dimension.
    pub(crate) only_array: bool,
}

/// The description of a resource for its creation on the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Descriptor {
    Texture(TextureProperties),
    Buffer { bytes: u64, usages: BufferUsages },
}

impl Descriptor {
    /// Adds the usages that are needed to clear a history to its initial value.
    fn clearing(self) -> Self {
        match self {
            Descriptor::Texture(mut texture) => {
                texture.usages |= wgpu_types::TextureUsages::RENDER_ATTACHMENT;
                Descriptor::Texture(texture)
            }
            Descriptor::Buffer { bytes, usages } => {
                Descriptor::Buffer { bytes, usages: usages | wgpu_types::BufferUsages::COPY_DST }
            }
        }
    }
}

/// The resolved properties of one resource that some pass uses which is not culled.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ResolvedResource {
    /// The descriptor for creation on the device; `None` for blackboard (CPU) data, and after a diagnostic.
    pub(crate) descriptor: Option<Descriptor>,
    /// The index of the compatibility class; resources of one class can share memory. `None` for resources that the
    /// plan does not create, such as imports.
    pub(crate) class: Option<usize>,
    pub(crate) bytes: u64,
}

impl ResolvedResource {
    pub(crate) fn texture(&self) -> Option<TextureProperties> {
        match self.descriptor {
            Some(Descriptor::Texture(texture)) => Some(texture),
            _ => None,
        }
    }
}

/// The resolved properties of every resource.
pub(crate) struct ResolvedResources<'a> {
    pub(crate) pipeline: &'a TypedPipeline,
    pub(crate) sizes: Sizes<'a>,
    /// Resolved resources by handle; `None` for those that no live pass uses.
    pub(crate) list: Vec<Option<ResolvedResource>>,
    /// The number of compatibility classes.
    pub(crate) classes: usize,
}

impl<'a> ResolvedResources<'a> {
    /// Resolves the size, format, usages and compatibility class of each resource that live passes use.
    pub(crate) fn new(
        pipeline: &'a TypedPipeline,
        options: &'a PlanOptions,
        sources: &'a Sources,
        live: &[PassHandle],
        conditional: &[bool],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Self {
        let mut resolved = Self::empty(pipeline, options, sources);
        let mut classes = CompatibilityClasses::new(pipeline, conditional, options.aliasing);
        let all = format::wants(pipeline, live);
        for handle in pipeline.resource_handles() {
            let resource = pipeline.resource(handle);
            if let Some(history) = resource.history.filter(|history| history.back > 0) {
                // As this frame's, which comes before it.
                let now = resolved.list[history.of.index()];
                resolved.list[handle.index()] = now.map(|now| classes.resource(handle, now.descriptor));
                continue;
            }
            let wants = &all[handle.index()];
            if wants.accesses.is_empty() {
                continue;
            }
            let is_state = matches!(resource.lifetime(), Lifetime::Persistent | Lifetime::History);
            let is_copyable = options.copyable_state && is_state;
            let descriptor = match (&resource.kind, resolved.sizes.of(handle)) {
                (ResourceKind::Texture(texture), Some(Size::Texture(size))) => {
                    let mut usages = wants.texture_usages();
                    if scrolls(pipeline, handle, wants) {
                        usages |= TextureUsages::COPY_SRC;
                    }
                    if resource.is_exposed() {
                        usages |= TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING;
                    }
                    if is_copyable {
                        usages |= TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
                    }
                    resolved.check_import(handle, usages, wants, options, diagnostics);
                    let import = told(options, resource);
                    let format = match import {
                        Some(import) => Some(import.format),
                        None => {
                            let goes = |format| resolved.goes_with_others(&all, handle, format, options);
                            format::choose(pipeline, resource, texture, wants, size, &goes)
                                .map_err(|diagnostic| diagnostics.push(*diagnostic))
                                .ok()
                        }
                    };
                    // What has several samples has to be an attachment, whatever else is done with it.
                    if import.is_none() && size.samples > 1 {
                        usages |= TextureUsages::RENDER_ATTACHMENT;
                    }
                    let volume = texture.view_dimension == Some(TextureShape::D3);
                    format.map(|format| {
                        let view_format =
                            wants.views.iter().map(|(_, view)| *view).find(|view| *view != format);
                        let only_array = view_shape::is_only_array(pipeline, texture);
                        Descriptor::Texture(TextureProperties {
                            format,
                            size,
                            volume,
                            usages,
                            view_format,
                            only_array,
                        })
                    })
                }
                (ResourceKind::Buffer(_), Some(Size::Buffer(bytes))) => {
                    let mut usages: BufferUsages =
                        wants.accesses.iter().map(|(_, one)| one.usage.buffer_usages()).collect();
                    if resource.is_exposed() {
                        usages |= BufferUsages::COPY_SRC | BufferUsages::STORAGE;
                    }
                    if is_copyable {
                        usages |= BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
                    }
                    Some(Descriptor::Buffer { bytes, usages })
                }
                _ => None,
            };
            let descriptor = match resource.history {
                Some(_) => descriptor.map(Descriptor::clearing),
                None => descriptor,
            };
            resolved.list[handle.index()] = Some(classes.resource(handle, descriptor));
        }
        resolved.classes = classes.known.len();
        resolved
    }

    /// Returns `true` if `format` suits all textures that copies or resolves connect to this one, directly or through
    /// other textures. Each has, or can have, a format that can be copied or resolved.
    fn goes_with_others(
        &self,
        wants: &[format::FormatRequirements<'_>],
        handle: ResourceHandle,
        format: TextureFormat,
        options: &PlanOptions,
    ) -> bool {
        // Each with whether it is reached by resolves alone, and so has to be the same.
        let mut known = vec![(handle, true)];
        let mut at = 0;
        while let Some((one, is_same)) = known.get(at).copied() {
            for (other, resolves) in &wants[one.index()].alike {
                let found = (*other, is_same && *resolves);
                if !known.contains(&found) && !known.contains(&(*other, true)) {
                    known.push(found);
                }
            }
            at += 1;
        }
        known[1..].iter().all(|(other, is_same)| {
            let fits = |other: TextureFormat| match is_same {
                true => other == format,
                false => format::are_alike(other, format),
            };
            let resource = self.pipeline.resource(*other);
            let size = self.sizes.texture(*other);
            match (self.texture(*other), told(options, resource), resource.texture(), size) {
                (Some(chosen), ..) => fits(chosen.format),
                (None, Some(import), ..) => fits(import.format),
                (None, None, Some(texture), Some(size)) => {
                    format::could_be_like(self.pipeline, texture, &wants[other.index()], size, &fits)
                }
                _ => true,
            }
        })
    }

    /// Resolves the resources again for changed sizes, with the same formats and usages. Returns `None` if a new plan
    /// is needed: a size is invalid, the sample count changes, or the layer count changes from or to 1.
    pub(crate) fn resized(
        pipeline: &'a TypedPipeline,
        options: &'a PlanOptions,
        sources: &'a Sources,
        before: &[Option<ResolvedResource>],
        conditional: &[bool],
    ) -> Option<Self> {
        let mut resolved = Self::empty(pipeline, options, sources);
        let mut classes = CompatibilityClasses::new(pipeline, conditional, options.aliasing);
        for handle in pipeline.resource_handles() {
            let Some(resource) = before[handle.index()] else { continue };
            let descriptor = match (resource.descriptor, resolved.sizes.of(handle)?) {
                (Some(Descriptor::Texture(texture)), Size::Texture(size)) => {
                    let layered = |size: TextureSize| size.layers != 1;
                    let alike =
                        texture.size.samples == size.samples && layered(texture.size) == layered(size);
                    let fits = texture_rules::of_format(texture.format, size, texture.volume, texture.usages)
                        .is_none();
                    Some(Descriptor::Texture(TextureProperties { size, ..texture })).filter(|_| alike && fits)
                }
                (Some(Descriptor::Buffer { usages, .. }), Size::Buffer(bytes)) => {
                    Some(Descriptor::Buffer { bytes, usages })
                }
                _ => None,
            };
            if descriptor.is_none() && resource.descriptor.is_some() {
                return None;
            }
            resolved.list[handle.index()] = Some(classes.resource(handle, descriptor));
        }
        resolved.classes = classes.known.len();
        Some(resolved)
    }

    /// Creates the list with no resource resolved yet.
    fn empty(pipeline: &'a TypedPipeline, options: &'a PlanOptions, sources: &'a Sources) -> Self {
        Self {
            pipeline,
            sizes: sizes(pipeline, options, sources),
            list: vec![None; pipeline.resources.len()],
            classes: 0,
        }
    }

    /// The properties of a resource; `None` if no live pass uses it.
    pub(crate) fn get(&self, handle: ResourceHandle) -> Option<&ResolvedResource> {
        self.list.get(handle.index())?.as_ref()
    }

    /// The properties of a texture.
    pub(crate) fn texture(&self, handle: ResourceHandle) -> Option<TextureProperties> {
        self.get(handle)?.texture()
    }

    /// Evaluates the sizes of all resources, so that errors are also reported for resources that no live pass uses.
    pub(crate) fn check_all_sizes(&self) {
        for handle in self.pipeline.resource_handles() {
            self.sizes.of(handle);
        }
    }

    /// Reports accesses of an imported texture that need a usage with which the host did not create the texture.
    fn check_import(
        &self,
        handle: ResourceHandle,
        usages: TextureUsages,
        wants: &format::FormatRequirements<'_>,
        options: &PlanOptions,
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        let resource = self.pipeline.resource(handle);
        let allowed = told(options, resource).map(|import| import.usages);
        let Some(allowed) = allowed.filter(|allowed| !allowed.contains(usages)) else { return };
        for (pass, one) in
            wants.accesses.iter().filter(|(_, one)| !allowed.contains(one.usage.texture_usages()))
        {
            let message = format!(
                "\"{}\" uses the import \"{}\" as {}, which the host's texture does not allow",
                self.pipeline.pass(*pass).name,
                resource.name,
                one.usage.name()
            );
            let diagnostic = one.error(codes::IMPORT_USAGE, message).related(resource.place, "declared here");
            let help = format!("create the host's texture with the usage {:?}", one.usage.texture_usages());
            diagnostics.push(diagnostic.help(help));
        }
    }
}

/// Creates the evaluator of resource sizes for a plan. Sizes are evaluated on demand.
pub(crate) fn sizes<'a>(
    pipeline: &'a TypedPipeline,
    options: &'a PlanOptions,
    sources: &'a Sources,
) -> Sizes<'a> {
    let imported =
        pipeline.resources.iter().map(|one| told(options, one).map(|import| import.size)).collect();
    Sizes::new(pipeline, sources, options.viewport, imported, &options.data_sizes)
}

/// Returns the host's description of an imported texture; `None` if the host gave none, or the resource is not
/// imported.
fn told<'a>(options: &'a PlanOptions, resource: &Resource) -> Option<&'a ImportDescriptor> {
    options.imports.get(&resource.name).filter(|_| resource.lifetime() == Lifetime::Imported)
}

/// Assigns each created resource the index of a compatibility class; resources of one class can share memory.
struct CompatibilityClasses<'a> {
    pipeline: &'a TypedPipeline,
    /// The index of each class by its descriptor. A resource that cannot share memory also has its handle in the key.
    known: FxHashMap<(Descriptor, Option<ResourceHandle>), usize>,
    conditional: &'a [bool],
    aliasing: bool,
}

impl<'a> CompatibilityClasses<'a> {
    fn new(pipeline: &'a TypedPipeline, conditional: &'a [bool], aliasing: bool) -> Self {
        Self { pipeline, known: FxHashMap::default(), conditional, aliasing }
    }

    fn resource(&mut self, handle: ResourceHandle, descriptor: Option<Descriptor>) -> ResolvedResource {
        let lifetime = self.pipeline.resource(handle).lifetime();
        let created = descriptor.filter(|_| lifetime != Lifetime::Imported);
        let shares = lifetime == Lifetime::Transient && self.aliasing && !self.conditional[handle.index()];
        let alone = (!shares).then_some(handle);
        let bytes = match descriptor {
            Some(Descriptor::Texture(texture)) => texture_bytes(&texture),
            Some(Descriptor::Buffer { bytes, .. }) => bytes,
            None => 0,
        };
        let class = created.map(|descriptor| {
            let like = match descriptor {
                Descriptor::Buffer { bytes, usages } => {
                    Descriptor::Buffer { bytes: bytes.checked_next_power_of_two().unwrap_or(bytes), usages }
                }
                texture @ Descriptor::Texture(_) => texture,
            };
            let next = self.known.len();
            *self.known.entry((like, alone)).or_insert(next)
        });
        ResolvedResource { descriptor, class, bytes }
    }
}

/// Returns `true` if a pass scrolls the kept texels of its depth texture, which needs a copy from the texture.
fn scrolls(
    pipeline: &TypedPipeline,
    texture: ResourceHandle,
    wants: &format::FormatRequirements<'_>,
) -> bool {
    wants.accesses.iter().any(|(pass, _)| {
        let work = pipeline.pass(*pass).work();
        let redraw = work.scene().and_then(|scene| scene.redraw.as_ref());
        let Work::Render(render) = work else { return false };
        let scrolls = redraw.is_some_and(|redraw| redraw.scroll);
        scrolls && render.depth.as_ref().is_some_and(|depth| depth.to.resource == texture)
    })
}
