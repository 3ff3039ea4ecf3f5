//! The importance of a light's shadow in a frame, and the number of texels that suits it.
//!
//! `importance = priority · coverage · proximity · strength`, with
//!
//! | factor | what | range |
//! |---|---|---|
//! | priority | the host's own weight ([`Light::priority`]) | 0 to 10⁶ |
//! | coverage | the part of the picture that the rectangle around the light's sphere takes; 1 where the camera stands in the sphere, and for a directional light | 0 to 1 |
//! | proximity | 10 m / (10 m + the distance from the camera to the sphere) | 0 to 1 |
//! | strength | log₂(1 + I), I the intensity times luminance of the colour, in candela, or in lux for a directional light | 0 to 128 |
//!
//! The sphere holds all that the light reaches: its range ([`crate::views::range`]) around it, or for a spot the
//! smallest sphere around its cone. Its rectangle in the picture is exact (from the tangents through the eye, in each
//! of the two axes apart), and is cut off at the picture's edges: a light comes into view and leaves it without a jump,
//! and one whose sphere is out of view has importance 0, since nothing that it shadows is seen.
//!
//! The texels: `full · √(coverage · proximity · min(priority, 1))`, at most `full`. So a light that fills the
//! picture gets `full`, and the sizes on the screen of all lights' texels are alike. Its strength does not matter here.
//!
//! The cadence, in which a kept map takes up what casters did: a map that is right with half, a quarter, an eighth of
//! the texels of one that fills the picture shows a caster's way as much coarser, and waits for two, four, eight
//! frames.
//!
//! Limits: a light or camera with unusable values has importance 0; a camera's far plane is not looked at, nor is
//! what hides the light. All results are finite.

use glam::{DMat4, DVec3};
use umbragraph_pipeline::frame::{Camera, Light, LightKind, Projection};

use crate::cascades::light::brightness;
use crate::views::range;

/// The distance in metres from the camera to a light's sphere at which the light's importance is halved.
const HALF_DISTANCE: f64 = 10.0;

/// The largest value of [`Light::priority`] that counts, a factor without unit; greater values are reduced to it.
const MAX_PRIORITY: f64 = 1e6;

/// The importance of a light's shadow in a frame, as factors to be multiplied.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Importance {
    /// The host's weight ([`Light::priority`]), 0 to 10⁶.
    pub priority: f64,
    /// The fraction of the picture that the rectangle around the light's sphere covers, 0 to 1.
    pub coverage: f64,
    /// The nearness of the light's sphere: 10 m / (10 m + its distance from the camera), 0 to 1.
    pub proximity: f64,
    /// The brightness on a logarithmic scale: log₂(1 + I), with I in candela, or in lux for a directional light.
    pub strength: f64,
}

impl Importance {
    /// The product of all factors; finite and not negative.
    pub fn value(&self) -> f32 {
        (self.priority * self.coverage * self.proximity * self.strength) as f32
    }

    /// The side in texels of a map for the light, if a light that fills the picture gets a map of side `full`.
    pub fn texels(&self, full: u32) -> u32 {
        (f64::from(full) * self.part()).ceil() as u32
    }

    /// The number of frames after which the light's kept map is drawn again: a power of two, at most `most`.
    pub fn cadence(&self, most: u32) -> u32 {
        cadence(1.0 / self.part(), most)
    }

    /// The side of the light's map, as a fraction of the side for a light that fills the picture.
    fn part(&self) -> f64 {
        (self.coverage * self.proximity * self.priority.min(1.0)).sqrt()
    }
}

/// The largest power of two that exceeds neither `ratio` nor `most`; at least 1.
pub fn cadence(ratio: f64, most: u32) -> u32 {
    let wanted = if ratio > 1.0 { ratio.min(f64::from(most)) as u32 } else { 1 };
    1 << wanted.max(1).ilog2()
}

/// A camera, prepared for the importance of many lights.
#[derive(Clone, Copy, Debug)]
pub struct Eye {
    view: DMat4,
    position: DVec3,
    /// Half the visible angle (for a perspective camera, in radians) or half the visible size (in metres), in x and y.
    half: [f64; 2],
    perspective: bool,
}

