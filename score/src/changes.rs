//! Temporal stability: the share of a shadow term that changes although the truth does not (swimming shadows).
//!
//! A point that two consecutive frames show is projected with the earlier camera. Its later value is compared with the
//! 4 by 4 pixels around it in the earlier frame. These must be equal within [`TOLERANCE`], so that the point is at
//! least a pixel away from any edge. The point has changed if its value differs from theirs by more than that.
//!
//! A point counts if rays give the same answer for it and for the four nearest pixels, which holds wherever only the
//! camera moves. These pixels must also show its own surface: it lies in the parallelogram of their positions.
//! Silhouettes, points that were hidden or outside the earlier frame, and surfaces at the most grazing angles do not
//! count.
//!
//! Limits: motion below a pixel is not found; details smaller than a pixel may lie between pixels and count as changed.

use glam::{DMat4, DVec2, DVec3};
use serde::Serialize;
use serde::ser::SerializeMap;

use crate::scores::{Rendered, ratio};
use crate::truth::{LightTruth, Truth};

/// The largest difference between two shadow-term values (0 to 1) that still counts as equal.
pub const TOLERANCE: f64 = 0.02;

/// The maximum distance of a position from the surface of the four nearest pixels, as a fraction of the distance
/// between neighbouring pixels.
const FLATNESS: f64 = 0.1;

/// The pixels of one light's shadow term in one frame that count towards temporal stability; row 0 on top.
#[derive(Clone, Debug)]
pub struct Seen {
    size: [u32; 2],
    clip_from_world: DMat4,
    pixels: Vec<Option<Pixel>>,
}

#[derive(Clone, Copy, Debug)]
struct Pixel {
    position: DVec3,
    value: f64,
    is_lit: bool,
}

/// The number of points that two consecutive frames show, and the number of them whose shadow term has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// The number of points that are compared.
    pub points: u64,
    /// The number of compared points whose shadow term has changed by more than [`TOLERANCE`].
    pub changed: u64,
}

impl Changes {
    /// The fraction of the compared points that has changed, 0 to 1; `None` if no point was compared.
    pub fn share(&self) -> Option<f64> {
        ratio(self.changed, self.points)
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.points += other.points;
        self.changed += other.changed;
    }
}

impl Serialize for Changes {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("points", &self.points)?;
        map.serialize_entry("changed", &self.changed)?;
        map.serialize_entry("share", &self.share())?;
        map.end()
    }
}

impl Seen {
    /// Collects the pixels of a rendered shadow term that count for a light. They are evaluated in the ray-traced
    /// truth, and the picture shows geometry there (alpha of at least 128).
    pub fn new(truth: &Truth<'_>, light: &LightTruth, picture: Rendered<'_>) -> Self {
        let pixel = |(at, point): (usize, &Option<crate::truth::Point>)| {
            let position = point.as_ref().filter(|_| light.evaluated[at] && picture.hits(at))?.position;
            Some(Pixel { position, value: picture.part(at), is_lit: light.lit[at] })
        };
        Self {
            size: truth.size,
            clip_from_world: truth.camera.clip(true) * truth.camera.view(),
            pixels: truth.points().iter().enumerate().map(pixel).collect(),
        }
    }

    /// Counts the points of this frame that the frame `before` shows too, and those of them whose shadow term has
    /// changed.
    pub fn changes_since(&self, before: &Self) -> Changes {
        let mut changes = Changes::default();
        for pixel in self.pixels.iter().flatten() {
            let Some([lowest, highest]) = before.around(pixel) else { continue };
            if highest - lowest <= TOLERANCE {
                changes.points += 1;
                let is_same = (highest - TOLERANCE..=lowest + TOLERANCE).contains(&pixel.value);
                changes.changed += u64::from(!is_same);
            }
        }
        changes
    }

