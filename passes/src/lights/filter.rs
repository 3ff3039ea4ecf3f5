//! Reports of filters that are narrower or wider than the pipeline wants.
//!
//! A filter of constant world width covers a different number of texels in each map, and in a perspective at each
//! distance. If the pipeline's bounds in texels change the width, a notice names the lights and the place. For cascades
//! that is their number and the width; for spots and point lights the distance along the view axis, within which the
//! filter is narrower or beyond which it is wider.
//!
//! A filter may follow the penumbra instead of having one width. Then only the maximum half width applies: in cascades
//! if a caster as high as the map's depth casts a wider penumbra; for spots and point lights below a distance from the
//! light.
//!
//! Limits: distances count where the scene's bounds and the light's range leave room for receivers; the actual
//! receivers are unknown here. A new notice is made when other bounds apply, not when distances or widths change alone.

use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use umbragraph_pipeline::data::BlackboardData;
use umbragraph_pipeline::diagnostic::{Diagnostic, Place, Severity, list_of};
use umbragraph_pipeline::frame::{Bounds, FrameInput, Light};
use umbragraph_pipeline::language::Expr;
use umbragraph_pipeline::pipeline::Evaluate;

use super::missing::NoBounds;
use crate::codes;

/// The width of a shadow filter in the world, and its bounds in texels of the shadow map.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FilterSettings {
    /// Half the width of the filter, in metres; 0 for no filter.
    pub radius: Expr,
    /// The minimum of half the width, in texels of the shadow map.
    pub min: Expr,
    /// The maximum of half the width, in texels of the shadow map.
    pub max: Expr,
    /// Whether the filter is as wide as the penumbra that the caster makes, instead of having a fixed width; false by
    /// default.
    pub penumbra: Option<Expr>,
}

/// Half the width of a filter in metres, and its bounds in texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Filter {
    radius: f64,
    min: f64,
    max: f64,
    penumbra: bool,
}

/// A place at which a bound in texels changes the width of a filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Where {
    /// In the cascade with this index; the second number is half the filter's width there, in metres.
    Cascade(usize, f64),
    /// Up to this distance from the light, in metres.
    Within(f64),
    /// Beyond this distance from the light, in metres.
    Beyond(f64),
}

impl Filter {
    /// Evaluates the settings of a filter. `Some(None)` is no filter: no settings, or a radius that is not positive.
    /// `None` follows a diagnostic.
    pub(crate) fn declare(
        settings: Option<&FilterSettings>,
        pass: &mut impl Evaluate,
    ) -> Option<Option<Self>> {
        let Some(settings) = settings else { return Some(None) };
        let radius = pass.number(&settings.radius, "/shadow_filter/radius");
        let min = pass.number(&settings.min, "/shadow_filter/min");
        let max = pass.number(&settings.max, "/shadow_filter/max");
        let penumbra = pass.boolean_or(&settings.penumbra, "/shadow_filter/penumbra", false);
        let filter = Self { radius: radius?, min: min?, max: max?, penumbra: penumbra? };
        Some((filter.radius > 0.0).then_some(filter))
    }

    /// The maximum of half the filter's width, in texels.
    pub(crate) fn reach(self) -> f64 {
        self.max.max(self.min)
    }

    /// The bound that changes the filter's width in the cascade with index `at`. `texel` is the width of a texel and
    /// `depth` the depth range, in metres; `tangent` is that of half the light's angular diameter. `None` if no bound
    /// applies.
    pub(crate) fn in_cascade(&self, at: usize, texel: f64, depth: f64, tangent: f64) -> Option<Where> {
        if self.penumbra {
            let width = self.max * texel;
            return (depth * tangent > width).then_some(Where::Cascade(at, width));
        }
        let width = (self.radius / texel).max(self.min).min(self.max) * texel;
        ((width - self.radius).abs() > 1e-6 * self.radius).then_some(Where::Cascade(at, width))
    }

    /// The bounds that change the filter's width in a perspective view: within a distance, and beyond a distance.
    /// Receivers lie between `nearest` and `farthest`; `texel` is the width of a texel at 1 m, `light` the light's
    /// radius, all in metres.
    pub(crate) fn in_perspective(
        &self,
        texel: f64,
        [nearest, farthest]: [f64; 2],
        light: f64,
    ) -> [Option<Where>; 2] {
        let ends = nearest < farthest;
        if self.penumbra {
            // The penumbra of a blocker at b has light · (1 / b − 1 / farthest) / texel texels at most.
            let within = 1.0 / (self.max * texel / light.max(1e-9) + 1.0 / farthest);
            return [(ends && within > nearest).then_some(Where::Within(within)), None];
        }
        let narrower = self.radius / (self.max * texel);
        let wider = self.radius / (self.min * texel);
        [
            (ends && narrower > nearest).then(|| Where::Within(narrower.min(farthest))),
            (ends && wider < farthest).then(|| Where::Beyond(wider.max(nearest))),
        ]
    }
}