impl Eye {
    /// Prepares a camera; `None` for a camera with unusable values.
    pub fn new(camera: &Camera) -> Option<Self> {
        if camera.check().is_some() {
            return None;
        }
        let (half, perspective) = match camera.projection {
            Projection::Perspective { vertical_fov, .. } => {
                let height = 0.5 * vertical_fov;
                ([(height.tan() * camera.aspect).atan(), height], true)
            }
            Projection::Orthographic { half_height, .. } => {
                ([half_height * camera.aspect, half_height], false)
            }
            projection @ Projection::Matrix { .. } => {
                let (center, half) = projection.picture(camera.aspect);
                let [x, y] = (center.abs() + half).to_array();
                let perspective = !projection.is_orthographic();
                (if perspective { [x.atan(), y.atan()] } else { [x, y] }, perspective)
            }
        };
        let eye = Self { view: camera.view(), position: camera.position, half, perspective };
        (eye.view.is_finite() && half.iter().all(|half| half.is_finite() && *half > 0.0)).then_some(eye)
    }

    /// The importance of a light, by factors; all zero for a light with unusable values.
    pub fn importance(&self, light: &Light) -> Importance {
        if light.check().is_some() {
            return Importance::default();
        }
        let number = |value: f64| if value > 0.0 { value.min(1e30) } else { 0.0 };
        let (coverage, proximity) = match sphere(light) {
            None => (1.0, 1.0),
            Some((center, radius)) => {
                let gap = number(center.distance(self.position) - radius);
                (self.coverage(center, radius), HALF_DISTANCE / (HALF_DISTANCE + gap))
            }
        };
        Importance {
            priority: number(f64::from(light.priority)).min(MAX_PRIORITY),
            coverage,
            proximity,
            strength: (1.0 + number(brightness(light))).log2(),
        }
    }

    /// The fraction of the picture that the rectangle around a sphere covers, 0 to 1. `center` is in world space, in
    /// metres, as is `radius`.
    pub fn coverage(&self, center: DVec3, radius: f64) -> f64 {
        let center = self.view.transform_point3(center);
        if !center.is_finite() || radius.is_nan() || radius <= 0.0 {
            return 0.0;
        }
        if self.perspective && center.length() <= radius {
            return 1.0;
        }
        let part = |across: f64, half: f64| {
            if self.perspective {
                angular_part(across, -center.z, radius, half)
            } else {
                ((across + radius).min(half) - (across - radius).max(-half)) / (2.0 * half)
            }
        };
        let parts = [part(center.x, self.half[0]), part(center.y, self.half[1])];
        if parts.iter().all(|part| *part > 0.0) { (parts[0] * parts[1]).min(1.0) } else { 0.0 }
    }
}

/// The fraction of the picture's width that a circle covers. Its centre lies `across` metres beside and `ahead` metres
/// in front of the eye; `half` is half the field of view in radians.
fn angular_part(across: f64, ahead: f64, radius: f64, half: f64) -> f64 {
    let distance = across.hypot(ahead);
    if distance <= radius {
        return 1.0;
    }
    let (middle, spread) = (across.atan2(ahead), (radius / distance).asin());
    let (low, high) = ((middle - spread).max(-half), (middle + spread).min(half));
    if low < high { (high.tan() - low.tan()) / (2.0 * half.tan()) } else { 0.0 }
}

