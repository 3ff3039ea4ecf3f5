//! Requests of lights, and their grants.

use std::fmt;

use super::tile::Tile;

/// The identity of a light over frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(pub u64);

impl Key {
    /// The key of a light by its name; `occurrence` counts lights of the same name from 0. It is the same on every
    /// machine (FNV-1a, finished by the mixer of `SplitMix64`).
    pub fn of(name: &str, occurrence: u32) -> Self {
        let bytes = name.bytes().chain(occurrence.to_le_bytes());
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        let hash = (hash ^ hash >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let hash = (hash ^ hash >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self(hash ^ hash >> 31)
    }
}

/// Something of which there is a limited number, besides texels of the atlas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Pool {
    /// Entries of the array by which shaders find a light's shadow.
    Descriptors,
    /// Views that casters are drawn from.
    Views,
    /// Cubes of a cube array.
    Cubes,
    /// Layers of an array.
    Layers,
    /// Spots, which have tiles of the atlas.
    Spots,
}

/// The number of pools.
pub const POOLS: usize = 5;

/// A number for each pool, at `Pool as usize`.
pub type PoolCounts = [u32; POOLS];

impl Pool {
    /// All of them.
    pub const ALL: [Self; POOLS] = [Self::Descriptors, Self::Views, Self::Cubes, Self::Layers, Self::Spots];

    /// Numbers for some pools, 0 for the others.
    pub fn counts(of: &[(Self, u32)]) -> PoolCounts {
        let mut counts = [0; POOLS];
        for (pool, count) in of {
            counts[*pool as usize] = *count;
        }
        counts
    }
}

impl fmt::Display for Pool {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Descriptors => "descriptors",
            Self::Views => "views",
            Self::Cubes => "cubes",
            Self::Layers => "layers",
            Self::Spots => "spots",
        })
    }
}

/// The tiles that a light asks for; all of them get one size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileRequest {
    /// The number of tiles, at most [`super::MAX_TILES`].
    pub count: u32,
    /// The texels on a side that would be right; rounded up to a power of two.
    pub wanted: u32,
    /// The texels on a side below which no shadow is better than this one; rounded up to a power of two.
    pub min: u32,
}

impl TileRequest {
    /// None.
    pub const NONE: Self = Self { count: 0, wanted: 0, min: 0 };
}

/// The request of a light in a frame. Requests of the same key count as one with the maximum of each value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// The light that makes the request.
    pub key: Key,
    /// The order of service: higher numbers first, then lower keys. NaN and negative numbers count as 0.
    pub importance: f32,
    /// The tiles of the atlas.
    pub tiles: TileRequest,
    /// The slots of each pool; those of one light follow one another.
    pub slots: PoolCounts,
}

/// Why a light gets nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Eviction {
    /// More important lights fill the atlas, each at the smallest size that it accepts.
    AtlasFull,
    /// Even alone its tiles are too large for the atlas.
    AtlasTooSmall,
    /// More important lights take all slots of the pool.
    PoolFull(Pool),
    /// Even alone it needs more slots than the pool has.
    PoolTooSmall(Pool),
}

impl fmt::Display for Eviction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtlasFull => f.write_str("more important lights fill the shadow atlas"),
            Self::AtlasTooSmall => f.write_str("the shadow atlas is smaller than its smallest tiles"),
            Self::PoolFull(pool) => write!(f, "more important lights take all shadow {pool}"),
            Self::PoolTooSmall(pool) => write!(f, "it needs more shadow {pool} than there are"),
        }
    }
}

/// The outcome of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fate {
    /// It gets all that it asks for.
    Granted,
    /// It gets smaller tiles, since the atlas has no room for larger ones.
    Downsized {
        /// The texels on a side that it asks for (as a power of two).
        from: u32,
        /// The texels on a side that it gets.
        to: u32,
    },
    /// It gets nothing.
    Evicted(Eviction),
}

/// The grant of a light in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grant<'a> {
    /// The outcome of the request.
    pub fate: Fate,
    /// Its tiles; empty if it was evicted.
    pub tiles: &'a [Tile],
    /// The first slot of each pool; the others follow. Meaningless if it requested none or was evicted.
    pub first_slots: PoolCounts,
}
