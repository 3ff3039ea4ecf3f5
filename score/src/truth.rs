//! Ray-traced truth: the surface that each pixel shows, and its visibility from a light.
//!
//! | value | definition |
//! |---|---|
//! | hit | the ray through the middle of the pixel meets a surface between the camera's planes |
//! | lit | nothing that casts shadows stands between that point and the light; surfaces do not shade themselves by facing away |
//! | visible part | the part of a light with an extent that is visible from the point |
//! | evaluated | the pixel hits a surface that receives shadows, with nothing blended before it; the light reaches the pixel and its eight neighbours; the cosine between the visible side and the light is at least [`MIN_COSINE`] |
//! | edge | a neighbour of the hit pixel has the other answer, or its 4 by 4 samples disagree |
//! | contact | shadowed, and the caster that the light meets first is nearer than [`CONTACT`] times the distance from the camera |
//!
//! The visible part of a light takes 16 samples, or 256 if these disagree.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use umbragraph_pipeline::frame::{Camera, Light, Projection};

use crate::light::{Source, disc_sample};
use crate::rays::{Rays, Seen};

/// The minimum cosine between a surface's normal and the direction to the light for a pixel to count: renderers treat
/// grazing light differently.
pub const MIN_COSINE: f64 = 0.05;

/// The greatest distance between caster and receiver of a contact shadow, as a fraction of the receiver's distance from
/// the camera.
pub const CONTACT: f64 = 0.02;

/// The numbers of samples of a light with an extent: 16 decide whether a point is in penumbra, where 256 are taken.
const SAMPLES: [u32; 2] = [16, 256];

/// The number of samples along each side of a pixel to find shadow edges in the pixel.
const SIDE: u32 = 4;

/// The surface points that a camera sees, one for each pixel, and the rays to trace the visibility of lights.
pub struct Truth<'r> {
    pub(crate) rays: &'r Rays<'r>,
    pub(crate) camera: Camera,
    /// The width and height of the image, in pixels.
    pub size: [u32; 2],
    points: Vec<Option<Point>>,
}

/// The surface point that a pixel shows.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The position of the point, in world metres.
    pub position: DVec3,
    /// The distance from the camera along its view axis, in metres.
    pub depth: f64,
    /// The surface that was hit.
    pub seen: Seen,
}

/// The visibility of a light at each pixel; row 0 on top.
pub struct LightTruth {
    /// Whether the middle of the light is visible; also `true` for pixels without a surface.
    pub lit: Vec<bool>,
    /// The fraction of the light that is visible, 0 to 1; `None` for a light without an extent.
    pub visible: Option<Vec<f32>>,
    /// Whether the pixel counts towards the scores.
    pub evaluated: Vec<bool>,
    /// The distance to the nearest shadow edge, in pixels; 5 for all greater distances.
    pub edge: Vec<f32>,
    /// Whether the pixel is in a contact shadow: its caster is nearer than [`CONTACT`] times the distance from the
    /// camera.
    pub contact: Vec<bool>,
}

impl<'r> Truth<'r> {
    /// Traces a camera ray through the middle of each pixel of an image. `size` is its width and height in pixels.
    pub fn new(rays: &'r Rays<'r>, camera: &Camera, size: [u32; 2]) -> Self {
        let mut truth = Self { rays, camera: *camera, size, points: Vec::new() };
        let middles = |pixel: usize| truth.see(pixel, DVec2::splat(0.5));
        truth.points = (0..truth.pixels()).into_par_iter().map(middles).collect();
        truth
    }

    /// The surface point that each pixel shows, row 0 on top; `None` for a pixel without a surface.
    pub fn points(&self) -> &[Option<Point>] {
        &self.points
    }

    fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Traces the camera ray through a place in a pixel: `within` runs from 0 to 1, right and down. `None` if no
    /// surface is hit.
    fn see(&self, pixel: usize, within: DVec2) -> Option<Point> {
        let (near, far) = self.camera.projection.depth_range();
        let (origin, direction) = camera_ray(&self.camera, self.size, pixel, within);
        // Lengths of the direction are distances along the axis.
        let seen = self.rays.seen(origin, direction, [near, far])?;
        Some(Point { position: origin + direction * seen.distance, depth: seen.distance, seen })
    }

