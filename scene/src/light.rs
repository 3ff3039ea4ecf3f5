//! Lights of a scene: `KHR_lights_punctual`, placed by nodes.
//!
//! Properties that glTF lacks come from `extras` of the light or, with priority, of its node: `castShadow`,
//! `contactShadow`, `shadowHardness` (`hard`, `soft` or `pcss`), `angular_diameter_deg` (degrees), `radius` (metres)
//! and `priority`.

use glam::{DMat4, DVec3};
use umbragraph_pipeline::frame::Light;

use crate::node::NodeId;

/// A light and the node that places it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneLight {
    /// The node that places the light; its −Z axis is the direction of the light.
    pub node: NodeId,
    /// The light without the position from its node; [`SceneLight::placed`] sets position and direction.
    pub light: Light,
}

impl SceneLight {
    /// Returns the light with the position and direction of its node, given the world transform of the node. Scale has
    /// no effect, as glTF requires. An animated scale of zero leaves no direction; the light then keeps its rest
    /// direction.
    pub fn placed(&self, world: &DMat4) -> Light {
        let direction = direction(world).unwrap_or(self.light.direction);
        self.light.clone().position(world.w_axis.truncate()).direction(direction)
    }
}

/// The unit direction of a light whose node has this world transform: the transformed −Z axis. `None` if that axis has
/// length zero.
pub(crate) fn direction(world: &DMat4) -> Option<DVec3> {
    world.transform_vector3(DVec3::NEG_Z).try_normalize()
}
