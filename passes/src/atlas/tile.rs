//! A square of an atlas.

/// A square of texels. Its side is a power of two, and its corner a multiple of its side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tile {
    /// The leftmost texel.
    pub x: u32,
    /// The uppermost texel.
    pub y: u32,
    /// The texels on a side; 0 for no tile.
    pub size: u32,
}

impl Tile {
    /// No tile.
    pub const NONE: Self = Self { x: 0, y: 0, size: 0 };

    /// The tile as a view's viewport: x, y, width, height in texels.
    pub fn viewport(self) -> [u32; 4] {
        [self.x, self.y, self.size, self.size]
    }

    /// The number of texels.
    pub fn area(self) -> u64 {
        u64::from(self.size) * u64::from(self.size)
    }

    /// Its number among the tiles of its size along the Z-shaped curve, which visits the four quarters of a square one
    /// after the other: whatever lies in a block has numbers that begin with the block's.
    pub(super) fn number(self) -> usize {
        let scale = self.size.max(1).trailing_zeros();
        spread(self.x >> scale) | spread(self.y >> scale) << 1
    }

    /// The tile of a number and a size.
    pub(super) fn of_number(number: usize, size: u32) -> Self {
        Self { x: gather(number) * size, y: gather(number >> 1) * size, size }
    }
}

/// Sixteen bits, with a zero after each.
fn spread(value: u32) -> usize {
    let mut value = value & 0xffff;
    value = (value | value << 8) & 0x00ff_00ff;
    value = (value | value << 4) & 0x0f0f_0f0f;
    value = (value | value << 2) & 0x3333_3333;
    value = (value | value << 1) & 0x5555_5555;
    value as usize
}

/// Every second bit.
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
        /// Whether two tiles have texels in common.
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
