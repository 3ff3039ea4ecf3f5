//! Levels of detail: the extension `MSFT_lod` of nodes.
//!
//! A node lists others, each coarser than the one before. A listed node contributes its mesh only: it is drawn at the
//! first node's place, with its own skin and the first node's morph weights, and is not shown by itself.
//!
//! Limits: children of listed nodes, the extension on materials and screen coverages are ignored: the caller chooses
//! the level. A listed node without a mesh, or with other morph targets, is left out with a warning.

use gltf::json::{Node as JsonNode, Root};

use super::morph;
use super::report::Report;
use crate::codes;

const EXTENSION: &str = "MSFT_lod";

/// The entries of a node's `MSFT_lod` list of coarser levels of detail: position in the list, and node index. The node
/// index is `None` for an entry that is not a valid index.
pub(super) fn nodes(json: &JsonNode) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
    let listed = json.extensions.as_ref().and_then(|extensions| extensions.others.get(EXTENSION));
    let ids = listed.and_then(|extension| extension.get("ids")).and_then(|ids| ids.as_array());
    let number = |id: &gltf::json::Value| id.as_u64().and_then(|id| usize::try_from(id).ok());
    ids.into_iter().flatten().enumerate().map(move |(place, id)| (place, number(id)))
}

/// Reads the mesh indices of a node's coarser levels of detail, from fine to coarse. Unusable levels are reported and
/// left out.
pub(super) fn read(root: &Root, index: usize, json: &JsonNode, report: &mut Report) -> Vec<usize> {
    let targets = |mesh: usize| root.meshes.get(mesh).map_or(0, morph::targets);
    let own = json.mesh.map(|mesh| mesh.value());
    let mut meshes = Vec::new();
    for (place, node) in nodes(json) {
        let at = format!("/nodes/{index}/extensions/{EXTENSION}/ids/{place}");
        let Some(node) = node else {
            let message = "a level of detail is the number of a node".to_owned();
            report.error(codes::BAD_VALUE, &at, message, "list the nodes that stand for this one");
            continue;
        };
        let Some(level) = report.lookup(&root.nodes, node, "node", &at) else { continue };
        match (own, level.mesh.map(|mesh| mesh.value())) {
            (Some(own), Some(mesh)) if targets(own) == targets(mesh) => meshes.push(mesh),
            _ => {
                let message =
                    format!("node {node} cannot stand for node {index}: their meshes do not correspond");
                let help = "give both nodes a mesh, with as many morph targets";
                report.warning(codes::LEFT_OUT, &at, message, help);
            }
        }
    }
    meshes.retain(|mesh| *mesh < root.meshes.len());
    meshes
}
