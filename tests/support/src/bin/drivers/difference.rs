//! The pixels in which two pictures differ, by cause.
//!
//! A pixel of a picture that differs by more than a level counts as one of:
//!
//! * **edge**: within a pixel of a place where the reference's depth or shadow term jumps; which side of an edge the middle
//!   of a pixel is on is the rounding of a driver;
//! * **filtering**: the shadow terms of both agree there, so that only textures, which drivers filter with other
//!   precision, or what else is shaded, differ; or the value lies between those of the reference's neighbours;
//! * **unexplained**: what is left.

use umbragraph_test_support::image::Picture;

/// A jump of the shadow term, in levels of 255.
const JUMP: i32 = 24;
/// A jump of depth, as a part of the depth itself; pictures of depth are scaled to their own range.
const DEPTH_JUMP: i32 = 3;

/// A case as one driver and as the reference drew it.
pub(crate) struct Pair<'a> {
    /// The picture of the reference, and its shadow term and depth.
    pub(crate) reference: &'a Picture,
    /// The shadow term of the reference.
    pub(crate) shadow: &'a Picture,
    /// The depth of the reference.
    pub(crate) depth: Option<&'a Picture>,
    /// The picture that is compared.
    pub(crate) picture: &'a Picture,
    /// Its shadow term.
    pub(crate) own_shadow: &'a Picture,
}

/// Numbers of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Difference {
    /// All.
    pub(crate) pixels: usize,
    /// Those that differ by more than 2 levels.
    pub(crate) beyond_2: usize,
    /// Those that differ by more than 8 levels, by cause.
    pub(crate) edge: usize,
    /// See the module.
    pub(crate) filtering: usize,
    /// See the module.
    pub(crate) unexplained: usize,
}

impl Difference {
    /// The difference of a pair; pictures of other sizes differ everywhere.
    pub(crate) fn of(pair: &Pair<'_>) -> Self {
        let (width, height) = (pair.reference.width() as usize, pair.reference.height() as usize);
        let size = |picture: &Picture| (picture.width() as usize, picture.height() as usize);
        let mut difference = Self { pixels: width * height, ..Self::default() };
        if [pair.shadow, pair.picture, pair.own_shadow].iter().any(|one| size(one) != (width, height)) {
            (difference.beyond_2, difference.unexplained) = (width * height, width * height);
            return difference;
        }
        let texels = |picture: &Picture| picture.rgba_pixels().collect::<Vec<_>>();
        let [reference, shadow, picture, own] =
            [pair.reference, pair.shadow, pair.picture, pair.own_shadow].map(texels);
        let depth = pair.depth.filter(|depth| size(depth) == (width, height)).map(texels);
        for at in 0..width * height {
            let by = apart(reference[at], picture[at]);
            difference.beyond_2 += usize::from(by > 2);
            if by <= 8 {
                continue;
            }
            let around = neighbours(at, width, height);
            let jumps = |texels: &[[u8; 4]], by: i32| spread(around.iter().map(|at| texels[*at])) > by;
            let is_edge =
                jumps(&shadow, JUMP) || depth.as_ref().is_some_and(|depth| jumps(depth, DEPTH_JUMP));
            let lies_between = (0..3).all(|channel| {
                let values = around.iter().map(|at| i32::from(reference[*at][channel]));
                let (min, max) = values.fold((255, 0), |(min, max), value| (min.min(value), max.max(value)));
                (min - 2..=max + 2).contains(&i32::from(picture[at][channel]))
            });
            if is_edge {
                difference.edge += 1;
            } else if lies_between || apart(shadow[at], own[at]) <= 8 {
                difference.filtering += 1;
            } else {
                difference.unexplained += 1;
            }
        }
        difference
    }

    /// The sum of two.
    #[must_use]
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            beyond_2: self.beyond_2 + other.beyond_2,
            edge: self.edge + other.edge,
            filtering: self.filtering + other.filtering,
            unexplained: self.unexplained + other.unexplained,
        }
    }

    /// The share of some pixels, as a percentage.
    pub(crate) fn percent(&self, count: usize) -> f64 {
        count as f64 * 100.0 / self.pixels.max(1) as f64
    }
}

/// The largest difference of a color channel.
fn apart(a: [u8; 4], b: [u8; 4]) -> i32 {
    (0..3).map(|channel| i32::from(a[channel]).abs_diff(i32::from(b[channel])) as i32).max().unwrap_or(0)
}

/// The largest spread of a channel, alpha included.
fn spread(texels: impl Iterator<Item = [u8; 4]>) -> i32 {
    let none = ([255; 4], [0; 4]);
    let (min, max) = texels.fold(none, |(mut min, mut max), texel| {
        for channel in 0..4 {
            min[channel] = min[channel].min(texel[channel]);
            max[channel] = max[channel].max(texel[channel]);
        }
        (min, max)
    });
    (0..4).map(|channel| i32::from(max[channel]) - i32::from(min[channel])).max().unwrap_or(0)
}

/// A pixel and those around it, as positions.
fn neighbours(at: usize, width: usize, height: usize) -> Vec<usize> {
    let (x, y) = (at % width, at / width);
    let mut all = Vec::with_capacity(9);
    for row in y.saturating_sub(1)..(y + 2).min(height) {
        all.extend((x.saturating_sub(1)..(x + 2).min(width)).map(|column| row * width + column));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbragraph_test_support::image::Channels;

    /// A grey picture of 8 by 8 with some other pixels.
    fn picture(others: &[(u32, u32, u8)]) -> Picture {
        let mut picture = Picture::filled(8, 8, Channels::Rgba, &[100, 100, 100, 255]);
        for (x, y, value) in others {
            picture.pixel_mut(*x, *y).unwrap()[..3].fill(*value);
        }
        picture
    }

    fn causes(shadow: &Picture, own_shadow: &Picture) -> [usize; 3] {
        let (reference, other) = (picture(&[]), picture(&[(4, 4, 200)]));
        let pair = Pair { reference: &reference, shadow, depth: None, picture: &other, own_shadow };
        let found = Difference::of(&pair);
        assert_eq!((found.pixels, found.beyond_2), (64, 1));
        [found.edge, found.filtering, found.unexplained]
    }

    #[test]
    fn a_pixel_has_one_cause() {
        let (plain, edge) = (picture(&[]), picture(&[(5, 5, 0)]));
        assert_eq!(causes(&edge, &edge), [1, 0, 0]);
        assert_eq!(causes(&plain, &plain), [0, 1, 0]);
        assert_eq!(causes(&plain, &picture(&[(4, 4, 0)])), [0, 0, 1]);
    }

    #[test]
    fn values_between_neighbours_are_filtering() {
        let reference = picture(&[(3, 4, 250)]);
        let other = picture(&[(3, 4, 250), (4, 4, 200)]);
        let (shadow, own_shadow) = (picture(&[]), picture(&[(4, 4, 0)]));
        let pair = Pair {
            reference: &reference,
            shadow: &shadow,
            depth: None,
            picture: &other,
            own_shadow: &own_shadow,
        };
        assert_eq!(Difference::of(&pair).filtering, 1);
    }
}
