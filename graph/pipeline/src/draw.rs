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

/// The name of the mesh property for meshes that are drawn from both sides. The rasteriser's culling is off for these
/// meshes. Shaders differ for them only if their template has a variant axis of this name.
pub const DOUBLE_SIDED: &str = "double_sided";

/// The index of the bind group with a material's resources.
pub const MATERIAL_GROUP: u32 = 2;

/// The index of the bind group with an object's resources. The host provides the groups from [`MATERIAL_GROUP`] to this
/// one.
pub const OBJECT_GROUP: u32 = 3;

/// The layout in which a host stores the vertices, materials and objects of a `geometry` of a pipeline.
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
    /// The vertex buffers; the index in this list is the slot that the host binds the buffer to.
    pub vertex_buffers: Vec<HostVertexBuffer>,
    /// The vertex buffers of meshes with a set of properties, for sets whose buffers differ from `vertex_buffers`.
    pub vertex_buffers_of: Vec<(PropertySet, Vec<HostVertexBuffer>)>,
    /// The bindings of bind group 2 (material), each with its name.
    pub material: Vec<HostResource>,
    /// The bindings of bind group 3 (object), each with its name.
    pub object: Vec<HostResource>,
    /// The names of mesh properties, such as `alpha_masked`. Bit `n` of a [`PropertySet`] stands for the name at index
    /// `n`.
    pub properties: Vec<String>,
    /// The combinations of mesh properties that occur; render pipelines are built for each of them.
    pub property_sets: Vec<PropertySet>,
    /// The draw filters that the host distinguishes; passes name them under `mesh_filter`.
    pub filters: HostFilters,
    /// The layout of bind group 2 if the host creates the bind groups of materials itself, else `None`. Bindings are
    /// then matched by number, and `material` needs to list only blocks whose members are to be compared.
    pub material_layout: Option<Vec<BindGroupLayoutEntry>>,
    /// The layout of bind group 3 if the host creates the bind groups of objects itself, else `None`. Bindings are then
    /// matched by number, and `object` needs to list only blocks whose members are to be compared.
    pub object_layout: Option<Vec<BindGroupLayoutEntry>>,
}

/// The draw filters that a host distinguishes. A pipeline draws casters, opaque and blended meshes in separate passes.
/// A host that ignored the filter would draw all of them in each pass, so it must declare its filters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum HostFilters {
    /// No filters are declared, which is an error if a pipeline draws the host's meshes.
    #[default]
    Unstated,
    /// Every filter name is allowed.
    Any,
    /// Only these filter names are allowed.
    Words(Vec<String>),
}

/// A set of mesh properties as a bit mask: bit 0 is the first name in [`HostInterface::properties`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PropertySet(pub u32);

impl HostInterface {
    /// Creates an interface without buffers and bindings, for meshes without properties.
    pub fn new() -> Self {
        Self { property_sets: vec![PropertySet::default()], ..Self::default() }
    }

    /// Adds a vertex buffer, in the next slot.
    #[must_use]
    pub fn vertices(mut self, buffer: HostVertexBuffer) -> Self {
        self.vertex_buffers.push(buffer);
        self
    }

    /// Adds a binding of bind group 2 (material).
    #[must_use]
    pub fn material(mut self, slot: HostResource) -> Self {
        self.material.push(slot);
        self
    }

    /// Adds a binding of bind group 3 (object).
    #[must_use]
    pub fn object(mut self, slot: HostResource) -> Self {
        self.object.push(slot);
        self
    }

    /// Sets the names of mesh properties, and the combinations of them that occur.
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

    /// Sets the filter names that passes may use under `mesh_filter`. The host finds the filter of a pass in
    /// `DrawPass::filter`.
    #[must_use]
    pub fn filters(mut self, filters: &[&str]) -> Self {
        self.filters = HostFilters::Words(filters.iter().map(|filter| (*filter).to_owned()).collect());
        self
    }

    /// Allows every filter name under `mesh_filter`: the host draws the same for all, or interprets the names itself.
    #[must_use]
    pub fn any_filter(mut self) -> Self {
        self.filters = HostFilters::Any;
        self
    }

    /// Sets the layout of the bind groups of materials, for a host that creates these bind groups itself.
    #[must_use]
    pub fn material_layout(mut self, entries: impl Into<Vec<BindGroupLayoutEntry>>) -> Self {
        self.material_layout = Some(entries.into());
        self
    }

    /// Sets the layout of the bind groups of objects, for a host that creates these bind groups itself.
    #[must_use]
    pub fn object_layout(mut self, entries: impl Into<Vec<BindGroupLayoutEntry>>) -> Self {
        self.object_layout = Some(entries.into());
        self
    }

    /// The vertex buffers of meshes with this set of properties: their own buffers, or else `vertex_buffers`.
    pub fn buffers(&self, set: PropertySet) -> &[HostVertexBuffer] {
        let own = self.vertex_buffers_of.iter().find(|(known, _)| *known == set);
        own.map_or(&self.vertex_buffers, |(_, buffers)| buffers)
    }

    /// The layout of bind group 2 or 3 if the host creates these bind groups itself; `None` otherwise.
    pub fn own_layout(&self, group: u32) -> Option<&[BindGroupLayoutEntry]> {
        match group {
            MATERIAL_GROUP => self.material_layout.as_deref(),
            OBJECT_GROUP => self.object_layout.as_deref(),
            _ => None,
        }
    }

