//! The scores of a rendered shadow mask.
//!
//! A pixel of the picture is shadowed when it is darker than half; it hits geometry when its alpha is more than
//! half, or always in a picture without alpha. A pixel is evaluated when the truth says that it counts and the
//! picture hits geometry there. Over the evaluated pixels, with *shadowed* as the positive answer:
//!
//! | score | definition |
//! |---|---|
//! | intersection over union | pixels shadowed in both / pixels shadowed in either |
//! | precision, recall | pixels shadowed in both / pixels shadowed in the picture, in the truth |
//! | leak | pixels shadowed in the truth and lit in the picture / pixels shadowed in the truth |
//! | acne | pixels lit in the truth and shadowed in the picture / pixels lit in the truth |
//!
//! Each is given for the [`BANDS`]: band 0 holds all evaluated pixels, band *k* leaves out those nearer than *k*
//! pixels to a shadow edge. Contact leak is leak over the pixels that something very near shadows, without those on
//! an edge. Soft errors are those of the grey itself against the visible part of a light with an extent; the penumbra
//! is where that is between 0.02 and 0.98. A score whose denominator is zero does not exist, and no limit on it is met.

use super::alignment::alignment_hint;
use super::error::TruthError;
use super::scene::TruthScene;
use crate::image::Picture;

/// The bands for which scores are given: band `k` contains the pixels at least `k` pixels from a shadow edge.
pub const BANDS: [u8; 4] = [0, 1, 2, 4];

/// The numbers of pixels in one band, by agreement with the ray-traced reference.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BandScore {
    /// Pixels in shadow in the reference and in the picture.
    pub shadowed_in_both: u64,
    /// Pixels in shadow in the reference but lit in the picture: light leaks.
    pub leaking: u64,
    /// Pixels lit in the reference but in shadow in the picture: shadow acne.
    pub acne: u64,
    /// Pixels lit in the reference and in the picture.
    pub lit_in_both: u64,
}

impl BandScore {
    /// Pixels in shadow in reference and picture, divided by pixels in shadow in at least one of them.
    ///
    /// `None` if no pixel is in shadow.
    pub fn intersection_over_union(&self) -> Option<f64> {
        ratio(self.shadowed_in_both, self.shadowed_in_both + self.leaking + self.acne)
    }

    /// Pixels in shadow in reference and picture, divided by all in shadow in the picture; `None` if divided by 0.
    pub fn precision(&self) -> Option<f64> {
        ratio(self.shadowed_in_both, self.shadowed_in_both + self.acne)
    }

    /// Pixels in shadow in reference and picture, divided by all in shadow in the reference; `None` if divided by 0.
    pub fn recall(&self) -> Option<f64> {
        ratio(self.shadowed_in_both, self.shadowed_in_both + self.leaking)
    }

    /// Pixels wrongly lit, divided by all pixels in shadow in the reference; `None` if the divisor is 0.
    pub fn leak(&self) -> Option<f64> {
        ratio(self.leaking, self.shadowed_in_both + self.leaking)
    }

    /// Pixels wrongly in shadow, divided by all pixels lit in the reference; `None` if the divisor is 0.
    pub fn acne(&self) -> Option<f64> {
        ratio(self.acne, self.acne + self.lit_in_both)
    }

    /// The number of pixels in the band.
    pub fn pixels(&self) -> u64 {
        self.shadowed_in_both + self.leaking + self.acne + self.lit_in_both
    }

    pub(super) fn count(&mut self, answer: Answer) {
        match answer {
            Answer::ShadowedInBoth => self.shadowed_in_both += 1,
            Answer::Leaking => self.leaking += 1,
            Answer::Acne => self.acne += 1,
            Answer::LitInBoth => self.lit_in_both += 1,
        }
    }
}

/// The errors of a picture against the ray-traced visible fraction of an area light, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftScore {
    /// The mean absolute error.
    pub mean_error: f64,
    /// The mean absolute error in the penumbra; `None` if there is no penumbra.
    pub in_penumbra: Option<f64>,
    /// The mean absolute error outside of the penumbra; `None` if there are no such pixels.
    pub outside_penumbra: Option<f64>,
    /// The mean signed difference: positive if the picture is too bright.
    pub bias: f64,
}

