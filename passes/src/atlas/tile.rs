//! A square of an atlas.

/// A square of texels in an atlas. Its side is a power of two, and the coordinates of its corner are multiples of its
/// side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tile {
    /// The x coordinate of the leftmost texels.
    pub x: u32,
    /// The y coordinate of the uppermost texels.
    pub y: u32,
    /// The side, in texels; 0 for no tile.
    pub size: u32,
}

impl Tile {
    /// The value that stands for no tile.
    pub const NONE: Self = Self { x: 0, y: 0, size: 0 };

    /// The tile as a view's viewport: x, y, width, height in texels.
    pub fn viewport(self) -> [u32; 4] {
        [self.x, self.y, self.size, self.size]
    }

    /// The area, in texels.
    pub fn area(self) -> u64 {
        u64::from(self.size) * u64::from(self.size)
    }

    /// The number of the tile among all tiles of its size along a Z-order curve (Morton order). Two bits less at the
    /// end give the number of the enclosing tile of twice the side.
    pub(super) fn number(self) -> usize {
        let scale = self.size.max(1).trailing_zeros();
        spread(self.x >> scale) | spread(self.y >> scale) << 1
    }

    /// The tile with a number along the Z-order curve; `size` is its side in texels.
    pub(super) fn of_number(number: usize, size: u32) -> Self {
        Self { x: gather(number) * size, y: gather(number >> 1) * size, size }
    }
}

/// Spreads the lower 16 bits to the even bit positions, with a zero bit between any two.
fn spread(value: u32) -> usize {
    let mut value = value & 0xffff;
    value = (value | value << 8) & 0x00ff_00ff;
    value = (value | value << 4) & 0x0f0f_0f0f;
    value = (value | value << 2) & 0x3333_3333;
    value = (value | value << 1) & 0x5555_5555;
    value as usize
}

/// Gathers the bits at even positions in the lower 16 bits: the inverse of `spread`.
fn gather(value: usize) -> u32 {
    let mut value = value as u32 & 0x5555_5555;
    value = (value | value >> 1) & 0x3333_3333;
    value = (value | value >> 2) & 0x0f0f_0f0f;
    value = (value | value >> 4) & 0x00ff_00ff;
    (value | value >> 8) & 0xffff
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Tile {
        /// Returns `true` if two tiles have texels in common.
        pub(in crate::atlas) fn overlaps(self, other: Self) -> bool {
            self.x < other.x + other.size
                && other.x < self.x + self.size
                && self.y < other.y + other.size
                && other.y < self.y + self.size
        }
    }

    #[test]
    fn numbers_lead_back_to_tiles_and_begin_with_their_blocks() {
        for number in (0..1 << 20).step_by(977) {
            let tile = Tile::of_number(number, 16);
            assert_eq!(tile.number(), number);
            let block = Tile::of_number(number >> 4, 64);
            assert!(block.overlaps(tile), "{block:?} {tile:?}");
        }
    }
}
