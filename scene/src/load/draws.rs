//! The list of draws, and the checks that need the whole scene.

use std::collections::BTreeMap;

use super::limits::{MAX_DISTANCE, MAX_DRAWS};
use super::report::Report;
use crate::codes;
use crate::material::AlphaMode;
use crate::node::NodeId;
use crate::pose::{Pose, joint_bounds};
use crate::scene::{Draw, Scene};

/// Fills the list of draws with the primitives of all drawn nodes. The draws are in the order of levels of detail, from
/// fine to coarse, with parents before children within a level.
pub(super) fn collect(scene: &mut Scene, pose: &Pose, report: &mut Report) {
    // Many nodes may show one skinned mesh: its boxes are computed once.
    let mut boxes = BTreeMap::new();
    // Whole levels of detail one after the other, the finest first.
    let last = scene.nodes.iter().filter(|node| node.shown).map(|node| node.details.len()).max().unwrap_or(0);
    for detail in 0..=last {
        for id in scene.order.clone() {
            let node = scene.node(id);
            let mesh = if detail == 0 { node.mesh } else { node.details.get(detail - 1).copied() };
            let (Some(mesh), true) = (mesh, node.shown) else { continue };
            let count = scene.meshes[mesh].primitives.len();
            if scene.draws.len() + count > MAX_DRAWS {
                let message = format!("the scene has more than {MAX_DRAWS} draws");
                report.error(
                    codes::TOO_LARGE,
                    &format!("/nodes/{}", id.index()),
                    message,
                    "join primitives that share a material",
                );
                return;
            }
            if scene.node(id).skin.is_some_and(|skin| !fits(scene, id, mesh, skin, report)) {
                continue;
            }
            for primitive in 0..count {
                if !scene.meshes[mesh].primitives[primitive].indices.is_empty() {
                    let draw = one(scene, id, (mesh, primitive), detail, &mut boxes);
                    scene.draws.push(draw);
                    check_distance(scene, draw, pose, report);
                }
            }
        }
        if detail == 0 {
            scene.finest = scene.draws.len();
        }
    }
    if scene.draws.is_empty() && !report.has_errors() {
        let help = "check which scene the document shows by default, and that its nodes have meshes";
        report.warning(codes::EMPTY_SCENE, "", "the scene has no triangles", help);
    }
}

fn one(
    scene: &mut Scene,
    id: NodeId,
    (mesh, primitive): (usize, usize),
    detail: usize,
    boxes: &mut BTreeMap<(usize, usize, usize), usize>,
) -> Draw {
    let node = scene.node(id);
    let (shape, skin) = (&scene.meshes[mesh], node.skin);
    let part = &shape.primitives[primitive];
    let material = &scene.materials[part.material];
    let mut draw = Draw {
        node: id,
        mesh,
        primitive,
        material: part.material,
        skin,
        cast_shadow: node.cast_shadow
            && shape.cast_shadow
            && material.cast_shadow
            && material.alpha_mode != AlphaMode::Blend,
        receive_shadow: node.receive_shadow && shape.receive_shadow && material.receive_shadow,
        dynamic: node.animated || skin.is_some(),
        detail: detail as u32,
        last_detail: node.details.len() as u32,
        joint_bounds: None,
    };
    if let (Some(skin), Some(joints)) = (skin, &part.joints) {
        draw.joint_bounds = Some(*boxes.entry((mesh, primitive, skin)).or_insert_with(|| {
            scene.joint_bounds.push(joint_bounds(&part.positions, joints, scene.skins[skin].joints.len()));
            scene.joint_bounds.len() - 1
        }));
    }
    draw
}

/// Returns `true` if every primitive of a mesh can be skinned with the given skin. Otherwise reports the reasons as
/// errors and returns `false`.
fn fits(scene: &Scene, id: NodeId, mesh: usize, skin: usize, report: &mut Report) -> bool {
    let count = scene.skins[skin].joints.len();
    let mut fits = true;
    for (index, primitive) in scene.meshes[mesh].primitives.iter().enumerate() {
        let at = format!("/meshes/{mesh}/primitives/{index}/attributes");
        let Some(joints) = &primitive.joints else {
            let message =
                format!("node {} gives the mesh skin {skin}, but a primitive has no JOINTS_0", id.index());
            report.error(
                codes::BAD_SKIN,
                &at,
                message,
                "export the mesh with its weights, or the node without a skin",
            );
            fits = false;
            continue;
        };
        let used = joints.joints.iter().flatten().zip(joints.weights.iter().flatten());
        let beyond = used
            .filter(|(joint, weight)| usize::from(**joint) >= count && **weight > 0.0)
            .map(|(joint, _)| *joint);
        if let Some(joint) = beyond.max() {
            let message = format!(
                "joint {joint} moves a vertex, but skin {skin} of node {} has {count} joints",
                id.index()
            );
            report.error(
                codes::BAD_SKIN,
                &format!("{at}/JOINTS_0"),
                message,
                "export the mesh and its skin again",
            );
            fits = false;
        }
    }
    fits
}

fn check_distance(scene: &Scene, draw: Draw, pose: &Pose, report: &mut Report) {
    let bounds = scene.draw_bounds(draw, pose);
    let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
    // Bounds that are not finite count as empty.
    if bounds.is_empty() || farthest > MAX_DISTANCE {
        report.error(
            codes::BAD_TRANSFORM,
            &format!("/nodes/{}", draw.node.index()),
            format!("mesh {} reaches farther than {MAX_DISTANCE:.0} metres from the origin", draw.mesh),
            "check the units: glTF is in metres",
        );
    }
}
