//! Scores of a picture against a traced one.
//!
//! | score | definition |
//! |---|---|
//! | mean error | the mean of the absolute difference over all pixels and channels, display-referred (0 to 1) |
//! | surface error | the same over the pixels whose middle shows a surface |
//! | bias | the mean of the signed difference; above 0 the picture is too bright |
//! | FLIP | the mean of LDR-FLIP over all pixels ([`super::flip`]) |
//! | noise | the mean error that is expected of the traced picture itself |

use glam::DVec3;
use serde::Serialize;

use super::display::Display;
use super::flip::flip;
use super::tracer::Traced;
use crate::limits::{Limited, Limits};
use crate::scores::Errors;

/// Limits on the scores of colors, by name, such as `max_flip`.
pub type ColorLimits = Limits<ColorScores>;

/// The scores of a picture, or of several together. A lower absolute value is better.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ColorScores {
    /// The absolute difference.
    pub mean_error: Errors,
    /// The absolute difference where a surface is seen.
    pub surface_error: Errors,
    /// The signed difference, picture less traced.
    pub bias: Errors,
    /// The difference that a person sees.
    pub flip: Errors,
    /// The error of the traced picture by its noise.
    pub noise: Errors,
}

/// A comparison: the scores, and what is shown of it.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The scores.
    pub scores: ColorScores,
    /// The traced picture as it is displayed.
    pub traced: Vec<DVec3>,
    /// FLIP of each pixel.
    pub flip: Vec<f64>,
}

/// Compares a displayed picture (sRGB-encoded, each channel 0 to 1, as many pixels as traced ones) with a traced one.
pub fn compare(picture: &[DVec3], traced: &Traced, width: u32, display: &Display) -> Compared {
    let shown: Vec<DVec3> = traced.radiance.iter().map(|radiance| display.shown(*radiance)).collect();
    let mut scores = ColorScores::default();
    let mean = |difference: DVec3| difference.element_sum() / 3.0;
    for (at, (picture, shown)) in picture.iter().zip(&shown).enumerate() {
        let difference = *picture - *shown;
        scores.mean_error.count(mean(difference.abs()));
        scores.bias.count(mean(difference));
        if traced.hit[at] {
            scores.surface_error.count(mean(difference.abs()));
        }
        let other = display.shown((traced.radiance[at] + traced.noise[at]).max(DVec3::ZERO));
        scores.noise.count(mean((other - *shown).abs()));
    }
    let flip = flip(picture, &shown, width as usize);
    flip.iter().for_each(|error| scores.flip.count(*error));
    Compared { scores, traced: shown, flip }
}

impl ColorScores {
    /// Adds the scores of another picture.
    pub fn add(&mut self, other: &Self) {
        self.mean_error.add(&other.mean_error);
        self.surface_error.add(&other.surface_error);
        self.bias.add(&other.bias);
        self.flip.add(&other.flip);
        self.noise.add(&other.noise);
    }
}

impl Limited for ColorScores {
    fn limits() -> Vec<String> {
        ["max_mean_error", "max_surface_error", "max_bias", "max_flip"].map(str::to_owned).into()
    }

    fn limited(&self, name: &str) -> Option<Option<f64>> {
        match name {
            "max_mean_error" => Some(self.mean_error.mean()),
            "max_surface_error" => Some(self.surface_error.mean()),
            "max_bias" => Some(self.bias.mean().map(f64::abs)),
            "max_flip" => Some(self.flip.mean()),
            _ => None,
        }
    }
}

impl Compared {
    /// A picture of three side by side: as rendered, as traced, and FLIP from black over red and yellow to white. Four
    /// bytes for each pixel.
    pub fn sheet(&self, picture: &[DVec3], width: u32) -> Vec<u8> {
        let width = (width as usize).max(1);
        let byte = |part: f64| (part.clamp(0.0, 1.0) * 255.0).round() as u8;
        let rgba = |color: DVec3| [byte(color.x), byte(color.y), byte(color.z), 255];
        let heat = |error: &f64| rgba(DVec3::new(3.0 * error, 3.0 * error - 1.0, 3.0 * error - 2.0));
        let rows = picture.chunks(width).zip(self.traced.chunks(width)).zip(self.flip.chunks(width));
        rows.flat_map(|((picture, traced), flip)| {
            let colors = picture.iter().chain(traced).map(|color| rgba(*color));
            colors.chain(flip.iter().map(heat)).flatten().collect::<Vec<u8>>()
        })
        .collect()
    }
}
