//! Allocation of shadow maps: tiles of the atlas for lights, and slots of all other limited resources.
//!
//! The problem: the lights that cast shadows change from frame to frame, and there is not room for all of them at their
//! wanted sizes. A light must keep its tile while it does not change (its map may be cached). No light may lose its
//! shadow because of its position in a list. Each loss is reported with the light's name and the reason.
//!
//! The algorithm, one step to a file:
//!
//! 1. [`request`]: what a light asks for and what it gets;
//! 2. `settle`: importances and sizes follow what is asked only when it changes by more than a tolerance, so that what
//!    wobbles decides nothing;
//! 3. `decide`: from the settled numbers alone, most important light first, who is let in and at which size. Square
//!    tiles whose sides are powers of two fill a square without a gap whenever their areas add up to no more than
//!    its area (largest first), so that this needs no geometry, and neither history nor the order of the lights;
//! 4. [`quadtree`]: the tiles themselves; lights whose size stays keep theirs. Where free space is enough but
//!    scattered, the blocks with the least in them are cleared by moving their (smaller) tiles elsewhere;
//! 5. [`slots`]: runs of slots for descriptors, views, cubes, layers and spots, kept likewise;
//! 6. `follow`: the sizes that would be enough for all, up at once and down after some calm frames.
//!
//! [`placement`] puts the steps together. All of it is on the CPU; a frame in which nothing settles again costs one
//! pass over the requests and takes nothing from the heap.
//!
//! Limits: tiles from [`MIN_TILE`] to [`MAX_TILE`] texels, atlases to [`MAX_SIDE`], at most
//! [`MAX_TILES`] tiles to one light, all of one size.
//!
//! Sources: Knowlton, "A Fast Storage Allocator" (1965) for the buddies; Morton, "A Computer Oriented Geodetic Data
//! Base" (1966) for their order.

mod bits;
mod decide;
mod follow;
pub mod placement;
pub mod quadtree;
pub mod request;
mod settle;
pub mod slots;
pub mod tile;

#[cfg(test)]
mod tests;

pub use placement::{Capacity, Placement, Settings};
pub use quadtree::TileAllocator;
pub use request::{Eviction, Fate, Grant, Key, POOLS, Pool, PoolCounts, Request, TileRequest};
pub use slots::SlotAllocator;
pub use tile::Tile;

/// The minimum number of texels on a tile's side.
pub const MIN_TILE: u32 = 16;
/// The maximum number of texels on a tile's side.
pub const MAX_TILE: u32 = 8192;
/// The maximum number of texels on an atlas's side.
pub const MAX_SIDE: u32 = 16384;
/// The maximum number of tiles of one light: eight cascades, or six faces of a cube.
pub const MAX_TILES: usize = 8;
