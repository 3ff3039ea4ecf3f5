//! Rays from a point to a light.
//!
//! A directional light has an angular diameter; a spot or point light is a disc of its radius that faces the receiver.
//! Samples cover a disc, and so does every prefix of their sequence (R2, M. Roberts 2018). A few samples find out
//! whether a point is in full light, full shadow or a penumbra, which takes more samples.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use umbragraph_pipeline::frame::{Light, LightKind};

/// A light as a target of rays.
#[derive(Clone, Debug)]
pub struct Source {
    kind: LightKind,
    position: DVec3,
    to_light: DVec3,
    range: f64,
    /// The tangent of half the angular diameter of a directional light, or the radius of another light in metres; 0 for
    /// no extent.
    size: f64,
}

impl Source {
    /// The target of rays for a light; `None` for a light with invalid values.
    pub fn of(light: &Light) -> Option<Self> {
        if light.check().is_some() {
            return None;
        }
        let size = match light.kind {
            LightKind::Directional => (0.5 * f64::from(light.angular_diameter)).tan(),
            _ => f64::from(light.radius),
        };
        Some(Self {
            kind: light.kind,
            position: light.position,
            to_light: -light.direction,
            range: f64::from(light.range),
            size: if size.is_finite() && size > 0.0 { size } else { 0.0 },
        })
    }

    /// Returns `true` if the light has an angular diameter or a radius above zero, so that it casts penumbrae.
    pub fn has_extent(&self) -> bool {
        self.size > 0.0
    }

    /// Returns `true` if the light reaches an unoccluded point: the point is inside the light's range and, for a spot,
    /// its cone.
    pub fn reaches(&self, point: DVec3) -> bool {
        let offset = self.position - point;
        match self.kind {
            LightKind::Directional => true,
            LightKind::Point => offset.length() <= self.range,
            LightKind::Spot { outer_angle, .. } => {
                let cosine = offset.normalize_or_zero().dot(self.to_light);
                offset.length() <= self.range && cosine >= f64::from(outer_angle).cos()
            }
        }
    }

    /// The unit direction from a point to the light, and the distance in metres (infinite for a directional light).
    /// `sample` chooses a point of the light by its place on the unit disc; zero is the middle.
    pub fn ray(&self, point: DVec3, sample: DVec2) -> (DVec3, f64) {
        let (middle, distance) = match self.kind {
            LightKind::Directional => (self.to_light, f64::INFINITY),
            _ => {
                let offset = self.position - point;
                (offset.normalize_or(DVec3::Y), offset.length())
            }
        };
        if sample == DVec2::ZERO {
            return (middle, distance);
        }
        let (across, along) = middle.any_orthonormal_pair();
        let aside = (across * sample.x + along * sample.y) * self.size;
        if distance.is_infinite() {
            return ((middle + aside).normalize(), distance);
        }
        let offset = middle * distance + aside;
        (offset.normalize_or(middle), offset.length())
    }
}

/// The point with this index of a sequence that covers the unit disc evenly.
pub fn disc_sample(index: u32) -> DVec2 {
    // The powers of the inverse of the root of x³ = x + 1.
    let part = |step: f64| (0.5 + step * f64::from(index + 1)).fract();
    let (radius, turn) = (part(0.754_877_666_246_692_8).sqrt(), TAU * part(0.569_840_290_998_053_3));
    DVec2::new(turn.cos(), turn.sin()) * radius
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_beginning_of_the_samples_covers_the_disc() {
        for count in [16, 64, 256] {
            let mean = (0..count).map(disc_sample).sum::<DVec2>() / f64::from(count);
            assert!(mean.length() < 1.5 / f64::from(count).sqrt() * 0.4, "{count} {mean}");
            let inner = (0..count).filter(|index| disc_sample(*index).length_squared() < 0.5).count();
            assert!((inner as f64 / f64::from(count) - 0.5).abs() < 0.07, "{count} {inner}");
            assert!((0..count).all(|index| disc_sample(index).length() <= 1.0));
        }
    }
}
