//! Directional albedo of the GGX lobe: the part of light from all sides that it reflects, by quadrature.
//!
//! With Schlick's Fresnel term the albedo is `f0 · x + f90 · y`; a table holds x and y over roughness and the cosine of
//! the view. It has 48 by 48 entries, denser at grazing angles, and is filled once for a process.

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::brdf::{Ggx, MIN_ROUGHNESS};

const ENTRIES: usize = 48;

/// The number of samples along each axis of the quadrature.
const STEPS: u32 = 40;

struct Table {
    /// Row by row: a row for each roughness, a column for the root of each cosine.
    entries: Vec<DVec2>,
    /// The mean over all cosines, for each roughness.
    means: Vec<DVec2>,
}

/// The directional albedo of the lobe at a perceptual roughness under the cosine of a view, 0 to 1: the factors of the
/// reflectances at normal and at grazing incidence.
pub fn directional(roughness: f64, cosine: f64) -> DVec2 {
    let table = table();
    let (row, down) = place(row_of(roughness));
    let (column, along) = place(cosine.clamp(0.0, 1.0).sqrt());
    let at = |row: usize, column: usize| table.entries[row * ENTRIES + column];
    let between = |row: usize| at(row, column).lerp(at(row, column + 1), along);
    between(row).lerp(between(row + 1), down)
}

/// The mean of [`directional`] over a hemisphere of equal light: the integral of 2 · cosine · albedo.
pub fn mean(roughness: f64) -> DVec2 {
    let (row, down) = place(row_of(roughness));
    table().means[row].lerp(table().means[row + 1], down)
}

fn row_of(roughness: f64) -> f64 {
    ((roughness - MIN_ROUGHNESS) / (1.0 - MIN_ROUGHNESS)).clamp(0.0, 1.0)
}

/// The entry before a place from 0 to 1, at most the last but one, and the part of the way to the next.
fn place(part: f64) -> (usize, f64) {
    let at = part * (ENTRIES - 1) as f64;
    let first = (at as usize).min(ENTRIES - 2);
    (first, at - first as f64)
}

fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| {
        let part = |at: usize| at as f64 / (ENTRIES - 1) as f64;
        let roughness = |row: usize| MIN_ROUGHNESS + (1.0 - MIN_ROUGHNESS) * part(row);
        let entry =
            |at: usize| integral(roughness(at / ENTRIES), part(at % ENTRIES).powi(2).max(1e-4), STEPS);
        let entries: Vec<DVec2> = (0..ENTRIES * ENTRIES).into_par_iter().map(entry).collect();
        let mean = |row: usize| {
            let middle = |at: u32| ((f64::from(at) + 0.5) / 32.0).sqrt();
            (0..32).map(|at| integral(roughness(row), middle(at), STEPS / 2)).sum::<DVec2>() / 32.0
        };
        Table { entries, means: (0..ENTRIES).into_par_iter().map(mean).collect() }
    })
}

/// Integrates the albedo over visible normals, with `steps` squared samples.
fn integral(roughness: f64, cosine: f64, steps: u32) -> DVec2 {
    let lobe = Ggx::new(roughness);
    let view = DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let part = |at: u32| (f64::from(at) + 0.5) / f64::from(steps);
    let samples = (0..steps * steps).map(|at| {
        let halfway = lobe.visible_normal(view, DVec2::new(part(at / steps), part(at % steps)));
        let toward = view.dot(halfway).clamp(0.0, 1.0);
        let light = 2.0 * toward * halfway - view;
        if light.z <= 0.0 {
            return DVec2::ZERO;
        }
        let edge = (1.0 - toward).powi(5);
        // Of the estimator f · cosine / density only the shadowing of the light's side remains.
        DVec2::new(1.0 - edge, edge) * (lobe.shadowing(view.z, light.z) / lobe.masking(view.z))
    });
    samples.sum::<DVec2>() / f64::from(steps * steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same integral as a sum over directions of light in equal solid angles, which shares no sampling.
    fn over_directions(roughness: f64, cosine: f64) -> DVec2 {
        let lobe = Ggx::new(roughness);
        let view = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
        let (rings, turns) = (1200, 1200);
        let mut sum = DVec2::ZERO;
        for ring in 0..rings {
            let z = (f64::from(ring) + 0.5) / f64::from(rings);
            for turn in 0..turns {
                let angle = std::f64::consts::TAU * (f64::from(turn) + 0.5) / f64::from(turns);
                let across = (1.0 - z * z).sqrt();
                let light = DVec3::new(across * angle.cos(), across * angle.sin(), z);
                let halfway = (view + light).normalize();
                let edge = (1.0 - view.dot(halfway)).powi(5);
                sum += DVec2::new(1.0 - edge, edge) * (lobe.value(view, light, halfway) * z);
            }
        }
        sum * std::f64::consts::TAU / f64::from(rings * turns)
    }

    #[test]
    fn the_table_holds_the_integral_over_directions() {
        for (roughness, cosine) in [(0.3, 0.9), (0.5, 0.2), (0.6, 0.7), (0.8, 0.05), (1.0, 0.5), (1.0, 1.0)] {
            let (found, expected) = (directional(roughness, cosine), over_directions(roughness, cosine));
            assert!((found - expected).length() < 0.004, "{roughness} {cosine}: {found} {expected}");
        }
        assert!(directional(0.045, 1.0).x > 0.999, "a mirror loses nothing");
    }

    #[test]
    fn the_mean_is_that_of_the_table() {
        for roughness in [0.1, 0.5, 1.0] {
            let sum: DVec2 =
                (0..400).map(|at| directional(roughness, ((f64::from(at) + 0.5) / 400.0).sqrt())).sum();
            assert!((sum / 400.0 - mean(roughness)).length() < 0.003, "{roughness}");
        }
    }
}
