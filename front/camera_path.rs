//! The path of the camera over the frames, as `--camera` of the command and of the viewer names it.
//!
//! `orbit` goes once around the middle of the scene, at the height and distance of the scene's own camera. If obstacles
//! are in the way, it stays before them, and goes around what that camera looks at, or around a point halfway to it.
//! `walk` goes straight on at one height. All frames together go as
//! far as the scene's radius, or up to the first obstacle. A file gives keys, between which positions are interpolated
//! along a straight line and directions along an arc:
//!
//! ```json
//! { "keys": [ { "time": 0, "position": [0, 2, 8], "target": [0, 1, 0] },
//!             { "time": 4, "position": [6, 3, 5], "target": [0, 1, 0] } ] }
//! ```
//!
//! Times in seconds, strictly increasing; positions in metres. Before the first key and after the last one the camera
//! stands still. Its projection is that of the scene's camera, up is +Y.
//!
//! `random` (or `random:SEED`) looks from elsewhere in every frame: up to a twentieth of the scene's radius away from
//! its own camera, towards any point of the scene's bounds, tilted by up to half a right angle.

use std::f64::consts::FRAC_PI_4;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::camera_keys;
use crate::diagnostic::{Diagnostic, Place};
use crate::frame::{Bounds, Camera};
use crate::glam::{DMat3, DQuat, DVec3};
use crate::low_level::source::Sources;

pub use super::codes::CAMERA_PATH;
use super::orbit::Orbit;

/// The value of the option `--camera`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraArgument {
    /// One orbit around the middle of the scene.
    Orbit,
    /// A straight walk forward.
    Walk,
    /// A random position and direction in every frame, derived from this seed.
    Random(u64),
    /// A path along the keys in this file.
    File(PathBuf),
}

/// The obstacles of a scene, as a query for a camera that follows an automatic path.
pub trait Obstacles {
    /// Returns how far a camera can move from `from` along `direction`, in metres, at most `distance`.
    fn free(&self, from: DVec3, direction: DVec3, distance: f64) -> f64;
}

impl CameraArgument {
    /// Parses the value of the option `--camera`. A value that is not one of the keywords is the path of a key file.
    ///
    /// # Errors
    /// Never returned: every value is valid.
    pub fn parse(text: &str) -> Result<Self, std::convert::Infallible> {
        if let Some(seed) = text.strip_prefix("random:").and_then(|seed| seed.parse().ok()) {
            return Ok(Self::Random(seed));
        }
        Ok(match text {
            "orbit" => Self::Orbit,
            "walk" => Self::Walk,
            "random" => Self::Random(1),
            file => Self::File(file.into()),
        })
    }
}

/// A camera path whose key file, if any, has been read.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraPath {
    /// The fixed camera of the scene.
    Scene,
    /// One orbit around the middle of the scene.
    Orbit,
    /// A straight walk forward.
    Walk,
    /// A random position and direction in every frame, derived from this seed.
    Random(u64),
    /// A path along keys; the list has at least one.
    Keys(Vec<Key>),
}

/// The position and target of the camera at one time.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Key {
    /// The time, in seconds.
    pub time: f64,
    /// The place of the camera, in metres.
    pub position: [f64; 3],
    /// The point that the camera looks at, in metres.
    pub target: [f64; 3],
}

impl CameraPath {
    /// Returns the path that an argument of `--camera` selects.
    ///
    /// # Errors
    /// A file that cannot be read, is no camera path, or has values that no camera can use.
    pub fn of(argument: Option<&CameraArgument>) -> Result<Self, Diagnostic> {
        let mut sources = Sources::new();
        Self::of_sources(argument, &mut sources).map_err(|mut error| {
            // Nobody has these sources.
            error.place = match error.place {
                Place::Span(span) => {
                    let file = sources.get(span.file);
                    let at =
                        file.map(|file| file.line_column(u32::try_from(span.range().start).unwrap_or(0)));
                    let locator = at.map(|at| format!("{}:{}", at.line, at.column)).unwrap_or_default();
                    Place::File { path: file.map(|file| file.name().to_owned()).unwrap_or_default(), locator }
                }
                other => other,
            };
            error.related.clear();
            error.fix = None;
            error
        })
    }

