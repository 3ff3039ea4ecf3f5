//! Poses: the transforms of all nodes at one time.
//!
//! World transforms are products along the hierarchy, computed parents first in `f64` without recursion. A pose belongs
//! to the scene that made it.
//!
//! Key frames are finite, but a spline or a chain of scales can overflow. A node that an animation moves farther than a
//! million kilometres, or scales as much, keeps its parent's transform at that time.

use glam::{DMat4, DQuat, DVec3};
use umbragraph_pipeline::frame::Bounds;

use crate::animation::Property;
use crate::load::limits::MAX_DISTANCE;
use crate::morph::MAX_WEIGHT;
use crate::node::{LocalTransform, NodeId};
use crate::scene::{Draw, Scene};

/// The transforms and morph weights of all nodes of a scene at one time.
#[derive(Debug, PartialEq)]
pub struct Pose {
    local: Vec<LocalTransform>,
    world: Vec<DMat4>,
    /// The morph weights of each node that has morph targets, sorted by node.
    weights: Vec<(NodeId, Vec<f32>)>,
}

impl Clone for Pose {
    fn clone(&self) -> Self {
        Self { local: self.local.clone(), world: self.world.clone(), weights: self.weights.clone() }
    }

    /// Copies `other` into this pose; does not allocate if the existing memory is large enough.
    fn clone_from(&mut self, other: &Self) {
        self.local.clone_from(&other.local);
        self.world.clone_from(&other.world);
        self.weights.clone_from(&other.weights);
    }
}

impl Pose {
    /// The transform from a node's space to world space, in metres; identity for an unknown node.
    pub fn world(&self, node: NodeId) -> DMat4 {
        self.world.get(node.index()).copied().unwrap_or(DMat4::IDENTITY)
    }

    /// The weight of each morph target of the node's mesh; empty if the mesh has no targets.
    pub fn weights(&self, node: NodeId) -> &[f32] {
        let at = self.weights.binary_search_by_key(&node, |(node, _)| *node);
        at.ok().and_then(|at| self.weights.get(at)).map_or(&[], |(_, weights)| weights)
    }
}

impl Scene {
    /// The pose without animation: every node has the transform and morph weights of the file.
    pub fn rest_pose(&self) -> Pose {
        let mut pose = Pose {
            local: self.nodes.iter().map(|node| node.local).collect(),
            world: vec![DMat4::IDENTITY; self.nodes.len()],
            weights: (0..)
                .map(NodeId)
                .zip(&self.nodes)
                .filter(|(_, node)| !node.weights.is_empty())
                .map(|(id, node)| (id, node.weights.clone()))
                .collect(),
        };
        self.update_world(&mut pose);
        pose
    }

    /// The pose at a time in seconds. The first animation of the scene plays in a loop. A time that is not finite
    /// counts as 0.
    pub fn pose(&self, time: f64) -> Pose {
        let mut pose = self.rest_pose();
        self.pose_into(time, &mut pose);
        pose
    }

    /// Updates a pose of this scene to a time in seconds, as [`Scene::pose`] computes it, without allocating. A pose
    /// with a different number of nodes is replaced.
    pub fn pose_into(&self, time: f64, pose: &mut Pose) {
        if pose.world.len() != self.nodes.len() {
            *pose = self.rest_pose();
        }
        let Some(animation) = self.animations.first() else { return };
        let time = if time.is_finite() && animation.duration > 0.0 {
            time.rem_euclid(animation.duration)
        } else {
            0.0
        };
        for channel in &animation.channels {
            if let Property::Weight(target) = channel.property {
                let at = pose.weights.binary_search_by_key(&channel.node, |(node, _)| *node);
                let weights = at.ok().and_then(|at| pose.weights.get_mut(at));
                if let Some(weight) = weights.and_then(|(_, weights)| weights.get_mut(target)) {
                    *weight = (channel.sample(time).x as f32).clamp(-MAX_WEIGHT, MAX_WEIGHT);
                }
                continue;
            }
            let Some(LocalTransform::Parts { translation, rotation, scale }) =
                pose.local.get_mut(channel.node.index())
            else {
                continue;
            };
            let value = channel.sample(time);
            match channel.property {
                Property::Translation => *translation = value.truncate(),
                Property::Rotation => *rotation = DQuat::from_vec4(value),
                Property::Scale => *scale = value.truncate(),
                Property::Weight(_) => {}
            }
        }
        self.update_world(pose);
    }

    fn update_world(&self, pose: &mut Pose) {
        for id in &self.order {
            let at = id.index();
            let parent = self.nodes[at].parent.map_or(DMat4::IDENTITY, |parent| pose.world[parent.index()]);
            let world = parent * pose.local[at].matrix();
            let is_usable = !self.nodes[at].animated
                || world.to_cols_array().into_iter().all(|value| value.abs() <= MAX_DISTANCE);
            pose.world[at] = if is_usable { world } else { parent };
        }
    }

    /// For each joint of a node's skin, the transform from mesh space to world space; empty for a node without a skin.
    /// For a skinned mesh, the joint transforms replace the transform of the node, as glTF requires.
    pub fn joint_transforms<'a>(&'a self, node: NodeId, pose: &'a Pose) -> impl Iterator<Item = DMat4> + 'a {
        let skin =
            self.nodes.get(node.index()).and_then(|node| node.skin).and_then(|skin| self.skins.get(skin));
        skin.into_iter()
            .flat_map(|skin| skin.joints.iter().zip(&skin.inverse_bind))
            .map(|(joint, inverse_bind)| pose.world(*joint) * *inverse_bind)
    }

    /// The bounding box of a draw in world space, in metres, for a pose. For a skinned draw, the box is the union of
    /// the bounding boxes of all joints, each transformed with its joint. It contains every skinned vertex, since that
    /// is a weighted mean of points in the transformed boxes.
    pub fn draw_bounds(&self, draw: Draw, pose: &Pose) -> Bounds {
        let (part, weights) = (self.primitive(draw), pose.weights(draw.node));
        match draw.joint_bounds.and_then(|at| self.joint_bounds.get(at)) {
            Some(boxes) => self
                .joint_transforms(draw.node, pose)
                .zip(boxes)
                .map(|(transform, bounds)| (transform, part.morphed_bounds(*bounds, weights)))
                .fold(Bounds::EMPTY, |all, (transform, bounds)| all.union(bounds.transformed(&transform))),
            None => part.morphed_bounds(part.bounds, weights).transformed(&pose.world(draw.node)),
        }
    }
}

/// For each of the first `joints` joints of a skin, the bounding box of the positions with a weight above 0 for that
/// joint.
pub(crate) fn joint_bounds(
    positions: &[[f32; 3]],
    weights: &crate::mesh::JointWeights,
    joints: usize,
) -> Vec<Bounds> {
    let mut bounds = vec![Bounds::EMPTY; joints];
    for ((position, joints), weights) in positions.iter().zip(&weights.joints).zip(&weights.weights) {
        let position = DVec3::from_array(position.map(f64::from));
        for (joint, weight) in joints.iter().zip(weights) {
            if let (Some(bounds), true) = (bounds.get_mut(usize::from(*joint)), *weight > 0.0) {
                *bounds = bounds.with(position);
            }
        }
    }
    bounds
}
