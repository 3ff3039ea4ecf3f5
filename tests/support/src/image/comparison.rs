//! Comparison of two pictures under a tolerance.
//!
//! A pixel fails when any of its channels, alpha included, differs by more than [`Tolerance::per_channel`]; the
//! pictures match when no more than [`Tolerance::failed_pixels`] pixels fail. A mean over the picture is left out
//! on purpose: it hides a few wholly wrong pixels among many right ones. Grey compares equal to the same grey in
//! RGB, and a missing alpha to an opaque one, so that an optimised reference file remains a reference.

use super::picture::{Channels, Picture};

/// The limits of differences within which two pictures still match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tolerance {
    /// The largest difference of a channel, in 8-bit levels, with which a pixel still passes.
    pub per_channel: u8,
    /// The number of pixels that may fail.
    pub failed_pixels: usize,
}

impl Tolerance {
    /// The tolerance that requires all bytes to be equal.
    pub const EXACT: Self = Self { per_channel: 0, failed_pixels: 0 };
}

/// The pixel with the largest difference of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MaxDifference {
    /// The difference of the most different channel, in 8-bit levels.
    pub amount: u8,
    /// The most different channel: `red`, `green`, `blue` or `alpha`.
    pub channel: &'static str,
    /// The column, from the left.
    pub x: u32,
    /// The row, from the top.
    pub y: u32,
    /// Red, green, blue and alpha of this pixel in the reference.
    pub reference: [u8; 4],
    /// Red, green, blue and alpha of this pixel in the actual picture.
    pub actual: [u8; 4],
}

/// The result of comparing two pictures.
#[must_use = "a comparison that nobody looks at lets every picture pass"]
#[derive(Clone, Debug)]
pub struct Comparison {
    tolerance: Tolerance,
    outcome: Outcome,
}

#[derive(Clone, Debug)]
enum Outcome {
    OtherSize { reference: (u32, u32), actual: (u32, u32) },
    Compared { pixels: usize, failed: usize, max: Option<MaxDifference>, difference: Picture },
}

const CHANNEL_NAMES: [&str; 4] = ["red", "green", "blue", "alpha"];

/// Compares a picture with its reference.
pub fn compare(reference: &Picture, actual: &Picture, tolerance: &Tolerance) -> Comparison {
    let sizes = ((reference.width(), reference.height()), (actual.width(), actual.height()));
    if sizes.0 != sizes.1 {
        let outcome = Outcome::OtherSize { reference: sizes.0, actual: sizes.1 };
        return Comparison { tolerance: *tolerance, outcome };
    }
    let (width, height) = sizes.0;
    let mut failed = 0;
    let mut max: Option<MaxDifference> = None;
    let mut difference = Picture::filled(width, height, Channels::Rgb, &[0; 3]);
    let mut places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    for (expected, found) in reference.rgba_pixels().zip(actual.rgba_pixels()) {
        let Some((x, y)) = places.next() else { break };
        let amounts: [u8; 4] = std::array::from_fn(|channel| expected[channel].abs_diff(found[channel]));
        let (mut channel, mut amount) = (0, 0);
        for (index, &candidate) in amounts.iter().enumerate() {
            if candidate > amount {
                (channel, amount) = (index, candidate);
            }
        }
        if amount > max.map_or(0, |max| max.amount) {
            max = Some(MaxDifference {
                amount,
                channel: CHANNEL_NAMES[channel],
                x,
                y,
                reference: expected,
                actual: found,
            });
        }
        let fails = amount > tolerance.per_channel;
        failed += usize::from(fails);
        if let Some(pixel) = difference.pixel_mut(x, y) {
            pixel.copy_from_slice(&difference_colour(expected, amount, fails));
        }
    }
    let pixels = width as usize * height as usize;
    Comparison { tolerance: *tolerance, outcome: Outcome::Compared { pixels, failed, max, difference } }
}

/// Returns the color of a pixel in the difference picture: red for failing, green for within the tolerance, else the
/// darkened reference.
fn difference_colour(reference: [u8; 4], amount: u8, fails: bool) -> [u8; 3] {
    // A difference of one must still be seen.
    let strength = 128 + amount / 2;
    match (fails, amount) {
        (true, _) => [strength, 0, 0],
        (false, 0) => {
            let sum: u16 = reference[..3].iter().map(|&value| u16::from(value)).sum();
            [(sum / 12) as u8; 3]
        }
        (false, _) => [0, strength, 0],
    }
}

impl Comparison {
    /// Returns `true` if the pictures match within the tolerance.
    pub fn matches(&self) -> bool {
        match &self.outcome {
            Outcome::OtherSize { .. } => false,
            Outcome::Compared { failed, .. } => *failed <= self.tolerance.failed_pixels,
        }
    }

    /// Returns the number of pixels beyond the tolerance; `None` if the sizes differ.
    pub fn failed_pixels(&self) -> Option<usize> {
        match &self.outcome {
            Outcome::OtherSize { .. } => None,
            Outcome::Compared { failed, .. } => Some(*failed),
        }
    }

    /// Returns the largest difference; `None` if the pictures are equal or their sizes differ.
    pub fn max_difference(&self) -> Option<MaxDifference> {
        match &self.outcome {
            Outcome::OtherSize { .. } => None,
            Outcome::Compared { max, .. } => *max,
        }
    }

    /// Returns a picture of the differences; `None` if the sizes differ.
    ///
    /// Red pixels fail, green ones differ within the tolerance, the rest is the reference, darkened.
    pub fn difference_picture(&self) -> Option<&Picture> {
        match &self.outcome {
            Outcome::OtherSize { .. } => None,
            Outcome::Compared { difference, .. } => Some(difference),
        }
    }