    /// The lowest and highest value of the 4 by 4 pixels around the projection of `point`. `None` if the point lies
    /// outside the frame or the four nearest pixels do not show its surface.
    fn around(&self, point: &Pixel) -> Option<[f64; 2]> {
        let clip = self.clip_from_world * point.position.extend(1.0);
        if clip.w <= 0.0 {
            return None;
        }
        let part = DVec2::new(0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
        let [width, height] = self.size;
        let place = part * DVec2::new(f64::from(width), f64::from(height)) - 0.5;
        let last = DVec2::new(f64::from(width), f64::from(height)) - 2.0;
        if !(place.cmpge(DVec2::ONE).all() && place.cmplt(last).all()) {
            return None;
        }
        let corner = place.floor();
        let (first, row) = ((corner.y as usize - 1) * width as usize + corner.x as usize - 1, width as usize);
        let at = |right: usize, down: usize| {
            let pixel = self.pixels.get(first + row + 1 + down * row + right).copied().flatten();
            pixel.filter(|pixel| pixel.is_lit == point.is_lit).map(|pixel| pixel.position)
        };
        let [a, b, c, d] = [at(0, 0)?, at(1, 0)?, at(0, 1)?, at(1, 1)?];
        let inside = place - corner;
        let found = a.lerp(b, inside.x).lerp(c.lerp(d, inside.x), inside.y);
        let least = FLATNESS * a.distance(b).min(a.distance(c));
        let is_flat = (a + d).distance(b + c) <= least && found.distance(point.position) <= least;
        if !is_flat {
            return None;
        }
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for pixels in (0..4).map(|down| self.pixels.get(first + down * row..first + down * row + 4)) {
            for pixel in pixels?.iter().flatten() {
                range = [range[0].min(pixel.value), range[1].max(pixel.value)];
            }
        }
        Some(range)
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use umbragraph_pipeline::frame::{Camera, Projection};

    use super::*;

    const SIZE: [u32; 2] = [64, 48];

    /// The floor and a wall at its end, as far as the camera sees them, with `value` at each point; all points are lit.
    fn seen(position: DVec3, turned: f64, value: impl Fn(DVec3) -> f64) -> Seen {
        let projection = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
        let rotation = DQuat::from_rotation_y(turned) * DQuat::from_rotation_x(-0.4);
        let camera = Camera::new(position, rotation, projection, 4.0 / 3.0);
        let clip_from_world = camera.clip(true) * camera.view();
        let world = clip_from_world.inverse();
        let pixel = |at: u32| {
            let [x, y] = [at % SIZE[0], at / SIZE[0]];
            let part = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / DVec2::new(64.0, 48.0);
            let clip = DVec3::new(2.0 * part.x - 1.0, 1.0 - 2.0 * part.y, 1.0);
            let ray = world.project_point3(clip) - position;
            let floor = if ray.y < 0.0 { -position.y / ray.y } else { f64::INFINITY };
            let wall = if ray.z < 0.0 { (-6.0 - position.z) / ray.z } else { f64::INFINITY };
            let position = position + ray * floor.min(wall);
            position.is_finite().then(|| Pixel { position, value: value(position), is_lit: true })
        };
        Seen { size: SIZE, clip_from_world, pixels: (0..SIZE[0] * SIZE[1]).map(pixel).collect() }
    }

    /// A checkerboard of light and dark squares with a side of 1 m, moved by `off` metres along x.
    fn squares(off: f64) -> impl Fn(DVec3) -> f64 {
        move |point| {
            let row = (point.x + off).floor() + (point.y + point.z).floor();
            if row.rem_euclid(2.0) < 0.5 { 1.0 } else { 0.0 }
        }
    }

    const START: DVec3 = DVec3::new(0.0, 2.0, 0.0);

    #[test]
    fn shadows_fixed_in_the_world_count_no_change_from_any_view() {
        let before = seen(START, 0.0, squares(0.0));
        for (step, turned) in [(0.0, 0.0), (0.03, 0.0), (0.4, 0.0), (0.0, 0.01), (0.1, -0.2)] {
            let after = seen(DVec3::new(step, 2.0, 0.5 * step), turned, squares(0.0));
            let changes = after.changes_since(&before);
            assert!(changes.points > 600, "{changes:?}");
            assert!(changes.share().unwrap() < 0.005, "{step} {turned}: {changes:?}");
        }
    }

    #[test]
    fn what_moves_on_the_world_has_changed_by_its_share() {
        let before = seen(START, 0.0, squares(0.0));
        let share = |off: f64| {
            let after = seen(DVec3::new(0.02, 2.0, 0.01), 0.01, squares(off));
            after.changes_since(&before).share().unwrap()
        };
        // Squares that are dark where light ones were have all changed.
        assert!((0.15..0.3).contains(&share(0.3)), "{}", share(0.3));
        assert!(share(1.0) == 1.0, "{}", share(1.0));
    }

    #[test]
    fn hidden_outside_and_truly_changed_pixels_do_not_count() {
        let (lit, dark) = (|_: DVec3| 1.0, |_: DVec3| 0.0);
        let before = seen(START, 0.0, lit);
        let behind = seen(START, std::f64::consts::PI, dark);
        assert_eq!(behind.changes_since(&before), Changes::default());
        let after = seen(START, 0.0, dark);
        assert_eq!(after.changes_since(&before).share(), Some(1.0));
        let mut nearer = after.clone();
        nearer.pixels.iter_mut().flatten().for_each(|pixel| pixel.position = pixel.position.lerp(START, 0.1));
        assert_eq!(nearer.changes_since(&before).share(), None);
        let mut shadowed = after;
        shadowed.pixels.iter_mut().flatten().for_each(|pixel| pixel.is_lit = false);
        assert_eq!(shadowed.changes_since(&before).share(), None, "a shadow that has moved on");
    }
}
