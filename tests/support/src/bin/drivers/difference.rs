//! The pixels in which two pictures differ, by cause.
//!
//! A pixel of a picture that differs by more than 8 levels counts as one of:
//!
//! * **edge**: within a pixel of a discontinuity of the reference: its depth or normal ([`creases`]), its shadow term,
//!   or, in debug views and lessons, what they show themselves; which side of an edge the middle of a pixel is on is
//!   the rounding of a driver;
//! * **filtering**: the difference is gone where both draw the scene with textures that are sampled at the nearest
//!   texel;
//! * **placement**: no further than 8 levels from what the reference itself draws there once its camera is turned by a
//!   small part of a pixel to each side ([`crate::variant`]): a rasterizer with few bits for parts of a pixel moves
//!   surfaces as far, and a step at which the picture jumps (a cell of noise, a texel of a shadow map) then lies on
//!   another side;
//! * **unexplained**: what is left.

use umbragraph_test_support::image::Picture;

/// The minimum spread of neighbouring pixels that counts as an edge, in 8-bit levels.
const JUMP: i32 = 24;
/// The minimum change of slope that counts as a crease, as a fraction of the slope itself.
const CREASE: f32 = 0.3;
/// The rounding error of depth, as a fraction of the depth.
const ROUNDING: f32 = 1e-6;

/// The picture of one driver and that of the reference driver, with data that explains differences.
pub(crate) struct Pair<'a> {
    pub(crate) reference: &'a Picture,
    pub(crate) picture: &'a Picture,
    /// Pictures of the reference driver whose discontinuities count as edges.
    pub(crate) jumps: Vec<&'a Picture>,
    /// The depth discontinuities of the scene, one value per pixel, row by row; `None` if unknown.
    pub(crate) creases: Option<&'a [bool]>,
    /// The reference's and the driver's picture with nearest-texel sampling; `None` if not rendered.
    pub(crate) nearest: Option<[&'a Picture; 2]>,
    /// Pictures of the reference driver with a slightly rotated camera.
    pub(crate) turned: Vec<&'a Picture>,
}

/// Numbers of differing pixels, by cause.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Difference {
    /// The number of all pixels.
    pub(crate) pixels: usize,
    /// Pixels that differ by more than 2 of 255 levels.
    pub(crate) beyond_2: usize,
    /// Pixels that differ by more than 8 levels and lie next to a discontinuity of the reference.
    pub(crate) edge: usize,
    /// Pixels that differ by more than 8 levels, but not with nearest-texel sampling.
    pub(crate) filtering: usize,
    /// Pixels that differ by more than 8 levels, but fit the reference with a slightly rotated camera.
    pub(crate) placement: usize,
    /// Pixels that differ by more than 8 levels for another reason.
    pub(crate) unexplained: usize,
}

impl Difference {
    /// Counts the differing pixels of a pair; in pictures of different sizes all pixels differ.
    pub(crate) fn of(pair: &Pair<'_>) -> Self {
        let size = |picture: &Picture| (picture.width() as usize, picture.height() as usize);
        let (width, height) = size(pair.reference);
        let mut difference = Self { pixels: width * height, ..Self::default() };
        let is_whole = |picture: &&Picture| size(picture) == (width, height);
        if !is_whole(&pair.picture) {
            (difference.beyond_2, difference.unexplained) = (width * height, width * height);
            return difference;
        }
        let [reference, picture] = [pair.reference, pair.picture].map(texels);
        let shown: Vec<_> = pair.jumps.iter().copied().filter(is_whole).map(texels).collect();
        let creases = pair.creases.filter(|creases| creases.len() == width * height);
        let nearest = pair.nearest.filter(|both| both.iter().all(is_whole)).map(|both| both.map(texels));
        let turned: Vec<_> = pair.turned.iter().copied().filter(is_whole).map(texels).collect();
        for at in 0..width * height {
            let by = apart(reference[at], picture[at]);
            difference.beyond_2 += usize::from(by > 2);
            if by <= 8 {
                continue;
            }
            let around = neighbours(at, width, height);
            let is_crease = creases.is_some_and(|creases| around.iter().any(|at| creases[*at]));
            let jumps = |texels: &Vec<[u8; 4]>| spread(around.iter().map(|at| texels[*at])) > JUMP;
            if is_crease || shown.iter().any(jumps) {
                difference.edge += 1;
            } else if nearest.as_ref().is_some_and(|[one, other]| apart(one[at], other[at]) <= 8) {
                difference.filtering += 1;
            } else if !turned.is_empty()
                && lies_among(
                    picture[at],
                    std::iter::once(&reference).chain(&turned).map(|texels| texels[at]),
                )
            {
                difference.placement += 1;
            } else {
                difference.unexplained += 1;
            }
        }
        difference
    }

    /// Returns the sum of two differences.
    #[must_use]
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            pixels: self.pixels + other.pixels,
            beyond_2: self.beyond_2 + other.beyond_2,
            edge: self.edge + other.edge,
            filtering: self.filtering + other.filtering,
            placement: self.placement + other.placement,
            unexplained: self.unexplained + other.unexplained,
        }
    }

    /// Returns a number of pixels as a percentage of all pixels.
    pub(crate) fn percent(&self, count: usize) -> f64 {
        count as f64 * 100.0 / self.pixels.max(1) as f64
    }
}

