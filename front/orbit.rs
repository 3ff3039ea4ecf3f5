//! Orbits of a camera among the obstacles of a scene.

use super::camera_path::{Key, Obstacles};
use crate::frame::Camera;
use crate::glam::{DQuat, DVec3};

/// A circle of the camera that stays before the obstacles of a scene.
#[derive(Clone, Copy)]
pub(crate) struct Orbit<'o> {
    around: &'o dyn Obstacles,
    pivot: DVec3,
    /// The vector from the pivot to the camera without obstacles.
    offset: DVec3,
    /// The fraction of `offset` from which on obstacles count: before it is what the camera goes around.
    core: f64,
}

impl<'o> Orbit<'o> {
    /// The number of directions in which obstacles are looked for.
    const DIRECTIONS: u32 = 48;
    /// The fraction of the distance within which what the camera goes around lies.
    const CORE: f64 = 0.3;

    /// Returns an orbit that stays before obstacles: around what the camera looks at, or around a point halfway to it.
    /// If nothing is ahead within two radii of the scene, that point is one radius ahead. `None` if there are no
    /// obstacles on the circle around the middle of the scene, or the camera cannot move ahead.
    pub(crate) fn among(
        around: &'o dyn Obstacles,
        scene: &Camera,
        middle: DVec3,
        radius: f64,
    ) -> Option<Self> {
        let usual = Self { around, pivot: middle, offset: scene.position - middle, core: 1.0 };
        let ahead = scene.rotation * DVec3::NEG_Z;
        let reach = around.free(scene.position, ahead, 2.0 * radius);
        if usual.is_clear() || reach <= 0.0 {
            return None;
        }
        let whole =
            Self { pivot: scene.position + ahead * reach, offset: -ahead * reach, core: Self::CORE, ..usual };
        if reach < 2.0 * radius && whole.is_clear() {
            return Some(whole);
        }
        let half = 0.5 * reach;
        Some(Self { pivot: scene.position + ahead * half, offset: -ahead * half, core: 0.0, ..whole })
    }

    fn turns() -> impl Iterator<Item = DQuat> {
        let step = std::f64::consts::TAU / f64::from(Self::DIRECTIONS);
        (0..=Self::DIRECTIONS).map(move |at| DQuat::from_rotation_y(step * f64::from(at)))
    }

    /// Returns `true` if nothing stands on the circle around the core.
    fn is_clear(&self) -> bool {
        let places: Vec<DVec3> =
            Self::turns().map(|turn| self.pivot + turn * self.offset * self.core).collect();
        places.windows(2).all(|pair| {
            let (way, length) = (pair[1] - pair[0], pair[0].distance(pair[1]));
            length == 0.0 || self.around.free(pair[0], way / length, length) >= length
        })
    }

    /// Returns the free fraction of the offset in a direction.
    fn free(&self, turn: DQuat) -> f64 {
        let offset = turn * self.offset;
        let (begin, length) = (self.pivot + offset * self.core, offset.length());
        self.core + self.around.free(begin, offset / length, length * (1.0 - self.core)) / length
    }

    /// Returns the camera at one turn. The circle is the largest that is free; only if that is small, the camera goes
    /// as far out in each direction as it can.
    pub(crate) fn camera(&self, scene: Camera, turn: DQuat) -> Camera {
        let smallest = Self::turns().map(|turn| self.free(turn)).fold(1.0, f64::min);
        let part = if smallest >= Self::CORE { smallest } else { self.free(turn).max(0.1) };
        let position = self.pivot + turn * self.offset * part;
        let key = Key { time: 0.0, position: position.into(), target: self.pivot.into() };
        let rotation = key.rotation().unwrap_or((turn * scene.rotation).normalize());
        scene.position(position).rotation(rotation)
    }
}

#[cfg(test)]
mod tests {
    use crate::frame::Projection;

    use super::*;

    /// A wall at x = 2 that is seen from both sides.
    struct Wall;

    impl Obstacles for Wall {
        fn free(&self, from: DVec3, direction: DVec3, distance: f64) -> f64 {
            let along = (2.0 - from.x) / direction.x;
            if along.is_finite() && along >= 0.0 { along.min(distance) } else { distance }
        }
    }

    #[test]
    fn an_orbit_with_nothing_ahead_stays_before_a_wall() {
        let projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
        let scene = Camera::new(DVec3::new(0.0, 0.0, 5.0), DQuat::IDENTITY, projection, 1.0);
        // The circle around the middle passes through the wall, and the camera looks along it.
        let orbit = Orbit::among(&Wall, &scene, DVec3::ZERO, 3.0).unwrap();
        for turn in Orbit::turns() {
            let camera = orbit.camera(scene, turn);
            assert!(camera.position.x <= 2.0 + 1e-9, "{}", camera.position);
            let ahead = (DVec3::new(0.0, 0.0, 2.0) - camera.position).normalize();
            assert!((camera.rotation * DVec3::NEG_Z).abs_diff_eq(ahead, 1e-9));
        }
    }
}
