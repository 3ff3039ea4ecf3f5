//! Split distances of cascades along the view axis.
//!
//! Explicit far distances are taken as they are. The formulas divide the range from `near` to `far` into n parts:
//!
//! ```text
//! uniform      u_i = near + (far − near)·i/n
//! logarithmic  l_i = near·(far/near)^(i/n)
//! practical    λ·l_i + (1 − λ)·u_i
//! ```
//!
//! A cascade blends into its successor over the end of its range, so the slice that the successor is fitted to begins
//! where that blend zone begins. All distances are metres along the view axis from the camera.
//!
//! If a pass on the GPU fits cascades to the visible depth, the CPU does not know the splits. Each slice is then the
//! whole range, so that no caster of any cascade is culled.
//!
//! Limits: the formulas need a near distance above zero; one that is not (an orthographic camera's) or is half the far
//! distance and more is moved between a millionth and half of the far distance.

use schemars::JsonSchema;
use serde::Deserialize;

use super::MAX_CASCADES;

/// The rule for the far distances of cascades.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SplitScheme {
    /// The far distances as they are listed.
    #[default]
    Explicit,
    /// All cascades have ranges of equal length.
    Uniform,
    /// Each far distance is the same multiple of the one before.
    Logarithmic,
    /// The weighted mean of the logarithmic distance (weight lambda) and the uniform distance (weight 1 − lambda).
    Practical,
    /// Each cascade covers the camera's entire depth range, so that casters may be drawn into any cascade. A pass on
    /// the GPU then fits the cascades.
    Whole,
}

/// The distance that the fraction of a blend zone refers to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BlendOf {
    /// A fraction of the cascade's far distance.
    #[default]
    Far,
    /// A fraction of the cascade's range, which begins at the far distance of the cascade before (for the first: at the
    /// near distance).
    Range,
}

/// The end of each cascade's range that blends into the next cascade.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Blend {
    /// The length of the zone as a fraction of the distance `of`, from 0 (no blending) to 1.
    pub fraction: f64,
    /// The distance that the fraction refers to.
    pub of: BlendOf,
}

/// The far distances of the cascades, or the formula for them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Splits {
    /// The far distances as they are listed.
    Explicit {
        /// The far distances in metres, strictly increasing; only the first `count` are used.
        far: [f64; MAX_CASCADES],
        /// The number of cascades.
        count: usize,
    },
    /// The far distances are computed by the practical formula.
    Formula {
        /// The weight of the logarithmic part: 0 is the uniform scheme, 1 the logarithmic.
        lambda: f64,
        /// The beginning of the first cascade, in metres; `None` for the camera's near plane.
        near: Option<f64>,
        /// The end of the last cascade, in metres.
        far: f64,
        /// The number of cascades.
        count: usize,
    },
    /// Each cascade covers the camera's entire depth range.
    Whole {
        /// The number of cascades.
        count: usize,
    },
}

/// One cascade's part of the view axis, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slice {
    /// The beginning of the range to cover, including the blend zone of the cascade before.
    pub begin: f64,
    /// The end of the range: the far distance, at most the camera's far plane.
    pub end: f64,
    /// The far distance of the cascade, which can lie beyond the camera's far plane.
    pub far: f64,
    /// The distance at which the cascade begins to blend into the next.
    pub blend_start: f64,
}

impl Splits {
    /// The number of cascades, at most [`MAX_CASCADES`].
    pub fn count(&self) -> usize {
        match self {
            Splits::Explicit { count, .. } | Splits::Formula { count, .. } | Splits::Whole { count } => {
                (*count).min(MAX_CASCADES)
            }
        }
    }

    /// The near distance from which the splits are computed, in metres. `camera_near` is the distance of the camera's
    /// near plane.
    pub fn near(&self, camera_near: f64) -> f64 {
        match self {
            Splits::Explicit { .. } | Splits::Whole { .. } => camera_near,
            Splits::Formula { near, far, .. } => near.unwrap_or(camera_near).min(far * 0.5).max(far * 1e-6),
        }
    }

    /// The far distances in metres; zero from the number of cascades on. `camera_near` is the distance of the camera's
    /// near plane.
    pub fn far(&self, camera_near: f64) -> [f64; MAX_CASCADES] {
        let mut distances = [0.0; MAX_CASCADES];
        let count = self.count();
        for (at, distance) in distances.iter_mut().take(count).enumerate() {
            *distance = match self {
                Splits::Explicit { far, .. } => far[at],
                Splits::Whole { .. } => f64::INFINITY,
                Splits::Formula { far, .. } if at + 1 == count => *far,
                Splits::Formula { lambda, far, .. } => {
                    practical(*lambda, self.near(camera_near), *far, (at + 1) as f64 / count as f64)
                }
            };
        }
        distances
    }

