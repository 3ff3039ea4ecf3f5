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
    /// The node whose −Z axis is the light's direction.
    pub node: NodeId,
    /// The light without its place, which [`SceneLight::placed`] adds.
    pub light: Light,
}

impl SceneLight {
    /// The light under the world transform of its node. Scale does not matter, as glTF says; where it destroys the
    /// direction (an animated scale of zero), the direction at rest stays.
    pub fn placed(&self, world: &DMat4) -> Light {
        let direction = direction(world).unwrap_or(self.light.direction);
        self.light.clone().position(world.w_axis.truncate()).direction(direction)
    }
}

/// The unit direction in which a light under this transform shines; `None` where the transform leaves none.
pub(crate) fn direction(world: &DMat4) -> Option<DVec3> {
    world.transform_vector3(DVec3::NEG_Z).try_normalize()
}