/// All scores of one picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scores {
    /// Pixels that hit geometry in reference and picture, divided by those in the reference; `None` if there are none.
    pub both_hit: Option<f64>,
    /// The number of pixels that hit geometry only in the picture.
    pub hit_in_picture_only: u64,
    /// The scores for each of the [`BANDS`], in the same order.
    pub bands: [BandScore; BANDS.len()],
    /// The scores over contact shadow pixels; `None` if the scene has no contact mask.
    pub contact: Option<BandScore>,
    /// The errors against an area light; `None` if the scene has no mask for it.
    pub soft: Option<SoftScore>,
    /// A mistake, such as an upside-down picture, whose correction would improve the score much; a hint that does not
    /// affect the result.
    pub alignment_hint: Option<&'static str>,
}

impl Scores {
    /// Returns the scores of a band; `None` if it is not one of the [`BANDS`].
    pub fn band(&self, band: u8) -> Option<&BandScore> {
        BANDS.iter().position(|&candidate| candidate == band).map(|index| &self.bands[index])
    }

    /// The light leak over contact shadow pixels; `None` if there are none.
    pub fn contact_leak(&self) -> Option<f64> {
        self.contact.and_then(|contact| contact.leak())
    }
}

/// The result of comparing a pixel with the ray-traced reference.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Answer {
    ShadowedInBoth,
    Leaking,
    Acne,
    LitInBoth,
}

impl Answer {
    pub(super) fn new(shadowed_in_truth: bool, shadowed_in_picture: bool) -> Self {
        match (shadowed_in_truth, shadowed_in_picture) {
            (true, true) => Self::ShadowedInBoth,
            (true, false) => Self::Leaking,
            (false, true) => Self::Acne,
            (false, false) => Self::LitInBoth,
        }
    }
}

/// The hits and shadows in a rendered picture, one value per pixel.
pub(super) struct Mask {
    pub(super) hit: Vec<bool>,
    pub(super) shadowed: Vec<bool>,
}

/// Scores a picture of raw visibility (255 is lit, 0 is in shadow), rendered with the scene's camera.
pub fn evaluate(scene: &TruthScene, picture: &Picture) -> Result<Scores, TruthError> {
    let mask = Mask::new(scene, picture)?;
    let pixels = 0..scene.hit.len();
    let count = |holds: &dyn Fn(usize) -> bool| pixels.clone().filter(|&pixel| holds(pixel)).count() as u64;
    let mut bands = [BandScore::default(); BANDS.len()];
    let mut contact = BandScore::default();
    for pixel in pixels.clone().filter(|&pixel| scene.evaluated[pixel] && mask.hit[pixel]) {
        let answer = Answer::new(!scene.lit[pixel], mask.shadowed[pixel]);
        for (score, band) in bands.iter_mut().zip(BANDS) {
            if scene.band[pixel] >= band {
                score.count(answer);
            }
        }
        let touched = scene.contact.get(pixel).copied().unwrap_or(false);
        if touched && scene.band[pixel] >= 1 && !scene.lit[pixel] {
            contact.count(answer);
        }
    }
    Ok(Scores {
        both_hit: ratio(
            count(&|pixel| scene.hit[pixel] && mask.hit[pixel]),
            count(&|pixel| scene.hit[pixel]),
        ),
        hit_in_picture_only: count(&|pixel| !scene.hit[pixel] && mask.hit[pixel]),
        bands,
        contact: (!scene.contact.is_empty()).then_some(contact),
        soft: soft(scene, picture, &mask),
        alignment_hint: alignment_hint(scene, &mask, bands[0].intersection_over_union()),
    })
}

