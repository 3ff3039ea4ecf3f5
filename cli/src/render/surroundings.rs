//! Obstacles of a camera that moves by itself: rays against the scene in its first pose.
//!
//! Without the feature `score` there are no rays, and nothing is in the way.

use glam::DVec3;
#[cfg(feature = "score")]
use umbragraph::frame::Bounds;
use umbragraph::low_level::camera_path::Obstacles;
use umbragraph::scene::Scene;
#[cfg(feature = "score")]
use umbragraph_score::Rays;

/// The minimum distance of a camera from obstacles ahead, in metres. `HEIGHT` is the minimum height above the surface
/// below.
#[cfg(feature = "score")]
const DISTANCE: f64 = 0.5;
#[cfg(feature = "score")]
const HEIGHT: f64 = 1.5;

/// The geometry around a camera, for avoiding obstacles.
#[cfg(feature = "score")]
pub(crate) struct Surroundings<'a> {
    rays: Rays<'a>,
    bounds: Bounds,
}

#[cfg(feature = "score")]
impl<'a> Surroundings<'a> {
    /// Creates the surroundings from the scene's rest pose.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let pose = scene.rest_pose();
        let bounds = scene.frame_input_of(&pose, 1.0, 0.0).scene_bounds;
        Self { rays: Rays::new(scene, &pose), bounds }
    }
}

#[cfg(feature = "score")]
impl Obstacles for Surroundings<'_> {
    fn lifted(&self, place: DVec3) -> DVec3 {
        let top = self.bounds.max.y.max(place.y) + HEIGHT;
        let from = DVec3::new(place.x, top, place.z);
        match self.rays.seen(from, DVec3::NEG_Y, [0.0, top - self.bounds.min.y + HEIGHT]) {
            Some(seen) => DVec3::new(place.x, place.y.max(top - seen.distance + HEIGHT), place.z),
            None => place,
        }
    }

    fn free(&self, from: DVec3, direction: DVec3, distance: f64) -> f64 {
        let seen = self.rays.seen(from, direction, [0.0, distance + DISTANCE]);
        seen.map_or(distance, |seen| (seen.distance - DISTANCE).clamp(0.0, distance))
    }
}

/// The geometry around a camera in a build without ray tracing: no obstacle is known.
#[cfg(not(feature = "score"))]
pub(crate) struct Surroundings<'a>(std::marker::PhantomData<&'a Scene>);

#[cfg(not(feature = "score"))]
impl<'a> Surroundings<'a> {
    pub(crate) fn new(_: &'a Scene) -> Self {
        Self(std::marker::PhantomData)
    }
}

#[cfg(not(feature = "score"))]
impl Obstacles for Surroundings<'_> {
    fn lifted(&self, place: DVec3) -> DVec3 {
        place
    }

    fn free(&self, _: DVec3, _: DVec3, distance: f64) -> f64 {
        distance
    }
}
