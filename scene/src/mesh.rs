//! Triangles: meshes, their primitives, and flat normals.
//!
//! A primitive is an indexed triangle list whose vertex streams all have the same length. Strips and fans become lists,
//! and a primitive without indices gets them, so that users have one case only. If a file gives no normals, glTF
//! requires flat ones: each triangle then gets three vertices of its own.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use umbragraph_pipeline::frame::Bounds;

use crate::morph::MorphTarget;

/// A group of primitives that a node places together.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// The primitives, in the order of the file.
    pub primitives: Vec<Primitive>,
    /// Whether the mesh casts shadows (`extras.castShadow`, true where absent).
    pub cast_shadow: bool,
    /// Whether the mesh receives shadows (`extras.receiveShadow`, true where absent).
    pub receive_shadow: bool,
    /// The weight of each morph target, if a node declares none.
    pub weights: Vec<f32>,
}

/// Triangles with one material.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// Positions in metres, in the space of the mesh.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, pointing outward.
    pub normals: Vec<[f32; 3]>,
    /// The texture coordinates of the base colour texture; zero where the file has none.
    pub texcoords: Vec<[f32; 2]>,
    /// The other attributes of each vertex, in a primitive whose shader reads them.
    pub details: Option<Vec<VertexDetail>>,
    /// The joints that move each vertex, in a primitive that can be skinned.
    pub joints: Option<JointWeights>,
    /// Three vertices for each triangle, counter-clockwise seen from its front; every index is below the number of
    /// vertices.
    pub indices: Vec<u32>,
    /// The index of the material in [`Scene::materials`](crate::Scene::materials).
    pub material: usize,
    /// The box around the positions, in the space of the mesh.
    pub bounds: Bounds,
    /// The shapes that the vertices can go towards.
    pub targets: Vec<MorphTarget>,
    /// Whether the file gives no normals, so that these are the triangles' normals.
    pub has_flat_normals: bool,
}

/// Attributes of a vertex that only whole materials read.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VertexDetail {
    /// The texture coordinates of the sets 0 and 1; zero where the file has none.
    pub texcoords: [f32; 4],
    /// The unit tangent along the first texture coordinate and the sign of the bitangent, 0 for a vertex without
    /// tangent.
    pub tangent: [f32; 4],
    /// Linear colour and alpha, multiplied with the base colour.
    pub color: [f32; 4],
}

impl VertexDetail {
    /// The details of `count` vertices by attribute; an attribute that is absent has its default.
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

/// Up to four joints of each vertex of a primitive, and the weight of each.
#[derive(Clone, Debug)]
pub struct JointWeights {
    /// Indices into the joints of the skin with which the mesh is drawn.
    pub joints: Vec<[u16; 4]>,
    /// Weights, not negative, with the sum 1.
    pub weights: Vec<[f32; 4]>,
}

/// The box around positions; empty for none.
pub fn bounds_of(positions: &[[f32; 3]]) -> Bounds {
    positions
        .iter()
        .fold(Bounds::EMPTY, |bounds, position| bounds.with(Vec3::from_array(*position).as_dvec3()))
}

/// The unit normal of a triangle whose corners are counter-clockwise seen from its front; +Y for a triangle without
/// area. Computed in `f64`, so that small triangles far from the origin keep their direction.
pub fn face_normal(corners: [[f32; 3]; 3]) -> [f32; 3] {
    let [a, b, c] = corners.map(|corner| Vec3::from_array(corner).as_dvec3());
    direction((b - a).cross(c - a))
}

/// The normals of triangles that share no vertices, three for each.
pub(crate) fn flat_normals(positions: &[[f32; 3]]) -> impl Iterator<Item = [f32; 3]> {
    let (triangles, _) = positions.as_chunks();
    triangles.iter().flat_map(|corners| [face_normal(*corners); 3])
}

/// A normal of unit length; +Y for one of length zero.
pub(crate) fn unit(normal: [f32; 3]) -> [f32; 3] {
    direction(Vec3::from_array(normal).as_dvec3())
}

/// The unit vector of a direction; +Y for none.
pub(crate) fn direction(vector: DVec3) -> [f32; 3] {
    vector.try_normalize().unwrap_or(DVec3::Y).as_vec3().to_array()
}

/// The indices of the triangles of a strip: every further vertex makes a triangle with the two before it, and every
/// second one is turned around to keep the winding.
pub fn strip_to_list(strip: &[u32]) -> Vec<u32> {
    let triangle = |(at, corners): (usize, &[u32])| {
        if at % 2 == 0 { [corners[0], corners[1], corners[2]] } else { [corners[0], corners[2], corners[1]] }
    };
    strip.windows(3).enumerate().flat_map(triangle).collect()
}

/// The indices of the triangles of a fan: every further vertex makes a triangle with the one before it and the first.
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