fn soft(scene: &TruthScene, picture: &Picture, mask: &Mask) -> Option<SoftScore> {
    let mut sums = [(0.0, 0_u64); 2];
    let mut bias = 0.0;
    for (pixel, (truth, rendered)) in scene.soft.iter().zip(picture.rgba_pixels()).enumerate() {
        if scene.evaluated[pixel] && mask.hit[pixel] {
            let truth = f64::from(*truth) / 255.0;
            let difference = f64::from(rendered[0]) / 255.0 - truth;
            let (sum, count) = &mut sums[usize::from(truth > 0.02 && truth < 0.98)];
            *sum += difference.abs();
            *count += 1;
            bias += difference;
        }
    }
    let [outside, inside] = sums;
    let mean = |sum: f64, count: u64| (count > 0).then(|| sum / count as f64);
    let count = outside.1 + inside.1;
    Some(SoftScore {
        mean_error: mean(outside.0 + inside.0, count)?,
        in_penumbra: mean(inside.0, inside.1),
        outside_penumbra: mean(outside.0, outside.1),
        bias: mean(bias, count)?,
    })
}

impl Mask {
    pub(super) fn new(scene: &TruthScene, picture: &Picture) -> Result<Self, TruthError> {
        let actual = (picture.width(), picture.height());
        if actual != scene.size() {
            return Err(TruthError::PictureSize { expected: scene.size(), actual });
        }
        let mut mask = Self { hit: Vec::new(), shadowed: Vec::new() };
        for (index, [red, green, blue, alpha]) in picture.rgba_pixels().enumerate() {
            if red.abs_diff(green) > 1 || red.abs_diff(blue) > 1 {
                let width = scene.width as usize;
                return Err(TruthError::NotGrey { x: (index % width) as u32, y: (index / width) as u32 });
            }
            mask.hit.push(alpha >= 128);
            mask.shadowed.push(red < 128);
        }
        Ok(mask)
    }
}

