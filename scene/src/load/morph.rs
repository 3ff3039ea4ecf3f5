//! Morph targets and their weights.

use gltf::json::mesh::{Mesh as JsonMesh, MorphTarget as JsonTarget};
use umbragraph_pipeline::frame::Bounds;

use super::accessor::Accessors;
use super::limits::MAX_DISTANCE;
use super::report::Report;
use crate::codes;
use crate::mesh::bounds_of;
use crate::morph::{MAX_WEIGHT, MorphTarget};

/// The number of morph targets of a mesh: the largest number of targets of one of its primitives.
pub(super) fn targets(mesh: &JsonMesh) -> usize {
    mesh.primitives.iter().filter_map(|primitive| primitive.targets.as_ref()).map(Vec::len).max().unwrap_or(0)
}

/// Returns `true` if there is one valid weight for each morph target. Otherwise reports an error and returns `false`.
pub(super) fn check_weights(
    weights: &[f32],
    targets: usize,
    what: &str,
    at: &str,
    report: &mut Report,
) -> bool {
    if weights.len() != targets {
        let message =
            format!("{what} has {} weights, but its mesh has {targets} morph targets", weights.len());
        report.error(codes::BAD_MORPH, at, message, "give one weight for each target, or none at all");
        return false;
    }
    let broken = weights.iter().position(|weight| weight.is_nan() || weight.abs() > MAX_WEIGHT);
    if let Some(place) = broken {
        let message = format!("weight {place} of {what} is {}", weights[place]);
        report.error(codes::BAD_MORPH, at, message, "weights are mostly between 0 and 1");
    }
    broken.is_none()
}

/// Reads the morph targets of a primitive with `count` vertices. Displacements that cannot be read are reported as
/// errors and left empty.
pub(super) fn read(
    accessors: &Accessors<'_>,
    json: &[JsonTarget],
    count: usize,
    at: &str,
    report: &mut Report,
) -> Vec<MorphTarget> {
    let mut targets = Vec::with_capacity(json.len());
    for (place, target) in json.iter().enumerate() {
        let mut read = |accessor: Option<gltf::json::Index<_>>, name: &str| {
            let at = format!("{at}/{place}/{name}");
            let Some(accessor) = accessor else { return Vec::new() };
            let values: Option<Vec<[f32; 3]>> = accessors.read(accessor.value(), &at, report);
            let Some(values) = values else { return Vec::new() };
            if values.len() != count {
                let message = format!(
                    "{name} of target {place} has {} elements, but POSITION has {count}",
                    values.len()
                );
                let help = "export the mesh again: a target has one element for each vertex";
                report.error(codes::BAD_MORPH, &at, message, help);
                return Vec::new();
            }
            let is_far = |value: &[f32; 3]| !value.iter().all(|part| f64::from(part.abs()) <= MAX_DISTANCE);
            if let Some(vertex) = values.iter().position(is_far) {
                let message = format!("target {place} moves vertex {vertex} by {:?}", values[vertex]);
                let help = "mend the mesh in the program that made it, and export it again";
                report.error(codes::NOT_FINITE, &at, message, help);
                return Vec::new();
            }
            values
        };
        let positions = read(target.positions, "POSITION");
        let normals = read(target.normals, "NORMAL");
        let bounds = bounds_of(&positions).union(Bounds { min: glam::DVec3::ZERO, max: glam::DVec3::ZERO });
        targets.push(MorphTarget { positions, normals, bounds });
    }
    targets
}
