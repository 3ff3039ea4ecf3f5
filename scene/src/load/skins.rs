//! Skins and their inverse bind matrices.

use glam::DMat4;

use super::accessor::Accessors;
use super::report::Report;
use crate::codes;
use crate::node::NodeId;
use crate::skin::Skin;

/// The tolerance for rounding errors in the last row of an inverse bind matrix, which should be 0, 0, 0, 1.
const AFFINE_TOLERANCE: f32 = 1e-4;

/// Reads all skins. Joints and inverse bind matrices that cannot be read are reported as errors and left out.
pub(super) fn read(accessors: &Accessors<'_>, report: &mut Report) -> Vec<Skin> {
    let root = accessors.root;
    let mut skins = Vec::with_capacity(root.skins.len());
    for (index, json) in root.skins.iter().enumerate() {
        let at = format!("/skins/{index}");
        let mut joints = Vec::with_capacity(json.joints.len());
        for (place, joint) in json.joints.iter().enumerate() {
            let joint = report.index(&root.nodes, Some(*joint), "node", &format!("{at}/joints/{place}"));
            joints.extend(joint.map(|joint| NodeId(joint as u32)));
        }
        if json.joints.is_empty() || json.joints.len() > usize::from(u16::MAX) {
            let message = format!("skin {index} has {} joints", json.joints.len());
            report.error(codes::BAD_SKIN, &format!("{at}/joints"), message, "a skin has 1 to 65535 joints");
        }
        let inverse_bind = match json.inverse_bind_matrices {
            None => vec![DMat4::IDENTITY; joints.len()],
            Some(accessor) => {
                let at = format!("{at}/inverseBindMatrices");
                let matrices = accessors.read::<f32, 16>(accessor.value(), &at, report).unwrap_or_default();
                check(index, json.joints.len(), &matrices, &at, report);
                matrices.iter().map(|matrix| DMat4::from_cols_array(&matrix.map(f64::from))).collect()
            }
        };
        skins.push(Skin { name: json.name.clone().unwrap_or_default(), joints, inverse_bind });
    }
    skins
}

fn check(index: usize, joints: usize, matrices: &[[f32; 16]], at: &str, report: &mut Report) {
    if matrices.is_empty() {
        return;
    }
    if matrices.len() < joints {
        let message =
            format!("skin {index} has {joints} joints, but {} inverse bind matrices", matrices.len());
        report.error(codes::BAD_SKIN, at, message, "there is one matrix for each joint, or none at all");
    }
    if let Some(first) = matrices.iter().position(|matrix| !matrix.iter().all(|value| value.is_finite())) {
        let message = format!("the inverse bind matrix of joint {first} of skin {index} is not finite");
        report.error(
            codes::NOT_FINITE,
            at,
            message,
            "mend the skin in the program that made it, and export it again",
        );
        return;
    }
    let is_affine = |matrix: &[f32; 16]| {
        let last_row = [matrix[3], matrix[7], matrix[11], matrix[15] - 1.0];
        last_row.into_iter().all(|value| value.abs() <= AFFINE_TOLERANCE)
    };
    if let Some(first) = matrices.iter().position(|matrix| !is_affine(matrix)) {
        let message = format!("the inverse bind matrix of joint {first} of skin {index} is not affine");
        report.error(codes::BAD_SKIN, at, message, "its last row has to be 0, 0, 0, 1");
    }
}
