//! Lights of a frame, as glTF's KHR_lights_punctual defines them, with an extent.
//!
//! A light with a radius is a disc that faces the receiver, and sends as much light to it as a point of the same
//! intensity. A directional light with an angular diameter is a disc in the sky.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use umbragraph_pipeline::frame::{Light, LightKind};

use crate::light::Source;

/// A light that can be sampled.
#[derive(Clone, Debug)]
pub struct Lamp {
    light: Light,
    source: Source,
    /// Whether surfaces cast shadows in its light.
    pub casts: bool,
}

/// The light that arrives from one point of a lamp.
#[derive(Clone, Copy, Debug)]
pub struct Arriving {
    /// The unit vector to the point of the lamp.
    pub direction: DVec3,
    /// The distance in metres; infinite for a directional light.
    pub distance: f64,
    /// Illuminance of a surface that faces the light.
    pub illuminance: DVec3,
}

impl Lamp {
    /// A light of a frame; `None` for one with values that are not usable.
    pub fn new(light: &Light, casts: bool) -> Option<Self> {
        Some(Self { source: Source::of(light)?, light: light.clone(), casts })
    }

    /// The light of one point of the lamp at `position`; `at` chooses the point, both parts from 0 to 1. The mean over
    /// all points is the light of the lamp.
    pub fn arriving(&self, position: DVec3, at: DVec2) -> Arriving {
        let color = self.light.color.as_dvec3() * f64::from(self.light.intensity);
        let (radius, angle) = (at.x.sqrt(), TAU * at.y);
        let has_extent = self.source.has_extent();
        let sample = if has_extent { DVec2::new(angle.cos(), angle.sin()) * radius } else { DVec2::ZERO };
        let (direction, distance) = self.source.ray(position, sample);
        if distance.is_infinite() {
            return Arriving { direction, distance, illuminance: color };
        }
        let (_, middle) = self.source.ray(position, DVec2::ZERO);
        // The disc faces the receiver, so its points send light under the cosine of middle to distance.
        let cosine = if distance > 0.0 { middle / distance } else { 1.0 };
        let fade = self.fade(position, middle);
        Arriving { direction, distance, illuminance: color * (fade * cosine / distance.powi(2).max(1e-8)) }
    }

    /// The part of the light that range and cone leave.
    fn fade(&self, position: DVec3, distance: f64) -> f64 {
        let range = f64::from(self.light.range);
        let in_range = if range.is_finite() && range > 0.0 { 1.0 - (distance / range).powi(4) } else { 1.0 };
        let in_range = in_range.clamp(0.0, 1.0);
        let LightKind::Spot { inner_angle, outer_angle } = self.light.kind else { return in_range };
        let [inner, outer] = [inner_angle, outer_angle].map(|angle| f64::from(angle).cos());
        let cosine = (position - self.light.position).normalize_or_zero().dot(self.light.direction);
        let cone = ((cosine - outer) / (inner - outer).max(0.001)).clamp(0.0, 1.0);
        in_range * cone * cone
    }
}
