//! The near and far planes of a cascade's light view.
//!
//! The far plane stands at the end of the slice: nothing behind it is looked up. The near plane has to take in every
//! caster between the slice and the light, also those that the camera does not see. It goes to the highest point of the
//! casters' bounds *above the cascade's rectangle*, so that a mountain elsewhere does not stretch the depth range, on
//! which the worth of a bias in clip depth hangs.
//!
//! The six faces of the bounds are clipped with the four sides of the rectangle (Sutherland and Hodgman) to find that
//! point: in light space, a convex body's highest point above a rectangle lies on one of its faces.
//!
//! Both planes are moved outwards to multiples of the texel's size, so that the matrices stay bit-identical until the
//! rectangle moves.
//!
//! Limits: the near plane stands at most [`LONGEST_REACH`] beyond the slice, so that one object with broken bounds does
//! not leave all others without depth.

use glam::{DMat3, DVec2, DVec3};
use umbragraph_pipeline::frame::Bounds;

use super::snap::Rectangle;

/// The maximum distance by which casters or settings move a plane away from the slice, in metres. 32-bit depth still
/// resolves centimetres at this distance.
pub const LONGEST_REACH: f64 = 1e5;

/// The largest absolute coordinate of casters, in metres; greater ones are reduced to it, so that clipping stays exact.
/// 32 bits do not tell a house from its neighbour there.
const MAX_WORLD: f64 = 1e9;

/// The rule for the position of a cascade's near plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum NearPull {
    /// The near plane lies at the highest point of the casters' bounds above the cascade.
    #[default]
    Casters,
    /// The near plane lies this many metres from the slice towards the light.
    Metres(f64),
    /// Near and far plane lie at the scene's bounds, wherever the slice is: depth stays the same while the camera
    /// moves.
    Scene,
}

/// The four corners of each face of a box, as indices in [`Bounds::corners`].
const FACES: [[usize; 4]; 6] =
    [[0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 5, 4], [2, 3, 7, 6], [0, 1, 3, 2], [4, 5, 7, 6]];

/// The near and far plane of a cascade as light-space z in metres; near is greater, since z grows towards the light.
/// `slice` has the greatest and the smallest z of the slice; `light` is the rotation from world to light space.
pub fn planes(
    slice: (f64, f64),
    rectangle: &Rectangle,
    casters: &Bounds,
    light: &DMat3,
    (pull, far_extension): (NearPull, f64),
) -> (f64, f64) {
    let (slice_near, slice_far) = slice;
    let near = match pull {
        NearPull::Casters => {
            let highest = highest(casters, light, rectangle).unwrap_or(slice_near);
            highest.max(slice_near).min(slice_near + LONGEST_REACH)
        }
        NearPull::Metres(metres) => slice_near + metres,
        NearPull::Scene => slice_near,
    };
    let step = rectangle.texel.max_element();
    // One step more, so that what lies on a plane, or is moved off its surface by a bias, stays inside.
    (((near / step).ceil() + 1.0) * step, (((slice_far - far_extension) / step).floor() - 1.0) * step)
}

/// The largest light-space z, in metres, of the part of a box that lies above or below a rectangle; `None` if there is
/// no such part. `light` is the rotation from world to light space.
pub fn highest(bounds: &Bounds, light: &DMat3, rectangle: &Rectangle) -> Option<f64> {
    if bounds.is_empty() {
        return None;
    }
    let within = |corner: DVec3| corner.clamp(DVec3::splat(-MAX_WORLD), DVec3::splat(MAX_WORLD));
    let bounds = Bounds { min: within(bounds.min), max: within(bounds.max) };
    let corners = bounds.corners().map(|corner| *light * corner);
    let (low, high) = (rectangle.min - rectangle.texel, rectangle.min + rectangle.size + rectangle.texel);
    FACES
        .into_iter()
        .flat_map(|face| Polygon::quad(face.map(|at| corners[at])).clipped(low, high).z_values())
        .max_by(f64::total_cmp)
}

/// A convex polygon in light space. A quad that is clipped at four lines has at most eight points; rounding may add a
/// few more.
#[derive(Clone, Copy)]
struct Polygon {
    points: [DVec3; 16],
    count: usize,
}

impl Polygon {
    fn quad(corners: [DVec3; 4]) -> Self {
        let mut points = [DVec3::ZERO; 16];
        points[..4].copy_from_slice(&corners);
        Self { points, count: 4 }
    }

    fn clipped(self, low: DVec2, high: DVec2) -> Self {
        self.cut(|point| point.x - low.x)
            .cut(|point| high.x - point.x)
            .cut(|point| point.y - low.y)
            .cut(|point| high.y - point.y)
    }

    /// The part of the polygon in which `distance` is not negative.
    fn cut(self, distance: impl Fn(DVec3) -> f64) -> Self {
        let mut cut = Self { count: 0, ..self };
        for at in 0..self.count {
            let (from, to) = (self.points[at], self.points[(at + 1) % self.count]);
            let (before, after) = (distance(from), distance(to));
            if before >= 0.0 {
                cut.push(from);
            }
            if (before >= 0.0) != (after >= 0.0) {
                cut.push(from + (to - from) * (before / (before - after)));
            }
        }
        cut
    }

