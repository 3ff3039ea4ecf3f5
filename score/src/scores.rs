//! Scores of an image of visibility against the truth.
//!
//! A pixel is shadowed if it is darker than half. The scores cover the evaluated pixels that the image hits, with
//! *shadowed* as the positive answer:
//!
//! | score | definition |
//! |---|---|
//! | intersection over union | pixels shadowed in both / pixels shadowed in either |
//! | leak | pixels shadowed in the truth and lit in the picture / pixels shadowed in the truth |
//! | acne | pixels lit in the truth and shadowed in the picture / pixels lit in the truth |
//! | contact leak | leak in contact shadows, without their edges |
//! | penumbra error | the mean of |grey − visible part| where that part is between 0.02 and 0.98; the mean error is over all |
//!
//! Each score is given for the [`BANDS`]: band 0 holds all pixels, band *k* holds those farther than *k* − 1 pixels from
//! a shadow edge. It is also given by distance from the camera, for each doubling. A score with a zero denominator does
//! not exist.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::ser::SerializeMap;

use crate::changes::Changes;
use crate::truth::{LightTruth, Truth};

/// The bands for which scores are given: 0 holds all pixels, k those farther than k − 1 pixels from a shadow edge.
pub const BANDS: [u8; 4] = [0, 1, 2, 4];

/// The range of a light's visible part (0 to 1) that counts as penumbra.
pub(crate) const PENUMBRA: std::ops::Range<f64> = 0.02..0.98;

/// A picture of the visibility of a light: 8 bits each for red, green, blue and alpha, row 0 on top. Red holds the
/// visibility; alpha of at least 128 marks geometry.
#[derive(Clone, Copy, Debug)]
pub struct Rendered<'p> {
    rgba: &'p [u8],
}

impl<'p> Rendered<'p> {
    /// Wraps a picture of the same size as the truth, four bytes for each pixel.
    pub fn new(rgba: &'p [u8]) -> Self {
        Self { rgba }
    }

    fn pixel(self, at: usize) -> [u8; 4] {
        let bytes = self.rgba.get(4 * at..4 * at + 4);
        bytes.and_then(|bytes| bytes.try_into().ok()).unwrap_or([255, 255, 255, 0])
    }

    pub(crate) fn hits(self, at: usize) -> bool {
        self.pixel(at)[3] >= 128
    }

    pub(crate) fn is_shadowed(self, at: usize) -> bool {
        self.pixel(at)[0] < 128
    }

    pub(crate) fn part(self, at: usize) -> f64 {
        f64::from(self.pixel(at)[0]) / 255.0
    }

    /// Returns `true` if every pixel that the picture hits (alpha of at least 128) is fully lit (red 255).
    pub fn is_lit_everywhere(self) -> bool {
        self.rgba.chunks_exact(4).all(|pixel| pixel[3] < 128 || pixel[0] == 255)
    }
}

/// The grey values of pixels that are partly lit, 0 to 1.
const PARTLY_LIT: std::ops::Range<f64> = 0.02..0.98;

/// The combination of truth and picture at one pixel: each is either shadowed or lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Shadowed in the truth and in the picture.
    ShadowedInBoth,
    /// Shadowed in the truth, lit in the picture.
    Leaking,
    /// Lit in the truth, shadowed in the picture.
    Acne,
    /// Lit in the truth and in the picture.
    LitInBoth,
}

impl Answer {
    pub(crate) fn new(lit: bool, shadowed: bool) -> Self {
        match (lit, shadowed) {
            (false, true) => Self::ShadowedInBoth,
            (false, false) => Self::Leaking,
            (true, true) => Self::Acne,
            (true, false) => Self::LitInBoth,
        }
    }
}

/// The numbers of pixels with each [`Answer`] in one group of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// The number of pixels that are shadowed in the truth and in the picture.
    pub shadowed_in_both: u64,
    /// The number of pixels that are shadowed in the truth, but lit in the picture: light leaks.
    pub leaking: u64,
    /// The number of pixels that are lit in the truth, but shadowed in the picture: acne.
    pub acne: u64,
    /// The number of pixels that are lit in the truth and in the picture.
    pub lit_in_both: u64,
}

