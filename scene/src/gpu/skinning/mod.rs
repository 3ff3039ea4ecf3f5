//! Skinning and morphing of vertices: linear blend skinning, once per pose for all passes and views.
//!
//! A skinned draw has its own range in the vertex streams. When the pose changes, its positions and normals are written
//! there in world space, so that every pass draws it like any other mesh. A compute dispatch for each skinned draw
//! reads the unskinned primitive and the joint matrices, and writes the streams. If a device cannot do that
//! ([`DeviceSkinning::fits`]: no compute stage, too few storage buffers, or ones that are too small), the CPU computes
//! the vertices.
//!
//! A vertex is transformed by the weighted sum of its joints' matrices, its normal by the cofactors of that sum. The
//! device computes in `f32` and the CPU in `f64`, so their vertices differ by a few units in the last place of their
//! coordinates.
//!
//! The dispatches are submitted on their own, after the matrices have been written to the queue. Work submitted before
//! sees the old pose, later work the new one, as with `Queue::write_buffer`. A pose with the same joints and weights
//! costs nothing. The CPU handles draws with [morph targets](crate::morph), skinned or not.
//!
//! Before a pose is written, the positions of the one before are copied to the stream of previous positions, and once
//! more when the pose has come to rest.

mod device;
mod host;

use glam::DMat4;
use umbragraph_executor::wgpu;

use super::geometry::Geometry;
use crate::pose::Pose;
use crate::scene::{Draw, Scene};
use device::DeviceSkinning;
use host::HostSkinning;

/// Skinning and morphing of the draws of a scene, on the device or the CPU.
pub(super) struct Skinning {
    /// Skinning of draws without morph targets on the device. `None` if the device does not support skinning, or if no
    /// skinned draw is without morph targets.
    device: Option<DeviceSkinning>,
    /// Skinning and morphing on the CPU, for all draws that `device` does not handle.
    host: HostSkinning,
    /// The concatenated joint matrices of all skinned draws in the last written pose.
    joints: Vec<DMat4>,
    /// The concatenated joint matrices of the pose that is being written; kept to reuse the allocation.
    next: Vec<DMat4>,
    /// The morph weights, in the last written pose, of the draws that the CPU handles. `None` before the first pose.
    weights: Option<Vec<f32>>,
    /// The device on which positions are copied to the buffer of previous positions.
    copier: wgpu::Device,
    /// Whether the last write changed vertices, so that the previous positions still differ from the current ones.
    has_moved: bool,
}

/// A skinned or morphed draw, and the locations of its vertices and joint matrices.
#[derive(Clone, Copy, Debug)]
struct Skinned {
    draw: Draw,
    /// The index of the draw's first vertex in the vertex streams.
    first_vertex: u32,
    /// The index of the draw's first joint matrix in the concatenated joint matrices of all skinned draws.
    first_joint: u32,
    joint_count: u32,
}

impl Skinning {
    pub(super) fn new(device: &wgpu::Device, scene: &Scene, geometry: &Geometry) -> Self {
        let moved = moved_draws(scene, geometry);
        let (morphing, draws): (Vec<Skinned>, Vec<Skinned>) =
            moved.iter().partition(|moved| scene.morphs(moved.draw));
        let fits = DeviceSkinning::fits(&device.limits(), scene, &draws, geometry.skinned_vertices);
        let (skinning, host) = if fits && !draws.is_empty() {
            (Some(DeviceSkinning::new(device, scene, &draws, geometry)), morphing)
        } else {
            (None, moved)
        };
        Self {
            device: skinning,
            host: HostSkinning::new(host),
            joints: Vec::new(),
            next: Vec::new(),
            weights: None,
            copier: device.clone(),
            has_moved: false,
        }
    }

    /// Writes the positions and normals of all skinned and morphed draws for a pose. The old positions become the
    /// previous positions for motion vectors.
    pub(super) fn write(&mut self, queue: &wgpu::Queue, geometry: &Geometry, scene: &Scene, pose: &Pose) {
        let joints = scene.draws_of_all_details().filter(|draw| draw.skin.is_some());
        self.next.clear();
        self.next.extend(joints.flat_map(|draw| scene.joint_transforms(draw.node, pose)));
        let joints_are_there = self.next == self.joints;
        let weights = || self.host.nodes().flat_map(|node| pose.weights(node)).copied();
        let weights_are_there =
            self.weights.as_ref().is_some_and(|known| weights().eq(known.iter().copied()));
        let moves = !(joints_are_there && weights_are_there);
        // Copied before the writes below, which the next submission carries out.
        if self.weights.is_some() && (moves || self.has_moved) {
            geometry.keep_positions(&self.copier, queue);
        }
        self.has_moved = moves;
        if !moves {
            return;
        }
        self.weights = Some(weights().collect());
        std::mem::swap(&mut self.next, &mut self.joints);
        self.host.write(queue, geometry, scene, pose, &self.joints);
        if let Some(device) = self.device.as_mut().filter(|_| !joints_are_there) {
            device.write(queue, &self.joints);
        }
    }
}

/// The draws with skinned or morphed vertices. Their joint count is 0 if they have no skin.
fn moved_draws(scene: &Scene, geometry: &Geometry) -> Vec<Skinned> {
    let mut first_joint = 0;
    let own = scene.draws_of_all_details().enumerate().filter(|(_, draw)| scene.has_own_vertices(*draw));
    let skinned = own.filter_map(|(number, draw)| {
        let skin = draw.skin.and_then(|skin| scene.skins.get(skin));
        let joint_count = skin.map_or(0, |skin| skin.joints.len() as u32);
        let first_vertex = geometry.part(scene, number, draw)?.first_vertex as u32;
        let skinned = Skinned { draw, first_vertex, first_joint, joint_count };
        first_joint += joint_count;
        Some(skinned)
    });
    skinned.collect()
}

#[cfg(test)]
mod tests;
