//! LDR-FLIP: the difference that a person sees who switches between two pictures, 0 to 1 for each pixel.
//!
//! P. Andersson et al., "FLIP: a difference evaluator for alternating images", Proceedings of the ACM on Computer Graphics
//! and Interactive Techniques 3.2, 2020. Constants are those of the paper; [`PIXELS_PER_DEGREE`] is its default, a monitor
//! 0.7 m wide with 3840 pixels across, seen from 0.7 m.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Pixels under one degree of the field of view.
pub const PIXELS_PER_DEGREE: f64 = 67.020_643_276_582_25;

/// The white of D65, from red, green and blue of 1.
const WHITE: DVec3 = DVec3::new(0.950_428_545_377_181, 1.0, 1.088_900_370_798_128);

/// From linear sRGB to XYZ, the rows of the matrix as columns.
const TO_XYZ: DMat3 = DMat3::from_cols(
    DVec3::new(10_135_552.0 / 24_577_794.0, 2_613_072.0 / 12_288_897.0, 1_425_312.0 / 73_733_382.0),
    DVec3::new(8_788_810.0 / 24_577_794.0, 8_788_810.0 / 12_288_897.0, 8_788_810.0 / 73_733_382.0),
    DVec3::new(4_435_075.0 / 24_577_794.0, 887_015.0 / 12_288_897.0, 70_074_185.0 / 73_733_382.0),
);

/// A picture: its width, and a value for each pixel.
struct Plane<T> {
    width: usize,
    values: Vec<T>,
}

impl<T: Copy + Send + Sync> Plane<T> {
    fn height(&self) -> usize {
        self.values.len() / self.width.max(1)
    }

    /// The value at a pixel, or at the nearest one of the picture.
    fn at(&self, x: i64, y: i64) -> T {
        let x = x.clamp(0, self.width as i64 - 1) as usize;
        let y = y.clamp(0, self.height() as i64 - 1) as usize;
        self.values[y * self.width + x]
    }

    fn each<U: Send>(&self, value: impl Fn(i64, i64) -> U + Sync) -> Plane<U> {
        let width = self.width;
        let at = |index: usize| value((index % width) as i64, (index / width) as i64);
        Plane { width, values: (0..self.values.len()).into_par_iter().map(at).collect() }
    }
}

/// The differences of two pictures of sRGB-encoded colors (each channel 0 to 1), `width` pixels wide; empty if their
/// sizes differ.
pub fn flip(one: &[DVec3], other: &[DVec3], width: usize) -> Vec<f64> {
    if one.len() != other.len() || width == 0 || !one.len().is_multiple_of(width) {
        return Vec::new();
    }
    let [(one, one_lightness), (other, other_lightness)] = [one, other].map(|colors| prepared(colors, width));
    let max = hyab(hunt(lab(DVec3::Y)), hunt(lab(DVec3::Z))).powf(0.7);
    let features = [features(&one_lightness), features(&other_lightness)];
    let pixel = |at: usize| {
        let color = hyab(one.values[at], other.values[at]).powf(0.7);
        let color = spread(color, max);
        let feature =
            (0..2).map(|kind| (features[0][at][kind] - features[1][at][kind]).abs()).fold(0.0, f64::max);
        let feature = (feature / 2.0_f64.sqrt()).min(1.0).sqrt();
        color.powf(1.0 - feature)
    };
    (0..one.values.len()).map(pixel).collect()
}

/// Spreads color differences over 0 to 1: those below 0.4 of the largest take the first 95 %.
fn spread(color: f64, max: f64) -> f64 {
    let (knee, top) = (0.4 * max, 0.95);
    if color < knee { top / knee * color } else { top + (color - knee) / (max - knee) * (1.0 - top) }
}

/// Colors as the eye resolves them, in L*a*b* with Hunt's effect; and the lightness before, 0 to 1.
fn prepared(colors: &[DVec3], width: usize) -> (Plane<DVec3>, Plane<f64>) {
    let opponent = |color: &DVec3| {
        let linear = DVec3::from_array(color.to_array().map(decoded));
        let [x, y, z] = (TO_XYZ * linear / WHITE).to_array();
        DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
    };
    let plane = Plane { width, values: colors.iter().map(opponent).collect() };
    let lightness =
        Plane { width, values: plane.values.iter().map(|color| (color.x + 16.0) / 116.0).collect() };
    let filtered = filtered(&plane);
    let seen = |color: &DVec3| {
        let y = (color.x + 16.0) / 116.0;
        let xyz = DVec3::new(y + color.y / 500.0, y, y - color.z / 200.0) * WHITE;
        hunt(lab((TO_XYZ.inverse() * xyz).clamp(DVec3::ZERO, DVec3::ONE)))
    };
    (Plane { width, values: filtered.values.iter().map(seen).collect() }, lightness)
}

