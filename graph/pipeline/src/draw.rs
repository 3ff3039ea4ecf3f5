//! The draw contract: how the host's meshes get into a pass.
//!
//! The pipeline's `geometry` says what a template may want. The host says here, once and without a device, how it
//! stores that: a [`HostInterface`] with vertex buffers, blocks with their members' offsets, and the combinations of
//! mesh properties that occur. The module checks it against every shader that draws it, builds all pipelines and bind
//! groups, and at record time hands the host a `DrawPass` for each view: the host binds its vertex buffers and issues
//! draws, choosing properties, material and object by number.
//!
//! Conventions: bind group 2 is the material, one bind group for each of the host's materials; bind group 3 is the
//! object, one bind group in all, whose blocks are moved by a dynamic offset of a fixed stride for each object, and
//! whose arrays stay in place: shaders index them by instance. A host that has bind groups of its own for one of the
//! two says their layout, and binds them itself. Front faces are counter-clockwise.
//!
//! Meshes whose vertices are stored otherwise than most have a property, and their sets of properties have vertex
//! buffers of their own. What is in vertex buffers can change from instance to instance, too.

use crate::data::ValueType;
use wgpu_types::{BindGroupLayoutEntry, VertexFormat, VertexStepMode};

/// The property under which a mesh is drawn from both sides. It changes no shader unless a template has an axis of
/// that name; the rasteriser's culling is switched off for it.
pub const DOUBLE_SIDED: &str = "double_sided";

/// The bind group of what a material has.
pub const MATERIAL_GROUP: u32 = 2;

/// The bind group of what an object has; it and those before, from [`MATERIAL_GROUP`] on, are the host's.
pub const OBJECT_GROUP: u32 = 3;

/// A host's storage of a `geometry` of a pipeline.
///
/// ```
/// use umbragraph_pipeline::data::ValueType;
/// use umbragraph_pipeline::draw::{HostInterface, HostResource, HostVertexBuffer};
/// use umbragraph_pipeline::wgpu_types::VertexFormat::Float32x3;
///
/// let interface = HostInterface::new()
///     .vertices(HostVertexBuffer::new(24, [("position", Float32x3, 0), ("normal", Float32x3, 12)]))
///     .object(HostResource::array("objects", 64, [("world_from_object", ValueType::MAT4, 0)]));
/// assert_eq!(interface.property_sets.len(), 1);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct HostInterface {
    /// The vertex buffers; the position is the slot that the host binds them to.
    pub vertex_buffers: Vec<HostVertexBuffer>,
    /// The vertex buffers of meshes with a set of properties, where they are others.
    pub vertex_buffers_of: Vec<(PropertySet, Vec<HostVertexBuffer>)>,
    /// The bindings of bind group 2, by name.
    pub material: Vec<HostResource>,
    /// The bindings of bind group 3, by name.
    pub object: Vec<HostResource>,
    /// The names of mesh properties, such as `alpha_masked`; a [`PropertySet`] is a set of positions here.
    pub properties: Vec<String>,
    /// The combinations of properties that occur; pipelines are built for these.
    pub property_sets: Vec<PropertySet>,
    /// The words that passes may write under `mesh_filter`.
    pub filters: HostFilters,
    /// The layout of bind group 2, where the host has bind groups of its own for it. Bindings are then found by their
    /// numbers, and `material` need only name blocks whose members are to be compared.
    pub material_layout: Option<Vec<BindGroupLayoutEntry>>,
    /// The layout of bind group 3, as `material_layout` for group 2.
    pub object_layout: Option<Vec<BindGroupLayoutEntry>>,
}

/// The filters of draws that a host knows. A pipeline draws casters, opaque and blended meshes in passes of their own,
/// and a host that took no notice of it would draw all of them in each: so it has to say which it tells apart.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum HostFilters {
    /// None is stated, which is an error where a pipeline draws meshes of the host.
    #[default]
    Unstated,
    /// Every word.
    Any,
    /// Some words.
    Words(Vec<String>),
}

/// A set of mesh properties, as positions in [`HostInterface::properties`]: bit 0 is the first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PropertySet(pub u32);

impl HostInterface {
    /// Meshes without properties.
    pub fn new() -> Self {
        Self { property_sets: vec![PropertySet::default()], ..Self::default() }
    }

    /// Adds a vertex buffer, in the next slot.
    #[must_use]
    pub fn vertices(mut self, buffer: HostVertexBuffer) -> Self {
        self.vertex_buffers.push(buffer);
        self
    }