impl Counts {
    /// Intersection over union: the pixels shadowed in truth and picture, divided by those shadowed in at least one.
    /// `None` if no pixel is shadowed.
    pub fn iou(&self) -> Option<f64> {
        ratio(self.shadowed_in_both, self.shadowed_in_both + self.leaking + self.acne)
    }

    /// The fraction of the pixels shadowed in the truth that the picture shows lit; `None` if the truth has no shadow.
    pub fn leak(&self) -> Option<f64> {
        ratio(self.leaking, self.shadowed_in_both + self.leaking)
    }

    /// The fraction of the pixels lit in the truth that the picture shows shadowed; `None` if the truth has no lit
    /// pixel.
    pub fn acne(&self) -> Option<f64> {
        ratio(self.acne, self.acne + self.lit_in_both)
    }

    /// The number of pixels of the group: the sum of the four counts.
    pub fn pixels(&self) -> u64 {
        self.shadowed_in_both + self.leaking + self.acne + self.lit_in_both
    }

    fn count(&mut self, answer: Answer) {
        *match answer {
            Answer::ShadowedInBoth => &mut self.shadowed_in_both,
            Answer::Leaking => &mut self.leaking,
            Answer::Acne => &mut self.acne,
            Answer::LitInBoth => &mut self.lit_in_both,
        } += 1;
    }

    fn add(&mut self, other: &Self) {
        self.shadowed_in_both += other.shadowed_in_both;
        self.leaking += other.leaking;
        self.acne += other.acne;
        self.lit_in_both += other.lit_in_both;
    }
}

impl Serialize for Counts {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("pixels", &self.pixels())?;
        map.serialize_entry("iou", &self.iou())?;
        map.serialize_entry("leak", &self.leak())?;
        map.serialize_entry("acne", &self.acne())?;
        map.serialize_entry("leaking_pixels", &self.leaking)?;
        map.serialize_entry("acne_pixels", &self.acne)?;
        map.end()
    }
}

/// The sum of errors over pixels, and the number of pixels. An error is the picture's grey value minus the visible
/// fraction of a light (each 0 to 1), or its absolute value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    sum: f64,
    pixels: u64,
}

impl Errors {
    /// The mean error of a pixel; `None` if no pixel was counted.
    pub fn mean(&self) -> Option<f64> {
        (self.pixels > 0).then(|| self.sum / self.pixels as f64)
    }

    pub(crate) fn count(&mut self, error: f64) {
        self.sum += error;
        self.pixels += 1;
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.sum += other.sum;
        self.pixels += other.pixels;
    }
}

impl Serialize for Errors {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.mean().serialize(serializer)
    }
}

/// The scores of a light, or of several lights together.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Scores {
    /// The number of pixels at which rays hit a surface.
    pub hit: u64,
    /// The number of pixels at which rays and the picture hit a surface.
    pub hit_in_both: u64,
    /// The number of pixels at which the picture hits a surface, but rays do not.
    pub hit_in_picture_only: u64,
    /// The counts by distance from shadow edges. Key 0 holds all pixels, key k those farther than k − 1 pixels from an
    /// edge.
    pub bands: BTreeMap<u8, Counts>,
    /// The counts by distance from the camera. The key k holds pixels from 2^k to 2^(k + 1) metres along the view axis.
    pub distances: BTreeMap<i32, Counts>,
    /// The counts of pixels in contact shadows, without the pixels at shadow edges.
    pub contact: Counts,
    /// The absolute errors of all evaluated pixels, for lights with an extent.
    pub mean_error: Errors,
    /// The absolute errors of evaluated pixels in penumbrae, for lights with an extent.
    pub penumbra_error: Errors,
    /// The signed errors of all evaluated pixels, for lights with an extent: positive if the picture is too light,
    /// negative if too dark.
    pub bias: Errors,
    /// The number of pixels that the picture shows in shadow, wholly or in part.
    pub darkened: u64,
    /// The number of these pixels that are partly lit.
    pub partly_lit: u64,
    /// The number of pixels in penumbrae, where a part of a light with an extent is visible.
    pub in_penumbrae: u64,
    /// The changes of the shadow term since the frame before.
    pub changes: Changes,
}