/// Finds the pixels at which depth jumps or its slope changes: silhouettes and creases. Projected depth is linear along
/// a flat surface, so its second difference is zero there.
pub(crate) fn creases(depth: &[f32], width: usize) -> Vec<bool> {
    let height = depth.len() / width.max(1);
    let mut creases = vec![false; depth.len()];
    let mut mark = |[before, at, after]: [usize; 3]| {
        let slopes = [depth[at] - depth[before], depth[after] - depth[at]];
        let slope = slopes[0].abs().max(slopes[1].abs());
        creases[at] |= (slopes[1] - slopes[0]).abs() > CREASE * slope + ROUNDING * depth[at].abs();
    };
    for y in 0..height {
        for x in 0..width {
            let at = y * width + x;
            if x > 0 && x + 1 < width {
                mark([at - 1, at, at + 1]);
            }
            if y > 0 && y + 1 < height {
                mark([at - width, at, at + width]);
            }
        }
    }
    creases
}

fn texels(picture: &Picture) -> Vec<[u8; 4]> {
    picture.rgba_pixels().collect()
}

/// Returns the largest difference of a color channel, in 8-bit levels.
fn apart(a: [u8; 4], b: [u8; 4]) -> i32 {
    (0..3).map(|channel| i32::from(a[channel]).abs_diff(i32::from(b[channel])) as i32).max().unwrap_or(0)
}

/// Returns `true` if each color channel of a texel is within 8 levels of the range of the others.
fn lies_among(texel: [u8; 4], others: impl Iterator<Item = [u8; 4]>) -> bool {
    let (min, max) = range(others);
    (0..3).all(|channel| {
        texel[channel] >= min[channel].saturating_sub(8) && texel[channel] <= max[channel].saturating_add(8)
    })
}

/// Returns the smallest and the largest value of each channel.
fn range(texels: impl Iterator<Item = [u8; 4]>) -> ([u8; 4], [u8; 4]) {
    texels.fold(([255; 4], [0; 4]), |(mut min, mut max), texel| {
        for channel in 0..4 {
            min[channel] = min[channel].min(texel[channel]);
            max[channel] = max[channel].max(texel[channel]);
        }
        (min, max)
    })
}

/// Returns the largest spread of a channel, alpha included, in 8-bit levels.
fn spread(texels: impl Iterator<Item = [u8; 4]>) -> i32 {
    let (min, max) = range(texels);
    (0..4).map(|channel| i32::from(max[channel]) - i32::from(min[channel])).max().unwrap_or(0)
}

/// Returns the indices of a pixel and of its up to eight neighbours.
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

    /// Returns a grey picture of 8 by 8 pixels with some pixels of other brightness.
    fn grey(others: &[(u32, u32, u8)]) -> Picture {
        let mut picture = Picture::filled(8, 8, Channels::Rgba, &[100, 100, 100, 255]);
        for (x, y, value) in others {
            picture.pixel_mut(*x, *y).unwrap()[..3].fill(*value);
        }
        picture
    }

    #[test]
    fn a_pixel_has_one_cause() {
        let (plain, other) = (grey(&[]), grey(&[(4, 4, 200)]));
        let shadow = grey(&[(5, 5, 0)]);
        let causes = |jumps: Vec<&Picture>, creases: Option<&[bool]>, nearest: Option<[&Picture; 2]>| {
            let pair =
                Pair { reference: &plain, picture: &other, jumps, creases, nearest, turned: vec![&plain] };
            let found = Difference::of(&pair);
            assert_eq!((found.pixels, found.beyond_2), (64, 1));
            [found.edge, found.filtering, found.placement, found.unexplained]
        };
        let mut crease = vec![false; 64];
        crease[3 * 8 + 3] = true;
        assert_eq!(causes(vec![&shadow], None, None), [1, 0, 0, 0]);
        assert_eq!(causes(vec![&plain], Some(&crease), None), [1, 0, 0, 0]);
        assert_eq!(causes(vec![&plain], None, Some([&plain, &plain])), [0, 1, 0, 0]);
        assert_eq!(causes(vec![&plain], None, Some([&plain, &other])), [0, 0, 0, 1]);
        assert_eq!(causes(Vec::new(), None, None), [0, 0, 0, 1]);
    }

    #[test]
    fn a_turned_camera_explains_what_lies_among_its_pictures() {
        let (reference, picture) = (grey(&[]), grey(&[(4, 4, 200)]));
        let found = |turned: &[Picture]| {
            let (reference, picture, turned) = (&reference, &picture, turned.iter().collect());
            let none = Pair { reference, picture, turned, jumps: Vec::new(), creases: None, nearest: None };
            let found = Difference::of(&none);
            [found.placement, found.unexplained]
        };
        assert_eq!(found(&[]), [0, 1]);
        let [much, less, elsewhere] = [(4, 4, 192), (4, 4, 191), (3, 4, 200)].map(|texel| grey(&[texel]));
        assert_eq!(found(&[elsewhere, much]), [1, 0]);
        assert_eq!(found(&[less]), [0, 1]);
    }

    #[test]
    fn silhouettes_and_edges_are_creases_and_flat_surfaces_are_not() {
        let row = |depth: &[f32]| depth.iter().copied().cycle().take(depth.len() * 3).collect::<Vec<_>>();
        let found = |depth: &[f32]| creases(&row(depth), depth.len())[depth.len()..2 * depth.len()].to_vec();
        assert_eq!(found(&[0.1, 0.11, 0.12, 0.13]), [false; 4]);
        assert_eq!(found(&[0.1, 0.11, 0.12, 0.5]), [false, false, true, false]);
        assert_eq!(found(&[0.12, 0.11, 0.12, 0.13]), [false, true, false, false]);
    }
}
