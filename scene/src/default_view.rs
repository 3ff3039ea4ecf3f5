//! The camera and the directional light of a scene that has none.
//!
//! The camera stands above and in front of the scene, a little to its side, as far away as it takes to see the sphere
//! around the scene's bounds whole, in height and in width. The sun comes over the viewer's left shoulder, so that
//! shadows fall to the right and away. Neither depends on anything but the bounds and the picture's aspect ratio.

use glam::{DMat3, DQuat, DVec3};
use umbragraph_pipeline::frame::{Bounds, Camera, Light, LightKind, Projection};

/// The vertical field of view of the default camera, in radians (40°).
pub const VERTICAL_FOV: f64 = 40.0 * std::f64::consts::PI / 180.0;

/// The direction from the centre of the scene's bounds towards the default camera; not a unit vector.
const TOWARDS_CAMERA: DVec3 = DVec3::new(0.45, 0.4, 1.0);

/// The direction from the scene towards the default directional light; not a unit vector.
const TOWARDS_SUN: DVec3 = DVec3::new(-0.6, 1.0, 0.5);

/// A perspective camera that shows the sphere around `bounds`. Empty bounds count as a sphere of radius 1 m around the
/// origin. `aspect` is the width of the picture over its height.
pub fn camera(bounds: &Bounds, aspect: f64) -> Camera {
    let (center, radius) =
        if bounds.is_empty() { (DVec3::ZERO, 1.0) } else { (bounds.center(), bounds.radius().max(1e-3)) };
    let narrower = if aspect > 0.0 && aspect.is_finite() { aspect.min(1.0) } else { 1.0 };
    let half_angle = ((0.5 * VERTICAL_FOV).tan() * narrower).atan();
    let distance = radius / half_angle.sin();
    let back = TOWARDS_CAMERA.normalize();
    let right = DVec3::Y.cross(back).normalize();
    let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)).normalize();
    Camera::new(
        center + back * distance,
        rotation,
        Projection::Perspective {
            vertical_fov: VERTICAL_FOV,
            near: (distance - radius).max(distance * 1e-3) * 0.5,
            far: (distance + radius) * 1.01,
        },
        aspect,
    )
}

/// The default directional light, with an illuminance of 3 lux. A white surface that faces the light then almost
/// reaches display white.
pub fn sun() -> Light {
    Light::new("sun", LightKind::Directional)
        .direction(-TOWARDS_SUN.normalize())
        .intensity(3.0)
        .property("cast_shadow")
        .property("contact_shadow")
        .angular_diameter(0.53_f32.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_camera_sees_every_corner_of_the_bounds() {
        let bounds = Bounds { min: DVec3::new(100.0, -3.0, 7.0), max: DVec3::new(140.0, 9.0, 8.0) };
        for aspect in [0.3, 1.0, 2.5] {
            let camera = camera(&bounds, aspect);
            assert_eq!(camera.check(), None);
            let (away, radius) = (camera.position.distance(bounds.center()), bounds.radius());
            let (near, far) = camera.projection.depth_range();
            assert!((near / (away - radius) - 0.5).abs() < 1e-9, "{near} of {away} and {radius}");
            assert!((1.0..1.05).contains(&(far / (away + radius))), "{far} of {away} and {radius}");
            let clip = camera.clip(false) * camera.view();
            for corner in bounds.corners() {
                let seen = clip.project_point3(corner);
                assert!(seen.x.abs() <= 1.0 && seen.y.abs() <= 1.0, "{corner} at {seen}, aspect {aspect}");
                assert!((0.0..=1.0).contains(&seen.z), "{corner} at depth {}", seen.z);
            }
        }
    }

    #[test]
    fn bounds_without_extent_still_give_a_usable_camera() {
        for bounds in [Bounds::EMPTY, Bounds::EMPTY.with(DVec3::splat(4.0))] {
            assert_eq!(camera(&bounds, 1.0).check(), None);
        }
    }

    #[test]
    fn without_a_usable_aspect_the_camera_stands_as_for_a_square() {
        let square = camera(&Bounds::EMPTY, 1.0).position;
        for aspect in [0.0, -2.0, f64::NAN, f64::INFINITY] {
            assert_eq!(camera(&Bounds::EMPTY, aspect).position, square, "aspect {aspect}");
        }
    }

    #[test]
    fn the_default_sun_is_usable_and_shines_down() {
        assert_eq!(sun().check(), None);
        assert!(sun().direction.y < -0.5);
    }
}
