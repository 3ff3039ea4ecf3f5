//! Skins: the joints that move a mesh.

use glam::DMat4;

use crate::node::NodeId;

/// The joints of a skinned mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// The nodes that act as joints, at least one.
    pub joints: Vec<NodeId>,
    /// The transform from mesh space into the space of each joint at rest.
    pub inverse_bind: Vec<DMat4>,
}
