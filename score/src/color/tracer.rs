//! The radiance of each pixel, by tracing paths from the camera (J. Kajiya, "The rendering equation", 1986).
//!
//! At each surface point light comes from three sources: emission, the lights of the scene with shadow rays to their
//! extents, and the sky. The sky takes one sample by its own brightness and one by the reflection, weighted by the
//! balance heuristic (E. Veach and L. Guibas, 1995). The second one goes on as a path while bounces are left.
//!
//! Blended surfaces before the first opaque one are composited by their alpha; further on a path passes each with the
//! probability of what it does not cover.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use umbragraph_pipeline::frame::Camera;

use super::lamp::Lamp;
use super::sequence::Sequence;
use super::sky::Sky;
use super::surface::{Footprint, Point, Surfaces};
use crate::rays::Rays;
use crate::triangles::Hit;
use crate::truth::camera_ray;

/// The light of the sky at surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ambient {
    /// Other surfaces stand in its way.
    #[default]
    Occluded,
    /// It arrives everywhere, times the occlusion map: what a pipeline computes without ambient occlusion.
    Open,
}

/// The part of a pixel that camera rays cover.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelArea {
    /// The middle alone, as rasterization with one sample.
    #[default]
    Middle,
    /// All of it, evenly: the mean over the pixel.
    Whole,
}

/// Settings of the tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The number of paths for each pixel, at least 1. Powers of two are distributed best.
    pub samples: u32,
    /// The number of surfaces after the first one from which light is reflected on to the camera.
    pub bounces: u32,
    /// The seed: the same one gives the same picture.
    pub seed: u64,
    /// The light of the sky at surfaces.
    pub ambient: Ambient,
    /// The part of a pixel that camera rays cover.
    pub area: PixelArea,
}

/// A traced picture; row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Traced {
    /// Linear radiance of each pixel.
    pub radiance: Vec<DVec3>,
    /// The difference between the mean of every second sample and that of the others, halved: an estimate of the noise.
    pub noise: Vec<DVec3>,
    /// Whether the ray through the pixel's middle meets a surface.
    pub hit: Vec<bool>,
}

/// A scene in a pose with its lights and its sky, to be traced.
pub struct ColorTracer<'r> {
    rays: &'r Rays<'r>,
    surfaces: Surfaces<'r>,
    sky: &'r Sky,
    lamps: Vec<Lamp>,
    settings: Settings,
}

/// A surface on a ray, and the part of the light that comes from it.
#[derive(Clone, Copy)]
struct Layer {
    triangle: u32,
    hit: Hit,
    weight: f64,
}

/// A ray with the sides of surfaces that it meets.
#[derive(Clone, Copy)]
struct Ray {
    origin: DVec3,
    direction: DVec3,
    range: [f64; 2],
    /// The triangle at which the ray begins; `None` for one of the camera, which sees no backs of single-sided surfaces.
    from: Option<u32>,
}

impl<'r> ColorTracer<'r> {
    /// Prepares a scene. `surfaces` are of the same scene and pose as `rays`.
    pub fn new(
        rays: &'r Rays<'r>,
        surfaces: Surfaces<'r>,
        sky: &'r Sky,
        lamps: Vec<Lamp>,
        settings: Settings,
    ) -> Self {
        Self { rays, surfaces, sky, lamps, settings }
    }

    /// Traces a picture of `size` pixels. Calls `row` once for each row, from any thread and in any order.
    pub fn picture(&self, camera: &Camera, size: [u32; 2], row: &(dyn Fn() + Sync)) -> Traced {
        let width = size[0] as usize;
        let pixels: Vec<([DVec3; 2], bool)> = (0..size[1] as usize)
            .into_par_iter()
            .flat_map_iter(|y| {
                let pixels: Vec<_> = (0..width).map(|x| self.pixel(camera, size, y * width + x)).collect();
                row();
                pixels
            })
            .collect();
        Traced {
            radiance: pixels.iter().map(|([one, other], _)| (*one + *other) * 0.5).collect(),
            noise: pixels.iter().map(|([one, other], _)| (*one - *other) * 0.5).collect(),
            hit: pixels.iter().map(|(_, hit)| *hit).collect(),
        }
    }