    /// Adds a binding of bind group 2.
    #[must_use]
    pub fn material(mut self, slot: HostResource) -> Self {
        self.material.push(slot);
        self
    }

    /// Adds a binding of bind group 3.
    #[must_use]
    pub fn object(mut self, slot: HostResource) -> Self {
        self.object.push(slot);
        self
    }

    /// Sets the properties of meshes, and the sets of them that occur.
    #[must_use]
    pub fn properties<'n>(
        mut self,
        names: impl IntoIterator<Item = &'n str>,
        sets: impl IntoIterator<Item = PropertySet>,
    ) -> Self {
        self.properties = names.into_iter().map(str::to_owned).collect();
        self.property_sets = sets.into_iter().collect();
        self
    }

    /// Sets the vertex buffers of meshes that have a set of properties.
    #[must_use]
    pub fn vertices_of(
        mut self,
        set: PropertySet,
        buffers: impl IntoIterator<Item = HostVertexBuffer>,
    ) -> Self {
        self.vertex_buffers_of.push((set, buffers.into_iter().collect()));
        self
    }

    /// Sets the words that passes may write under `mesh_filter`: those that the host tells apart in
    /// `DrawPass::filter`.
    #[must_use]
    pub fn filters(mut self, filters: &[&str]) -> Self {
        self.filters = HostFilters::Words(filters.iter().map(|filter| (*filter).to_owned()).collect());
        self
    }

    /// Allows every word under `mesh_filter`: the host draws the same for all, or interprets words itself.
    #[must_use]
    pub fn any_filter(mut self) -> Self {
        self.filters = HostFilters::Any;
        self
    }

    /// Sets the layout of the host's own bind groups for materials.
    #[must_use]
    pub fn material_layout(mut self, entries: impl Into<Vec<BindGroupLayoutEntry>>) -> Self {
        self.material_layout = Some(entries.into());
        self
    }

    /// Sets the layout of the host's own bind groups for objects.
    #[must_use]
    pub fn object_layout(mut self, entries: impl Into<Vec<BindGroupLayoutEntry>>) -> Self {
        self.object_layout = Some(entries.into());
        self
    }

    /// The vertex buffers of meshes with a set of properties.
    pub fn buffers(&self, set: PropertySet) -> &[HostVertexBuffer] {
        let own = self.vertex_buffers_of.iter().find(|(known, _)| *known == set);
        own.map_or(&self.vertex_buffers, |(_, buffers)| buffers)
    }

    /// The layout of one of the host's bind groups, where it binds those itself.
    pub fn own_layout(&self, group: u32) -> Option<&[BindGroupLayoutEntry]> {
        match group {
            MATERIAL_GROUP => self.material_layout.as_deref(),
            OBJECT_GROUP => self.object_layout.as_deref(),
            _ => None,
        }
    }

    /// Whether a block of bind group 3 is moved from object to object.
    pub fn is_moved(&self, name: &str) -> bool {
        let slot = self.object.iter().find(|slot| slot.name == name);
        slot.is_none_or(|slot| matches!(slot.kind, HostResourceKind::Block { .. }))
    }

    /// The names of the properties of a set.
    pub fn property_names(&self, set: PropertySet) -> Vec<&str> {
        let in_set = |at: usize| at < 32 && set.0 & (1 << at) != 0;
        self.properties
            .iter()
            .enumerate()
            .filter(|(at, _)| in_set(*at))
            .map(|(_, name)| name.as_str())
            .collect()
    }

    /// Messages about misplaced vertex attributes. WebGPU wants each within the stride of its buffer, and both at
    /// multiples of 4 bytes (attributes of less than 4 bytes at multiples of their size).
    pub(super) fn misplaced_attributes(&self) -> Vec<String> {
        let own = self.vertex_buffers_of.iter().flat_map(|(_, buffers)| buffers);
        let mut messages = Vec::new();
        for buffer in self.vertex_buffers.iter().chain(own) {
            if !buffer.stride.is_multiple_of(4) {
                messages.push(format!("a vertex buffer has a stride of {} bytes", buffer.stride));
            }
            for HostAttribute { name, format, offset } in &buffer.attributes {
                let end = offset.saturating_add(format.size());
                if end > buffer.stride {
                    messages.push(format!(
                        "the vertex attribute \"{name}\" ends at byte {end} of a vertex, whose stride is {}",
                        buffer.stride
                    ));
                } else if !offset.is_multiple_of(format.size().min(4)) {
                    messages
                        .push(format!("the vertex attribute \"{name}\" lies at byte {offset} of a vertex"));
                }
            }
        }
        messages
    }

    /// The vertex attribute of a name, of meshes with a set of properties.
    pub fn attribute(&self, set: PropertySet, name: &str) -> Option<&HostAttribute> {
        let mut attributes = self.buffers(set).iter().flat_map(|buffer| &buffer.attributes);
        attributes.find(|attribute| attribute.name == name)
    }
}

