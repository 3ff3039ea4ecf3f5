//! An allocator of square tiles: buddies in four.
//!
//! The atlas is a quadtree: a free square is split into four quarters until one has the requested size, and four free
//! quarters merge again. Each size has a set of its free squares, numbered along a Z-order curve. An allocation takes
//! the smallest free square that is large enough, with the lowest number among equals; so the same calls always give
//! the same tiles. Allocation and release cost a few steps for each size in between.
//!
//! On that curve an atlas of half the side is the first quarter: the atlas grows and shrinks in place.
//!
//! Limits: sizes are rounded up to powers of two; a release of an unallocated tile is rejected. A request can fail
//! although the free area suffices, since tiles are never moved here (see [`super::placement`]).

use super::bits::Bits;
use super::tile::Tile;
use super::{MAX_SIDE, MIN_TILE};

/// An allocator of square tiles in a square atlas: a quadtree of free squares.
#[derive(Clone, Debug)]
pub struct TileAllocator {
    /// The side of the smallest tile, in texels.
    pub(super) min: u32,
    max_side: u32,
    /// The side of the atlas, in texels; 0 for an atlas without room for any tile.
    pub(super) side: u32,
    /// The free squares, as numbers along a Z-order curve: a set for each size class, from the smallest.
    free: Vec<Bits>,
    /// The allocated tiles, as numbers along a Z-order curve: a set for each size class, from the smallest.
    used: Vec<Bits>,
    /// The number of texels in allocated tiles.
    pub(super) used_area: u64,
}

impl TileAllocator {
    /// Creates an allocator whose atlas has side 0. Tiles have at least `min` texels on a side, and the atlas grows up
    /// to `max_side` texels. Both numbers are rounded up to powers of two from [`MIN_TILE`] to [`MAX_SIDE`].
    pub fn new(min: u32, max_side: u32) -> Self {
        let within = |value: u32| value.clamp(MIN_TILE, MAX_SIDE).next_power_of_two();
        let min = within(min);
        let max_side = within(max_side).max(min);
        let sizes = (max_side / min).trailing_zeros() + 1;
        let sets: Vec<Bits> = (0..sizes)
            .map(|class| {
                let across = (max_side / (min << class)) as usize;
                Bits::new(across * across)
            })
            .collect();
        Self { min, max_side, side: 0, free: sets.clone(), used: sets, used_area: 0 }
    }

    /// Makes the atlas larger or smaller; tiles stay in place. `side`, in texels, is rounded down to a power of two and
    /// limited to the largest side; below the smallest tile it counts as 0. Returns `false`, and changes nothing, if a
    /// tile lies beyond the new side.
    #[must_use]
    pub fn set_side(&mut self, side: u32) -> bool {
        let wanted = self.rounded_side(side);
        if !self.is_free_beyond(wanted) {
            return false;
        }
        while self.side < wanted {
            self.double();
        }
        while self.side > wanted {
            self.halve();
        }
        true
    }

    /// The side in texels that the atlas gets for a requested side: rounded down to a power of two within the limits,
    /// or 0.
    pub(super) fn rounded_side(&self, side: u32) -> u32 {
        let side = side.min(self.max_side);
        if side < self.min { 0 } else { 1 << side.ilog2() }
    }

    fn double(&mut self) {
        if self.side == 0 {
            self.side = self.min;
            self.free[0].insert(0);
            return;
        }
        let class = self.class(self.side);
        self.side *= 2;
        if self.free[class].contains(0) {
            self.free[class].remove(0);
            self.free[class + 1].insert(0);
        } else {
            (1..4).for_each(|quarter| self.free[class].insert(quarter));
        }
    }

    fn halve(&mut self) {
        let class = self.class(self.side);
        let whole = self.free[class].contains(0);
        self.free[class].remove(0);
        if class == 0 {
            self.side = 0;
            return;
        }
        self.side /= 2;
        (1..4).for_each(|quarter| self.free[class - 1].remove(quarter));
        if whole {
            self.free[class - 1].insert(0);
        }
    }

    fn is_free_beyond(&self, side: u32) -> bool {
        if self.used_area == 0 {
            return true;
        }
        let (mut class, last) = (self.class(self.side), self.class(side.max(self.min)));
        if side == 0 {
            return false;
        }
        while class > last {
            class -= 1;
            if !(1..4).all(|quarter| self.free[class].contains(quarter)) {
                // Nothing of an atlas that is in use is one free square with its first quarter.
                return false;
            }
        }
        true
    }

    /// The size class of a square with a side of `size` texels: 0 for the smallest tile, 1 more for each doubling.
    fn class(&self, size: u32) -> usize {
        (size / self.min).max(1).trailing_zeros() as usize
    }

    /// Allocates a tile with at least `size` texels a side; `None` if no square of the size is free.
    #[must_use]
    pub fn allocate(&mut self, size: u32) -> Option<Tile> {
        let size = size.max(self.min).checked_next_power_of_two()?;
        if size > self.side {
            return None;
        }
        let class = self.class(size);
        let (mut found, mut number) = (class..=self.class(self.side))
            .find_map(|class| self.free[class].first().map(|number| (class, number)))?;
        self.free[found].remove(number);
        while found > class {
            found -= 1;
            number *= 4;
            (1..4).for_each(|quarter| self.free[found].insert(number + quarter));
        }
        self.used[class].insert(number);
        let tile = Tile::of_number(number, size);
        self.used_area += tile.area();
        Some(tile)
    }

    /// Returns `true` if exactly this tile is allocated.
    pub fn contains(&self, tile: Tile) -> bool {
        tile.size >= self.min
            && tile.size <= self.side
            && tile.size.is_power_of_two()
            && (tile.x | tile.y).is_multiple_of(tile.size)
            && tile.x.max(tile.y) < self.side
            && self.used[self.class(tile.size)].contains(tile.number())
    }

    /// Releases a tile. Returns false, and changes nothing, if it is not allocated.
    pub fn release(&mut self, tile: Tile) -> bool {
        if !self.contains(tile) {
            return false;
        }
        let (mut class, mut number) = (self.class(tile.size), tile.number());
        self.used[class].remove(number);
        self.used_area -= tile.area();
        let root = self.class(self.side);
        while class < root {
            let first = number & !3;
            let all_free =
                (first..first + 4).all(|buddy| buddy == number || self.free[class].contains(buddy));
            if !all_free {
                break;
            }
            (first..first + 4).for_each(|buddy| self.free[class].remove(buddy));
            number /= 4;
            class += 1;
        }
        self.free[class].insert(number);
        true
    }
}
