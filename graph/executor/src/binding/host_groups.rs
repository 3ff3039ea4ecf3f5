//! Bind groups of the host: its materials and its objects.
//!
//! There is one bind group for each material and layout, and one for all objects of a layout, whose blocks are selected
//! by dynamic offsets. They are made again when the host's generation reports replaced resources. Passes whose shaders
//! declare equal materials share them.

use super::draw::DrawSource;
use crate::objects::creation::Creation;
use umbragraph_pipeline::diagnostic::{Diagnostic, Place, codes};
use umbragraph_pipeline::draw::{HostInterface, HostResourceKind};

/// The bindings of the host's materials or objects in a shader.
#[derive(Clone, PartialEq)]
pub(crate) struct HostLayout {
    pub(crate) layout: wgpu::BindGroupLayout,
    /// The binding index and name of each binding.
    pub(crate) bindings: Vec<(u32, String)>,
}

/// The bind groups of the host for one layout: one for each material, or one for all objects.
pub(crate) struct HostGroups {
    layout: HostLayout,
    kind: Kind,
    groups: Vec<wgpu::BindGroup>,
    /// The number of objects whose blocks all lie within their buffers.
    count: u32,
    generation: Option<u64>,
}

#[derive(PartialEq)]
enum Kind {
    Materials,
    /// The size of each block binding and its stride from object to object, in bytes.
    Objects(Vec<Option<(u32, u32)>>),
}

impl HostGroups {
    pub(crate) fn materials(layout: HostLayout) -> Self {
        Self { layout, kind: Kind::Materials, groups: Vec::new(), count: 0, generation: None }
    }

    /// Creates the bind groups of objects, with block sizes and strides from the host's interface.
    pub(crate) fn objects(layout: HostLayout, interface: &HostInterface) -> Self {
        let block = |name: &str| {
            interface.object.iter().find(|slot| slot.name == name).and_then(|slot| match slot.kind {
                HostResourceKind::Block { size, stride, .. } => Some((size, stride)),
                HostResourceKind::Opaque(_) | HostResourceKind::Array { .. } => None,
            })
        };
        let kind = Kind::Objects(layout.bindings.iter().map(|(_, name)| block(name)).collect());
        Self { kind, ..Self::materials(layout) }
    }

    /// Returns `true` if `other` has an equal layout and equal blocks, so that shaders can use either of the two.
    pub(crate) fn is_alike(&self, other: &Self) -> bool {
        self.layout == other.layout && self.kind == other.kind
    }

    /// Creates the bind groups, unless those of the host's current generation exist.
    ///
    /// # Errors
    /// A material or a binding for which the host returns no resource.
    pub(crate) fn prepare(
        &mut self,
        creation: &mut Creation<'_>,
        source: &dyn DrawSource,
    ) -> Result<(), Diagnostic> {
        let generation = source.generation();
        if self.generation == Some(generation) {
            return Ok(());
        }
        self.forget();
        let layout = &self.layout;
        match &self.kind {
            Kind::Materials => {
                for material in 0..source.material_count() {
                    let give = |name: &str| {
                        let given = source.material(material, name);
                        given.ok_or_else(|| lacks(name, &format!("material {material}")))
                    };
                    let (group, _) = make(creation, layout, "materials", give)?;
                    self.groups.push(group);
                }
            }
            Kind::Objects(blocks) => {
                let give = |name: &str| {
                    let mut resource = source.object(name).ok_or_else(|| lacks(name, "objects"))?;
                    let at = layout.bindings.iter().position(|(_, known)| known == name);
                    // Of a buffer of blocks one is bound, which the offset moves.
                    if let (wgpu::BindingResource::Buffer(binding), Some((bytes, 1..))) =
                        (&mut resource, at.and_then(|at| blocks[at]))
                    {
                        binding.size = binding.size.or(wgpu::BufferSize::new(bytes.into()));
                    }
                    Ok(resource)
                };
                let (group, room) = make(creation, layout, "objects", give)?;
                self.count = object_count(blocks, &room);
                self.groups.push(group);
            }
        }
        self.generation = Some(generation);
        Ok(())
    }

    /// Drops all created bind groups, since some may have been rejected by the device.
    pub(crate) fn forget(&mut self) {
        self.generation = None;
        self.groups.clear();
    }

    /// The bind group of a material; `None` if the host has no such material.
    pub(crate) fn material(&self, material: u32) -> Option<&wgpu::BindGroup> {
        self.groups.get(usize::try_from(material).ok()?)
    }

    /// The bind group of objects, with the dynamic offsets of one object; `None` if the host's buffers have no such
    /// object.
    pub(crate) fn object<'a>(&'a self, object: u32, offsets: &mut Vec<u32>) -> Option<&'a wgpu::BindGroup> {
        let Kind::Objects(blocks) = &self.kind else { return None };
        let group = self.groups.first().filter(|_| object < self.count)?;
        offsets.clear();
        offsets.extend(blocks.iter().flatten().map(|(_, stride)| stride.saturating_mul(object)));
        Some(group)
    }
}

/// Returns the number of objects whose blocks all lie within their buffers; `room` is the bytes after each first block.
fn object_count(blocks: &[Option<(u32, u32)>], room: &[Option<u64>]) -> u32 {
    let counts = room.iter().zip(blocks).filter_map(|(room, block)| {
        let (_, stride) = (*block)?;
        // An offset has 32 bits.
        let addressable = u32::MAX.checked_div(stride).unwrap_or(u32::MAX);
        let count = match room {
            None => 0,
            Some(room) => room.checked_div(stride.into()).map_or(u64::MAX, |count| count + 1),
        };
        Some(u32::try_from(count).unwrap_or(u32::MAX).min(addressable))
    });
    counts.min().unwrap_or(u32::MAX)
}

/// Creates a bind group. Also returns, for each binding, the bytes of its buffer after the bound range; `None` if
/// it binds no buffer, or the range exceeds the buffer.
fn make<'a>(
    creation: &mut Creation<'_>,
    layout: &HostLayout,
    label: &str,
    give: impl Fn(&str) -> Result<wgpu::BindingResource<'a>, Diagnostic>,
) -> Result<(wgpu::BindGroup, Vec<Option<u64>>), Diagnostic> {
    let mut entries = Vec::with_capacity(layout.bindings.len());
    let mut room = Vec::new();
    for (binding, name) in &layout.bindings {
        let resource = give(name)?;
        room.push(match &resource {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size }) => {
                let behind = buffer.size().checked_sub(*offset);
                behind.and_then(|behind| behind.checked_sub(size.map_or(behind, wgpu::BufferSize::get)))
            }
            _ => None,
        });
        entries.push(wgpu::BindGroupEntry { binding: *binding, resource });
    }
    let descriptor =
        wgpu::BindGroupDescriptor { label: Some(label), layout: &layout.layout, entries: &entries };
    Ok((creation.bind_group(&descriptor), room))
}

fn lacks(name: &str, of: &str) -> Diagnostic {
    let message = format!("the host gives nothing for \"{name}\" of {of}");
    Diagnostic::error(codes::HOST_INTERFACE, Place::Nowhere, message)
        .help("let its draw source give every binding that its interface names")
}
