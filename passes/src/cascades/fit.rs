//! The box of a slice in light space, relative to the camera.
//!
//! - **tight**: the axis-aligned box around the eight corners of the slice. Smallest, but its size changes as the
//!   camera turns.
//! - **sphere**: the box around the smallest sphere that has the slice's corners inside and its centre on the view
//!   axis. Its size depends on the projection alone.
//!
//! Either is computed for a camera at the origin, so its size and its place relative to the camera are bit-identical
//! wherever the camera stands. In depth the box is always tight: depth does not shimmer.
//!
//! With k the tangent of the angle between the view axis and the frustum's edges, the sphere around the slice from n to
//! f has its centre at (n + f)/2·(1 + k²), but not beyond f; its radius is the distance to the far corners.
//!
//! [`within_scene`] narrows a box to the part in which there is something to receive shadows, without giving up
//! stability: what changes with the camera is only where the narrowed box lies, not how large it is.

use std::f64::consts::PI;

use glam::{DMat3, DVec2, DVec3};
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::frame::{Bounds, Camera, Projection};

use super::splits::Slice;

/// The shape that encloses a slice of the view frustum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FitShape {
    /// The axis-aligned box around the slice: the most texels for each metre, but its size changes as the camera turns.
    Tight,
    /// The box around the slice with sides along the view direction, turned in steps of 15 degrees: the most texels for
    /// views that are longer than wide.
    Aligned,
    /// The box around a sphere that encloses the slice: its size stays the same as the camera turns.
    #[default]
    Sphere,
}

/// The box that a light view must cover, in light space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The corner of the minimum coordinates, in metres.
    pub min: DVec3,
    /// The size in x and y, in metres; it does not depend on the camera's position.
    pub size: DVec2,
    /// The largest z, in metres: the side towards the light.
    pub near: f64,
    /// The centre of the slice, in metres.
    pub center: DVec3,
}

/// The box in light space around a slice of the camera's view frustum. `light` is the rotation from world to light
/// space.
pub fn extent(camera: &Camera, slice: &Slice, light: &DMat3, shape: FitShape) -> Extent {
    let origin = camera.position(DVec3::ZERO);
    let (near, far) = (origin.slice_corners(slice.begin), origin.slice_corners(slice.end));
    let corners = [near, far].into_iter().flatten().map(|corner| *light * corner);
    let tight = corners.clone().fold(Bounds::EMPTY, Bounds::with);
    let center = corners.sum::<DVec3>() / 8.0;
    let (min, size) = match shape {
        FitShape::Tight | FitShape::Aligned => (tight.min.truncate(), (tight.max - tight.min).truncate()),
        FitShape::Sphere => {
            let (distance, radius) = sphere(&camera.projection, camera.aspect, slice);
            let middle = (*light * (origin.forward() * distance)).truncate();
            (middle - radius, DVec2::splat(2.0 * radius))
        }
    };
    let position = *light * camera.position;
    Extent {
        min: position + min.extend(tight.min.z),
        size,
        near: position.z + tight.max.z,
        center: position + center,
    }
}

/// Turns light space about the light's direction in steps of 15°, so that its y axis lies as near as possible to the
/// view direction.
pub fn aligned(light: &DMat3, camera: &Camera) -> DMat3 {
    const STEP: f64 = PI / 12.0;
    let ahead = *light * camera.forward();
    // Looking along the light, any side is up.
    let turn = if ahead.truncate().length() < 0.05 { 0.0 } else { ahead.x.atan2(ahead.y) };
    DMat3::from_rotation_z((turn / STEP).round() * STEP) * *light
}

/// The sphere that encloses a slice: the distance of its centre along the view axis, and its radius, in metres.
pub fn sphere(projection: &Projection, aspect: f64, slice: &Slice) -> (f64, f64) {
    let Slice { begin, end, .. } = *slice;
    // From the view axis to a corner of the picture: at 1 m, or anywhere if it is orthographic.
    let edge = match projection {
        Projection::Perspective { vertical_fov, .. } => (0.5 * vertical_fov).tan() * aspect.hypot(1.0),
        Projection::Orthographic { half_height, .. } => half_height * aspect.hypot(1.0),
        Projection::Matrix { .. } => {
            // Around the view axis, on which an off-centre picture does not lie.
            let (middle, half) = projection.picture(aspect);
            (middle.abs() + half).length()
        }
    };
    if projection.is_orthographic() {
        return (0.5 * (begin + end), (0.5 * (end - begin)).hypot(edge));
    }
    let center = (0.5 * (begin + end) * (1.0 + edge * edge)).min(end);
    (center, (end - center).hypot(end * edge))
}

/// Narrows an extent to the scene's bounds, on each axis of light space.
///
/// The new size is the smaller of the slice's size and the scene's. The slice's size is constant while the camera
/// moves, and the scene's size while the scene does not change; so the new size is constant too. The scene's size is
/// rounded up to a quarter of an octave, so that small animations do not change it. The new size is large enough: the
/// overlap of two intervals is at most as long as the shorter interval.
#[must_use]
pub fn within_scene(extent: Extent, scene: &Bounds, light: &DMat3) -> Extent {
    let scene = in_light_space(scene, light);
    if scene.is_empty() {
        return extent;
    }
    let min = scene.min.max(extent.min);
    let rounded = (scene.max - scene.min).truncate().map(|length| (4.0 * length.log2()).ceil() / 4.0).exp2();
    let near = extent.near.min(scene.max.z);
    Extent {
        // Where slice and scene have nothing in common, there is nothing to cover, but the depth range stays one.
        min: min.truncate().extend(min.z.min(near)),
        size: extent.size.min(rounded),
        near,
        center: extent.center,
    }
}