/// The picture after the contrast sensitivity of the eye: sums of two Gaussians for each channel (section 4.1.1).
fn filtered(plane: &Plane<DVec3>) -> Plane<DVec3> {
    let (first, first_width) = (DVec3::new(1.0, 1.0, 34.1), DVec3::new(0.0047, 0.0053, 0.04));
    let (second, second_width) = (DVec3::new(0.0, 0.0, 13.5), DVec3::new(1e-5, 1e-5, 0.025));
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i64;
    // Each Gaussian is a product of one along and one down; both halves of a sum are filtered apart.
    let gaussian = |widths: DVec3, at: i64| {
        let square = (at as f64 / PIXELS_PER_DEGREE).powi(2);
        DVec3::from_array(widths.to_array().map(|width| (-PI * PI * square / width).exp()))
    };
    let scale = |factor: DVec3, widths: DVec3| {
        factor * DVec3::from_array(widths.to_array().map(|width| (PI / width).sqrt()))
    };
    let sum = |widths: DVec3| (-radius..=radius).map(|at| gaussian(widths, at)).sum::<DVec3>();
    let scales = [scale(first, first_width), scale(second, second_width)];
    let whole = scales[0] * sum(first_width).powf(2.0) + scales[1] * sum(second_width).powf(2.0);
    let passed = |widths: DVec3| {
        let along = plane.each(|x, y| {
            (-radius..=radius).map(|at| plane.at(x + at, y) * gaussian(widths, at)).sum::<DVec3>()
        });
        along.each(|x, y| {
            (-radius..=radius).map(|at| along.at(x, y + at) * gaussian(widths, at)).sum::<DVec3>()
        })
    };
    let [one, other] = [passed(first_width), passed(second_width)];
    let values = one.values.iter().zip(&other.values);
    let values = values.map(|(one, other)| (*one * scales[0] + *other * scales[1]) / whole).collect();
    Plane { width: plane.width, values }
}

/// The strengths of edges and of points at each pixel (section 4.2).
fn features(lightness: &Plane<f64>) -> Vec<[f64; 2]> {
    let deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i64;
    let bell = |at: i64| (-(at * at) as f64 / (2.0 * deviation * deviation)).exp();
    let edge = |at: i64| -at as f64 * bell(at);
    let point = |at: i64| ((at * at) as f64 / (deviation * deviation) - 1.0) * bell(at);
    let bells: f64 = (-radius..=radius).map(bell).sum();
    let strengths = [&edge as &(dyn Fn(i64) -> f64 + Sync), &point].map(|kernel| {
        // Positive weights add up to 1, negative ones to -1.
        let positive: f64 = (-radius..=radius).map(|at| kernel(at).max(0.0)).sum::<f64>() * bells;
        let negative: f64 = -(-radius..=radius).map(|at| kernel(at).min(0.0)).sum::<f64>() * bells;
        let weight = |at: i64| kernel(at) / if kernel(at) > 0.0 { positive } else { negative };
        let product = |along: &(dyn Fn(i64) -> f64 + Sync), down: &(dyn Fn(i64) -> f64 + Sync)| {
            let first = lightness
                .each(|x, y| (-radius..=radius).map(|at| lightness.at(x + at, y) * along(at)).sum::<f64>());
            first.each(|x, y| (-radius..=radius).map(|at| first.at(x, y + at) * down(at)).sum::<f64>())
        };
        let [along, down] = [product(&weight, &bell), product(&bell, &weight)];
        along.values.iter().zip(&down.values).map(|(along, down)| along.hypot(*down)).collect::<Vec<f64>>()
    });
    strengths[0].iter().zip(&strengths[1]).map(|(edge, point)| [*edge, *point]).collect()
}

/// L*a*b* of a linear color.
fn lab(linear: DVec3) -> DVec3 {
    let delta = 6.0 / 29.0;
    let root = |part: f64| {
        if part > delta * delta * delta { part.cbrt() } else { part / (3.0 * delta * delta) + 4.0 / 29.0 }
    };
    let [x, y, z] = (TO_XYZ * linear / WHITE).to_array().map(root);
    DVec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
}

/// Colors are less vivid in the dark (R. Hunt, 1952).
fn hunt(lab: DVec3) -> DVec3 {
    DVec3::new(lab.x, 0.01 * lab.x * lab.y, 0.01 * lab.x * lab.z)
}

/// Lightness and color apart (S. Abasi et al., 2020).
fn hyab(one: DVec3, other: DVec3) -> f64 {
    let difference = one - other;
    difference.x.abs() + difference.y.hypot(difference.z)
}

/// The inverse of the sRGB transfer function.
fn decoded(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_color_difference_is_that_of_the_paper() {
        let max = hyab(hunt(lab(DVec3::Y)), hunt(lab(DVec3::Z)));
        assert!((max.powf(0.7) - 41.2761).abs() < 1e-3, "{max}");
    }

    #[test]
    fn a_difference_is_seen_where_it_is() {
        let grey = vec![DVec3::splat(0.5); 40 * 30];
        assert!(flip(&grey, &grey, 40).iter().all(|error| *error == 0.0));
        let mut dot = grey.clone();
        dot[15 * 40 + 20] = DVec3::ONE;
        let errors = flip(&grey, &dot, 40);
        let at = |x: usize, y: usize| errors[y * 40 + x];
        assert!(at(20, 15) > at(22, 15) && at(22, 15) > at(30, 15) && at(2, 2) < 1e-6, "{}", at(20, 15));
        assert!(at(20, 15) > 0.1 && at(20, 15) <= 1.0);
        assert_eq!(flip(&grey, &dot[1..], 40), Vec::<f64>::new());
    }

    #[test]
    fn flat_pictures_differ_by_their_colors_alone() {
        let plane = |color: DVec3| vec![color; 32 * 32];
        let of = |one: DVec3, other: DVec3| flip(&plane(one), &plane(other), 32)[500];
        // L* of black and white is 0 and 100, so the difference is 100 to the power of 0.7.
        let expected = spread(100_f64.powf(0.7), 41.2761);
        assert!((of(DVec3::ZERO, DVec3::ONE) - expected).abs() < 1e-3);
        assert!((of(DVec3::Y, DVec3::Z) - 1.0).abs() < 1e-6, "the largest one");
        assert!(of(DVec3::splat(0.5), DVec3::splat(0.52)) < of(DVec3::splat(0.5), DVec3::splat(0.6)));
    }
}