    fn push(&mut self, point: DVec3) {
        if let Some(free) = self.points.get_mut(self.count) {
            *free = point;
            self.count += 1;
        }
    }

    fn z_values(self) -> impl Iterator<Item = f64> {
        self.points.into_iter().take(self.count).map(|point| point.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(min: DVec2, size: f64) -> Rectangle {
        Rectangle { min, texel: DVec2::splat(size / 1000.0), size: DVec2::splat(size) }
    }

    fn tilted() -> DMat3 {
        super::super::light::from_world(DVec3::new(0.6, -0.7, 0.2).normalize(), DVec3::Y)
    }

    #[test]
    fn the_highest_point_is_that_of_a_fine_grid_of_points() {
        let bounds = Bounds { min: DVec3::new(-40.0, -1.0, -70.0), max: DVec3::new(60.0, 25.0, 30.0) };
        for (x, y, size) in [(-5.0, -5.0, 10.0), (20.0, 3.0, 8.0), (-60.0, -60.0, 130.0), (-50.0, 0.0, 30.0)]
        {
            let rectangle = rectangle(DVec2::new(x, y), size);
            let steps = 60;
            let mut sampled = f64::NEG_INFINITY;
            for index in 0..(steps + 1) * (steps + 1) * (steps + 1) {
                let part = DVec3::new(
                    f64::from(index % (steps + 1)),
                    f64::from(index / (steps + 1) % (steps + 1)),
                    f64::from(index / (steps + 1) / (steps + 1)),
                ) / f64::from(steps);
                let point = tilted() * (bounds.min + (bounds.max - bounds.min) * part);
                let inside = point.truncate() - rectangle.min;
                if inside.min_element() >= 0.0 && inside.max_element() <= size {
                    sampled = sampled.max(point.z);
                }
            }
            let found = highest(&bounds, &tilted(), &rectangle).unwrap();
            assert!(sampled <= found && found < sampled + 4.0, "{found} {sampled}");
        }
    }

    #[test]
    fn casters_beside_the_rectangle_do_not_stretch_the_depth_range() {
        let bounds = Bounds { min: DVec3::splat(500.0), max: DVec3::splat(900.0) };
        let far_away = rectangle(DVec2::new(-5.0, -5.0), 10.0);
        assert_eq!(highest(&bounds, &tilted(), &far_away), None);
        assert_eq!(highest(&Bounds::EMPTY, &tilted(), &far_away), None);
        let (near, far) = planes((3.0, -3.0), &far_away, &bounds, &tilted(), (NearPull::Casters, 0.0));
        assert!((3.0..3.1).contains(&near) && (-3.1..=-3.0).contains(&far), "{near} {far}");
    }

    #[test]
    fn casters_within_a_texel_of_the_rectangle_count() {
        // Of 10 m, with texels of 1 cm.
        let rectangle = rectangle(DVec2::ZERO, 10.0);
        for (off, highest_there) in [(0.005, Some(7.0)), (0.02, None)] {
            for (min, max) in [
                ((10.0 + off, 2.0), (30.0, 3.0)),
                ((-30.0, 2.0), (-off, 3.0)),
                ((2.0, 10.0 + off), (3.0, 30.0)),
                ((2.0, -30.0), (3.0, -off)),
            ] {
                let bounds = Bounds { min: DVec2::from(min).extend(-1.0), max: DVec2::from(max).extend(7.0) };
                assert_eq!(highest(&bounds, &DMat3::IDENTITY, &rectangle), highest_there, "{bounds:?}");
            }
        }
    }

    #[test]
    fn the_planes_move_by_the_metres_that_are_asked_for() {
        let rectangle = rectangle(DVec2::ZERO, 10.0);
        let (near, far) =
            planes((3.0, -3.0), &rectangle, &Bounds::EMPTY, &tilted(), (NearPull::Metres(100.0), 50.0));
        assert!((103.0..103.1).contains(&near) && (-53.1..-53.0).contains(&far), "{near} {far}");
    }

    #[test]
    fn immense_bounds_pull_the_near_plane_as_far_as_it_goes() {
        let rectangle = rectangle(DVec2::splat(-5.0), 10.0);
        for size in [1e7, 1e20, 1e300, f64::MAX] {
            let bounds = Bounds { min: DVec3::splat(-size), max: DVec3::splat(size) };
            for light in [tilted(), DMat3::IDENTITY] {
                let (near, far) = planes((3.0, -3.0), &rectangle, &bounds, &light, (NearPull::Casters, 0.0));
                assert!(
                    (near - LONGEST_REACH - 3.0).abs() < 0.1 && (-3.1..=-3.0).contains(&far),
                    "{size} {near}"
                );
            }
        }
    }
}