fn ratio(part: u64, whole: u64) -> Option<f64> {
    (whole != 0).then(|| part as f64 / whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Channels;
    use crate::truth::scene::half_shadowed;

    fn picture(scene: &TruthScene) -> Picture {
        let bytes = scene.lit.iter().map(|&lit| if lit { 255 } else { 0 });
        let bytes =
            bytes.zip(&scene.hit).flat_map(|(grey, &hit)| [grey, if hit { 255 } else { 0 }]).collect();
        Picture::new(scene.width, scene.height, Channels::GreyAlpha, bytes).unwrap()
    }

    fn paint(picture: &mut Picture, row: u32, columns: std::ops::Range<u32>, grey: u8) {
        for x in columns {
            picture.pixel_mut(x, row).unwrap()[0] = grey;
        }
    }

    #[test]
    fn the_truth_itself_is_perfect() {
        let scene = half_shadowed();
        let scores = evaluate(&scene, &picture(&scene)).unwrap();
        assert_eq!(scores.both_hit, Some(1.0));
        assert_eq!(scores.hit_in_picture_only, 0);
        assert_eq!(scores.bands.map(|band| band.pixels()), [64, 48, 48, 16]);
        for band in scores.bands {
            assert_eq!(band.intersection_over_union(), Some(1.0));
            assert_eq!((band.leak(), band.acne()), (Some(0.0), Some(0.0)));
        }
        assert_eq!(scores.contact_leak(), Some(0.0));
        assert_eq!(scores.alignment_hint, None);
    }

    #[test]
    fn leaks_and_acne_are_counted_in_the_bands_they_lie_in() {
        let scene = half_shadowed();
        let mut picture = picture(&scene);
        paint(&mut picture, 3, 0..2, 255);
        paint(&mut picture, 1, 0..1, 255);
        paint(&mut picture, 5, 0..3, 0);
        let scores = evaluate(&scene, &picture).unwrap();
        let all = scores.band(0).unwrap();
        assert_eq!((all.leaking, all.acne), (3, 3));
        assert_eq!(all.intersection_over_union(), Some(29.0 / 35.0));
        assert_eq!((all.precision(), all.recall()), (Some(29.0 / 32.0), Some(29.0 / 32.0)));
        assert_eq!((all.leak(), all.acne()), (Some(3.0 / 32.0), Some(3.0 / 32.0)));
        let inner = scores.band(2).unwrap();
        assert_eq!((inner.leaking, inner.acne), (1, 3));
        let innermost = scores.band(4).unwrap();
        assert_eq!((innermost.leaking, innermost.acne), (0, 0));
        assert_eq!(scores.band(3), None);
    }

    #[test]
    fn contact_leak_counts_only_near_shadows_off_the_edge() {
        let mut scene = half_shadowed();
        let mut picture = picture(&scene);
        paint(&mut picture, 2, 0..2, 255);
        assert_eq!(evaluate(&scene, &picture).unwrap().contact_leak(), Some(0.25));
        scene.band[2 * 8] = 0;
        assert_eq!(evaluate(&scene, &picture).unwrap().contact_leak(), Some(1.0 / 7.0));
        scene.contact.clear();
        assert_eq!(evaluate(&scene, &picture).unwrap().contact_leak(), None);
    }

    #[test]
    fn missed_geometry_lowers_the_hits_and_is_not_evaluated() {
        let scene = half_shadowed();
        let mut picture = picture(&scene);
        for x in 0..8 {
            picture.pixel_mut(x, 0).unwrap()[1] = 0;
        }
        let scores = evaluate(&scene, &picture).unwrap();
        assert_eq!(scores.both_hit, Some(56.0 / 64.0));
        assert_eq!(scores.bands[0].pixels(), 56);
    }

    #[test]
    fn extra_geometry_is_reported_but_not_evaluated() {
        let mut scene = half_shadowed();
        let picture = picture(&scene);
        scene.hit[0] = false;
        scene.evaluated[0] = false;
        let scores = evaluate(&scene, &picture).unwrap();
        assert_eq!(scores.hit_in_picture_only, 1);
        assert_eq!(scores.both_hit, Some(1.0));
        assert_eq!(scores.bands[0].pixels(), 63);
    }

    #[test]
    fn soft_errors_are_of_the_grey_in_penumbra_and_elsewhere() {
        let mut scene = half_shadowed();
        let mut picture = picture(&scene);
        paint(&mut picture, 0, 0..8, 255);
        let soft = evaluate(&scene, &picture).unwrap().soft.unwrap();
        // Two rows of eight are penumbra, 0.2 off in either direction; of the other six one is wrong.
        assert!((soft.in_penumbra.unwrap() - 0.2).abs() < 1e-12);
        assert!((soft.outside_penumbra.unwrap() - 1.0 / 6.0).abs() < 1e-12);
        assert!((soft.mean_error - (2.0 * 0.2 + 1.0) / 8.0).abs() < 1e-12);
        assert!((soft.bias - 1.0 / 8.0).abs() < 1e-12);
        scene.soft.clear();
        assert_eq!(evaluate(&scene, &picture).unwrap().soft, None);
    }

    #[test]
    fn half_is_where_shadow_and_hit_begin() {
        let scene = half_shadowed();
        for (grey, shadowed) in [(127, 64), (128, 0)] {
            let picture = Picture::filled(8, 8, Channels::GreyAlpha, &[grey, 128]);
            let all = evaluate(&scene, &picture).unwrap().bands[0];
            assert_eq!(all.shadowed_in_both + all.acne, shadowed, "{grey}");
        }
        let missed = Picture::filled(8, 8, Channels::GreyAlpha, &[0, 127]);
        assert_eq!(evaluate(&scene, &missed).unwrap().both_hit, Some(0.0));
    }

    #[test]
    fn a_score_without_pixels_does_not_exist() {
        let mut scene = half_shadowed();
        scene.lit = vec![true; 64];
        let scores = evaluate(&scene, &Picture::filled(8, 8, Channels::Grey, &[255])).unwrap();
        assert_eq!(scores.bands[0].intersection_over_union(), None);
        assert_eq!(scores.bands[0].leak(), None);
        assert_eq!(scores.bands[0].acne(), Some(0.0));
    }

    #[test]
    fn a_picture_of_another_size_or_with_colour_has_no_score() {
        let scene = half_shadowed();
        let small = Picture::filled(8, 7, Channels::Grey, &[0]);
        assert!(matches!(evaluate(&scene, &small), Err(TruthError::PictureSize { actual: (8, 7), .. })));
        let mut coloured = Picture::filled(8, 8, Channels::Rgb, &[9, 10, 10]);
        assert!(evaluate(&scene, &coloured).is_ok());
        coloured.pixel_mut(3, 6).unwrap()[2] = 11;
        assert!(matches!(evaluate(&scene, &coloured), Err(TruthError::NotGrey { x: 3, y: 6 })));
    }
}