impl Scores {
    /// Scores a picture against the ray-traced visibility of a light.
    pub fn of(truth: &Truth<'_>, light: &LightTruth, picture: Rendered<'_>) -> Self {
        let mut scores =
            Self { bands: BANDS.map(|band| (band, Counts::default())).into(), ..Self::default() };
        for (at, point) in truth.points().iter().enumerate() {
            let hits = picture.hits(at);
            let Some(point) = point else {
                scores.hit_in_picture_only += u64::from(hits);
                continue;
            };
            scores.hit += 1;
            scores.hit_in_both += u64::from(hits);
            if !hits || !light.evaluated[at] {
                continue;
            }
            let answer = Answer::new(light.lit[at], picture.is_shadowed(at));
            for (band, counts) in &mut scores.bands {
                if *band == 0 || light.edge[at] > f32::from(*band) - 1.0 {
                    counts.count(answer);
                }
            }
            let doubling = point.depth.abs().max(1e-30).log2().floor() as i32;
            scores.distances.entry(doubling).or_default().count(answer);
            if light.contact[at] && light.edge[at] > 0.0 {
                scores.contact.count(answer);
            }
            let shown = picture.part(at);
            if shown < PARTLY_LIT.end {
                scores.darkened += 1;
                scores.partly_lit += u64::from(PARTLY_LIT.contains(&shown));
            }
            if let Some(visible) = &light.visible {
                let part = f64::from(visible[at]);
                let difference = shown - part;
                scores.mean_error.count(difference.abs());
                scores.bias.count(difference);
                scores.in_penumbrae += u64::from(PARTLY_LIT.contains(&part));
                if PENUMBRA.contains(&part) {
                    scores.penumbra_error.count(difference.abs());
                }
            }
        }
        scores
    }

    /// Adds the counts and errors of other scores to these.
    pub fn add(&mut self, other: &Self) {
        self.hit += other.hit;
        self.hit_in_both += other.hit_in_both;
        self.hit_in_picture_only += other.hit_in_picture_only;
        other.bands.iter().for_each(|(band, counts)| self.bands.entry(*band).or_default().add(counts));
        other.distances.iter().for_each(|(at, counts)| self.distances.entry(*at).or_default().add(counts));
        self.contact.add(&other.contact);
        self.mean_error.add(&other.mean_error);
        self.penumbra_error.add(&other.penumbra_error);
        self.bias.add(&other.bias);
        self.darkened += other.darkened;
        self.partly_lit += other.partly_lit;
        self.in_penumbrae += other.in_penumbrae;
        self.changes.add(&other.changes);
    }

    /// The counts of a band, one of [`BANDS`]; zeros for another number.
    pub fn band(&self, band: u8) -> Counts {
        self.bands.get(&band).copied().unwrap_or_default()
    }

    /// Intersection over union of shadowed pixels over all pixels; `None` if no pixel is shadowed.
    pub fn iou(&self) -> Option<f64> {
        self.band(0).iou()
    }

    /// Returns `true` if two fifths of the shadow or more are partly lit: counts that compare with a hard mask then say
    /// little. A single comparison that is filtered bilinearly stays below, also where shadows are thin.
    pub fn is_soft(&self) -> bool {
        5 * self.partly_lit >= 2 * self.darkened.max(1)
    }

    /// Returns `true` if penumbrae are more than a tenth of the shadow, and the picture has less than half of them:
    /// errors against the extent of the light then say little.
    pub fn lacks_penumbrae(&self) -> bool {
        10 * self.in_penumbrae > self.darkened && 2 * self.partly_lit < self.in_penumbrae
    }
}

pub(crate) fn ratio(part: u64, whole: u64) -> Option<f64> {
    (whole != 0).then(|| part as f64 / whole as f64)
}