    /// The slices of a camera with its planes at `near` and `far`, in metres. Slices that begin beyond the far plane
    /// are left out.
    pub fn slices(&self, blend: Blend, near: f64, far: f64) -> impl Iterator<Item = Slice> + use<> {
        let is_whole = matches!(self, Splits::Whole { .. });
        let distances = self.far(near);
        let mut begin = near;
        let mut previous = self.near(near);
        distances.into_iter().take(self.count()).map_while(move |distance| {
            if is_whole {
                return Some(Slice { begin: near, end: far, far, blend_start: far });
            }
            let zone = blend.fraction
                * match blend.of {
                    BlendOf::Far => distance,
                    BlendOf::Range => distance - previous,
                };
            let slice = Slice {
                begin: begin.min(distance),
                end: distance.min(far),
                far: distance,
                blend_start: (distance - zone).max(previous.min(distance)),
            };
            previous = distance;
            begin = slice.blend_start.max(near);
            // Beyond the camera's far plane there is nothing to receive a shadow.
            (slice.begin < far).then_some(slice)
        })
    }
}

/// The practical split distance in metres at the fraction `part` (0 to 1) of the range from `near` to `far`. `lambda`
/// is the weight of the logarithmic part.
pub fn practical(lambda: f64, near: f64, far: f64, part: f64) -> f64 {
    lambda * near * (far / near).powf(part) + (1.0 - lambda) * (near + (far - near) * part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formula(lambda: f64, near: f64, far: f64, count: usize) -> [f64; MAX_CASCADES] {
        Splits::Formula { lambda, near: Some(near), far, count }.far(1.0)
    }

    fn explicit(far: &[f64]) -> Splits {
        let mut all = [0.0; MAX_CASCADES];
        all[..far.len()].copy_from_slice(far);
        Splits::Explicit { far: all, count: far.len() }
    }

    #[test]
    fn the_practical_split_gives_the_documented_distances() {
        let near = formula(0.7, 0.1, 200.0, 3);
        assert!(
            (near[0] - 20.9).abs() < 0.05 && (near[1] - 51.1).abs() < 0.05 && near[2] == 200.0,
            "{near:?}"
        );
        let half = formula(0.5, 0.1, 200.0, 3);
        assert!(
            (half[0] - 34.0).abs() < 0.05 && (half[1] - 74.6).abs() < 0.1 && half[2] == 200.0,
            "{half:?}"
        );
    }

    #[test]
    fn the_mix_ends_at_the_uniform_and_the_logarithmic_split() {
        assert_eq!(formula(0.0, 1.0, 401.0, 4)[..4], [101.0, 201.0, 301.0, 401.0]);
        for (found, wanted) in formula(1.0, 1.0, 10_000.0, 4).into_iter().zip([10.0, 100.0, 1000.0, 10_000.0])
        {
            assert!((found / wanted - 1.0).abs() < 1e-12, "{found} {wanted}");
        }
    }

    #[test]
    fn an_unusable_near_plane_still_gives_increasing_distances() {
        for near in [-5.0, 0.0, 1e-300, 199.0, 200.0, 1e9] {
            for lambda in [0.0, 0.5, 1.0] {
                let far = formula(lambda, near, 200.0, 8);
                assert!(
                    far[0] > 0.0 && far.windows(2).all(|pair| pair[0] < pair[1]),
                    "{near} {lambda} {far:?}"
                );
            }
        }
    }

    #[test]
    fn each_slice_begins_where_the_one_before_begins_to_blend() {
        for of in [BlendOf::Far, BlendOf::Range] {
            let slices: Vec<_> =
                explicit(&[10.0, 30.0, 80.0]).slices(Blend { fraction: 0.1, of }, 0.1, 1e4).collect();
            assert_eq!((slices[0].begin, slices[2].end), (0.1, 80.0));
            for pair in slices.windows(2) {
                assert_eq!(pair[1].begin, pair[0].blend_start);
            }
            let starts = if of == BlendOf::Far { [9.0, 27.0, 72.0] } else { [9.01, 28.0, 75.0] };
            for (slice, start) in slices.iter().zip(starts) {
                assert!((slice.blend_start - start).abs() < 1e-12, "{slices:?}");
            }
        }
    }

    #[test]
    fn every_cascade_can_have_the_whole_range() {
        let slices: Vec<_> = Splits::Whole { count: 3 }.slices(Blend::default(), 0.1, 20.0).collect();
        assert_eq!(slices, [Slice { begin: 0.1, end: 20.0, far: 20.0, blend_start: 20.0 }; 3]);
    }

    #[test]
    fn a_blend_zone_never_begins_before_its_own_cascade() {
        let slices: Vec<_> =
            explicit(&[10.0, 12.0]).slices(Blend { fraction: 0.5, of: BlendOf::Far }, 0.1, 1e4).collect();
        assert_eq!(slices[1].blend_start, 10.0);
    }

    #[test]
    fn slices_end_at_the_far_plane_of_the_camera() {
        let slices: Vec<_> = explicit(&[10.0, 30.0, 80.0]).slices(Blend::default(), 0.1, 20.0).collect();
        assert_eq!(slices.iter().map(|slice| slice.end).collect::<Vec<_>>(), [10.0, 20.0]);
        assert_eq!(slices[1].far, 30.0);
        let ends_there = explicit(&[10.0, 30.0, 80.0]).slices(Blend::default(), 0.1, 30.0);
        assert_eq!(ends_there.map(|slice| slice.end).collect::<Vec<_>>(), [10.0, 30.0]);
    }
}
