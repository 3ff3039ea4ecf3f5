//! Well distributed random numbers: the Sobol sequence in two dimensions, scrambled and shuffled anew for each pair of
//! dimensions (B. Burley, "Practical hash-based Owen scrambling", Journal of Computer Graphics Techniques 9.4, 2020).
//!
//! Pixels, and pairs of dimensions of a pixel, are independent of one another; the samples of a pair cover the square
//! evenly after each power of two. The same seed gives the same numbers.

use glam::DVec2;

/// The random numbers of one sample of a pixel, drawn in pairs.
#[derive(Clone, Copy, Debug)]
pub struct Sequence {
    seed: u32,
    index: u32,
    pair: u32,
}

impl Sequence {
    /// The numbers of the sample `index` of a pixel.
    pub fn new(seed: u64, pixel: usize, index: u32) -> Self {
        let pixel = pixel as u64;
        let words = [seed as u32, (seed >> 32) as u32, pixel as u32, (pixel >> 32) as u32];
        Self { seed: words.into_iter().fold(0x9e37_79b9, combined), index, pair: 0 }
    }

    /// The next two numbers, each at least 0 and below 1.
    pub fn pair(&mut self) -> DVec2 {
        self.pair += 1;
        let seed = combined(self.seed, self.pair);
        let index = scrambled(self.index, seed);
        let [x, y] = sobol(index);
        let part = |bits: u32, seed: u32| f64::from(scrambled(bits, seed)) / 4_294_967_296.0;
        DVec2::new(part(x, combined(seed, 1)), part(y, combined(seed, 2)))
    }
}

/// Mixes a word into a hash (the finaliser of MurmurHash3, A. Appleby).
fn combined(hash: u32, word: u32) -> u32 {
    let mut x = hash.rotate_left(5) ^ word.wrapping_mul(0x9e37_79b1);
    x = (x ^ (x >> 16)).wrapping_mul(0x85eb_ca6b);
    x = (x ^ (x >> 13)).wrapping_mul(0xc2b2_ae35);
    x ^ (x >> 16)
}

/// The first two dimensions of the Sobol sequence, as parts of 2³².
fn sobol(index: u32) -> [u32; 2] {
    let (mut second, mut direction, mut rest) = (0, 1_u32 << 31, index);
    while rest != 0 {
        if rest & 1 != 0 {
            second ^= direction;
        }
        direction ^= direction >> 1;
        rest >>= 1;
    }
    [index.reverse_bits(), second]
}

/// Owen's nested uniform scrambling, by a hash of Laine and Karras with Burley's constants.
fn scrambled(bits: u32, seed: u32) -> u32 {
    let mut x = bits.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c_u32, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_samples_lie_in_sixteen_cells() {
        for (pixel, skipped) in [(0, 0), (7, 1), (123_456, 3)] {
            for [columns, rows] in [[4.0, 4.0], [16.0, 1.0], [2.0, 8.0]] {
                let mut cells = [0; 16];
                for index in 0..16 {
                    let mut sequence = Sequence::new(3, pixel, index);
                    for _ in 0..skipped {
                        sequence.pair();
                    }
                    let at = sequence.pair();
                    assert!(at.min_element() >= 0.0 && at.max_element() < 1.0, "{at}");
                    cells[((at.x * columns).floor() + columns * (at.y * rows).floor()) as usize] += 1;
                }
                assert_eq!(cells, [1; 16], "pixel {pixel}");
            }
        }
    }

    #[test]
    fn pairs_pixels_and_seeds_are_independent() {
        let correlation = |one: fn(u32) -> f64, other: fn(u32) -> f64| {
            (0..4096).map(|at| (one(at) - 0.5) * (other(at) - 0.5) * 12.0).sum::<f64>() / 4096.0
        };
        let first = |at: u32| Sequence::new(1, 5, at).pair().x;
        let second = |at: u32| {
            let mut sequence = Sequence::new(1, 5, at);
            sequence.pair();
            sequence.pair().x
        };
        assert!(correlation(first, first) > 0.9);
        assert!(correlation(first, second).abs() < 0.06);
        assert!(correlation(first, |at| Sequence::new(1, 6, at).pair().x).abs() < 0.06);
        assert!(correlation(first, |at| Sequence::new(2, 5, at).pair().x).abs() < 0.06);
    }
}
