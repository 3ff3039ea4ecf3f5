//! Morph targets: weighted displacements of vertices.
//!
//! A target adds to each vertex a displacement of its position and of its normal, times the target's weight; the
//! displacements of all targets are summed before joints or the node move the vertex (glTF 2.0, section 3.7.2.2). Flat
//! normals, where a file gives none, are those of the morphed triangles.
//!
//! Limits: weights are clamped to ±`MAX_WEIGHT`; a spline can exceed it between two keys.

use glam::Vec3;
use umbragraph_pipeline::frame::Bounds;

use crate::mesh::{Primitive, flat_normals, unit};

/// The maximum absolute value of a morph weight; animated weights are clamped to it.
pub(crate) const MAX_WEIGHT: f32 = 1e6;

/// A morph target: displacements of the vertices of a primitive, all multiplied by one weight.
#[derive(Clone, Debug)]
pub struct MorphTarget {
    /// The displacement of each position, in metres; empty if the target does not move positions.
    pub positions: Vec<[f32; 3]>,
    /// The displacement of each normal; empty if the target does not change normals.
    pub normals: Vec<[f32; 3]>,
    /// The bounding box of all position displacements and of the zero displacement, in metres.
    pub bounds: Bounds,
}

impl Primitive {
    /// Replaces the contents of `positions` and `normals` with the morphed positions (in metres) and unit normals.
    /// `weights` has one weight for each morph target; missing weights count as 0.
    pub fn morph(&self, weights: &[f32], positions: &mut Vec<[f32; 3]>, normals: &mut Vec<[f32; 3]>) {
        positions.clone_from(&self.positions);
        normals.clone_from(&self.normals);
        let add = |to: &mut [[f32; 3]], what: &[[f32; 3]], weight: f32| {
            for (to, what) in to.iter_mut().zip(what) {
                *to = (Vec3::from_array(*to) + weight * Vec3::from_array(*what)).to_array();
            }
        };
        for (target, weight) in self.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            add(positions, &target.positions, *weight);
            add(normals, &target.normals, *weight);
        }
        if self.has_flat_normals {
            normals.clear();
            normals.extend(flat_normals(positions));
        } else {
            normals.iter_mut().for_each(|normal| *normal = unit(*normal));
        }
    }

    /// Returns `bounds`, a bounding box of vertices of this primitive, enlarged to contain the same vertices morphed
    /// with `weights`.
    pub(crate) fn morphed_bounds(&self, bounds: Bounds, weights: &[f32]) -> Bounds {
        if bounds.is_empty() {
            return bounds;
        }
        let targets = self.targets.iter().zip(weights);
        targets.fold(bounds, |bounds, (target, weight)| {
            let ends = [target.bounds.min * f64::from(*weight), target.bounds.max * f64::from(*weight)];
            Bounds { min: bounds.min + ends[0].min(ends[1]), max: bounds.max + ends[0].max(ends[1]) }
        })
    }
}