    /// Returns the path that an argument of `--camera` selects. A key file is added to `sources`, which diagnostics
    /// about it refer to.
    ///
    /// # Errors
    /// A file that cannot be read, is no camera path, or has values that no camera can use.
    pub fn of_sources(argument: Option<&CameraArgument>, sources: &mut Sources) -> Result<Self, Diagnostic> {
        Ok(match argument {
            None => Self::Scene,
            Some(CameraArgument::Orbit) => Self::Orbit,
            Some(CameraArgument::Walk) => Self::Walk,
            Some(CameraArgument::Random(seed)) => Self::Random(*seed),
            Some(CameraArgument::File(path)) => Self::Keys(camera_keys::read(path, sources)?),
        })
    }

    /// Returns `true` if the camera moves by itself, so that an obstacle can be in its way.
    pub fn may_collide(&self) -> bool {
        matches!(self, Self::Orbit | Self::Walk)
    }

    /// Returns the camera of a frame. `scene` is the scene's own camera, and `around` the obstacles, if any. The
    /// numbers are the frame index, the covered fraction of the path from 0 to 1, and the time in seconds.
    pub fn camera(
        &self,
        scene: Camera,
        bounds: &Bounds,
        around: Option<&dyn Obstacles>,
        [index, part, time]: [f64; 3],
    ) -> Camera {
        let (middle, radius) =
            if bounds.is_empty() { (DVec3::ZERO, 1.0) } else { (bounds.center(), bounds.radius()) };
        match self {
            Self::Scene => scene,
            Self::Orbit => {
                let turn = DQuat::from_rotation_y(part * std::f64::consts::TAU);
                let orbit = around.and_then(|around| Orbit::among(around, &scene, middle, radius));
                orbit.map_or_else(
                    || {
                        let position = middle + turn * (scene.position - middle);
                        scene.position(position).rotation((turn * scene.rotation).normalize())
                    },
                    |orbit| orbit.camera(scene, turn),
                )
            }
            Self::Walk => {
                let ahead = scene.rotation * DVec3::NEG_Z;
                let level = DVec3::new(ahead.x, 0.0, ahead.z).try_normalize().unwrap_or(DVec3::NEG_Z);
                let way = around.map_or(radius, |around| around.free(scene.position, level, radius));
                scene.position(scene.position + level * (part * way))
            }
            Self::Random(seed) => {
                let [at, aside] =
                    [0, 1].map(|half| random(seed.wrapping_add(index as u64), half) * 2.0 - 1.0);
                let position = scene.position + aside * DVec3::new(1.0, 0.1, 1.0) * (0.05 * radius);
                let extent = if bounds.is_empty() { DVec3::ONE } else { 0.5 * (bounds.max - bounds.min) };
                let ahead = middle + at * extent - position;
                let tilt = ahead.y.atan2(ahead.x.hypot(ahead.z)).clamp(-FRAC_PI_4, FRAC_PI_4);
                let turn = (-ahead.x).atan2(-ahead.z);
                // Upright whatever the scene's own camera is.
                let rotation = DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(tilt);
                scene.position(position).rotation(rotation.normalize())
            }
            Self::Keys(keys) => {
                let after = keys.partition_point(|key| key.time <= time);
                let (Some(from), Some(to)) =
                    (keys.get(after.saturating_sub(1)), keys.get(after.min(keys.len() - 1)))
                else {
                    return scene;
                };
                let span = to.time - from.time;
                let t = if span > 0.0 { ((time - from.time) / span).clamp(0.0, 1.0) } else { 0.0 };
                let position = DVec3::from(from.position).lerp(DVec3::from(to.position), t);
                let (Some(one), Some(other)) = (from.rotation(), to.rotation()) else { return scene };
                scene.position(position).rotation(one.slerp(other, t).normalize())
            }
        }
    }
}

/// Returns three pseudo-random numbers from 0 to 1 (S. Vigna's splitmix64). `which` selects one of several sets of
/// three numbers for the same seed.
fn random(seed: u64, which: u64) -> DVec3 {
    DVec3::from([1, 2, 3].map(|at| {
        let mut bits = seed.wrapping_mul(8).wrapping_add(3 * which + at).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }))
}

impl Key {
    /// Returns the rotation from camera space to world space. `None` if position and target coincide, or the camera
    /// looks straight up or down.
    pub fn rotation(&self) -> Option<DQuat> {
        let back = (DVec3::from(self.position) - DVec3::from(self.target)).try_normalize()?;
        let right = DVec3::Y.cross(back).try_normalize()?;
        let rotation = DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)).normalize();
        rotation.is_finite().then_some(rotation)
    }
}

#[cfg(test)]
mod tests {
    use crate::frame::Projection;

    use super::*;

    fn scene() -> Camera {
        let projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
        Camera::new(DVec3::new(0.0, 2.0, 5.0), DQuat::IDENTITY, projection, 1.0)
    }

