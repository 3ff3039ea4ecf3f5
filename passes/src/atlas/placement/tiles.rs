//! The tiles that lights hold in the atlas.
//!
//! Sizes are processed from the largest down. A tile that its light keeps does not move; any other takes a free place.
//! If none is free although the decided sizes fit, the block with the least used area is cleared; its smaller tiles are
//! placed again when their size is processed.

use super::{Placement, Scratch};
use crate::atlas::request::{Eviction, Fate};
use crate::atlas::tile::Tile;

impl Placement {
    /// Allocates the tiles of each admitted light in an atlas with a side of `side` texels. Releases the tiles of
    /// evicted lights.
    pub(super) fn place_tiles(&mut self, side: u32) {
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.pending.iter_mut().for_each(Vec::clear);
        for candidate in &scratch.candidates {
            let (at, count) = (candidate.entry as usize, candidate.need.tiles as u8);
            let entry = &self.entries[at];
            let Ok(class) = candidate.verdict else {
                self.release_tiles(at);
                continue;
            };
            if entry.held_tiles != count || entry.held_class != class {
                self.release_tiles(at);
                self.entries[at].held_tiles = count;
                self.entries[at].held_class = class;
            }
            for position in 0..count {
                let tile = &mut self.entries[at].tiles[usize::from(position)];
                if tile.size != 0 && tile.x.max(tile.y) >= side {
                    self.atlas.release(std::mem::replace(tile, Tile::NONE));
                }
                if tile.size == 0 {
                    scratch.pending[usize::from(class)].push((candidate.entry, position));
                }
            }
        }
        let resized = self.atlas.set_side(side);
        debug_assert!(resized, "no tile lies beyond the side");
        for class in (0..scratch.pending.len()).rev() {
            self.place_class(class, &mut scratch);
        }
        self.scratch = scratch;
    }

    /// Places all pending tiles of one size class. Smaller tiles that must make room become pending in their own class.
    fn place_class(&mut self, class: usize, scratch: &mut Scratch) {
        let size = self.settings.min_tile << class;
        let pending = std::mem::take(&mut scratch.pending[class]);
        let mut next_block = None;
        for (entry, position) in &pending {
            let (at, position) = (*entry as usize, usize::from(*position));
            // A tile of a light that found no room before.
            if position >= usize::from(self.entries[at].held_tiles) {
                continue;
            }
            let tile = self.atlas.allocate(size).or_else(|| {
                let block = next_block.unwrap_or_else(|| {
                    self.find_blocks(class, scratch);
                    0
                });
                next_block = Some(block + 1);
                self.clear_block(block, scratch);
                self.atlas.allocate(size)
            });
            match tile {
                Some(tile) => self.entries[at].tiles[position] = tile,
                // The areas that were decided on fit, so that this is for safety only.
                None => {
                    debug_assert!(false, "a tile of {size} texels does not fit");
                    self.release_tiles(at);
                    self.entries[at].fate = Fate::Evicted(Eviction::AtlasFull);
                    self.fates_changed = true;
                }
            }
        }
        scratch.pending[class] = pending;
    }

    /// Lists the blocks of one size class that contain smaller tiles, in ascending order of the used area.
    fn find_blocks(&self, class: usize, scratch: &mut Scratch) {
        let Scratch { movable, blocks, .. } = scratch;
        movable.clear();
        for (at, entry) in self.entries.iter().enumerate() {
            let held = usize::from(entry.held_class);
            if entry.seen == 0 || held >= class {
                continue;
            }
            for (position, tile) in entry.tiles[..usize::from(entry.held_tiles)].iter().enumerate() {
                if tile.size != 0 {
                    let number = tile.number();
                    movable.push((number >> (2 * (class - held)), number, at as u32, position as u8));
                }
            }
        }
        movable.sort_unstable();
        blocks.clear();
        let mut start = 0;
        for part in movable.chunk_by(|a, b| a.0 == b.0) {
            let area = part
                .iter()
                .map(|(_, _, at, position)| self.entries[*at as usize].tiles[usize::from(*position)].area());
            blocks.push((area.sum(), part[0].0, start, start + part.len()));
            start += part.len();
        }
        blocks.sort_unstable();
    }

    /// Releases all tiles in the block at index `block` of `scratch.blocks`, and makes them pending.
    fn clear_block(&mut self, block: usize, scratch: &mut Scratch) {
        let Some((_, _, start, end)) = scratch.blocks.get(block).copied() else { return };
        for (_, _, entry, position) in &scratch.movable[start..end] {
            let at = *entry as usize;
            let tile = &mut self.entries[at].tiles[usize::from(*position)];
            self.atlas.release(std::mem::replace(tile, Tile::NONE));
            scratch.pending[usize::from(self.entries[at].held_class)].push((*entry, *position));
        }
    }

    pub(super) fn release_tiles(&mut self, at: usize) {
        for tile in &mut self.entries[at].tiles {
            self.atlas.release(std::mem::replace(tile, Tile::NONE));
        }
        self.entries[at].held_tiles = 0;
    }
}
