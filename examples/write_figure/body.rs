//! The figure: joints, the mesh around them, and how they move.

use crate::glb::document::{MaterialId, NodeId};
use crate::glb::functions::sin_cos;
use crate::glb::solids::ball;
use crate::glb::streams::Weight;
use crate::glb::{Document, Placement, Shape, Vec3, vec3};

/// A joint: name, index of the parent, and position at rest in metres. `limb` is the end of the limb that starts at the
/// joint, and its radius at both ends; `None` for no limb.
struct Joint {
    name: &'static str,
    parent: Option<usize>,
    at: Vec3,
    limb: Option<(Vec3, f64, f64)>,
}

fn joints() -> Vec<Joint> {
    let joint = |name, parent, at: (f64, f64, f64), limb: Option<((f64, f64, f64), f64, f64)>| {
        let limb = limb.map(|((x, y, z), near, far)| (vec3(x, y, z), near, far));
        Joint { name, parent, at: vec3(at.0, at.1, at.2), limb }
    };
    vec![
        joint("hips", None, (0.0, 0.92, 0.0), Some(((0.0, 1.12, 0.0), 0.15, 0.13))),
        joint("chest", Some(0), (0.0, 1.12, 0.0), Some(((0.0, 1.42, 0.0), 0.13, 0.16))),
        joint("head", Some(1), (0.0, 1.50, 0.0), Some(((0.0, 1.70, 0.0), 0.06, 0.11))),
        joint("left arm", Some(1), (-0.20, 1.40, 0.0), Some(((-0.24, 1.12, 0.0), 0.06, 0.05))),
        joint("left forearm", Some(3), (-0.24, 1.12, 0.0), Some(((-0.26, 0.86, 0.04), 0.05, 0.035))),
        joint("right arm", Some(1), (0.20, 1.40, 0.0), Some(((0.24, 1.12, 0.0), 0.06, 0.05))),
        joint("right forearm", Some(5), (0.24, 1.12, 0.0), Some(((0.26, 0.86, 0.04), 0.05, 0.035))),
        joint("left thigh", Some(0), (-0.10, 0.90, 0.0), Some(((-0.12, 0.48, 0.01), 0.09, 0.065))),
        joint("left shin", Some(7), (-0.12, 0.48, 0.01), Some(((-0.13, 0.06, 0.0), 0.065, 0.045))),
        joint("right thigh", Some(0), (0.10, 0.90, 0.0), Some(((0.12, 0.48, 0.01), 0.09, 0.065))),
        joint("right shin", Some(9), (0.12, 0.48, 0.01), Some(((0.13, 0.06, 0.0), 0.065, 0.045))),
    ]
}

/// Adds the skinned figure with its animation to a document.
pub(crate) fn add(document: &mut Document, material: MaterialId, placement: Placement) {
    let joints = joints();
    let root = document.group("figure", None, placement);
    let mut nodes: Vec<NodeId> = Vec::new();
    for joint in &joints {
        let (parent, origin) = match joint.parent {
            Some(parent) => (nodes[parent], joints[parent].at),
            None => (root, Vec3::ZERO),
        };
        let offset = joint.at - origin;
        nodes.push(document.group(joint.name, Some(parent), Placement::at(offset.x, offset.y, offset.z)));
    }
    let (shape, weights) = mesh(&joints);
    let mesh = document.skinned_mesh("figure", &[(material, &shape, Some(&weights))]);
    let node = document.place("figure mesh", Some(root), mesh, Placement::IDENTITY);
    let bones: Vec<(NodeId, Vec3)> = nodes.iter().copied().zip(joints.iter().map(|joint| joint.at)).collect();
    document.skin(node, &bones);
    animate(document, &nodes, &joints);
}