    fn bounds() -> Bounds {
        Bounds { min: DVec3::splat(-1.0), max: DVec3::ONE }
    }

    #[test]
    fn an_orbit_comes_back_and_looks_at_the_middle_on_its_way() {
        let path = CameraPath::Orbit;
        for part in [0.0, 1.0] {
            assert!(
                path.camera(scene(), &bounds(), None, [0.0, part, 0.0])
                    .position
                    .abs_diff_eq(scene().position, 1e-9)
            );
        }
        let half = path.camera(scene(), &bounds(), None, [0.0, 0.5, 0.0]);
        assert!(half.position.abs_diff_eq(DVec3::new(0.0, 2.0, -5.0), 1e-9));
        assert!((half.rotation * DVec3::NEG_Z).abs_diff_eq(DVec3::Z, 1e-9));
    }

    /// Spheres with these middles and radii, seen from outside, and the room from −4 to 4 around them, seen from
    /// inside.
    struct Room(Vec<(DVec3, f64)>);

    impl Obstacles for Room {
        fn free(&self, from: DVec3, direction: DVec3, distance: f64) -> f64 {
            let to_walls = (0..3).map(|axis| {
                let side = 4.0 * direction[axis].signum();
                if direction[axis] == 0.0 { f64::INFINITY } else { (side - from[axis]) / direction[axis] }
            });
            let to_spheres = self.0.iter().filter_map(|(middle, radius)| {
                let to = *middle - from;
                let along = to.dot(direction);
                let inside = radius * radius - (to.length_squared() - along * along);
                (inside >= 0.0 && along > 0.0).then(|| along - inside.sqrt())
            });
            to_walls.chain(to_spheres).fold(distance, f64::min).max(0.0)
        }
    }

    #[test]
    fn an_orbit_stays_in_a_room_and_goes_around_a_thing() {
        // The middle of the scene is outside the room.
        let outside = Bounds { min: DVec3::splat(-20.0), max: DVec3::splat(80.0) };
        let camera = scene().position(DVec3::new(0.0, 1.0, 3.5));
        for (room, pivot) in [
            (Room(Vec::new()), DVec3::new(0.0, 1.0, -0.25)),
            (Room(vec![(DVec3::new(0.0, 1.0, 0.0), 0.15)]), DVec3::new(0.0, 1.0, 0.15)),
        ] {
            for at in 0..16 {
                let part = f64::from(at) / 16.0;
                let Camera { position, rotation, .. } =
                    CameraPath::Orbit.camera(camera, &outside, Some(&room), [0.0, part, 0.0]);
                assert!(position.abs().max_element() <= 4.0, "{position}");
                let ahead = (pivot - position).normalize();
                assert!((rotation * DVec3::NEG_Z).abs_diff_eq(ahead, 1e-9), "{position} looks at {pivot}");
            }
        }
    }

    #[test]
    fn a_walk_keeps_its_height() {
        let end = CameraPath::Walk.camera(scene(), &bounds(), None, [0.0, 1.0, 0.0]);
        assert_eq!(end.position.y, 2.0);
        assert!((end.position.z - (5.0 - bounds().radius())).abs() < 1e-9);
    }

    #[test]
    fn random_views_follow_from_their_seed_and_stay_near() {
        let camera = |seed, index: i32| {
            CameraPath::Random(seed).camera(scene(), &bounds(), None, [index.into(), 0.0, 0.0])
        };
        assert_eq!(camera(1, 3), camera(1, 3));
        assert_ne!(camera(1, 3).rotation, camera(1, 4).rotation);
        for index in 0..50 {
            let Camera { position, rotation, .. } = camera(7, index);
            assert!(position.distance(scene().position) <= 0.1 * bounds().radius());
            let (up, ahead) = (rotation * DVec3::Y, rotation * DVec3::NEG_Z);
            assert!(up.y > 0.7, "upright");
            assert!(ahead.dot(-position) > 0.0, "towards the scene, which is in the middle");
        }
    }

    #[test]
    fn between_keys_the_camera_moves_and_outside_it_stands() {
        let key = |time, x| Key { time, position: [x, 0.0, 0.0], target: [x, 0.0, -1.0] };
        let path = CameraPath::Keys(vec![key(1.0, 0.0), key(3.0, 4.0)]);
        let x = |time| path.camera(scene(), &bounds(), None, [0.0, 0.0, time]).position.x;
        assert_eq!([0.0, 1.0, 2.0, 3.0, 9.0].map(x), [0.0, 0.0, 2.0, 4.0, 4.0]);
    }
}