    /// The means of every second sample of a pixel, and whether its middle meets a surface.
    fn pixel(&self, camera: &Camera, size: [u32; 2], pixel: usize) -> ([DVec3; 2], bool) {
        let middle = self.seen(camera, size, pixel, DVec2::splat(0.5));
        let is_whole = self.settings.area == PixelArea::Whole;
        let (mut sums, mut counts) = ([DVec3::ZERO; 2], [0.0; 2]);
        for index in 0..self.settings.samples.max(1) {
            let mut sequence = Sequence::new(self.settings.seed, pixel, index);
            let within = sequence.pair();
            let other = is_whole.then(|| self.seen(camera, size, pixel, within));
            let radiance = self.radiance(other.as_ref().unwrap_or(&middle), &mut sequence);
            let half = index as usize % 2;
            sums[half] += if radiance.is_finite() { radiance } else { DVec3::ZERO };
            counts[half] += 1.0;
        }
        let means = if counts[1] == 0.0 { [sums[0]; 2] } else { [sums[0] / counts[0], sums[1] / counts[1]] };
        (means, !middle.layers.is_empty())
    }

    /// The surfaces that a camera ray meets through a place in a pixel.
    fn seen(&self, camera: &Camera, size: [u32; 2], pixel: usize, within: DVec2) -> Seen {
        let ray = |within: DVec2| camera_ray(camera, size, pixel, within);
        let (origin, direction) = ray(within);
        let (near, far) = camera.projection.depth_range();
        let toward = direction.normalize();
        let neighbours = [DVec2::X, DVec2::Y].map(|step| ray(within + step));
        let footprint = |triangle: u32, hit: Hit| -> Option<Footprint> {
            let triangle = self.rays.triangle(triangle);
            let (normal, place) = (triangle.normal(), origin + direction * hit.distance);
            let offsets = neighbours.map(|(origin, direction)| {
                let distance = (place - origin).dot(normal) / direction.dot(normal);
                origin + direction * distance - place
            });
            offsets.iter().all(|offset| offset.is_finite()).then_some(offsets)
        };
        let layers = self.layers(Ray { origin, direction, range: [near, far], from: None }, &footprint);
        let layers = layers.into_iter().map(|layer| (layer, footprint(layer.triangle, layer.hit))).collect();
        Seen { toward, layers }
    }

    /// The surfaces on a ray up to the first that covers all, with the part of light that comes from each.
    fn layers(&self, ray: Ray, footprint: &dyn Fn(u32, Hit) -> Option<Footprint>) -> Vec<Layer> {
        let [begin, mut end] = ray.range;
        let (mut last, mut blended) = (None, Vec::new());
        self.rays.each(ray.origin, ray.direction, end, &mut |index, triangle, surface, hit| {
            let is_met = hit.distance >= begin && hit.distance < end && ray.from != Some(index);
            let is_visible =
                ray.from.is_some() || surface.is_double_sided || surface.is_front(triangle, ray.direction);
            if is_met && is_visible && self.rays.is_there(triangle, surface, hit) {
                if surface.is_blended {
                    blended.push((index, hit));
                } else {
                    end = hit.distance;
                    last = Some((index, hit));
                }
            }
            Some(end)
        });
        blended.retain(|(_, hit)| hit.distance < end);
        blended.sort_by(|(_, one), (_, other)| one.distance.total_cmp(&other.distance));
        let mut left = 1.0;
        let mut layers = Vec::with_capacity(blended.len() + 1);
        for (triangle, hit) in blended {
            let covered = self.surfaces.coverage(self.rays.triangle(triangle), hit, footprint(triangle, hit));
            layers.push(Layer { triangle, hit, weight: left * covered });
            left *= 1.0 - covered;
        }
        layers.extend(last.map(|(triangle, hit)| Layer { triangle, hit, weight: left }));
        layers
    }

    /// The radiance of one sample toward the camera.
    fn radiance(&self, seen: &Seen, sequence: &mut Sequence) -> DVec3 {
        let (mut sum, mut left) = (DVec3::ZERO, 1.0);
        for (layer, footprint) in &seen.layers {
            sum += self.path(layer, seen.toward, *footprint, *sequence) * layer.weight;
            left -= layer.weight;
        }
        if left > 1e-9 { sum + self.sky.seen(seen.toward) * left } else { sum }
    }

