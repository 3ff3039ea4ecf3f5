//! Triangles: meshes, their primitives, and flat normals.
//!
//! A primitive is an indexed triangle list whose vertex streams all have the same length. Strips and fans become lists,
//! and a primitive without indices gets them, so that users have one case only. If a file gives no normals, glTF
//! requires flat ones: each triangle then gets three vertices of its own.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use umbragraph_pipeline::frame::Bounds;

use crate::morph::MorphTarget;

/// A group of primitives that a node places in the scene as one object.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// The primitives, in the order of the file.
    pub primitives: Vec<Primitive>,
    /// Whether the mesh casts shadows (glTF property `extras.castShadow`, `true` if absent).
    pub cast_shadow: bool,
    /// Whether the mesh receives shadows (glTF property `extras.receiveShadow`, `true` if absent).
    pub receive_shadow: bool,
    /// The default weight of each morph target, for nodes that declare no weights; empty if the mesh has no targets.
    pub weights: Vec<f32>,
}

/// An indexed triangle list with one material.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// Positions of the vertices in metres, in the space of the mesh.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals of the vertices, pointing outwards, in the space of the mesh.
    pub normals: Vec<[f32; 3]>,
    /// For each vertex, the coordinates at which the base colour texture is sampled, with its `KHR_texture_transform`
    /// applied. Zero if the file has no texture coordinates.
    pub texcoords: Vec<[f32; 2]>,
    /// The texture coordinate sets, tangent and colour of each vertex. `None` if no shader for the primitive's material
    /// reads them.
    pub details: Option<Vec<VertexDetail>>,
    /// The joint indices and joint weights of each vertex. `None` for a primitive without skinning attributes.
    pub joints: Option<JointWeights>,
    /// Three vertex indices for each triangle, counter-clockwise seen from the front; each is below the number of
    /// vertices.
    pub indices: Vec<u32>,
    /// The index of the material in [`Scene::materials`](crate::Scene::materials).
    pub material: usize,
    /// The bounding box of the positions, in metres in the space of the mesh.
    pub bounds: Bounds,
    /// The morph targets; empty if the primitive has none.
    pub targets: Vec<MorphTarget>,
    /// Whether `normals` holds computed face normals, because the file has no usable normals for the primitive.
    pub has_flat_normals: bool,
}

/// Vertex attributes that shaders read only for physically based materials (draws with the property `pbr`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VertexDetail {
    /// The texture coordinates of set 0 (x, y) and set 1 (z, w); zero for a set that is missing or unused.
    pub texcoords: [f32; 4],
    /// The unit tangent along the first texture coordinate (x, y, z) and the sign of the bitangent (w). All zero for a
    /// vertex without a tangent.
    pub tangent: [f32; 4],
    /// Linear vertex colour and alpha, multiplied with the base colour; white if the file has no vertex colours.
    pub color: [f32; 4],
}

impl VertexDetail {
    /// Combines two texture coordinate sets, tangents and colours into one element for each of `count` vertices.
    /// Missing texture coordinates and tangents become zero, missing colours white.
    pub(crate) fn all(
        count: usize,
        [first, second]: [Option<Vec<[f32; 2]>>; 2],
        tangents: Option<Vec<[f32; 4]>>,
        colors: Option<Vec<[f32; 4]>>,
    ) -> Vec<Self> {
        let pair = |set: &Option<Vec<[f32; 2]>>, at: usize| {
            set.as_ref().and_then(|set| set.get(at).copied()).unwrap_or_default()
        };
        let detail = |at: usize| {
            let ([u, v], [s, t]) = (pair(&first, at), pair(&second, at));
            let of = |list: &Option<Vec<[f32; 4]>>| list.as_ref().and_then(|list| list.get(at).copied());
            let tangent = of(&tangents).unwrap_or_default();
            Self { texcoords: [u, v, s, t], tangent, color: of(&colors).unwrap_or([1.0; 4]) }
        };
        (0..count).map(detail).collect()
    }
}

/// Up to four joints for each vertex of a primitive, and their weights.
#[derive(Clone, Debug)]
pub struct JointWeights {
    /// For each vertex, four indices into [`Skin::joints`](crate::skin::Skin::joints) of the skin used for the draw.
    pub joints: Vec<[u16; 4]>,
    /// For each vertex, the weights of its four joints: not negative, with a sum of 1.
    pub weights: Vec<[f32; 4]>,
}

/// The axis-aligned bounding box of positions; the empty box if the list is empty.
pub fn bounds_of(positions: &[[f32; 3]]) -> Bounds {
    positions
        .iter()
        .fold(Bounds::EMPTY, |bounds, position| bounds.with(Vec3::from_array(*position).as_dvec3()))
}

/// The unit normal of a triangle whose corners are counter-clockwise seen from its front; +Y for a triangle without
/// area. It is computed in `f64`, so that small triangles far from the origin keep their direction.
pub fn face_normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| Vec3::from_array(corner).as_dvec3());
    direction((b - a).cross(c - a))
}

/// The face normals of triangles given as three positions each. Each normal is returned three times, once for each
/// vertex of its triangle.
pub(crate) fn flat_normals(positions: &[[f32; 3]]) -> impl Iterator<Item = [f32; 3]> {
    let (triangles, _) = positions.as_chunks();
    triangles.iter().flat_map(|corners| [face_normal(*corners); 3])
}

/// Normalizes a normal; returns +Y for a normal of length zero.
pub(crate) fn unit(normal: [f32; 3]) -> [f32; 3] {
    direction(Vec3::from_array(normal).as_dvec3())
}

/// Normalizes a vector; returns +Y for a vector of length zero.
pub(crate) fn direction(vector: DVec3) -> [f32; 3] {
    vector.try_normalize().unwrap_or(DVec3::Y).as_vec3().to_array()
}

/// Converts the indices of a triangle strip to a triangle list. Every second triangle of a strip has the reverse
/// winding, which is corrected in the list.
pub fn strip_to_list(strip: &[u32]) -> Vec<u32> {
    let triangle = |(at, corners): (usize, &[u32])| {
        if at % 2 == 0 { [corners[0], corners[1], corners[2]] } else { [corners[0], corners[2], corners[1]] }
    };
    strip.windows(3).enumerate().flat_map(triangle).collect()
}

/// Converts the indices of a triangle fan, whose triangles all share the first vertex, to a triangle list.
pub fn fan_to_list(fan: &[u32]) -> Vec<u32> {
    let Some((first, rest)) = fan.split_first() else { return Vec::new() };
    rest.windows(2).flat_map(|pair| [pair[0], pair[1], *first]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_counter_clockwise_from_above_faces_up() {
        assert_eq!(face_normal([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn a_triangle_without_area_gets_a_normal_that_is_finite() {
        assert_eq!(face_normal([[1.0; 3]; 3]), [0.0, 1.0, 0.0]);
    }

    #[test]
    fn a_strip_keeps_its_winding() {
        assert_eq!(strip_to_list(&[0, 1, 2, 3, 4]), [0, 1, 2, 1, 3, 2, 2, 3, 4]);
        assert!(strip_to_list(&[0, 1]).is_empty());
    }

    #[test]
    fn a_fan_turns_around_its_first_vertex() {
        assert_eq!(fan_to_list(&[7, 1, 2, 3]), [1, 2, 7, 2, 3, 7]);
        assert!(fan_to_list(&[]).is_empty());
    }
}
