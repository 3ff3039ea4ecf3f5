//! Lights of a scene: `KHR_lights_punctual`, placed by nodes.
//!
//! Properties that glTF lacks come from `extras` of the light or, with priority, of its node: `castShadow`,
//! `contactShadow`, `shadowHardness` (`hard`, `soft` or `pcss`), `angular_diameter_deg` (degrees), `radius` (metres)
//! and `priority`.

use glam::{DMat4, DVec3};
use umbragraph_pipeline::frame::Light;

use crate::node::NodeId;

/// A light, and the node that gives the light its position and direction.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneLight {
    /// The node at the position of the light. The light shines along the node's −Z axis.
    pub node: NodeId,
    /// The light with its direction in the rest pose, but without a position. [`SceneLight::placed`] sets both for a
    /// pose.
    pub light: Light,
}

impl SceneLight {
    /// Returns the light with the position and direction of its node, whose world transform is `world`. The scale of
    /// the node has no effect, as glTF requires. If the −Z axis of the node has length zero, the light keeps its
    /// direction in the rest pose.
    pub fn placed(&self, world: &DMat4) -> Light {
        let direction = direction(world).unwrap_or(self.light.direction);
        self.light.clone().position(world.w_axis.truncate()).direction(direction)
    }
}

/// The unit direction of a light whose node has the transform `world`: the transformed −Z axis. `None` if the
/// transformed axis has length zero.
pub(crate) fn direction(world: &DMat4) -> Option<DVec3> {
    world.transform_vector3(DVec3::NEG_Z).try_normalize()
}
