//! Obstacles of a camera that moves by itself: rays against the scene in its first pose.
//!
//! Without the feature `score` there are no rays, and nothing is in the way.

use glam::DVec3;
use umbragraph::low_level::camera_path::Obstacles;
use umbragraph::scene::Scene;
#[cfg(feature = "score")]
use umbragraph_score::Rays;

/// The minimum distance of a camera from obstacles ahead, in metres.
#[cfg(feature = "score")]
const DISTANCE: f64 = 0.5;

/// The geometry around a camera, for avoiding obstacles.
#[cfg(feature = "score")]
pub(crate) struct Surroundings<'a>(Rays<'a>);

#[cfg(feature = "score")]
impl<'a> Surroundings<'a> {
    /// Creates the surroundings from the scene's rest pose.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        Self(Rays::new(scene, &scene.rest_pose()))
    }
}

#[cfg(feature = "score")]
impl Obstacles for Surroundings<'_> {
    fn free(&self, from: DVec3, direction: DVec3, distance: f64) -> f64 {
        let seen = self.0.seen(from, direction, [0.0, distance + DISTANCE]);
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
    fn free(&self, _: DVec3, _: DVec3, distance: f64) -> f64 {
        distance
    }
}

#[cfg(test)]
mod tests {
    #[cfg(feature = "score")]
    #[test]
    fn orbits_stay_in_the_room_and_within_the_walls() {
        use umbragraph::low_level::camera_path::{CameraPath, Obstacles as _};
        for (name, side) in [("interior", glam::DVec3::Y), ("courtyard", glam::DVec3::NEG_Y)] {
            let path = format!("{}/../examples/scenes/{name}.glb", env!("CARGO_MANIFEST_DIR"));
            let scene = umbragraph::scene::load(std::path::Path::new(&path)).unwrap();
            let around = super::Surroundings::new(&scene);
            let input = scene.frame_input_of(&scene.rest_pose(), 1.0, 0.0);
            for at in 0..24 {
                let moment = [0.0, f64::from(at) / 24.0, 0.0];
                let camera =
                    CameraPath::Orbit.camera(input.camera, &input.scene_bounds, Some(&around), moment);
                // A ceiling above, or a ground below.
                let is_inside = around.0.seen(camera.position, side, [0.0, 20.0]).is_some();
                let away = camera.position.distance(input.camera.position);
                assert!(is_inside && away < 50.0, "{name} at {at}: {away} m away");
                let ahead = camera.rotation * glam::DVec3::NEG_Z;
                assert!(around.free(camera.position, ahead, 1.0) > 0.4, "{name} at {at}: a wall ahead");
            }
        }
    }
}