    /// The distance from the point, in metres, at which a ray towards a light begins: greater than the point's rounding
    /// error.
    fn begin(&self, point: &Point) -> f64 {
        let size = point.position.abs().max_element().max(point.depth.abs());
        size * 1e-9
    }

    fn is_lit(&self, point: &Point, source: &Source, sample: DVec2) -> bool {
        let (direction, distance) = source.ray(point.position, sample);
        !self.rays.is_blocked(point.seen.triangle, point.position, direction, [self.begin(point), distance])
    }

    /// Traces rays from the surface point of each pixel to a light; `None` for a light with invalid values.
    pub fn light(&self, light: &Light) -> Option<LightTruth> {
        self.light_by_rows(light, &|| {})
    }

    /// Traces rays as [`Self::light`] does. Calls `row` once for each row of the image when the most of its rays are
    /// traced, from any thread and in any order.
    pub fn light_by_rows(&self, light: &Light, row: &(dyn Fn() + Sync)) -> Option<LightTruth> {
        let source = Source::of(light)?;
        let is_lit = |point: &Option<Point>| {
            point.as_ref().is_none_or(|point| self.is_lit(point, &source, DVec2::ZERO))
        };
        let nothing = || {};
        // Samples of an extent take most of the time.
        let (of_lit, of_visible): (&(dyn Fn() + Sync), _) =
            if source.has_extent() { (&nothing, row) } else { (row, &nothing as &(dyn Fn() + Sync)) };
        let lit: Vec<bool> = self.by_rows(of_lit, is_lit);
        let visible = source.has_extent().then(|| self.visible(&source, of_visible));
        let contact = self.contact(&source, &lit);
        let evaluated = self.evaluated(&source);
        let edge = distances(&self.edges(&source, &lit), self.size);
        Some(LightTruth { lit, visible, evaluated, edge, contact })
    }

    /// Computes a value for the point of each pixel, and calls `row` after each row.
    fn by_rows<T: Send>(
        &self,
        row: &(dyn Fn() + Sync),
        value: impl Fn(&Option<Point>) -> T + Sync,
    ) -> Vec<T> {
        let values = |points: &[Option<Point>]| {
            let values: Vec<T> = points.par_iter().map(&value).collect();
            row();
            values
        };
        self.points.par_chunks((self.size[0] as usize).max(1)).flat_map(values).collect()
    }

    fn visible(&self, source: &Source, row: &(dyn Fn() + Sync)) -> Vec<f32> {
        let part = |point: &Point| {
            let count = |range: std::ops::Range<u32>| {
                range.filter(|index| self.is_lit(point, source, disc_sample(*index))).count() as u32
            };
            let few = count(0..SAMPLES[0]);
            if few == 0 || few == SAMPLES[0] {
                return few as f32 / SAMPLES[0] as f32;
            }
            (few + count(SAMPLES[0]..SAMPLES[1])) as f32 / SAMPLES[1] as f32
        };
        self.by_rows(row, |point| point.as_ref().map_or(1.0, part))
    }

    fn contact(&self, source: &Source, lit: &[bool]) -> Vec<bool> {
        let touches = |(point, lit): (&Option<Point>, &bool)| {
            let Some(point) = point.as_ref().filter(|_| !lit) else { return false };
            let (direction, distance) = source.ray(point.position, DVec2::ZERO);
            let range = [self.begin(point), distance];
            let first = self.rays.first_blocker(point.seen.triangle, point.position, direction, range);
            first.is_some_and(|first| first < CONTACT * point.position.distance(self.camera.position))
        };
        self.points.par_iter().zip(lit).map(touches).collect()
    }

    fn evaluated(&self, source: &Source) -> Vec<bool> {
        let reached = |pixel: usize| self.points[pixel].is_none_or(|point| source.reaches(point.position));
        let counts = |pixel: usize| {
            let Some(point) = self.points[pixel] else { return false };
            let (direction, _) = source.ray(point.position, DVec2::ZERO);
            point.seen.counts
                && point.seen.normal.dot(direction) >= MIN_COSINE
                && reached(pixel)
                && neighbours(pixel, self.size).all(reached)
        };
        (0..self.pixels()).into_par_iter().map(counts).collect()
    }

    fn edges(&self, source: &Source, lit: &[bool]) -> Vec<bool> {
        let is_edge = |pixel: usize| {
            if self.points[pixel].is_none() {
                return false;
            }
            let other = |near: usize| self.points[near].is_some() && lit[near] != lit[pixel];
            neighbours(pixel, self.size).any(other) || self.samples_disagree(pixel, source, lit[pixel])
        };
        (0..self.pixels()).into_par_iter().map(is_edge).collect()
    }

