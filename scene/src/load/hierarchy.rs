//! The node hierarchy: a forest, walked without recursion.
//!
//! Every node is visited once from the roots, parents first. Recording parents finds a node with two parents; any node
//! that no root reaches belongs to a cycle. A second walk marks the nodes of the shown scene.

use glam::{DMat4, DQuat, DVec3};
use gltf::json::{Node as JsonNode, Root};

use super::details;
use super::extras::ObjectExtras;
use super::morph;
use super::report::Report;
use crate::codes;
use crate::node::{LocalTransform, Node, NodeId};
use crate::scene::Scene;
use umbragraph_pipeline::diagnostic::way_of;

/// All nodes of a document, and an order of the nodes with parents before their children.
pub(super) struct Hierarchy {
    pub(super) nodes: Vec<Node>,
    pub(super) order: Vec<NodeId>,
}

/// Reads the nodes. Reports an error and returns `None` if a node has two parents or is its own ancestor.
pub(super) fn read(root: &Root, report: &mut Report) -> Option<Hierarchy> {
    let mut nodes = Vec::with_capacity(root.nodes.len());
    for (index, json) in root.nodes.iter().enumerate() {
        nodes.push(one(root, index, json, report));
    }
    let mut is_tree = true;
    for (index, json) in root.nodes.iter().enumerate() {
        for (place, child) in json.children.iter().flatten().enumerate() {
            let at = format!("/nodes/{index}/children/{place}");
            if report.lookup(&root.nodes, child.value(), "node", &at).is_none() {
                continue;
            }
            if let Some(first) = nodes[child.value()].parent {
                let message = format!(
                    "node {} is a child of node {} and of node {index}",
                    child.value(),
                    first.index()
                );
                report.error(codes::NOT_A_TREE, &at, message, "give each of them its own copy of the node");
                is_tree = false;
                continue;
            }
            nodes[child.value()].parent = Some(NodeId(index as u32));
        }
    }
    if !is_tree {
        return None;
    }
    let roots = (0..nodes.len()).filter(|index| nodes[*index].parent.is_none());
    let order = walk(root, roots.collect());
    if order.len() < nodes.len() {
        report_cycle(&nodes, &order, report);
        return None;
    }
    for index in walk(root, shown_roots(root, report)) {
        nodes[index].shown = true;
    }
    // What stands for another is not shown beside it.
    for node in root.nodes.iter().flat_map(details::nodes).filter_map(|(_, node)| node) {
        if let Some(node) = nodes.get_mut(node) {
            node.shown = false;
        }
    }
    Some(Hierarchy { nodes, order: order.into_iter().map(|index| NodeId(index as u32)).collect() })
}

/// Lists the indices of the nodes reachable from `starts` in depth-first order, parents before children, each node
/// once.
fn walk(root: &Root, mut starts: Vec<usize>) -> Vec<usize> {
    starts.reverse();
    let (mut stack, mut order, mut seen) = (starts, Vec::new(), vec![false; root.nodes.len()]);
    while let Some(index) = stack.pop() {
        if seen[index] {
            continue;
        }
        seen[index] = true;
        order.push(index);
        let children = root.nodes[index].children.iter().flatten().map(gltf::json::Index::value);
        let before = stack.len();
        stack.extend(children.filter(|child| *child < root.nodes.len()));
        stack[before..].reverse();
    }
    order
}

/// Reports the nodes of every cycle in the hierarchy. `reached` lists the nodes below roots. From any other node,
/// following the parents leads into a cycle.
fn report_cycle(nodes: &[Node], reached: &[usize], report: &mut Report) {
    let mut done = vec![false; nodes.len()];
    reached.iter().for_each(|index| done[*index] = true);
    for start in 0..nodes.len() {
        if done[start] {
            continue;
        }
        let mut trail = vec![start];
        done[start] = true;
        while let Some(parent) = nodes[trail[trail.len() - 1]].parent.map(NodeId::index) {
            if done[parent] {
                // Either the trail has closed, or it ran into one that was followed before.
                if let Some(first) = trail.iter().position(|index| *index == parent) {
                    report_members(trail.split_off(first), report);
                }
                break;
            }
            done[parent] = true;
            trail.push(parent);
        }
    }
}

fn report_members(mut members: Vec<usize>, report: &mut Report) {
    const LISTED: usize = 20;
    members.reverse();
    members.push(members[0]);
    let mut names: Vec<String> = members.iter().take(LISTED).map(usize::to_string).collect();
    if members.len() > LISTED {
        names.push(format!("… ({} nodes)", members.len() - 1));
    }
    let message = format!("nodes are their own ancestors: {}", way_of(names));
    let at = format!("/nodes/{}/children", members[0]);
    report.error(codes::NOT_A_TREE, &at, message, "take one of them out of the children of the other");
}