    /// Returns `true` if a binding of bind group 3 is a uniform block, which a dynamic offset moves from object to
    /// object. Also returns `true` for a name that the host does not provide.
    pub fn is_moved(&self, name: &str) -> bool {
        let slot = self.object.iter().find(|slot| slot.name == name);
        slot.is_none_or(|slot| matches!(slot.kind, HostResourceKind::Block { .. }))
    }

    /// The names of the mesh properties in a set.
    pub fn property_names(&self, set: PropertySet) -> Vec<&str> {
        let in_set = |at: usize| at < 32 && set.0 & (1 << at) != 0;
        self.properties
            .iter()
            .enumerate()
            .filter(|(at, _)| in_set(*at))
            .map(|(_, name)| name.as_str())
            .collect()
    }

    /// Returns messages about vertex attributes at invalid offsets. WebGPU requires each attribute to lie within the
    /// stride of its buffer. Strides and offsets are multiples of 4 bytes; the offset of a smaller attribute is a
    /// multiple of its size.
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

    /// Returns the vertex attribute with this name for meshes with a set of properties, or `None` if there is none.
    pub fn attribute(&self, set: PropertySet, name: &str) -> Option<&HostAttribute> {
        let mut attributes = self.buffers(set).iter().flat_map(|buffer| &buffer.attributes);
        attributes.find(|attribute| attribute.name == name)
    }
}

/// The layout of one of the host's vertex buffers.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostVertexBuffer {
    /// The distance from one element to the next, in bytes.
    pub stride: u64,
    /// Whether the buffer has one element for each vertex or for each instance.
    pub step: VertexStepMode,
    /// The vertex attributes of an element.
    pub attributes: Vec<HostAttribute>,
}

impl HostVertexBuffer {
    /// Creates a buffer with one element for each vertex. `stride` is in bytes; attributes are given as name, format
    /// and byte offset.
    pub fn new<'n>(stride: u64, attributes: impl IntoIterator<Item = (&'n str, VertexFormat, u64)>) -> Self {
        let attribute =
            |(name, format, offset): (&str, _, _)| HostAttribute { name: name.to_owned(), format, offset };
        let attributes = attributes.into_iter().map(attribute).collect();
        Self { stride, step: VertexStepMode::Vertex, attributes }
    }

    /// Makes the buffer advance per instance instead of per vertex.
    #[must_use]
    pub fn per_instance(self) -> Self {
        Self { step: VertexStepMode::Instance, ..self }
    }
}

/// A vertex attribute in a vertex buffer of the host.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostAttribute {
    /// The name of the attribute in shaders.
    pub name: String,
    /// The vertex format of the attribute, such as `float32x3`.
    pub format: VertexFormat,
    /// The offset of the attribute within an element of the buffer, in bytes.
    pub offset: u64,
}

/// A binding of bind group 2 (material) or 3 (object) that the host provides.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostResource {
    /// The name of the binding in shaders.
    pub name: String,
    /// The kind of the binding: texture, sampler, block or array.
    pub kind: HostResourceKind,
}

impl HostResource {
    /// Creates a texture or sampler binding; `wgsl` is its WGSL type, such as `texture_2d<f32>`.
    pub fn opaque(name: impl Into<String>, wgsl: impl Into<String>) -> Self {
        Self { name: name.into(), kind: HostResourceKind::Opaque(wgsl.into()) }
    }

    /// Creates a uniform block from its members, given as name, type and byte offset. `stride` is the number of bytes
    /// from one object's block to the next; 0 for a material.
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

    /// Creates an array in a storage buffer from the members of an element, given as name, type and byte offset.
    /// `stride` is the number of bytes from one element to the next.
    pub fn array<'n>(
        name: impl Into<String>,
        stride: u32,
        members: impl IntoIterator<Item = (&'n str, ValueType, u32)>,
    ) -> Self {
        let members = members.into_iter().map(HostMember::from).collect();
        Self { name: name.into(), kind: HostResourceKind::Array { members, stride } }
    }
}

/// The kind of a binding that the host provides, with its layout in memory.
#[derive(Clone, Debug, PartialEq)]
pub enum HostResourceKind {
    /// A texture or a sampler, by its WGSL type (`texture_2d<f32>`, `sampler`).
    Opaque(String),
    /// A uniform block in a buffer of the host.
    Block {
        /// The members of the block, with their types and byte offsets.
        members: Vec<HostMember>,
        /// The size of one block in bytes.
        size: u32,
        /// The distance from one object's block to the next, in bytes; a multiple of 256, or 0 for a material's block.
        stride: u32,
    },
    /// An array of structs in a storage buffer; its length follows from the size of the buffer.
    Array {
        /// The members of an element with their types and byte offsets.
        members: Vec<HostMember>,
        /// The distance from one element to the next, in bytes.
        stride: u32,
    },
}

/// A member of a host's block or of an element of a host's array.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct HostMember {
    /// The name of the member in shaders.
    pub name: String,
    /// The type of the member in shaders.
    pub value_type: ValueType,
    /// The offset within the block or element, in bytes.
    pub offset: u32,
    /// The size in bytes, including padding between columns or elements.
    pub size: u32,
}

impl From<(&str, ValueType, u32)> for HostMember {
    /// Creates a member without padding from its name, type and byte offset.
    fn from((name, value_type, offset): (&str, ValueType, u32)) -> Self {
        Self { name: name.to_owned(), value_type, offset, size: 4 * value_type.words() as u32 }
    }
}
