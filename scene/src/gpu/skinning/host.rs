//! Vertices transformed by the CPU: morphed draws, and skinned draws if the device cannot; also the reference for
//! tests.

use glam::{DMat4, DVec3};
use umbragraph_executor::wgpu;

use super::Skinned;
use crate::gpu::geometry::{Geometry, normal_matrix};
use crate::mesh::{Primitive, direction};
use crate::node::NodeId;
use crate::pose::Pose;
use crate::scene::Scene;

/// The draws that the CPU skins or morphs, and reused lists for the vertices of one draw.
pub(super) struct HostSkinning {
    draws: Vec<Skinned>,
    morphed: [Vec<[f32; 3]>; 2],
    moved: [Vec<[f32; 3]>; 2],
}

impl HostSkinning {
    pub(super) fn new(draws: Vec<Skinned>) -> Self {
        Self { draws, morphed: Default::default(), moved: Default::default() }
    }

    /// The nodes of the draws that the CPU skins or morphs, in the order of the draws.
    pub(super) fn nodes(&self) -> impl Iterator<Item = NodeId> {
        self.draws.iter().map(|moved| moved.draw.node)
    }

    pub(super) fn write(
        &mut self,
        queue: &wgpu::Queue,
        geometry: &Geometry,
        scene: &Scene,
        pose: &Pose,
        joints: &[DMat4],
    ) {
        let Self { draws, morphed, moved } = self;
        for Skinned { draw, first_vertex, first_joint, joint_count } in draws {
            let first = *first_joint as usize;
            let joints = joints.get(first..first + *joint_count as usize).unwrap_or_default();
            let primitive = scene.primitive(*draw);
            let mut vertices = [&primitive.positions, &primitive.normals];
            if scene.morphs(*draw) {
                let [positions, normals] = &mut *morphed;
                primitive.morph(pose.weights(draw.node), positions, normals);
                vertices = [&*positions, &*normals];
            }
            if draw.skin.is_some() {
                let [positions, normals] = &mut *moved;
                skin(primitive, vertices, joints, positions, normals);
                vertices = [&*positions, &*normals];
            }
            let [positions, normals] = vertices;
            let offset = u64::from(*first_vertex) * 12;
            queue.write_buffer(&geometry.positions, offset, bytemuck::cast_slice(positions));
            queue.write_buffer(&geometry.normals, offset, bytemuck::cast_slice(normals));
        }
    }
}

/// Skins the vertices of a primitive with joint matrices, from its morphed or original positions and normals to world
/// space.
fn skin(
    primitive: &Primitive,
    [modelled, modelled_normals]: [&Vec<[f32; 3]>; 2],
    joints: &[DMat4],
    positions: &mut Vec<[f32; 3]>,
    normals: &mut Vec<[f32; 3]>,
) {
    positions.clear();
    normals.clear();
    let Some(weights) = &primitive.joints else { return };
    let vertices = modelled.iter().zip(modelled_normals);
    for ((position, normal), (four, weights)) in vertices.zip(weights.joints.iter().zip(&weights.weights)) {
        let mut blended = DMat4::ZERO;
        for (joint, weight) in four.iter().zip(weights) {
            if let (Some(transform), true) = (joints.get(usize::from(*joint)), *weight > 0.0) {
                blended += *transform * f64::from(*weight);
            }
        }
        let position = blended.transform_point3(DVec3::from_array(position.map(f64::from)));
        let normal = normal_matrix(&blended) * DVec3::from_array(normal.map(f64::from));
        positions.push(position.as_vec3().to_array());
        normals.push(direction(normal));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::JointWeights;
    use umbragraph_pipeline::frame::Bounds;

    #[test]
    fn a_vertex_between_two_joints_goes_half_the_way() {
        let primitive = Primitive {
            positions: vec![[1.0, 0.0, 0.0]],
            normals: vec![[0.0, 1.0, 0.0]],
            texcoords: vec![[0.0; 2]],
            details: None,
            joints: Some(JointWeights { joints: vec![[0, 1, 0, 0]], weights: vec![[0.5, 0.5, 0.0, 0.0]] }),
            indices: Vec::new(),
            material: 0,
            bounds: Bounds::EMPTY,
            targets: Vec::new(),
            has_flat_normals: false,
        };
        let joints = [DMat4::IDENTITY, DMat4::from_translation(DVec3::new(0.0, 4.0, 0.0))];
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        skin(&primitive, [&primitive.positions, &primitive.normals], &joints, &mut positions, &mut normals);
        assert_eq!((positions, normals), (vec![[1.0, 2.0, 0.0]], vec![[0.0, 1.0, 0.0]]));
    }
}
