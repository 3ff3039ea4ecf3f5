//! Requests of lights, and their grants.

use std::fmt;

use super::tile::Tile;

/// A key that identifies a light from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(pub u64);

impl Key {
    /// The key for a light's name: a hash that is the same on every machine (FNV-1a, finished by the mixer of
    /// `SplitMix64`). `occurrence` counts lights of the same name from 0.
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

/// A kind of limited resource for shadows, other than texels of the atlas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Pool {
    /// Shadow descriptors: elements of the array in which shaders find a light's shadow maps.
    Descriptors,
    /// Views from which shadow casters are drawn.
    Views,
    /// Cubes of the cube texture array, for point lights.
    Cubes,
    /// Layers of the texture array, for the cascades of directional lights.
    Layers,
    /// Spot lights with tiles of the atlas.
    Spots,
}

/// The number of pools.
pub const POOLS: usize = 5;

/// A number of slots for each pool; the index is `Pool as usize`.
pub type PoolCounts = [u32; POOLS];

impl Pool {
    /// All pools, in the order of their indices.
    pub const ALL: [Self; POOLS] = [Self::Descriptors, Self::Views, Self::Cubes, Self::Layers, Self::Spots];

    /// Builds the counts from pairs of a pool and a number; all other pools get 0.
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

/// The tiles of the atlas that a light requests; all tiles of a light have the same size.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileRequest {
    /// The number of tiles, at most [`super::MAX_TILES`].
    pub count: u32,
    /// The preferred side of each tile, in texels; rounded up to a power of two.
    pub wanted: u32,
    /// The smallest acceptable side of each tile, in texels; rounded up to a power of two. A light that cannot get it
    /// has no shadow.
    pub min: u32,
}

impl TileRequest {
    /// The request for no tiles.
    pub const NONE: Self = Self { count: 0, wanted: 0, min: 0 };
}

/// The request of a light in a frame. Requests of the same key count as one with the maximum of each value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// The light that makes the request.
    pub key: Key,
    /// The importance of the light: greater values are served first, and equal ones by ascending key. NaN and negative
    /// values count as 0.
    pub importance: f32,
    /// The requested tiles of the atlas.
    pub tiles: TileRequest,
    /// The number of slots requested in each pool; the slots of one light are contiguous.
    pub slots: PoolCounts,
}

/// The reason why a light gets no tiles and slots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Eviction {
    /// More important lights fill the atlas, each at the smallest size that it accepts.
    AtlasFull,
    /// The light's tiles, at their smallest size, do not fit even into an empty atlas.
    AtlasTooSmall,
    /// More important lights leave too few slots of the pool.
    PoolFull(Pool),
    /// The light needs more slots than the pool has.
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
    /// The light gets all that it requests.
    Granted,
    /// The light gets smaller tiles than it requests, since the atlas has no room for larger ones.
    Downsized {
        /// The requested side of a tile in texels, rounded up to a power of two.
        from: u32,
        /// The granted side of a tile, in texels.
        to: u32,
    },
    /// The light gets nothing, for this reason.
    Evicted(Eviction),
}

/// The tiles and slots that a light gets in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grant<'a> {
    /// The outcome of the request.
    pub fate: Fate,
    /// The granted tiles of the atlas; empty if the light requested none or was evicted.
    pub tiles: &'a [Tile],
    /// The index of the light's first slot in each pool; its other slots follow. Meaningless for a pool in which the
    /// light requested no slots, and for an evicted light.
    pub first_slots: PoolCounts,
}
