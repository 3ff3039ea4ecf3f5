//! Tangents of primitives with a normal map that bring none: by MikkTSpace, as glTF asks for (M. Mikkelsen, "Simulation
//! of wrinkled surfaces revisited", 2008), from positions, normals and the coordinates of the normal map.
//!
//! MikkTSpace finds a tangent for each corner of a triangle. Where the corners of a vertex differ, as beside mirrored
//! coordinates, the vertex is split. Its second axis runs along the second coordinate, which runs down in glTF, while
//! glTF's bitangent points up: the sign is the opposite one.
//!
//! Limits: vertices that skins or morph targets move keep none, since tangents would have to move with them. Neither
//! have corners of triangles without area, values whose squares 32 bits do not hold, and primitives with more than
//! [`MAX_AROUND`] triangles around one vertex, around which the library recurses. The shader finds these tangents.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};

use crate::material::Map;
use crate::mesh::Primitive;

/// The maximum number of triangles that meet at one vertex; primitives with more get no tangents.
const MAX_AROUND: usize = 1024;

/// The exclusive limit of absolute values of positions and texture coordinates, so that sums of their squares fit
/// `f32`.
const MAX: f32 = 1e15;

/// The input and output of MikkTSpace: a primitive, the normal map coordinates of each vertex, and a tangent for each
/// corner of each triangle.
struct Corners<'a> {
    primitive: &'a Primitive,
    texcoords: Vec<[f32; 2]>,
    tangents: Vec<[f32; 4]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.indices[3 * face + corner] as usize
    }

    /// Returns `true` if MikkTSpace can process the primitive: values are below [`MAX`], and at most [`MAX_AROUND`]
    /// triangles meet at a vertex.
    fn fits(&self) -> bool {
        let Primitive { positions, normals, indices, .. } = self.primitive;
        let mut values = positions.iter().flatten().chain(self.texcoords.iter().flatten());
        if normals.len() != positions.len() || !values.all(|value| value.abs() < MAX) {
            return false;
        }
        // Vertices with the same values are one to the library.
        let mut around = HashMap::new();
        indices.iter().all(|index| {
            let at = *index as usize;
            let [x, y, z] = positions[at].map(f32::to_bits);
            let [a, b, c] = normals[at].map(f32::to_bits);
            let [u, v] = self.texcoords[at].map(f32::to_bits);
            let count = around.entry([x, y, z, a, b, c, u, v]).or_insert(0);
            *count += 1;
            *count <= MAX_AROUND
        })
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.indices.len() / 3
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.positions[self.vertex(face, corner)]
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.normals[self.vertex(face, corner)]
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.texcoords[self.vertex(face, corner)]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let Some([x, y, z, sign]) = space.map(|space| space.tangent_encoded()) else { return };
        let square = x * x + y * y + z * z;
        if square.is_finite() && square > 0.5 {
            self.tangents[3 * face + corner] = [x, y, z, -sign];
        }
    }
}

/// Adds tangents for a normal map to a primitive. Primitives with skinning attributes or morph targets get no tangents.
pub(super) fn add(primitive: &mut Primitive, map: &Map) {
    let Some(details) = &primitive.details else { return };
    if primitive.joints.is_some() || !primitive.targets.is_empty() {
        return;
    }
    let texcoord = |[u, v, s, t]: [f32; 4]| map.texcoord(if map.set == 0 { [u, v] } else { [s, t] });
    let texcoords = details.iter().map(|detail| texcoord(detail.texcoords)).collect();
    let tangents = vec![[0.0; 4]; primitive.indices.len()];
    let mut corners = Corners { primitive, texcoords, tangents };
    if !corners.fits() || generate_tangents(&mut corners).is_err() {
        return;
    }
    let tangents = corners.tangents;
    split(primitive, &tangents);
}