/// The mesh of capsules around the limbs, with weights. Vertices near a joint also follow the joint's parent.
fn mesh(joints: &[Joint]) -> (Shape, Vec<Weight>) {
    const CAP: u32 = 4;
    const CONE: u32 = 4;
    const SIDES: u32 = 12;
    let mut shape = Shape::new();
    let mut weights = Vec::new();
    for (number, joint) in joints.iter().enumerate() {
        let Some((end, near, far)) = joint.limb else { continue };
        let length = (end - joint.at).length();
        // Half balls at both ends, a cone between.
        let cap = |step: u32| sin_cos(f64::from(step) / f64::from(CAP) * std::f64::consts::FRAC_PI_2);
        let mut profile: Vec<(f64, f64)> = vec![(0.0, -near)];
        profile.extend((1..CAP).map(cap).map(|(sin, cos)| (near * sin, -near * cos)));
        profile.extend((0..=CONE).map(|ring| {
            let t = f64::from(ring) / f64::from(CONE);
            (near + (far - near) * t, length * t)
        }));
        profile.extend((1..CAP).map(cap).map(|(sin, cos)| (far * cos, length + far * sin)));
        profile.push((0.0, length + far));
        let limb = crate::glb::solids::lathe(&profile, SIDES).placed(&Placement::pointing(joint.at, end));
        shape.join(&limb);
        let parent = joint.parent.unwrap_or(number) as u8;
        let axis = (end - joint.at).normalize_or(Vec3::Y);
        for vertex in &limb.vertices {
            let along = (vertex.position - joint.at).dot(axis) / length;
            let own = (0.5 + 2.5 * along).clamp(0.0, 1.0);
            weights.push((parent, number as u8, own));
        }
    }
    for (number, at, size) in [(8, vec3(-0.13, 0.04, 0.06), 0.05), (10, vec3(0.13, 0.04, 0.06), 0.05)] {
        let foot = ball(8, 12).placed(&Placement::at(at.x, at.y, at.z).scaled(0.055, size, 0.13));
        shape.join(&foot);
        weights.extend(foot.vertices.iter().map(|_| (number, number, 1.0)));
    }
    (shape, weights)
}

/// The quaternion (x, y, z, w) of a rotation about a unit axis, by an angle in degrees.
fn turn(axis: Vec3, degrees: f64) -> [f64; 4] {
    let (sin, cos) = sin_cos(0.5 * degrees.to_radians());
    [axis.x * sin, axis.y * sin, axis.z * sin, cos]
}

fn animate(document: &mut Document, nodes: &[NodeId], joints: &[Joint]) {
    let (x, z) = (vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0));
    let times = vec![0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0];
    let keys =
        |axis: Vec3, degrees: [f64; 9]| degrees.into_iter().flat_map(|angle| turn(axis, angle)).collect();
    let channel = |name: &str, axis: Vec3, degrees: [f64; 9]| {
        let at = joints.iter().position(|joint| joint.name == name).unwrap_or(0);
        (nodes[at], "rotation", times.clone(), keys(axis, degrees))
    };
    document.animation(
        "wave",
        &[
            channel("right arm", z, [8.0, 60.0, 125.0, 130.0, 125.0, 130.0, 120.0, 60.0, 8.0]),
            channel("right forearm", z, [0.0, 15.0, 45.0, 5.0, 45.0, 5.0, 40.0, 15.0, 0.0]),
            channel("left arm", z, [-8.0, -10.0, -14.0, -16.0, -14.0, -12.0, -10.0, -8.0, -8.0]),
            channel("left forearm", x, [-6.0, -12.0, -25.0, -30.0, -25.0, -20.0, -12.0, -8.0, -6.0]),
            channel("chest", z, [0.0, -3.0, -7.0, -5.0, -7.0, -5.0, -6.0, -3.0, 0.0]),
            channel("head", z, [0.0, 5.0, 10.0, 6.0, 10.0, 6.0, 8.0, 4.0, 0.0]),
            channel("left thigh", x, [0.0, -6.0, -14.0, -18.0, -14.0, -10.0, -6.0, -2.0, 0.0]),
            channel("left shin", x, [0.0, 10.0, 24.0, 30.0, 24.0, 16.0, 10.0, 4.0, 0.0]),
        ],
    );
}