    /// Returns a message that describes the result.
    pub fn message(&self) -> String {
        match &self.outcome {
            Outcome::OtherSize { reference, actual } => format!(
                "the reference is {}x{} pixels, the actual picture {}x{}",
                reference.0, reference.1, actual.0, actual.1
            ),
            Outcome::Compared { max: None, pixels, .. } => format!("all {pixels} pixels are the same"),
            Outcome::Compared { max: Some(max), pixels, failed, .. } => format!(
                "{failed} of {pixels} pixels differ by more than {} ({} may); the largest difference is {} in \
                 {} at column {}, row {}: reference {:?}, actual {:?}",
                self.tolerance.per_channel,
                self.tolerance.failed_pixels,
                max.amount,
                max.channel,
                max.x,
                max.y,
                max.reference,
                max.actual,
            ),
        }
    }

    /// Fails the test unless the pictures match.
    ///
    /// # Panics
    /// With [`message`](Self::message), if they do not.
    #[track_caller]
    pub fn expect_match(&self) {
        assert!(self.matches(), "the pictures do not match: {}", self.message());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient() -> Picture {
        let bytes = (0..16 * 8 * 4).map(|index| (index * 7 % 251) as u8).collect();
        Picture::new(16, 8, Channels::Rgba, bytes).unwrap()
    }

    fn with_pixel(x: u32, y: u32, change: impl Fn(&mut [u8])) -> Picture {
        let mut picture = gradient();
        change(picture.pixel_mut(x, y).unwrap());
        picture
    }

    #[test]
    fn a_picture_matches_itself_exactly() {
        let comparison = compare(&gradient(), &gradient(), &Tolerance::EXACT);
        assert!(comparison.matches());
        assert_eq!(comparison.failed_pixels(), Some(0));
        assert_eq!(comparison.max_difference(), None);
    }

    #[test]
    fn one_corrupted_pixel_is_found_with_its_place() {
        let corrupted = with_pixel(11, 5, |pixel| pixel[1] ^= 0x40);
        let comparison = compare(&gradient(), &corrupted, &Tolerance::EXACT);
        assert!(!comparison.matches());
        assert_eq!(comparison.failed_pixels(), Some(1));
        let max = comparison.max_difference().unwrap();
        assert_eq!((max.amount, max.channel, max.x, max.y), (64, "green", 11, 5));
        let message = comparison.message();
        assert!(message.contains("1 of 128 pixels") && message.contains("column 11, row 5"), "{message}");
    }

    #[test]
    fn the_difference_picture_marks_the_corrupted_pixel_only() {
        let corrupted = with_pixel(3, 2, |pixel| pixel[0] ^= 1);
        let comparison = compare(&gradient(), &corrupted, &Tolerance::EXACT);
        let difference = comparison.difference_picture().unwrap();
        let red: Vec<usize> = difference
            .rgba_pixels()
            .enumerate()
            .filter(|(_, pixel)| pixel[0] >= 128 && pixel[1] == 0)
            .map(|(index, _)| index)
            .collect();
        assert_eq!(red, [2 * 16 + 3]);
    }

    #[test]
    fn a_difference_in_alpha_alone_fails() {
        let corrupted = with_pixel(0, 7, |pixel| pixel[3] ^= 0x80);
        let comparison = compare(&gradient(), &corrupted, &Tolerance { per_channel: 100, failed_pixels: 0 });
        assert!(!comparison.matches());
        assert_eq!(comparison.max_difference().unwrap().channel, "alpha");
    }

    #[test]
    fn the_tolerance_of_a_channel_is_inclusive() {
        let corrupted = with_pixel(4, 4, |pixel| pixel[2] ^= 4);
        for (per_channel, expected) in [(3, false), (4, true)] {
            let tolerance = Tolerance { per_channel, failed_pixels: 0 };
            assert_eq!(compare(&gradient(), &corrupted, &tolerance).matches(), expected, "{per_channel}");
        }
    }

    #[test]
    fn as_many_pixels_as_allowed_may_fail_and_no_more() {
        let mut corrupted = gradient();
        for x in 0..3 {
            corrupted.pixel_mut(x, 0).unwrap()[0] ^= 0x80;
        }
        for (failed_pixels, expected) in [(2, false), (3, true)] {
            let tolerance = Tolerance { per_channel: 0, failed_pixels };
            assert_eq!(compare(&gradient(), &corrupted, &tolerance).matches(), expected, "{failed_pixels}");
        }
    }

    #[test]
    fn pictures_of_other_sizes_never_match() {
        let everything = Tolerance { per_channel: 255, failed_pixels: usize::MAX };
        let wide = Picture::filled(4, 2, Channels::Grey, &[0]);
        let tall = Picture::filled(2, 4, Channels::Grey, &[0]);
        let comparison = compare(&wide, &tall, &everything);
        assert!(!comparison.matches());
        assert!(comparison.message().contains("4x2") && comparison.message().contains("2x4"));
    }

    #[test]
    fn grey_equals_rgb_grey_but_transparent_is_not_opaque() {
        let grey = Picture::filled(3, 3, Channels::Grey, &[90]);
        let colour = Picture::filled(3, 3, Channels::Rgb, &[90; 3]);
        let transparent = Picture::filled(3, 3, Channels::GreyAlpha, &[90, 0]);
        assert!(compare(&grey, &colour, &Tolerance::EXACT).matches());
        assert!(!compare(&grey, &transparent, &Tolerance::EXACT).matches());
    }

    #[test]
    #[should_panic(expected = "the pictures do not match")]
    fn an_expected_match_that_is_none_fails_the_test() {
        let corrupted = with_pixel(1, 1, |pixel| pixel[0] ^= 1);
        compare(&gradient(), &corrupted, &Tolerance::EXACT).expect_match();
    }
}
