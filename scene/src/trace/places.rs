//! World-space vertices of a draw.
//!
//! Vertices are morphed in 32 bits, as they are uploaded, and transformed in 64: by the node of the draw, or by the joints of
//! a skinned vertex, whose weights sum to one.

use glam::{DMat4, DVec3};

use crate::pose::Pose;
use crate::scene::{Draw, Scene};

/// Replaces the contents of `places` with the world-space vertices of a draw in a pose, in metres.
pub fn place(scene: &Scene, draw: Draw, pose: &Pose, places: &mut Vec<DVec3>) {
    let primitive = scene.primitive(draw);
    let world = pose.world(draw.node);
    let (mut morphed, mut normals) = (Vec::new(), Vec::new());
    let positions = if primitive.targets.is_empty() {
        &primitive.positions
    } else {
        primitive.morph(pose.weights(draw.node), &mut morphed, &mut normals);
        &morphed
    };
    let joints: Vec<DMat4> = match (&primitive.joints, draw.skin) {
        (Some(_), Some(_)) => scene.joint_transforms(draw.node, pose).collect(),
        _ => Vec::new(),
    };
    let skinned = primitive.joints.as_ref().filter(|_| draw.skin.is_some());
    places.clear();
    places.extend(positions.iter().enumerate().map(|(vertex, position)| {
        let point = DVec3::from_array(position.map(f64::from));
        let Some(moved) = skinned else { return world.transform_point3(point) };
        let parts = moved.joints[vertex].into_iter().zip(moved.weights[vertex]);
        let joint = |index: u16| joints.get(usize::from(index)).copied().unwrap_or(world);
        let parts = parts.filter(|(_, weight)| *weight > 0.0);
        parts.map(|(index, weight)| joint(index).transform_point3(point) * f64::from(weight)).sum()
    }));
}