/// The nearest and farthest distance of possible receivers from a light, in metres. They lie in the scene's bounds,
/// between the near and far plane of the light's view.
pub(crate) fn receivers(position: DVec3, near: f64, far: f64, scene: &Bounds) -> (f64, f64) {
    if scene.is_empty() {
        return (near, near);
    }
    let nearest = position.clamp(scene.min, scene.max).distance(position);
    let farthest = scene.corners().into_iter().map(|corner| corner.distance(position)).fold(0.0, f64::max);
    (near.max(nearest), far.min(farthest))
}

/// The places of a frame at which a filter's bounds change its width, and the places in the last notice. Each frame
/// reuses the memory.
#[derive(Debug, Default)]
pub(crate) struct Bounded {
    places: Vec<(u32, Where)>,
    /// The index of the light and the kind of bound, for each place in the last notice.
    reported: Vec<(u32, usize)>,
    /// Whether the last notices report missing bounds of the scene.
    said_lacks: bool,
}

/// The index of the light and a number for the kind of bound: 0 within a distance, 1 beyond a distance, 2 + index in a
/// cascade.
fn key((light, place): &(u32, Where)) -> (u32, usize) {
    match place {
        Where::Within(_) => (*light, 0),
        Where::Beyond(_) => (*light, 1),
        Where::Cascade(at, _) => (*light, 2 + at),
    }
}

impl Bounded {
    /// Removes the places of the last frame.
    pub(crate) fn clear(&mut self) {
        self.places.clear();
    }

    /// Adds places at which a bound changes the filter's width, for the light with this index in the frame.
    pub(crate) fn add(&mut self, light: u32, places: impl IntoIterator<Item = Where>) {
        self.places.extend(places.into_iter().map(|place| (light, place)));
    }

    /// Publishes new notices if other bounds apply than in the last notices, or if scene bounds went missing or came
    /// back.
    pub(crate) fn report(
        &mut self,
        filter: Option<Filter>,
        frame: &FrameInput,
        lacks: Option<NoBounds>,
        data: &mut BlackboardData,
    ) {
        let are_same = self.places.iter().map(key).eq(self.reported.iter().copied());
        if are_same && self.said_lacks == lacks.is_some() {
            return;
        }
        self.reported.clear();
        self.reported.extend(self.places.iter().map(key));
        self.said_lacks = lacks.is_some();
        let bounded = filter.and_then(|filter| self.notice(filter, &frame.lights));
        data.set_notices(lacks.map(NoBounds::notice).into_iter().chain(bounded).collect());
    }

    fn notice(&self, filter: Filter, lights: &[Light]) -> Option<Diagnostic> {
        let Filter { radius, min, max, penumbra } = filter;
        if self.places.is_empty() {
            return None;
        }
        let words = self.places.iter().map(|(light, place)| {
            let name = lights.get(*light as usize).map_or("", |light| &light.name);
            match place {
                Where::Cascade(at, width) => format!("in cascade {at} of \"{name}\" ({width:.3} m)"),
                Where::Within(distance) if penumbra => {
                    format!("of what is within {distance:.2} m of \"{name}\"")
                }
                Where::Within(distance) => format!("within {distance:.2} m of \"{name}\" (narrower)"),
                Where::Beyond(distance) => format!("beyond {distance:.2} m of \"{name}\" (wider)"),
            }
        });
        let words: Vec<String> = words.collect();
        let places = list_of(words.iter().map(String::as_str));
        let (message, help) = if penumbra {
            (
                format!("penumbrae can be wider than shadow filters {places}"),
                format!(
                    "these have at most {max} texels to a side: raise it, or lower the resolution of the maps"
                ),
            )
        } else {
            (
                format!("shadow filters are not {radius} m to a side {places}"),
                format!(
                    "their bounds of {min} to {max} texels bite there: change them, or the resolution of the maps"
                ),
            )
        };
        let notice = Diagnostic::warning(codes::FILTER_BOUNDED, Place::Nowhere, message).help(help);
        Some(notice.severity(Severity::Note))
    }
}

#[cfg(test)]
mod tests {
    use umbragraph_pipeline::data::DataShape;
    use umbragraph_pipeline::frame::{Camera, LightKind, Projection};

    use super::*;

    const FILTER: Filter = Filter { radius: 0.1, min: 2.0, max: 10.0, penumbra: false };

    #[test]
    fn a_perspective_filter_is_as_wide_as_set_between_two_limits() {
        // Ten texels are 0.1 m at 5 m, two at 25 m.
        let of = |nearest, farthest| FILTER.in_perspective(0.002, [nearest, farthest], 0.5);
        assert_eq!(of(6.0, 24.0), [None, None]);
        assert_eq!(of(1.0, 24.0), [Some(Where::Within(5.0)), None]);
        assert_eq!(of(6.0, 40.0), [None, Some(Where::Beyond(25.0))]);
        assert_eq!(of(1.0, 3.0), [Some(Where::Within(3.0)), None]);
        assert_eq!(of(30.0, 40.0), [None, Some(Where::Beyond(30.0))]);
        assert_eq!(of(3.0, 3.0), [None, None]);
        assert_eq!(of(5.0, 25.0), [None, None]);
    }

