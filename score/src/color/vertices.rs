//! World-space normals and tangents of the vertices of a draw, beside the positions of
//! [`umbragraph_scene::trace::place`].

use glam::{DMat3, DMat4, DVec3, DVec4};
use umbragraph_scene::{Draw, Pose, Scene};

/// The directions of the vertices of a draw in the world.
pub struct Directions {
    /// Unit normals.
    pub normals: Vec<DVec3>,
    /// Tangents, and the sign of the bitangent in w; w is 0 for a vertex without a tangent. Empty if the draw has none.
    pub tangents: Vec<DVec4>,
}

/// The directions of all vertices of a draw in a pose, morphed and skinned. Tangents of vertices that morph are those of
/// the mesh, since the loader reads no morphed ones.
pub fn directions(scene: &Scene, draw: Draw, pose: &Pose) -> Directions {
    let primitive = scene.primitive(draw);
    let (mut places, mut morphed) = (Vec::new(), Vec::new());
    let normals = if primitive.targets.is_empty() {
        &primitive.normals
    } else {
        primitive.morph(pose.weights(draw.node), &mut places, &mut morphed);
        &morphed
    };
    let world = pose.world(draw.node);
    let joints: Vec<DMat4> = match (&primitive.joints, draw.skin) {
        (Some(_), Some(_)) => scene.joint_transforms(draw.node, pose).collect(),
        _ => Vec::new(),
    };
    let skinned = primitive.joints.as_ref().filter(|_| draw.skin.is_some());
    let moved_by = |vertex: usize| {
        let Some(moved) = skinned else { return world };
        let parts = moved.joints[vertex].into_iter().zip(moved.weights[vertex]);
        parts
            .filter(|(_, weight)| *weight > 0.0)
            .map(|(joint, weight)| {
                joints.get(usize::from(joint)).copied().unwrap_or(world) * f64::from(weight)
            })
            .fold(DMat4::ZERO, |sum, part| sum + part)
    };
    let vector = |vector: [f32; 3]| DVec3::from_array(vector.map(f64::from));
    let normal = |(vertex, normal): (usize, &[f32; 3])| {
        (cofactors(&moved_by(vertex)) * vector(*normal)).normalize_or(DVec3::Y)
    };
    let details = primitive.details.iter().flatten().enumerate();
    let tangent = |(vertex, detail): (usize, &umbragraph_scene::mesh::VertexDetail)| {
        let [x, y, z, sign] = detail.tangent;
        let along = moved_by(vertex).transform_vector3(vector([x, y, z]));
        let sign = if along == DVec3::ZERO { 0.0 } else { f64::from(sign) };
        along.normalize_or_zero().extend(sign)
    };
    Directions {
        normals: normals.iter().enumerate().map(normal).collect(),
        tangents: details.map(tangent).collect(),
    }
}

/// The matrix that transforms normals: the inverse transpose times the determinant's absolute value.
fn cofactors(transform: &DMat4) -> DMat3 {
    let [x, y, z] = [transform.x_axis, transform.y_axis, transform.z_axis].map(DVec4::truncate);
    let sign = if x.cross(y).dot(z) < 0.0 { -1.0 } else { 1.0 };
    DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
}