/// The indices of the nodes from which the drawn nodes are reachable. They are the root nodes of the default scene or,
/// without a default, of the first scene. All nodes if the document has no scene.
fn shown_roots(root: &Root, report: &mut Report) -> Vec<usize> {
    let index = root.scene.map_or(0, |scene| scene.value());
    let scene = match root.scene {
        Some(_) => report.lookup(&root.scenes, index, "scene", "/scene"),
        None => root.scenes.first(),
    };
    let Some(scene) = scene else { return (0..root.nodes.len()).collect() };
    let mut roots = Vec::with_capacity(scene.nodes.len());
    for (place, node) in scene.nodes.iter().enumerate() {
        let at = format!("/scenes/{index}/nodes/{place}");
        roots.extend(report.index(&root.nodes, Some(*node), "node", &at));
    }
    roots
}

fn one(root: &Root, index: usize, json: &JsonNode, report: &mut Report) -> Node {
    let at = format!("/nodes/{index}");
    let extras = ObjectExtras::new(&json.extras, &at);
    let mesh = report.index(&root.meshes, json.mesh, "mesh", &format!("{at}/mesh"));
    let skin = report.index(&root.skins, json.skin, "skin", &format!("{at}/skin"));
    Node {
        name: json.name.clone().unwrap_or_default(),
        parent: None,
        local: local(index, json, &at, report),
        mesh,
        skin,
        weights: weights(root, json, mesh, (index, &at), report),
        details: details::read(root, index, json, report),
        shown: false,
        animated: false,
        cast_shadow: extras.boolean("castShadow", report).unwrap_or(true),
        receive_shadow: extras.boolean("receiveShadow", report).unwrap_or(true),
    }
}

/// The morph weights of a node: its own weights if they are valid, else the weights of its mesh, else zeros.
fn weights(
    root: &Root,
    json: &JsonNode,
    mesh: Option<usize>,
    (index, at): (usize, &str),
    report: &mut Report,
) -> Vec<f32> {
    let mesh = mesh.and_then(|mesh| root.meshes.get(mesh));
    let targets = mesh.map_or(0, morph::targets);
    let of_mesh = mesh.and_then(|mesh| mesh.weights.clone()).filter(|weights| weights.len() == targets);
    if let Some(weights) = &json.weights {
        let at = format!("{at}/weights");
        if morph::check_weights(weights, targets, &format!("node {index}"), &at, report) {
            return weights.clone();
        }
    }
    of_mesh.unwrap_or_else(|| vec![0.0; targets])
}

fn local(index: usize, json: &JsonNode, at: &str, report: &mut Report) -> LocalTransform {
    let mut bad = |property: &str, message: String, help: &str| {
        report.error(codes::BAD_TRANSFORM, &format!("{at}/{property}"), message, help);
        LocalTransform::IDENTITY
    };
    const HELP: &str = "mend the transform in the program that made it, and export the scene again";
    if let Some(matrix) = json.matrix {
        if !matrix.iter().all(|value| value.is_finite()) {
            return bad("matrix", format!("the matrix of node {index} is not finite"), HELP);
        }
        if [matrix[3], matrix[7], matrix[11], matrix[15]] != [0.0, 0.0, 0.0, 1.0] {
            return bad(
                "matrix",
                format!("the matrix of node {index} is not affine"),
                "its last row has to be 0, 0, 0, 1",
            );
        }
        return LocalTransform::Matrix(DMat4::from_cols_array(&matrix.map(f64::from)));
    }
    let translation = json.translation.unwrap_or([0.0; 3]);
    let rotation = json.rotation.map_or([0.0, 0.0, 0.0, 1.0], |rotation| rotation.0);
    let scale = json.scale.unwrap_or([1.0; 3]);
    let parts: [(&str, &[f32]); 3] =
        [("translation", &translation), ("rotation", &rotation), ("scale", &scale)];
    for (property, values) in parts {
        if !values.iter().all(|value| value.is_finite()) {
            return bad(property, format!("the {property} of node {index} is not finite"), HELP);
        }
    }
    let rotation = DQuat::from_array(rotation.map(f64::from));
    if rotation.length() < 1e-6 {
        return bad(
            "rotation",
            format!("the rotation of node {index} has length zero"),
            "it has to be a unit quaternion",
        );
    }
    LocalTransform::Parts {
        translation: DVec3::from_array(translation.map(f64::from)),
        rotation: rotation.normalize(),
        scale: DVec3::from_array(scale.map(f64::from)),
    }
}

/// Sets `animated` for the nodes that the first animation changes, and for all their descendants.
pub(super) fn mark_animated(scene: &mut Scene) {
    for channel in scene.animations.first().iter().flat_map(|animation| &animation.channels) {
        scene.nodes[channel.node.index()].animated = true;
    }
    for id in &scene.order {
        if let Some(parent) = scene.nodes[id.index()].parent {
            scene.nodes[id.index()].animated |= scene.nodes[parent.index()].animated;
        }
    }
}