/// The axis-aligned box in light space around a box in world space. `light` is the rotation from world to light space.
pub fn in_light_space(bounds: &Bounds, light: &DMat3) -> Bounds {
    if bounds.is_empty() {
        return Bounds::EMPTY;
    }
    bounds.corners().into_iter().fold(Bounds::EMPTY, |all, corner| all.with(*light * corner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sphere_is_the_smallest_that_holds_the_corners() {
        for (begin, end) in [(0.1, 10.0), (9.0, 10.0), (30.0, 31.0), (5.0, 5.0)] {
            for (vertical_fov, aspect) in [(0.2, 1.0), (1.0, 1.78), (2.5, 0.5)] {
                for projection in [
                    Projection::Perspective { vertical_fov, near: 0.1, far: 100.0 },
                    Projection::Orthographic { half_height: 7.0 * vertical_fov, near: 0.1, far: 100.0 },
                ] {
                    let slice = Slice { begin, end, ..Slice::default() };
                    let (center, radius) = sphere(&projection, aspect, &slice);
                    let camera = Camera::new(DVec3::ZERO, glam::DQuat::IDENTITY, projection, aspect);
                    let middle = camera.forward() * center;
                    let farthest = |depth: f64| {
                        camera
                            .slice_corners(depth)
                            .into_iter()
                            .map(|corner| corner.distance(middle))
                            .fold(0.0, f64::max)
                    };
                    assert!(
                        farthest(begin) <= radius * (1.0 + 1e-12),
                        "{projection:?} {aspect} {begin} {end}"
                    );
                    assert!(
                        (farthest(end) / radius - 1.0).abs() < 1e-12,
                        "{projection:?} {aspect} {begin} {end}"
                    );
                    // No other centre on the axis has a smaller sphere.
                    for part in (0..=100).map(|step| 0.01 * f64::from(step)) {
                        let other = camera.forward() * (begin + (end - begin) * part);
                        let corners = [begin, end].map(|depth| camera.slice_corners(depth));
                        let needed =
                            corners.iter().flatten().map(|corner| corner.distance(other)).fold(0.0, f64::max);
                        assert!(
                            needed >= radius * (1.0 - 1e-12),
                            "{projection:?} {aspect} {begin} {end} {part}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn the_centre_of_an_extent_is_that_of_its_slice() {
        let projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
        let rotation = glam::DQuat::from_rotation_y(0.7) * glam::DQuat::from_rotation_x(-0.3);
        let camera = Camera::new(DVec3::new(3.0, -2.0, 7.0), rotation, projection, 1.6);
        let light = super::super::light::from_world(DVec3::new(0.6, -0.7, 0.2).normalize(), DVec3::Y);
        let slice = Slice { begin: 2.0, end: 10.0, ..Slice::default() };
        for shape in [FitShape::Tight, FitShape::Sphere] {
            let found = extent(&camera, &slice, &light, shape).center;
            let wanted = light * (camera.position + 6.0 * camera.forward());
            assert!(found.distance(wanted) < 1e-9, "{shape:?} {found} {wanted}");
        }
    }

    #[test]
    fn an_aligned_fit_does_not_turn_if_the_camera_faces_the_light() {
        let projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
        let camera = Camera::new(DVec3::ZERO, glam::DQuat::IDENTITY, projection, 1.6);
        for turn in [-0.03, 0.0, 0.03] {
            let camera = camera.rotation(glam::DQuat::from_rotation_y(turn));
            assert_eq!(aligned(&DMat3::IDENTITY, &camera), DMat3::IDENTITY, "{turn}");
        }
    }

    #[test]
    fn the_narrowed_box_holds_what_slice_and_scene_have_in_common() {
        let extent =
            Extent { min: DVec3::splat(-10.0), size: DVec2::splat(20.0), near: 10.0, center: DVec3::ZERO };
        for (min, max) in [(-3.0, 5.0), (-30.0, -5.0), (5.0, 40.0), (-50.0, 60.0), (2.0, 2.0)] {
            let scene = Bounds { min: DVec3::splat(min), max: DVec3::splat(max) };
            let narrowed = within_scene(extent, &scene, &DMat3::IDENTITY);
            let (low, high) = (f64::max(-10.0, min), f64::min(10.0, max));
            assert!(narrowed.min.x <= low && narrowed.min.x + narrowed.size.x >= high, "{narrowed:?}");
            assert!(narrowed.min.z <= low && narrowed.near >= high, "{narrowed:?}");
            assert!(narrowed.size.x <= 20.0);
        }
        let apart = Bounds { min: DVec3::splat(100.0), max: DVec3::splat(101.0) };
        let narrowed = within_scene(extent, &apart, &DMat3::IDENTITY);
        assert!(narrowed.min.z <= narrowed.near && narrowed.size.x > 0.0);
        assert_eq!(within_scene(extent, &Bounds::EMPTY, &DMat3::IDENTITY), extent);
    }
}
