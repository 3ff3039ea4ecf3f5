//! Cameras of a scene.

use glam::{DMat3, DMat4, DQuat, DVec3};
use umbragraph_pipeline::frame::{Bounds, Camera, Projection};

use crate::node::NodeId;

/// A camera, and the node that gives the camera its position and rotation.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SceneCamera {
    /// The name of the camera, or the name of its node if the camera has none; may be empty.
    pub name: String,
    /// The node at the position of the camera. The camera looks along the node's −Z axis.
    pub node: NodeId,
    /// The projection; its far plane is infinite if the file gives no far plane.
    pub projection: Projection,
}

impl SceneCamera {
    /// Returns the camera with the position and rotation of its node, whose world transform is `world`.
    ///
    /// Scale, shear and mirroring of the transform have no effect. An infinite far plane of a perspective camera is
    /// replaced by a far plane just beyond `bounds`. `aspect` is the width of the picture over its height. It replaces
    /// the aspect ratio of the file; the vertical field of view is kept.
    pub fn placed(&self, world: &DMat4, bounds: &Bounds, aspect: f64) -> Camera {
        let position = world.w_axis.truncate();
        let rotation = rotation_of(world).unwrap_or(DQuat::IDENTITY);
        let forward = rotation * DVec3::NEG_Z;
        let farthest = || {
            let depth = |corner: DVec3| (corner - position).dot(forward);
            let depths = (!bounds.is_empty()).then(|| bounds.corners().map(depth));
            depths.into_iter().flatten().fold(0.0, f64::max) * 1.001
        };
        let projection = match self.projection {
            Projection::Perspective { vertical_fov, near, far } if far.is_infinite() => {
                Projection::Perspective { vertical_fov, near, far: farthest().max(near * 10.0) }
            }
            other => other,
        };
        Camera::new(position, rotation, projection, aspect)
    }
}

/// Extracts the rotation of a camera from a world transform. The rotation has the exact direction of the transformed −Z
/// axis, and a +Y axis as close as possible to the transformed one. Returns `None` if one of the two axes has length
/// zero or they are parallel.
pub(crate) fn rotation_of(world: &DMat4) -> Option<DQuat> {
    let back = world.z_axis.truncate().try_normalize()?;
    let right = world.y_axis.truncate().try_normalize()?.cross(back).try_normalize()?;
    let up = back.cross(right);
    let rotation = DQuat::from_mat3(&DMat3::from_cols(right, up, back)).normalize();
    rotation.is_finite().then_some(rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_and_mirroring_leave_the_view_direction() {
        let rotation = DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(-0.3);
        for scale in [DVec3::ONE, DVec3::new(3.0, 2.0, 0.5), DVec3::new(-1.0, 1.0, 1.0)] {
            let world = DMat4::from_scale_rotation_translation(scale, rotation, DVec3::ZERO);
            let found = rotation_of(&world).unwrap();
            assert!((found * DVec3::NEG_Z).abs_diff_eq(rotation * DVec3::NEG_Z, 1e-12), "{scale}");
            assert!((found * DVec3::Y).abs_diff_eq(rotation * DVec3::Y, 1e-12), "{scale}");
        }
        assert_eq!(rotation_of(&DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0))), None);
    }

    #[test]
    fn an_infinite_far_plane_is_drawn_in_to_the_scene() {
        let camera = SceneCamera {
            name: String::new(),
            node: NodeId(0),
            projection: Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: f64::INFINITY },
        };
        let bounds = Bounds { min: DVec3::new(-1.0, -1.0, -50.0), max: DVec3::new(1.0, 1.0, -5.0) };
        let (near, far) = camera.placed(&DMat4::IDENTITY, &bounds, 1.0).projection.depth_range();
        assert_eq!(near, 0.1);
        assert!(far > 50.0 && far < 51.0, "{far}");
        let back = DMat4::from_translation(DVec3::new(0.0, 0.0, 10.0));
        let (_, far) = camera.placed(&back, &bounds, 1.0).projection.depth_range();
        assert!(far > 60.0 && far < 61.0, "{far}");
        let (_, far) = camera.placed(&DMat4::IDENTITY, &Bounds::EMPTY, 1.0).projection.depth_range();
        assert_eq!(far, 1.0, "nothing in view: still a depth range");
    }
}
