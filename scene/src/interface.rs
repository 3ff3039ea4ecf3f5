//! Storage of a scene for pipelines: the host's side of the draw contract, without a device.
//!
//! A scene has one geometry contract, [`GEOMETRY`]. Its vertex streams are separate buffers, so that a pass binds only
//! the streams that it reads. The blocks of materials and objects are plain structs; one list of members gives both
//! their bytes and the interface.

use bytemuck::{Pod, Zeroable};
use std::collections::BTreeSet;
use umbragraph_pipeline::data::ValueType;
use umbragraph_pipeline::draw::{DOUBLE_SIDED, HostInterface, HostResource, HostVertexBuffer, PropertySet};
use umbragraph_pipeline::wgpu_types::VertexFormat;

use crate::filter::FILTERS;
use crate::material::{AlphaMode, Map, Material};
use crate::mesh::VertexDetail;
use crate::scene::{Draw, Scene};

/// The name of the geometry (vertex streams and bindings of draws) that scenes provide. Passes of a pipeline refer to
/// it by this name.
pub const GEOMETRY: &str = "scene";

/// The name of the storage buffer that pipelines import to trace rays through a scene ([`crate::trace::packed`]).
pub const RAYS: &str = "scene_rays";

/// The name of the property of draws whose material has alpha mode `MASK`: fragments below the alpha cutoff are
/// discarded.
pub const ALPHA_MASKED: &str = "alpha_masked";

/// The name of the property of draws that need the full physically based material model, beyond base colour and
/// constant emission.
pub const PBR: &str = "pbr";

/// The names of all properties that draws of a scene can have. The index of a name is the number of its bit in a
/// [`PropertySet`].
const PROPERTIES: [&str; 3] = [ALPHA_MASKED, DOUBLE_SIDED, PBR];

/// The distance in bytes between consecutive uniform blocks in a buffer. Every device supports this value as the
/// alignment of dynamic offsets.
pub const BLOCK_STRIDE: u32 = 256;

/// The vertex streams that have a buffer of their own: name, format, and bytes per vertex.
pub(crate) const STREAMS: [(&str, VertexFormat, u64); 3] = [
    ("position", VertexFormat::Float32x3, 12),
    ("normal", VertexFormat::Float32x3, 12),
    ("texcoord", VertexFormat::Float32x2, 8),
];

/// The vertex stream with the positions in the previous pose, for motion vectors: name, format, and bytes per vertex.
pub(crate) const PREVIOUS: (&str, VertexFormat, u64) = ("previous_position", VertexFormat::Float32x3, 12);

/// The attributes of [`VertexDetail`]: name, format, and byte offset in the struct.
pub(crate) const DETAILS: [(&str, VertexFormat, u64); 3] = [
    ("texcoords", VertexFormat::Float32x4, std::mem::offset_of!(VertexDetail, texcoords) as u64),
    ("tangent", VertexFormat::Float32x4, std::mem::offset_of!(VertexDetail, tangent) as u64),
    ("color", VertexFormat::Float32x4, std::mem::offset_of!(VertexDetail, color) as u64),
];

/// The names of the texture maps of a material. For each name, shaders have a texture `<name>_texture` and a sampler
/// `<name>_sampler`.
pub(crate) const MAPS: [&str; 5] = ["base_color", "metallic_roughness", "normal", "occlusion", "emissive"];

/// The texture maps of a material in the order of [`MAPS`]; `None` for a map that the material lacks. The flag of each
/// map is `true` if its texels are sRGB-encoded colours.
pub(crate) fn maps(material: &Material) -> [(Option<Map>, bool); MAPS.len()] {
    [
        (material.base_color_map, true),
        (material.metallic_roughness_map, false),
        (material.normal_map, false),
        (material.occlusion_map, false),
        (material.emissive_map, true),
    ]
}