    fn samples_disagree(&self, pixel: usize, source: &Source, lit: bool) -> bool {
        (0..SIDE * SIDE).any(|at| {
            let place = (DVec2::new(f64::from(at % SIDE), f64::from(at / SIDE)) + 0.5) / f64::from(SIDE);
            self.see(pixel, place).is_some_and(|point| self.is_lit(&point, source, DVec2::ZERO) != lit)
        })
    }
}

/// The ray of a camera through a place in a pixel: `within` runs from 0 to 1, right and down. Lengths of the direction are
/// distances along the view axis.
pub(crate) fn camera_ray(camera: &Camera, size: [u32; 2], pixel: usize, within: DVec2) -> (DVec3, DVec3) {
    let width = size[0] as usize;
    let at = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + within;
    let size = DVec2::new(f64::from(size[0]), f64::from(size[1]));
    let place = (at / size * 2.0 - 1.0) * DVec2::new(camera.aspect, -1.0);
    let (origin, direction) = match camera.projection {
        Projection::Perspective { vertical_fov, .. } => {
            (DVec3::ZERO, (place * (0.5 * vertical_fov).tan()).extend(-1.0))
        }
        Projection::Orthographic { half_height, .. } => ((place * half_height).extend(0.0), DVec3::NEG_Z),
        projection @ Projection::Matrix { .. } => {
            let [low, right, up, _] = projection.corners(camera.aspect, 1.0);
            let part = DVec2::new(at.x / size.x, 1.0 - at.y / size.y);
            let across = low + (right - low) * part.x + (up - low) * part.y;
            if projection.is_orthographic() {
                (across.extend(0.0), DVec3::NEG_Z)
            } else {
                (DVec3::ZERO, across.extend(-1.0))
            }
        }
    };
    (camera.position + camera.rotation * origin, camera.rotation * direction)
}

/// The indices of the up to eight neighbours of a pixel inside the image.
fn neighbours(pixel: usize, [width, height]: [u32; 2]) -> impl Iterator<Item = usize> {
    let (width, height) = (i64::from(width), i64::from(height));
    let (x, y) = (pixel as i64 % width, pixel as i64 / width);
    (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy))).filter_map(move |(i, j)| {
        let inside = (0..width).contains(&i) && (0..height).contains(&j) && (i, j) != (x, y);
        inside.then_some((j * width + i) as usize)
    })
}

/// The maximum distance to an edge that is measured, in pixels.
const FARTHEST: i64 = 5;

/// The distance from each pixel to the nearest pixel that is set, in pixels and at most 5.
fn distances(set: &[bool], [width, height]: [u32; 2]) -> Vec<f32> {
    let (width, height) = (i64::from(width), i64::from(height));
    let nearest = |pixel: usize| {
        let (x, y) = (pixel as i64 % width, pixel as i64 / width);
        let mut nearest = FARTHEST * FARTHEST;
        for j in (y - FARTHEST).max(0)..(y + FARTHEST + 1).min(height) {
            for i in (x - FARTHEST).max(0)..(x + FARTHEST + 1).min(width) {
                if set[(j * width + i) as usize] {
                    nearest = nearest.min((i - x) * (i - x) + (j - y) * (j - y));
                }
            }
        }
        (nearest as f32).sqrt()
    };
    (0..set.len()).into_par_iter().map(nearest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_to_the_next_edge() {
        let mut set = vec![false; 12 * 8];
        set[3 * 12 + 4] = true;
        let found = distances(&set, [12, 8]);
        assert_eq!((found[3 * 12 + 4], found[3 * 12 + 6], found[0]), (0.0, 2.0, 5.0));
        assert!((found[5 * 12 + 5] - 5_f32.sqrt()).abs() < 1e-6);
        assert_eq!(found[7 * 12 + 11], 5.0, "far away");
    }

    #[test]
    fn a_corner_has_three_neighbours() {
        assert_eq!(neighbours(0, [3, 3]).collect::<Vec<_>>(), [1, 3, 4]);
        assert_eq!(neighbours(4, [3, 3]).count(), 8);
        assert_eq!(neighbours(0, [1, 1]).count(), 0);
    }
}
