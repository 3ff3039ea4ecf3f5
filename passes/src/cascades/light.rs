//! The light that cascades are fitted to, and light space.
//!
//! Light space is a rotation of world space about its origin: the light looks along −Z, so z grows towards the light.
//! It has no translation; a point's light-space coordinates do not depend on the camera.
//!
//! The choice does not depend on the order of the lights: those that cast shadows come before those that do not, then
//! the brighter (intensity times luminance), then the name that is alphabetically first. A light that casts none is
//! chosen where no other is there, so that shaders still have a directional light; nothing is fitted to it.
//!
//! Limits: where the light is within about 8° of the up vector (the cosine is 0.99 or more), another one takes its
//! place, and a light that moves through that angle turns its texels there.

use glam::{DMat3, DVec3, Vec3};
use umbragraph_pipeline::frame::{Light, LightKind};

use crate::words::CAST_SHADOW;

/// The cosine of the angle between light and up vector from which another up vector is used: about 8°.
const PARALLEL: f64 = 0.99;

/// Chooses a directional light and returns it with its index: the brightest that casts shadows, or else the brightest.
/// With a name, only lights of this name count. Lights with unusable values are ignored; `None` if no light is left.
pub fn choose<'a>(lights: &'a [Light], name: Option<&str>) -> Option<(usize, &'a Light)> {
    lights
        .iter()
        .enumerate()
        .filter(|(_, light)| matches!(light.kind, LightKind::Directional) && light.check().is_none())
        .filter(|(_, light)| name.is_none_or(|name| light.name == name))
        .min_by(|(_, a), (_, b)| {
            let dark_first = brightness(a).total_cmp(&brightness(b));
            let casts = |light: &Light| light.has(CAST_SHADOW);
            casts(b).cmp(&casts(a)).then(dark_first.reverse()).then_with(|| a.name.cmp(&b.name))
        })
}

/// The intensity times the luminance of the colour: in lux for a directional light, else in candela.
pub(crate) fn brightness(light: &Light) -> f64 {
    f64::from(light.intensity) * light.color.as_dvec3().dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// The colour times the intensity (lux for a directional light, else candela), limited to the finite range of `f32`.
pub fn radiance(light: &Light) -> Vec3 {
    (light.color * light.intensity).clamp(Vec3::splat(f32::MIN), Vec3::splat(f32::MAX))
}

/// The rotation from world to light space for a light that shines along the unit vector `direction`. `up` points up in
/// the map unless it is nearly parallel to the light. Then the world's Y axis does, or Z if Y is parallel too.
pub fn from_world(direction: DVec3, up: DVec3) -> DMat3 {
    let back = -direction;
    let usable = |up: &DVec3| up.dot(direction).abs() < PARALLEL;
    let up = [up.normalize_or_zero(), DVec3::Y]
        .into_iter()
        .filter(|up| *up != DVec3::ZERO)
        .find(usable)
        .unwrap_or(DVec3::Z);
    let right = up.cross(back).normalize_or(DVec3::X);
    DMat3::from_cols(right, back.cross(right), back).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(name: &str, intensity: f32, cast_shadow: bool) -> Light {
        let light = Light::new(name.to_owned(), LightKind::Directional).intensity(intensity);
        if cast_shadow { light.property(CAST_SHADOW) } else { light }
    }

    #[test]
    fn the_choice_of_light_does_not_depend_on_the_order() {
        let mut lights =
            vec![sun("moon", 1.0, true), sun("b", 5.0, true), sun("a", 5.0, true), sun("fill", 90.0, false)];
        lights.push(Light::new("0", LightKind::Point).intensity(1e6).property(CAST_SHADOW));
        lights.push(sun("broken", 1e6, true).direction(DVec3::NAN));
        // Blue counts a fourteenth of white.
        lights.push(sun("blue", 20.0, true).color(Vec3::Z));
        for _ in 0..lights.len() {
            lights.rotate_left(1);
            assert_eq!(choose(&lights, None).map(|(_, light)| &*light.name), Some("a"));
            assert_eq!(choose(&lights, Some("moon")).map(|(_, light)| &*light.name), Some("moon"));
            assert!(choose(&lights, Some("mon")).is_none());
        }
    }

    #[test]
    fn light_space_is_a_rotation_that_looks_along_the_light() {
        for direction in
            [DVec3::NEG_Y, DVec3::Y, DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.3, -0.9, 0.1).normalize()]
        {
            for up in [DVec3::Y, DVec3::Z, DVec3::X * 1e-200, DVec3::ZERO] {
                let light = from_world(direction, up);
                assert!((light.determinant() - 1.0).abs() < 1e-12, "{direction} {up}");
                assert!((light * direction - DVec3::NEG_Z).length() < 1e-12, "{direction} {up}");
            }
        }
    }

    #[test]
    fn the_up_vector_points_up_in_the_map() {
        let light = from_world(DVec3::new(0.5, -0.5, 0.1).normalize(), DVec3::Z);
        let up = light * DVec3::Z;
        assert!(up.x.abs() < 1e-12 && up.y > 0.0);
        // A light that falls along it takes Y instead.
        assert!((from_world(DVec3::NEG_Z, DVec3::Z) * DVec3::Y - DVec3::Y).length() < 1e-12);
        let nearly = from_world(DVec3::new(0.08, 0.03, -1.0).normalize(), DVec3::Z) * DVec3::Y;
        assert!(nearly.x.abs() < 1e-12 && nearly.y > 0.0, "{nearly}");
        // The last direction that is too near to it.
        let beside = (1.0_f64 - 0.99 * 0.99).sqrt();
        let back = from_world(DVec3::new(0.6 * beside, -0.99, 0.8 * beside), DVec3::Y) * DVec3::Z;
        assert!(back.x.abs() < 1e-12 && back.y > 0.9, "{back}");
    }
}