/// Declares a uniform block as a `#[repr(C)]` struct, together with the list of its members and their WGSL types.
macro_rules! block {
    ($(#[$meta:meta])* $block:ident { $(#[doc = $doc:literal] $member:ident: $type:ty = $value:expr,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
        pub struct $block {
            $(#[doc = $doc] pub $member: $type,)*
        }

        #[cfg(test)]
        impl $block {
            /// The members in memory order: name, WGSL type, and description for shader source.
            pub(crate) const MEMBERS: &[(&str, ValueType, &str)] =
                &[$((stringify!($member), $value, $doc)),*];
        }

        impl $block {
            /// The size of the block in bytes by the rules of WGSL, padding at its end included.
            pub const SIZE: u32 = (std::mem::size_of::<Self>() as u32).next_multiple_of(16);

            /// Describes the block as a uniform buffer binding with this name. `stride` is the distance in bytes
            /// between consecutive blocks for objects, or 0 for a material.
            fn slot(name: &str, stride: u32) -> HostResource {
                let members = [$((stringify!($member), $value, std::mem::offset_of!(Self, $member) as u32)),*];
                HostResource::block(name, stride, members)
            }
        }
    };
}

block! {
    /// The uniform block of a material, with the values that shaders of every draw use.
    MaterialBlock {
        /// Linear colour and alpha, multiplied with the texture.
        base_color: [f32; 4] = ValueType::VEC4,
        /// Linear emitted colour.
        emissive: [f32; 3] = ValueType::VEC3,
        /// Alpha below this is a hole; 0 in materials without holes.
        alpha_cutoff: f32 = ValueType::F32,
        /// 1 if the material receives shadows.
        receive_shadow: u32 = ValueType::U32,
    }
}

block! {
    /// The second uniform block of a material, used only by draws with the property [`PBR`]: reflectance and texture
    /// transforms. The texture coordinates of each map are transformed by a matrix of two rows. The w component of the
    /// first row is the index of the coordinate set.
    MaterialDetailBlock {
        /// Texture coordinates of the metallic and roughness map: first row of their matrix, and in w the set.
        metallic_roughness_u: [f32; 4] = ValueType::VEC4,
        /// Texture coordinates of the metallic and roughness map: second row of their matrix.
        metallic_roughness_v: [f32; 4] = ValueType::VEC4,
        /// Texture coordinates of the normal map: first row of their matrix, and in w the set.
        normal_u: [f32; 4] = ValueType::VEC4,
        /// Texture coordinates of the normal map: second row of their matrix.
        normal_v: [f32; 4] = ValueType::VEC4,
        /// Texture coordinates of the occlusion map: first row of their matrix, and in w the set.
        occlusion_u: [f32; 4] = ValueType::VEC4,
        /// Texture coordinates of the occlusion map: second row of their matrix.
        occlusion_v: [f32; 4] = ValueType::VEC4,
        /// Texture coordinates of the emissive map: first row of their matrix, and in w the set.
        emissive_u: [f32; 4] = ValueType::VEC4,
        /// Texture coordinates of the emissive map: second row of their matrix.
        emissive_v: [f32; 4] = ValueType::VEC4,
        /// Reflectance of the dielectric at normal incidence.
        f0: [f32; 3] = ValueType::VEC3,
        /// Reflectance of the dielectric at grazing incidence.
        f90: f32 = ValueType::F32,
        /// 1 for a metal.
        metallic: f32 = ValueType::F32,
        /// 1 for the roughest surface.
        roughness: f32 = ValueType::F32,
        /// Factor of the slopes of the normal map.
        normal_scale: f32 = ValueType::F32,
        /// Weight of the occlusion map.
        occlusion_strength: f32 = ValueType::F32,
        /// 1 for a colour that no light changes.
        unlit: f32 = ValueType::F32,
    }
}

impl From<&Material> for MaterialBlock {
    fn from(material: &Material) -> Self {
        Self {
            base_color: material.base_color,
            emissive: material.emissive,
            alpha_cutoff: match material.alpha_mode {
                AlphaMode::Mask { cutoff } => cutoff,
                AlphaMode::Opaque | AlphaMode::Blend => 0.0,
            },
            receive_shadow: u32::from(material.receive_shadow),
        }
    }
}

impl From<&Material> for MaterialDetailBlock {
    fn from(material: &Material) -> Self {
        let [_, metallic_roughness, normal, occlusion, emissive] = maps(material).map(|(map, _)| {
            let set = map.map_or(0, |map| map.set);
            let [[a, b, x], [c, d, y]] = map.map_or(Map::IDENTITY, |map| map.transform);
            [[a, b, x, set as f32], [c, d, y, 0.0]]
        });
        Self {
            metallic_roughness_u: metallic_roughness[0],
            metallic_roughness_v: metallic_roughness[1],
            normal_u: normal[0],
            normal_v: normal[1],
            occlusion_u: occlusion[0],
            occlusion_v: occlusion[1],
            emissive_u: emissive[0],
            emissive_v: emissive[1],
            f0: material.f0,
            f90: material.f90,
            metallic: material.metallic,
            roughness: material.roughness,
            // Without a map its texel is white, which is no normal.
            normal_scale: material.normal_map.map_or(0.0, |_| material.normal_scale),
            occlusion_strength: material.occlusion_strength,
            unlit: f32::from(u8::from(material.unlit)),
        }
    }
}

block! {
    /// The uniform block of a draw: the transforms of the drawn object to world space.
    ObjectBlock {
        /// From the mesh's space to the world.
        world_from_object: [[f32; 4]; 4] = ValueType::MAT4,
        /// Turns normals of the mesh into world normals, whose length has no meaning.
        normal_from_object: [[f32; 4]; 4] = ValueType::MAT4,
        /// 1 if the object receives shadows.
        receive_shadow: u32 = ValueType::U32,
    }
}

block! {
    /// The uniform block of a draw for motion vectors: the transform of the drawn object in the previous pose.
    MotionBlock {
        /// From the mesh's space to the world, in the pose before.
        previous_world_from_object: [[f32; 4]; 4] = ValueType::MAT4,
    }
}

/// The set of properties that a draw has, out of [`ALPHA_MASKED`], [`DOUBLE_SIDED`] and [`PBR`].
pub fn properties(scene: &Scene, draw: Draw) -> PropertySet {
    let is_double_sided = scene.material(draw).double_sided;
    let properties = [scene.is_alpha_masked(draw), is_double_sided, scene.primitive(draw).details.is_some()];
    PropertySet((0..).zip(properties).map(|(at, has)| u32::from(has) << at).sum())
}

/// The vertex buffer layouts and bindings of the geometry [`GEOMETRY`], with the property sets that occur among the
/// draws of `scene`.
pub fn interface(scene: &Scene) -> HostInterface {
    let sets: BTreeSet<PropertySet> =
        scene.draws_of_all_details().map(|draw| properties(scene, draw)).collect();
    any_scene().properties(PROPERTIES, sets)
}

/// The vertex buffer layouts and bindings of the geometry [`GEOMETRY`], which are the same for every scene, with all
/// possible property sets.
pub fn any_scene() -> HostInterface {
    let stream = |(name, format, stride): (&'static str, VertexFormat, u64)| {
        HostVertexBuffer::new(stride, [(name, format, 0)])
    };
    let interface = STREAMS.into_iter().map(stream).fold(HostInterface::new(), HostInterface::vertices);
    let interface = interface
        .vertices(HostVertexBuffer::new(size_of::<VertexDetail>() as u64, DETAILS))
        .vertices(stream(PREVIOUS))
        .material(MaterialBlock::slot("material", 0))
        .material(MaterialDetailBlock::slot("material_detail", 0));
    let interface = MAPS.into_iter().fold(interface, |interface, map| {
        interface
            .material(HostResource::opaque(format!("{map}_texture"), "texture_2d<f32>"))
            .material(HostResource::opaque(format!("{map}_sampler"), "sampler"))
    });
    interface
        .object(ObjectBlock::slot("object", BLOCK_STRIDE))
        .object(MotionBlock::slot("motion", BLOCK_STRIDE))
        .properties(PROPERTIES, (0..1 << PROPERTIES.len()).map(PropertySet))
        .filters(FILTERS)
}

#[cfg(test)]
mod tests {
    use umbragraph_pipeline::draw::{HostMember, HostResourceKind};

    use super::*;

    /// The byte offsets of the members of a uniform block and the size of the block in bytes, by the alignment rules of
    /// WGSL.
    fn wgsl_offsets(members: &[HostMember]) -> (Vec<u32>, u32) {
        let (mut at, mut offsets) = (0_u32, Vec::new());
        for member in members {
            let alignment = match member.value_type.rows {
                1 => 4,
                2 => 8,
                _ => 16,
            };
            at = at.next_multiple_of(alignment);
            offsets.push(at);
            at += member.size;
        }
        (offsets, at.next_multiple_of(16))
    }

    #[test]
    fn blocks_lie_in_memory_as_wgsl_reads_them() {
        let interface = any_scene();
        for (slot, bytes) in [
            (&interface.material[0], MaterialBlock::SIZE),
            (&interface.material[1], MaterialDetailBlock::SIZE),
            (&interface.object[0], ObjectBlock::SIZE),
            (&interface.object[1], MotionBlock::SIZE),
        ] {
            let HostResourceKind::Block { members, size, .. } = &slot.kind else { panic!("{slot:?}") };
            assert_eq!(*size, bytes);
            let offsets: Vec<u32> = members.iter().map(|member| member.offset).collect();
            assert_eq!((offsets, bytes), wgsl_offsets(members));
            assert!(bytes <= BLOCK_STRIDE);
        }
    }
}