    /// The radiance that comes from a surface against the direction `toward`.
    fn path(
        &self,
        first: &Layer,
        mut toward: DVec3,
        mut footprint: Option<Footprint>,
        mut sequence: Sequence,
    ) -> DVec3 {
        let (mut sum, mut throughput, mut layer) = (DVec3::ZERO, DVec3::ONE, *first);
        for bounce in 0..=self.settings.bounces {
            let triangle = self.rays.triangle(layer.triangle);
            let surface = &self.rays.surfaces[triangle.draw as usize];
            let is_front = surface.is_front(triangle, toward);
            let Some(point) = self.surfaces.point(triangle, is_front, layer.hit, toward, footprint.take())
            else {
                break;
            };
            sum += throughput * point.emission;
            let Some(brdf) = point.brdf else { break };
            sum += throughput * self.of_lamps(&point, layer.triangle, surface.receives, &mut sequence);
            let (direction, density) = self.sky.sample(sequence.pair());
            let at = sequence.pair();
            let choice = sequence.pair().x;
            let local = point.to_local(direction);
            let value = brdf.value(local);
            if value != DVec3::ZERO {
                let weight = 1.0 / (density + brdf.density(local));
                let arrives = self.sky_arriving(&point, layer.triangle, direction);
                sum += throughput * value * self.sky.light(direction) * (weight * arrives);
            }
            let Some(sampled) = brdf.sample(at) else { break };
            let direction = point.to_world(sampled.light);
            throughput *= sampled.weight;
            let weight = sampled.density / (sampled.density + self.sky.density(direction));
            if self.settings.ambient == Ambient::Open {
                sum += throughput * self.sky.light(direction) * (weight * point.occlusion);
                break;
            }
            // What a bent normal reflects from behind the plane of its triangle is the inside.
            if point.plane.dot(direction) <= 0.0 {
                break;
            }
            match self.next(&point, layer.triangle, direction, choice) {
                Some(next) if bounce < self.settings.bounces => (layer, toward) = (next, direction),
                Some(_) => break,
                None => {
                    sum += throughput * self.sky.light(direction) * weight;
                    break;
                }
            }
        }
        sum
    }

    /// Light of the lamps that a point reflects.
    fn of_lamps(&self, point: &Point, triangle: u32, receives: bool, sequence: &mut Sequence) -> DVec3 {
        let Some(brdf) = point.brdf else { return DVec3::ZERO };
        let mut sum = DVec3::ZERO;
        for lamp in &self.lamps {
            let arriving = lamp.arriving(point.position, sequence.pair());
            let value = brdf.value(point.to_local(arriving.direction));
            if value == DVec3::ZERO || arriving.illuminance == DVec3::ZERO {
                continue;
            }
            let range = [begin(point.position), arriving.distance];
            let is_lit = !lamp.casts
                || !receives
                || !self.rays.is_blocked(triangle, point.position, arriving.direction, range);
            if is_lit {
                sum += value * arriving.illuminance;
            }
        }
        sum
    }

    /// The part of the sky's light from a direction that arrives at a point.
    fn sky_arriving(&self, point: &Point, triangle: u32, direction: DVec3) -> f64 {
        if self.settings.ambient == Ambient::Open {
            return point.occlusion;
        }
        if point.plane.dot(direction) <= 0.0 {
            return 0.0;
        }
        1.0 - self
            .layers_from(point, triangle, direction)
            .iter()
            .map(|layer| layer.weight)
            .sum::<f64>()
            .min(1.0)
    }

    /// The surface that a path meets in a direction, chosen among those on its way; `None` for the sky.
    fn next(&self, point: &Point, triangle: u32, direction: DVec3, choice: f64) -> Option<Layer> {
        let mut passed = 0.0;
        self.layers_from(point, triangle, direction).into_iter().find(|layer| {
            passed += layer.weight;
            choice < passed
        })
    }

    fn layers_from(&self, point: &Point, triangle: u32, direction: DVec3) -> Vec<Layer> {
        let range = [begin(point.position), f64::INFINITY];
        self.layers(Ray { origin: point.position, direction, range, from: Some(triangle) }, &|_, _| None)
    }
}

/// The surfaces on a camera ray, and how large a pixel is on each.
struct Seen {
    /// The unit direction of the ray.
    toward: DVec3,
    layers: Vec<(Layer, Option<Footprint>)>,
}

/// The distance in metres at which a ray from a surface begins, beyond the rounding error of its origin.
fn begin(position: DVec3) -> f64 {
    position.abs().max_element() * 1e-9
}