/// A vertex buffer of the host.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostVertexBuffer {
    /// Bytes from one element to the next.
    pub stride: u64,
    /// Whether elements belong to vertices or to instances.
    pub step: VertexStepMode,
    /// The members.
    pub attributes: Vec<HostAttribute>,
}

impl HostVertexBuffer {
    /// A buffer with an element for each vertex: its bytes, and its attributes with their formats and first bytes.
    pub fn new<'n>(stride: u64, attributes: impl IntoIterator<Item = (&'n str, VertexFormat, u64)>) -> Self {
        let attribute =
            |(name, format, offset): (&str, _, _)| HostAttribute { name: name.to_owned(), format, offset };
        let attributes = attributes.into_iter().map(attribute).collect();
        Self { stride, step: VertexStepMode::Vertex, attributes }
    }

    /// Advances per instance instead of per vertex.
    #[must_use]
    pub fn per_instance(self) -> Self {
        Self { step: VertexStepMode::Instance, ..self }
    }
}

/// A vertex attribute of the host.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostAttribute {
    /// The name that shaders use.
    pub name: String,
    /// Its format.
    pub format: VertexFormat,
    /// Its first byte in a vertex.
    pub offset: u64,
}

/// A binding that the host fills.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostResource {
    /// The name that shaders use.
    pub name: String,
    /// The kind.
    pub kind: HostResourceKind,
}

impl HostResource {
    /// A texture or a sampler, by its WGSL type.
    pub fn opaque(name: impl Into<String>, wgsl: impl Into<String>) -> Self {
        Self { name: name.into(), kind: HostResourceKind::Opaque(wgsl.into()) }
    }

    /// A uniform block, with its members' types and first bytes; `stride` are the bytes to the next object's, 0 for a
    /// material's.
    pub fn block<'n>(
        name: impl Into<String>,
        stride: u32,
        members: impl IntoIterator<Item = (&'n str, ValueType, u32)>,
    ) -> Self {
        let members: Vec<_> = members.into_iter().map(HostMember::from).collect();
        let size = members.iter().map(|member| member.offset + member.size).max().unwrap_or(0);
        let size = size.next_multiple_of(16);
        Self { name: name.into(), kind: HostResourceKind::Block { members, size, stride } }
    }

    /// An array in a storage buffer, with the bytes from one element to the next, and the members of an element.
    pub fn array<'n>(
        name: impl Into<String>,
        stride: u32,
        members: impl IntoIterator<Item = (&'n str, ValueType, u32)>,
    ) -> Self {
        let members = members.into_iter().map(HostMember::from).collect();
        Self { name: name.into(), kind: HostResourceKind::Array { members, stride } }
    }
}

/// The kind of a binding of the host.
#[derive(Clone, Debug, PartialEq)]
pub enum HostResourceKind {
    /// A texture or a sampler, by its WGSL type (`texture_2d<f32>`, `sampler`).
    Opaque(String),
    /// A block in a buffer.
    Block {
        /// The members with their types and first bytes.
        members: Vec<HostMember>,
        /// The size of one block in bytes.
        size: u32,
        /// Bytes from one object's block to the next; a multiple of 256. 0 for a material's block.
        stride: u32,
    },
    /// An array of structs in a storage buffer, whose length is the buffer's.
    Array {
        /// The members of an element with their types and first bytes.
        members: Vec<HostMember>,
        /// Bytes from one element to the next.
        stride: u32,
    },
}

/// A member of a host's block.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostMember {
    /// The name that shaders use.
    pub name: String,
    /// Its type.
    pub value_type: ValueType,
    /// Its first byte.
    pub offset: u32,
    /// Its bytes, padding between columns or elements included.
    pub size: u32,
}

impl From<(&str, ValueType, u32)> for HostMember {
    /// A member without padding, with its type and its first byte.
    fn from((name, value_type, offset): (&str, ValueType, u32)) -> Self {
        Self { name: name.to_owned(), value_type, offset, size: 4 * value_type.words() as u32 }
    }
}