    #[test]
    fn in_a_cascade_the_filter_is_as_wide_as_wanted_for_some_texels() {
        assert_eq!(FILTER.in_cascade(0, 0.02, 50.0, 0.1), None);
        assert_eq!(FILTER.in_cascade(1, 0.1, 50.0, 0.1), Some(Where::Cascade(1, 0.2)));
        assert_eq!(FILTER.in_cascade(2, 0.001, 50.0, 0.1), Some(Where::Cascade(2, 0.01)));
        let narrow = Filter { radius: 1e-4, ..FILTER };
        assert_eq!(narrow.in_cascade(3, 0.001, 50.0, 0.1), Some(Where::Cascade(3, 0.002)));
    }

    #[test]
    fn penumbrae_are_cut_where_something_can_cast_a_wider_one() {
        let filter = Filter { penumbra: true, ..FILTER };
        // What is 50 m high has a penumbra of 0.5 m to a side; ten texels are 0.6 m, or 0.4 m.
        assert_eq!(filter.in_cascade(0, 0.06, 50.0, 0.01), None);
        assert_eq!(filter.in_cascade(0, 0.05, 50.0, 0.01), None);
        assert_eq!(filter.in_cascade(1, 0.04, 50.0, 0.01), Some(Where::Cascade(1, 0.4)));
        assert_eq!(filter.in_cascade(2, 0.04, 50.0, 0.0), None);
        // At 8 m ten texels are 0.16 m: so wide is the penumbra of a lamp of 0.08 m for what is 8/3 m from it.
        let [within, beyond] = filter.in_perspective(0.002, [0.5, 8.0], 0.08);
        let Some(Where::Within(distance)) = within else { panic!("{within:?}") };
        assert!((0.08 * (8.0 - distance) / distance - 0.16).abs() < 1e-9 && beyond.is_none());
        assert_eq!(filter.in_perspective(0.002, [3.0, 8.0], 0.08), [None, None]);
        assert_eq!(filter.in_perspective(0.002, [0.5, 8.0], 0.0), [None, None]);
    }

    #[test]
    fn a_notice_is_made_only_when_other_bounds_apply() {
        let lens = Projection::Perspective { vertical_fov: 1.0, near: 0.1, far: 100.0 };
        let lights = vec![Light::new("sun", LightKind::Directional), Light::new("lamp", LightKind::Point)];
        let frame =
            FrameInput::new(Camera::new(DVec3::ZERO, glam::DQuat::IDENTITY, lens, 1.6)).lights(lights);
        let mut bounded = Bounded::default();
        let mut told = |filter, places: &[(u32, Where)]| {
            bounded.clear();
            places.iter().for_each(|(light, place)| bounded.add(*light, [*place]));
            let mut data = BlackboardData::new(DataShape::new());
            bounded.report(Some(filter), &frame, None, &mut data);
            data.notices().iter().map(|notice| notice.message.clone()).collect::<Vec<_>>().join("; ")
        };
        let first = told(FILTER, &[(0, Where::Cascade(1, 0.2)), (1, Where::Within(2.0))]);
        assert!(first.contains("in cascade 1 of \"sun\" (0.200 m)"), "{first}");
        assert!(first.contains("within 2.00 m of \"lamp\" (narrower)"), "{first}");
        assert_eq!(told(FILTER, &[(0, Where::Cascade(1, 0.3)), (1, Where::Within(3.0))]), "");
        for (places, words) in [
            ([(0, Where::Cascade(2, 0.2)), (1, Where::Within(2.0))], "in cascade 2 of \"sun\""),
            ([(0, Where::Cascade(2, 0.2)), (1, Where::Beyond(9.0))], "beyond 9.00 m of \"lamp\" (wider)"),
            ([(0, Where::Cascade(2, 0.2)), (0, Where::Beyond(9.0))], "beyond 9.00 m of \"sun\""),
        ] {
            let other = told(FILTER, &places);
            assert!(other.contains(words) && told(FILTER, &places).is_empty(), "{other}");
        }
        let penumbra = told(Filter { penumbra: true, ..FILTER }, &[(1, Where::Within(2.5))]);
        assert!(penumbra.contains("penumbrae can be wider"), "{penumbra}");
        assert!(penumbra.contains("of what is within 2.50 m of \"lamp\""), "{penumbra}");
    }

    #[test]
    fn receivers_stand_between_the_planes_and_within_the_scene() {
        let scene = Bounds { min: DVec3::splat(-1.0), max: DVec3::ONE };
        assert_eq!(receivers(DVec3::new(0.0, 0.0, 4.0), 0.1, 100.0, &scene), (3.0, 27.0_f64.sqrt()));
        assert_eq!(receivers(DVec3::ZERO, 0.1, 1.5, &scene), (0.1, 1.5));
        let (nearest, farthest) = receivers(DVec3::ZERO, 0.1, 1.5, &Bounds::EMPTY);
        assert!(nearest >= farthest);
    }
}
