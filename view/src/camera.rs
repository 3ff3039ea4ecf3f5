//! The camera that the user moves: around a point, or flying.
//!
//! A position, two angles and the distance to the point that it turns around. Both modes share them, so that a change
//! of mode moves nothing. Up is +Y; a camera of a scene that is tilted stays so until it is moved.

use std::f64::consts::FRAC_PI_2;

use serde_json::{Value, json};
use umbragraph::frame::{Bounds, Camera};
use umbragraph::glam::{DQuat, DVec2, DVec3};
use umbragraph::low_level::camera_path::Key;
use umbragraph::scene::Scene;

/// The maximum tilt up or down, in radians, slightly less than straight up.
const STEEPEST: f64 = FRAC_PI_2 - 0.01;

/// The movement of the camera by a drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The camera orbits around a point in front of it.
    Orbit,
    /// The camera turns in place; W, A, S, D, Q and E move it.
    Fly,
}

/// A camera that the user moves, as a position and two angles.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct View {
    pub(crate) mode: Mode,
    position: DVec3,
    turn: f64,
    tilt: f64,
    /// The distance to the orbit point, in metres.
    distance: f64,
    /// The rotation of the scene's camera, which may have roll; `None` once the user has turned the camera.
    rotation: Option<DQuat>,
    /// The radius of the scene in metres, which scales the speed of movements.
    radius: f64,
}

impl View {
    /// Creates a view at the camera of a scene. The orbit point lies at the nearest of the bounding boxes `things`
    /// ahead, or else at the depth of the scene's centre.
    pub(crate) fn new(camera: &Camera, bounds: &Bounds, things: impl Iterator<Item = Bounds>) -> Self {
        let radius = if bounds.is_empty() { 1.0 } else { bounds.radius().max(1e-3) };
        let ahead = camera.rotation * DVec3::NEG_Z;
        let middle = if bounds.is_empty() { DVec3::ZERO } else { bounds.center() };
        let nearest = things.filter_map(|thing| hit(&thing, camera.position, ahead)).reduce(f64::min);
        let along = nearest.unwrap_or_else(|| (middle - camera.position).dot(ahead));
        let [turn, tilt] = angles(ahead);
        Self {
            mode: Mode::Orbit,
            position: camera.position,
            turn,
            tilt,
            distance: along.clamp(0.01 * radius, 2.0 * radius),
            rotation: Some(camera.rotation),
            radius,
        }
    }

    /// The initial camera of a scene: its first camera, or the default one.
    pub(crate) fn home(scene: &Scene) -> Self {
        let pose = scene.pose(0.0);
        let input = scene.frame_input_of(&pose, 1.0, 0.0);
        let things = scene.draws().map(|draw| scene.draw_bounds(draw, &pose));
        Self::new(&input.camera, &input.scene_bounds, things)
    }

    fn rotation(&self) -> DQuat {
        let turned = DQuat::from_rotation_y(self.turn) * DQuat::from_rotation_x(self.tilt);
        self.rotation.unwrap_or(turned)
    }

    /// The orbit point, in world space.
    pub(crate) fn target(&self) -> DVec3 {
        self.position + self.rotation() * DVec3::NEG_Z * self.distance
    }

    /// The camera with this position and rotation, and the projection of `base`.
    pub(crate) fn camera(&self, base: Camera) -> Camera {
        base.position(self.position).rotation(self.rotation())
    }

    /// Copies the position and rotation of another camera.
    pub(crate) fn place(&mut self, camera: &Camera) {
        self.position = camera.position;
        [self.turn, self.tilt] = angles(camera.rotation * DVec3::NEG_Z);
        self.rotation = Some(camera.rotation);
    }

    /// Turns the camera by angles in radians: around the orbit point, or in place in fly mode.
    pub(crate) fn turn(&mut self, by: DVec2) {
        let target = self.target();
        self.turn = (self.turn - by.x) % std::f64::consts::TAU;
        self.tilt = (self.tilt - by.y).clamp(-STEEPEST, STEEPEST);
        self.rotation = None;
        if self.mode == Mode::Orbit {
            self.position = target - self.rotation() * DVec3::NEG_Z * self.distance;
        }
    }

    /// Moves the camera sideways and up. `by` is the drag as a fraction of the frame height.
    pub(crate) fn pan(&mut self, by: DVec2) {
        self.position += self.rotation() * DVec3::new(-by.x, by.y, 0.0) * self.distance;
    }

    /// Moves the camera towards the orbit point, or forward in fly mode; away or backward if `steps` is negative.
    pub(crate) fn zoom(&mut self, steps: f64) {
        match self.mode {
            Mode::Orbit => {
                let target = self.target();
                let nearest = 1e-3 * self.radius;
                self.distance = (self.distance * (-0.15 * steps).exp()).clamp(nearest, 20.0 * self.radius);
                self.position = target - self.rotation() * DVec3::NEG_Z * self.distance;
            }
            Mode::Fly => self.fly(DVec3::NEG_Z * 0.1 * steps),
        }
    }