/// The sphere that holds every point the light reaches: centre and radius in world metres; `None` for a directional
/// light.
pub fn sphere(light: &Light) -> Option<(DVec3, f64)> {
    let range = range::of(light);
    match light.kind {
        LightKind::Directional => None,
        LightKind::Point => Some((light.position, range)),
        LightKind::Spot { outer_angle, .. } => {
            let angle = f64::from(outer_angle);
            let angle = if angle > 0.0 { angle } else { 0.0 };
            let (along, radius) = if angle <= std::f64::consts::FRAC_PI_4 {
                let half = 0.5 * range / angle.cos();
                (half, half)
            } else if angle < std::f64::consts::FRAC_PI_2 {
                (range * angle.cos(), range * angle.sin())
            } else {
                (0.0, range)
            };
            Some((light.position + light.direction * along, radius))
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use proptest::prelude::*;
    use umbragraph_test_support::property;

    use super::*;

    impl Importance {
        fn of(light: &Light, camera: &Camera) -> Self {
            Eye::new(camera).map_or(Self::default(), |eye| eye.importance(light))
        }
    }

    fn camera() -> Camera {
        Camera::new(
            DVec3::new(1.0, 2.0, 3.0),
            DQuat::from_rotation_y(0.4),
            Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 },
            1.6,
        )
    }

    fn lamp() -> Light {
        Light::new("lamp", LightKind::Point).intensity(100.0).range(5.0).property("cast_shadow")
    }

    /// A point light at `place` in the camera's view space, with a range in metres.
    fn seen_at(place: DVec3, range: f32) -> Light {
        lamp().position(camera().position + camera().rotation * place).range(range)
    }

    proptest! {
        #![proptest_config(property::config(256))]

        #[test]
        fn the_rectangle_holds_every_point_of_the_sphere_and_no_more(
            x in -30.0..30.0f64, y in -20.0..20.0f64, z in -60.0..-1.0f64, radius in 0.1..20.0f64,
        ) {
            let center = DVec3::new(x, y, z);
            prop_assume!(center.length() > radius * 1.01 && z < -radius * 1.05);
            let (half_height, aspect) = ((0.5f64).tan(), 1.6);
            let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
            for step in 0..40_000 {
                let (height, turn) = (1.0 - 2.0 * (f64::from(step) + 0.5) / 40_000.0, 2.399_963 * f64::from(step));
                let wide = (1.0 - height * height).sqrt();
                let point = center + radius * DVec3::new(wide * turn.cos(), wide * turn.sin(), height);
                let screen = [point.x / -point.z / (half_height * aspect), point.y / -point.z / half_height];
                for axis in 0..2 {
                    low[axis] = low[axis].min(screen[axis].clamp(-1.0, 1.0));
                    high[axis] = high[axis].max(screen[axis].clamp(-1.0, 1.0));
                }
            }
            let sampled = (high[0] - low[0]) * (high[1] - low[1]) / 4.0;
            let eye = Eye::new(&camera()).unwrap();
            let found = eye.coverage(camera().position + camera().rotation * center, radius);
            prop_assert!(found >= sampled - 1e-9 && found <= sampled + 0.02, "{found} {sampled}");
        }

        #[test]
        fn every_number_is_finite_for_any_input(
            numbers in proptest::array::uniform10(prop_oneof![
                4 => -100.0..100.0f64, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(f64::NEG_INFINITY),
                1 => Just(0.0), 1 => Just(1e300), 1 => Just(1e-300), 1 => Just(3e38),
            ]),
            kind in 0..3,
        ) {
            let [x, y, z, dx, dy, dz, range, intensity, priority, angle] = numbers;
            let kind = match kind {
                0 => LightKind::Point,
                1 => LightKind::Directional,
                _ => LightKind::Spot { inner_angle: 0.0, outer_angle: angle as f32 },
            };
            let (range, intensity, priority) = (range as f32, intensity as f32, priority as f32);
            let direction = DVec3::new(dx, dy, dz).normalize_or(DVec3::NEG_Y);
            let light = Light::new("lamp", kind).position([x, y, z]).direction(direction).range(range);
            let light = light.intensity(intensity).priority(priority);
            let importance = Importance::of(&light, &camera());
            prop_assert!(importance.value().is_finite() && importance.value() >= 0.0);
            prop_assert!((0.0..=1.0).contains(&importance.coverage) && (0.0..=1.0).contains(&importance.proximity));
            prop_assert!(importance.texels(2048) <= 2048);
            let broken = Camera::new([x, y, z], camera().rotation, camera().projection, range.into());
            prop_assert!(Importance::of(&light, &broken).value().is_finite());
        }
    }

    #[test]
    fn out_of_view_covers_nothing_and_around_the_camera_all() {
        let coverage = |place, range| Importance::of(&seen_at(place, range), &camera()).coverage;
        assert_eq!(coverage(DVec3::new(0.0, 0.0, 20.0), 5.0), 0.0);
        assert_eq!(coverage(DVec3::new(90.0, 0.0, -20.0), 5.0), 0.0);
        assert_eq!(coverage(DVec3::new(1.0, 0.0, 1.0), 5.0), 1.0);
        assert!(coverage(DVec3::new(0.0, 0.0, 5.1), 5.0) < 1e-9);
    }

    #[test]
    fn an_orthographic_sphere_has_the_same_size_everywhere() {
        let eye = Eye::new(&camera().projection(Projection::Orthographic {
            half_height: 10.0,
            near: 0.1,
            far: 100.0,
        }))
        .unwrap();
        // The picture is 32 m wide and 20 m high; of the second sphere 6 m are in it from top to bottom.
        for (place, part) in [
            (DVec3::new(3.0, 2.0, -20.0), 8.0 / 32.0 * 8.0 / 20.0),
            (DVec3::new(3.0, -8.0, -60.0), 8.0 / 32.0 * 6.0 / 20.0),
            (DVec3::new(3.0, -14.5, -60.0), 0.0),
        ] {
            let found = eye.coverage(camera().position + camera().rotation * place, 4.0);
            assert!((found - part).abs() < 1e-9, "{found} at {place}");
        }
    }

    #[test]
    fn a_sphere_without_a_place_or_a_radius_covers_nothing() {
        let eye = Eye::new(&camera()).unwrap();
        let ahead = camera().position + 9.0 * camera().forward();
        for (center, radius) in [(DVec3::NAN, 4.0), (ahead, f64::NAN), (ahead, 0.0), (ahead, -1.0)] {
            assert_eq!(eye.coverage(center, radius), 0.0, "{center} {radius}");
        }
    }

    #[test]
    fn a_light_counts_half_at_ten_metres_and_less_beyond() {
        for (gap, wanted) in [(-1.0, 1.0), (0.0, 1.0), (10.0, 0.5), (30.0, 0.25), (90.0, 0.1)] {
            let seen = seen_at(DVec3::new(0.0, 0.0, -4.0 - gap), 4.0);
            let found = Importance::of(&seen, &camera()).proximity;
            assert!((found - wanted).abs() < 1e-9, "{found} at {gap} m");
        }
    }

    #[test]
    fn a_light_comes_into_view_without_a_jump() {
        let mut before = 0.0;
        for step in 0..4_000 {
            let coverage = Importance::of(
                &seen_at(DVec3::new(-40.0 + 0.01 * f64::from(step), 0.0, -30.0), 4.0),
                &camera(),
            )
            .coverage;
            assert!((coverage - before).abs() < 2e-4, "{step}");
            before = coverage;
        }
        assert!(before > 0.03);
    }

    #[test]
    fn nearer_brighter_and_weightier_lights_matter_more() {
        let value = |light: Light| Importance::of(&light, &camera()).value();
        let plain = seen_at(DVec3::new(0.0, 0.0, -20.0), 4.0);
        assert!(value(plain.clone()) > value(seen_at(DVec3::new(0.0, 0.0, -40.0), 4.0)));
        assert!(value(plain.clone().intensity(200.0)) > value(plain.clone()));
        assert_eq!(value(plain.clone().priority(2.0)), 2.0 * value(plain.clone()));
        assert_eq!(value(plain.clone().priority(f32::NAN)), 0.0);
        let texels = |light: Light| Importance::of(&light, &camera()).texels(2048);
        assert_eq!(texels(plain.clone().intensity(1e6)), texels(plain));
        assert_eq!(texels(Light::new("sun", LightKind::Directional)), 2048);
    }

    #[test]
    fn smaller_maps_wait_longer_in_powers_of_two() {
        let cadence = |part: f64| {
            Importance { priority: 1.0, coverage: part * part, proximity: 1.0, strength: 1.0 }.cadence(8)
        };
        let parts = [1.0, 0.6, 0.49, 0.3, 0.24, 0.12, 0.05, 0.0];
        assert_eq!(parts.map(cadence), [1, 1, 2, 2, 4, 8, 8, 8]);
        assert_eq!([1, 2, 3, 6].map(|most| super::cadence(1e9, most)), [1, 2, 2, 4]);
        assert_eq!(super::cadence(f64::NAN, 8), 1);
    }

    #[test]
    fn the_sphere_around_a_cone_is_the_smallest() {
        for (angle, radius) in
            [(0.0f64, 2.5), (0.6, 2.5 / 0.6f64.cos()), (1.2, 5.0 * 1.2f64.sin()), (3.1, 5.0)]
        {
            let spot = Light::new("spot", LightKind::Spot { inner_angle: 0.0, outer_angle: angle as f32 })
                .range(5.0);
            let (center, found) = sphere(&spot).unwrap();
            assert!((found - radius).abs() < 1e-6, "{angle}");
            // The tip, and a point on the rim.
            let angle = angle.min(std::f64::consts::PI);
            let rim = DVec3::new(5.0 * angle.sin(), -5.0 * angle.cos(), 0.0);
            assert!(center.length() <= found + 1e-6 && center.distance(rim) <= found + 1e-6);
        }
    }
}