/// Writes the tangent of each corner to its vertex. A vertex with several different tangents is duplicated.
fn split(primitive: &mut Primitive, tangents: &[[f32; 4]]) {
    let Primitive { positions, normals, texcoords, details: Some(details), indices, .. } = primitive else {
        return;
    };
    let count = positions.len();
    let mut is_taken = vec![false; count];
    let mut copies = HashMap::new();
    for (index, tangent) in indices.iter_mut().zip(tangents) {
        let vertex = *index as usize;
        let copy = *copies.entry((vertex, tangent.map(f32::to_bits))).or_insert_with(|| {
            if !std::mem::replace(&mut is_taken[vertex], true) {
                details[vertex].tangent = *tangent;
                return vertex;
            }
            positions.push(positions[vertex]);
            normals.push(normals[vertex]);
            texcoords.push(texcoords[vertex]);
            details.push(details[vertex]);
            let copy = details.len() - 1;
            details[copy].tangent = *tangent;
            copy
        });
        *index = copy as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{VertexDetail, bounds_of};

    /// A flat primitive that faces +Z, with the given positions and texture coordinates.
    fn squares(corners: &[([f32; 3], [f32; 2])], indices: &[u32]) -> Primitive {
        let positions: Vec<[f32; 3]> = corners.iter().map(|(position, _)| *position).collect();
        let detail = |(_, [u, v]): &([f32; 3], [f32; 2])| VertexDetail {
            texcoords: [*u, *v, 0.0, 0.0],
            color: [1.0; 4],
            ..VertexDetail::default()
        };
        Primitive {
            normals: vec![[0.0, 0.0, 1.0]; positions.len()],
            texcoords: corners.iter().map(|(_, texcoord)| *texcoord).collect(),
            details: Some(corners.iter().map(detail).collect()),
            joints: None,
            indices: indices.to_vec(),
            material: 0,
            bounds: bounds_of(&positions),
            targets: Vec::new(),
            has_flat_normals: false,
            positions,
        }
    }

    fn map() -> Map {
        Map { texture: 0, set: 0, transform: Map::IDENTITY }
    }

    fn tangents(primitive: &Primitive) -> Vec<[f32; 4]> {
        primitive.details.iter().flatten().map(|detail| detail.tangent).collect()
    }

    #[track_caller]
    fn assert_near(found: [f32; 4], wanted: [f32; 4]) {
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?} is not {wanted:?}");
    }

    /// The first texture coordinate increases to the right and the second one downwards, as in glTF. So the bitangent,
    /// cross(normal, tangent) times the sign, points up.
    #[test]
    fn tangents_of_a_square_are_those_by_hand() {
        let corners = [
            ([0.0, 0.0, 0.0], [0.0, 1.0]),
            ([1.0, 0.0, 0.0], [1.0, 1.0]),
            ([1.0, 1.0, 0.0], [1.0, 0.0]),
            ([0.0, 1.0, 0.0], [0.0, 0.0]),
        ];
        let mut plain = squares(&corners, &[0, 1, 2, 0, 2, 3]);
        add(&mut plain, &map());
        assert_eq!(plain.positions.len(), 4);
        tangents(&plain).into_iter().for_each(|tangent| assert_near(tangent, [1.0, 0.0, 0.0, 1.0]));
        // Turned by a quarter: the first coordinate runs up, and the second one to the right.
        let turned = corners.map(|(position, [u, v])| (position, [1.0 - v, u]));
        let mut turned = squares(&turned, &[0, 1, 2, 0, 2, 3]);
        add(&mut turned, &map());
        tangents(&turned).into_iter().for_each(|tangent| assert_near(tangent, [0.0, 1.0, 0.0, 1.0]));
        // A transform of the map counts.
        let mut transformed = squares(&corners, &[0, 1, 2, 0, 2, 3]);
        add(&mut transformed, &Map { transform: [[-1.0, 0.0, 1.0], [0.0, 1.0, 0.0]], ..map() });
        tangents(&transformed).into_iter().for_each(|tangent| assert_near(tangent, [-1.0, 0.0, 0.0, -1.0]));
    }

    /// Two squares side by side have mirrored texture coordinates, so the vertices of their common edge are duplicated.
    #[test]
    fn mirrored_coordinates_split_their_edge() {
        let corners = [
            ([-1.0, 0.0, 0.0], [0.0, 1.0]),
            ([0.0, 0.0, 0.0], [1.0, 1.0]),
            ([0.0, 1.0, 0.0], [1.0, 0.0]),
            ([-1.0, 1.0, 0.0], [0.0, 0.0]),
            ([1.0, 0.0, 0.0], [0.0, 1.0]),
            ([1.0, 1.0, 0.0], [0.0, 0.0]),
        ];
        let mut mirrored = squares(&corners, &[0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2]);
        add(&mut mirrored, &map());
        assert_eq!((mirrored.positions.len(), mirrored.normals.len(), mirrored.texcoords.len()), (8, 8, 8));
        let tangents = tangents(&mirrored);
        for (at, index) in mirrored.indices.iter().enumerate() {
            let sign = if at < 6 { 1.0 } else { -1.0 };
            assert_near(tangents[*index as usize], [sign, 0.0, 0.0, sign]);
            assert_eq!(mirrored.positions[*index as usize].map(|value| value.abs() <= 1.0), [true; 3]);
        }
        // The corners are where they were.
        let shape = |primitive: &Primitive| -> Vec<[f32; 3]> {
            primitive.indices.iter().map(|index| primitive.positions[*index as usize]).collect()
        };
        assert_eq!(shape(&mirrored), shape(&squares(&corners, &[0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2])));
    }

    #[test]
    fn what_has_no_direction_has_no_tangent() {
        let corners = [([0.0; 3], [0.5; 2]), ([1.0, 0.0, 0.0], [0.5; 2]), ([0.0, 1.0, 0.0], [0.5; 2])];
        let mut even = squares(&corners, &[0, 1, 2]);
        add(&mut even, &map());
        assert!(tangents(&even).iter().flatten().all(|value| value.is_finite()));
        let mut huge =
            squares(&corners.map(|(position, _)| (position.map(|one| one * 1e30), [1e30, 0.0])), &[0, 1, 2]);
        add(&mut huge, &map());
        assert_eq!(tangents(&huge), [[0.0; 4]; 3]);
        // A fan of which each triangle has the first vertex.
        let rim = (0..5000).map(|at| {
            let angle = at as f32 * 1e-3;
            ([angle.cos(), angle.sin(), 0.0], [angle, 1.0])
        });
        let corners: Vec<_> = std::iter::once(([0.0; 3], [0.0; 2])).chain(rim).collect();
        let indices: Vec<u32> = (1..5000).flat_map(|at| [0, at, at + 1]).collect();
        let mut fan = squares(&corners, &indices);
        add(&mut fan, &map());
        assert_eq!(fan.positions.len(), 5001);
    }
}