    /// Moves the camera along its own axes, in units of the scene's radius.
    pub(crate) fn fly(&mut self, by: DVec3) {
        self.position += self.rotation() * by * self.radius;
    }

    /// The camera as a key of a camera path, with its position and orbit point. `time` is in seconds.
    pub(crate) fn key(&self, time: f64) -> Key {
        Key { time, position: self.position.into(), target: self.target().into() }
    }

    /// The position and orbit point in metres, rounded to 0.1 mm, as JSON.
    pub(crate) fn rounded(&self) -> Value {
        let rounded = |at: DVec3| [at.x, at.y, at.z].map(|one| (one * 1e4).round() / 1e4);
        json!({ "position": rounded(self.position), "target": rounded(self.target()) })
    }

    /// Places the camera at a key of a camera path.
    pub(crate) fn go_to(&mut self, key: &Key) {
        self.position = key.position.into();
        let ahead = DVec3::from(key.target) - self.position;
        self.distance = ahead.length().max(1e-3 * self.radius);
        [self.turn, self.tilt] = angles(ahead);
        self.rotation = None;
    }

    /// Places the camera at a bookmark, but keeps the current mode.
    pub(crate) fn visit(&mut self, bookmark: &Self) {
        *self = Self { mode: self.mode, ..bookmark.clone() };
    }

    /// Returns `true` if the camera has no roll, so that a key of a camera path describes it completely.
    pub(crate) fn is_upright(&self) -> bool {
        let key = self.key(0.0).rotation();
        key.is_some_and(|key| key.angle_between(self.rotation()) < 1e-6)
    }
}

/// The distance in metres along a ray to the middle of the segment inside a box. `None` if the ray misses the box or
/// starts inside it.
fn hit(bounds: &Bounds, from: DVec3, ahead: DVec3) -> Option<f64> {
    let [a, b] = [bounds.min, bounds.max].map(|corner| (corner - from) / ahead);
    let (near, far) = (a.min(b).max_element(), a.max(b).min_element());
    (near > 0.0 && near <= far).then_some(0.5 * (near + far))
}

/// The turn around +Y and the tilt of a direction, in radians.
fn angles(ahead: DVec3) -> [f64; 2] {
    [(-ahead.x).atan2(-ahead.z), ahead.y.atan2(ahead.x.hypot(ahead.z)).clamp(-STEEPEST, STEEPEST)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        let camera = Camera::look_at([4.0, 3.0, 5.0], [0.0; 3], 0.8, 1.5);
        View::new(&camera, &Bounds::between([-3.0; 3], [3.0; 3]), std::iter::empty())
    }

    #[test]
    fn an_orbit_keeps_its_point_and_its_distance() {
        let mut view = view();
        let (target, distance) = (view.target(), view.position.distance(view.target()));
        view.turn(DVec2::new(1.2, -0.3));
        assert!(view.target().distance(target) < 1e-9);
        assert!((view.position.distance(target) - distance).abs() < 1e-9);
        view.zoom(2.0);
        assert!(view.target().distance(target) < 1e-9 && view.position.distance(target) < distance);
    }

    #[test]
    fn rays_hit_boxes_ahead_and_none_that_they_start_in() {
        let bounds = Bounds::between([-1.0; 3], [1.0; 3]);
        assert_eq!(hit(&bounds, DVec3::new(0.2, 0.3, 5.0), DVec3::NEG_Z), Some(5.0));
        assert_eq!(hit(&bounds, DVec3::new(0.2, 0.3, 5.0), DVec3::Z), None);
        assert_eq!(hit(&bounds, DVec3::new(2.0, 0.3, 5.0), DVec3::NEG_Z), None);
        assert_eq!(hit(&bounds, DVec3::splat(0.5), DVec3::NEG_Z), None);
    }

    #[test]
    fn flying_turns_in_place_and_never_over() {
        let mut view = View { mode: Mode::Fly, ..view() };
        let position = view.position;
        view.turn(DVec2::new(0.4, -100.0));
        assert_eq!(view.position, position);
        assert!((view.rotation() * DVec3::Y).y > 0.0, "upright");
        view.fly(DVec3::X);
        assert!((view.position.distance(position) - view.radius).abs() < 1e-9);
    }

    #[test]
    fn bookmarks_and_keys_say_the_place_exactly() {
        let mut view = view();
        view.turn(DVec2::new(0.123_456_789, 0.2));
        let bookmark = view.clone();
        let text = serde_json::to_string(&view.key(0.0)).expect("JSON");
        view.turn(DVec2::new(1.0, 0.2));
        view.mode = Mode::Fly;
        view.visit(&bookmark);
        assert_eq!(view, View { mode: Mode::Fly, ..bookmark.clone() });
        let key: Key = serde_json::from_str(&text).expect("a key");
        view.go_to(&key);
        assert!(view.position.distance(bookmark.position) < 1e-12);
        assert!(view.target().distance(bookmark.target()) < 1e-12);
        assert!(view.is_upright());
        view.rotation = Some(view.rotation() * DQuat::from_rotation_z(0.1));
        assert!(!view.is_upright(), "a key has no roll");
    }
}
