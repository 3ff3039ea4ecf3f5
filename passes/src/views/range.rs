//! The range of lights with a position.
//!
//! The declared range, limited to the distance at which the light gives [`DARKEST`] lux. An infinite range gives that
//! distance. The result is clamped to [`SHORTEST`] and [`LONGEST`]; zero and NaN count as the shortest. The shadow's
//! far plane stands at the range; nothing is in shadow beyond it.

use glam::DVec3;
use umbragraph_pipeline::frame::Light;

use super::NEAR;

/// The illuminance in lux below which light counts as invisible. It is about the first step of an 8-bit sRGB picture of
/// a white surface at exposure 1.
pub const DARKEST: f64 = 1e-3;

/// The shortest range, in metres: twice the near plane's distance.
pub const SHORTEST: f64 = 2.0 * NEAR;

/// The longest range, in metres. In its last 100 m, 32-bit depth can only resolve half metres.
pub const LONGEST: f64 = 1e4;

/// The range of a point or spot light, in metres; meaningless for a directional light.
pub fn of(light: &Light) -> f64 {
    let luminance = light.color.as_dvec3().abs().max_element().min(f64::from(f32::MAX));
    let brightest = f64::from(light.intensity).abs() * luminance;
    seen(brightest).min(clamped(f64::from(light.range)))
}

/// The distance in metres at which a light of `candela` gives [`DARKEST`] lux, clamped to the limits of the range.
fn seen(candela: f64) -> f64 {
    clamped((candela / DARKEST).sqrt())
}

/// The range in metres, clamped to [`SHORTEST`] and [`LONGEST`]; NaN counts as the shortest.
pub(super) fn clamped(range: f64) -> f64 {
    if range > SHORTEST { range.min(LONGEST) } else { SHORTEST }
}

/// The unit vector along which a light shines. A direction of zero or without finite values gives −Z, as in glTF.
pub fn direction(direction: DVec3) -> DVec3 {
    let max = direction.abs().max_element();
    if max.is_finite() { (direction / max).normalize_or(DVec3::NEG_Z) } else { DVec3::NEG_Z }
}

#[cfg(test)]
mod tests {
    use umbragraph_pipeline::frame::LightKind;

    use super::*;

    #[test]
    fn every_range_is_within_the_limits() {
        let ranges = [f64::NAN, -1.0, 0.0, 1e-9, 0.3, 7.0, 1e4, 1e300, f64::INFINITY];
        assert_eq!(ranges.map(clamped), [0.1, 0.1, 0.1, 0.1, 0.3, 7.0, 1e4, 1e4, 1e4]);
        assert_eq!([0.0, 0.1, 10.0, f64::INFINITY, f64::NAN].map(seen), [0.1, 10.0, 100.0, 1e4, 0.1]);
    }

    #[test]
    fn a_light_reaches_as_far_as_its_brightest_color_is_seen() {
        let light = Light::new("lamp", LightKind::Point).intensity(4.0).color([0.125, 0.25, 0.0]);
        assert!((of(&light.clone().range(f32::INFINITY)) - 1000f64.sqrt()).abs() < 1e-9);
        assert_eq!(of(&light.range(7.0)), 7.0);
    }

    #[test]
    fn every_direction_is_of_unit_length() {
        for given in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::splat(1e-310)] {
            assert!((direction(given).length() - 1.0).abs() < 1e-9, "{given}");
        }
        assert_eq!(direction(DVec3::new(0.0, -1e300, 0.0)), DVec3::NEG_Y);
        assert_eq!(direction(DVec3::ZERO), DVec3::NEG_Z);
    }
}
