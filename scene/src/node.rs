//! Nodes: the transform hierarchy of a scene.

use glam::{DMat4, DQuat, DVec3};

/// Names one node of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub(crate) u32);

impl NodeId {
    /// The index of the node in [`Scene::nodes`](crate::Scene::nodes), which is also its index in the file.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A transform from a node's space to its parent's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalTransform {
    /// An affine matrix, as the file has it. Cannot be animated.
    Matrix(DMat4),
    /// First scaled, then rotated, then moved.
    Parts {
        /// The translation (unit: metres).
        translation: DVec3,
        /// The rotation, of unit length.
        rotation: DQuat,
        /// The scale along each axis.
        scale: DVec3,
    },
}

impl LocalTransform {
    /// The transform that changes nothing.
    pub const IDENTITY: Self =
        Self::Parts { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };

    /// The transform as a matrix.
    pub fn matrix(&self) -> DMat4 {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Parts { translation, rotation, scale } => {
                DMat4::from_scale_rotation_translation(scale, rotation, translation)
            }
        }
    }
}

/// A node of the hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// The node in whose space this one stands; `None` for a root.
    pub parent: Option<NodeId>,
    /// The transform from this node's space to its parent's, at rest.
    pub local: LocalTransform,
    /// The index of the mesh in [`Scene::meshes`](crate::Scene::meshes) that the node shows.
    pub mesh: Option<usize>,
    /// The index of the skin in [`Scene::skins`](crate::Scene::skins) that moves the mesh.
    pub skin: Option<usize>,
    /// The weight of each morph target of the mesh, if no animation sets another.
    pub weights: Vec<f32>,
    /// The meshes that stand for it in coarser levels of detail, from fine to coarse (`MSFT_lod`).
    pub details: Vec<usize>,
    /// Whether the node belongs to the scene that the file shows by default.
    pub shown: bool,
    /// Whether the node or one of its ancestors is animated.
    pub animated: bool,
    /// Whether what the node shows casts shadows (`extras.castShadow`, true where absent).
    pub cast_shadow: bool,
    /// Whether what the node shows receives shadows (`extras.receiveShadow`, true where absent).
    pub receive_shadow: bool,
}
