//! Skins: the joints that move a mesh.

use glam::DMat4;

use crate::node::NodeId;

/// The joints that deform a skinned mesh, and their inverse bind matrices.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// The nodes that act as joints; at least one.
    pub joints: Vec<NodeId>,
    /// One inverse bind matrix for each joint: the transform from mesh space to the joint's space in the bind pose.
    pub inverse_bind: Vec<DMat4>,
}
