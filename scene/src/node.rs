//! Nodes: the transform hierarchy of a scene.

use glam::{DMat4, DQuat, DVec3};

/// The identifier of a node in a scene: an index into [`Scene::nodes`](crate::Scene::nodes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub(crate) u32);

impl NodeId {
    /// The index of the node in [`Scene::nodes`](crate::Scene::nodes), which is also its index in the file.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A transform from a node's space to the space of its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LocalTransform {
    /// An affine matrix from the file. An animation cannot change the transform of a node with a matrix.
    Matrix(DMat4),
    /// Separate translation, rotation and scale, applied in the order scale, rotation, translation.
    Parts {
        /// The translation, in metres.
        translation: DVec3,
        /// The rotation, a unit quaternion.
        rotation: DQuat,
        /// The scale factor along each axis.
        scale: DVec3,
    },
}

impl LocalTransform {
    /// The identity transform.
    pub const IDENTITY: Self =
        Self::Parts { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };

    /// Converts the transform to a matrix.
    pub fn matrix(&self) -> DMat4 {
        match *self {
            Self::Matrix(matrix) => matrix,
            Self::Parts { translation, rotation, scale } => {
                DMat4::from_scale_rotation_translation(scale, rotation, translation)
            }
        }
    }
}

/// A node of the scene's transform hierarchy.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The name in the file; may be empty or not unique.
    pub name: String,
    /// The parent node; `None` for a root.
    pub parent: Option<NodeId>,
    /// The transform from this node's space to the space of its parent, without animation.
    pub local: LocalTransform,
    /// The index of the node's mesh in [`Scene::meshes`](crate::Scene::meshes); `None` for a node without a mesh.
    pub mesh: Option<usize>,
    /// The index in [`Scene::skins`](crate::Scene::skins) of the skin that deforms the mesh; `None` without skinning.
    pub skin: Option<usize>,
    /// The weight of each morph target of the mesh, without animation; empty if the mesh has no targets.
    pub weights: Vec<f32>,
    /// The indices in [`Scene::meshes`](crate::Scene::meshes) of the meshes for coarser levels of detail, from fine to
    /// coarse (`MSFT_lod`). Empty if the node has only one level.
    pub details: Vec<usize>,
    /// Whether the node is drawn: it belongs to the default scene of the file, and is not a level of detail of another
    /// node.
    pub shown: bool,
    /// Whether the first animation changes the transform or morph weights of the node or of one of its ancestors.
    pub animated: bool,
    /// Whether the node's mesh casts shadows (glTF property `extras.castShadow`, `true` if absent).
    pub cast_shadow: bool,
    /// Whether the node's mesh receives shadows (glTF property `extras.receiveShadow`, `true` if absent).
    pub receive_shadow: bool,
}
