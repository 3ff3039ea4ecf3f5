//! Tiles and slots for the lights of each frame; see [`super`] for the algorithm.
//!
//! Call [`Placement::update`] once for each frame with all requests, then get the [`Grant`] of each by its position.
//! All grants fit the [`Capacity`] of the frame: the existing atlas and arrays. [`Placement::wanted`] is the capacity
//! that the requests need, up to the limits in [`Settings`]. If the host follows it, a later frame has room for more.
//!
//! Stability: a light keeps its tiles while its committed importance, size and number of tiles stay, unless the atlas
//! is so full that one of its tiles must make room for a larger one. Two placements grant the same for the same
//! requests in any order.

mod slots;
mod tiles;

use std::collections::HashMap;

use super::decide::{Candidate, decide};
use super::follow::Follower;
use super::quadtree::TileAllocator;
use super::request::{Fate, Grant, Key, POOLS, PoolCounts, Request};
use super::settle::{self, Settled};
use super::slots::{MAX_SLOTS, SlotAllocator};
use super::tile::Tile;
use super::{MAX_SIDE, MAX_TILE, MAX_TILES, MIN_TILE};

/// The settings of a [`Placement`]; they are constant over frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The minimum number of texels on a tile's side; a power of two, at least [`MIN_TILE`].
    pub min_tile: u32,
    /// The maximum number of texels on a tile's side; a power of two, at most [`MAX_TILE`].
    pub max_tile: u32,
    /// The minimum side of the atlas that [`Placement::wanted`] returns, in texels; a power of two.
    pub min_side: u32,
    /// The maximum side of the atlas that [`Placement::wanted`] returns, in texels; a power of two, at most
    /// [`MAX_SIDE`].
    pub max_side: u32,
    /// The maximum number of slots of each pool that [`Placement::wanted`] returns.
    pub max_pools: PoolCounts,
    /// The relative change of an importance or a size up to which a new value is ignored; 0.25 means 25 %.
    pub tolerance: f32,
    /// The number of consecutive frames with a lower need after which [`Placement::wanted`] falls.
    pub patience: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            min_tile: MIN_TILE,
            max_tile: MAX_TILE,
            min_side: 256,
            max_side: 8192,
            max_pools: [256, 256, 16, 16, 256],
            tolerance: 0.25,
            patience: 60,
        }
    }
}

/// The capacity for shadow maps in a frame: the side of the atlas, and the number of slots of each pool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capacity {
    /// The side of the atlas, in texels: rounded down to a power of two, and 0 (no atlas) below the smallest tile.
    pub side: u32,
    /// The number of slots of each pool, at most [`MAX_SLOTS`].
    pub pools: PoolCounts,
}

/// Places the shadow maps of lights, frame after frame.
#[derive(Clone, Debug)]
pub struct Placement {
    /// The settings, clamped to their limits.
    pub(super) settings: Settings,
    /// The size class of the largest tile: `min_tile << max` texels on a side.
    max: u8,
    pub(super) atlas: TileAllocator,
    pools: [SlotAllocator; POOLS],
    entries: Vec<Entry>,
    vacant: Vec<u32>,
    by_key: HashMap<Key, u32>,
    /// The index in `entries` for each request of the last update.
    asked: Vec<u32>,
    frame: u64,
    /// The capacity for which the last update placed the lights, rounded and clamped to its limits.
    pub(super) capacity: Capacity,
    need: Capacity,
    wanted: Capacity,
    side_follower: Follower,
    pool_followers: [Follower; POOLS],
    fates_changed: bool,
    scratch: Scratch,
}

/// Buffers that each update reuses.
#[derive(Clone, Debug, Default)]
struct Scratch {
    order: Vec<(u32, Key, u32)>,
    candidates: Vec<Candidate>,
    /// The tiles to place, for each size class: the index of the entry, and the index of the tile in the entry.
    pending: Vec<Vec<(u32, u8)>>,
    /// The tiles that could be moved: number of the enclosing block, number of the tile, index of the entry, index of
    /// the tile in the entry.
    movable: Vec<(usize, usize, u32, u8)>,
    /// The blocks that could be cleared: used area in texels, number of the block, start and end of its tiles in
    /// `movable`.
    blocks: Vec<(u64, usize, usize, usize)>,
    /// The runs of slots to place again: first slot so far, key of the light, index of the entry.
    runs: Vec<(u32, Key, u32)>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    /// The number of the frame in which the light last made a request; 0 for a vacant entry.
    seen: u64,
    /// The request of this frame. Several requests with the same key are merged to the maximum of each value.
    asked: Request,
    /// The values of the request after hysteresis, on which all decisions depend; `None` before the first decision.
    settled: Option<Settled>,
    fate: Fate,
    /// The tiles that the light holds. `held_class` is their size class, and `held_tiles` their number.
    tiles: [Tile; MAX_TILES],
    held_class: u8,
    held_tiles: u8,
    /// The number of slots that the light holds in each pool. `first_slots` has the index of the first one.
    held_slots: PoolCounts,
    first_slots: PoolCounts,
}

impl Placement {
    /// An empty placement. Settings beyond the limits are clamped.
    pub fn new(settings: Settings) -> Self {
        let power = |value: u32, low: u32, high: u32| value.clamp(low, high).next_power_of_two().min(high);
        let min_tile = power(settings.min_tile, MIN_TILE, MAX_TILE);
        let min_side = power(settings.min_side, min_tile, MAX_SIDE);
        let settings = Settings {
            min_tile,
            max_tile: power(settings.max_tile, min_tile, MAX_TILE),
            min_side,
            max_side: power(settings.max_side, min_side, MAX_SIDE),
            tolerance: if settings.tolerance > 0.0 { settings.tolerance.min(100.0) } else { 0.0 },
            ..settings
        };
        let max = settle::class_of(settings.max_tile, min_tile, u8::MAX);
        let atlas = TileAllocator::new(min_tile, settings.max_side);
        Self {
            settings,
            max,
            atlas,
            pools: Default::default(),
            entries: Vec::new(),
            vacant: Vec::new(),
            by_key: HashMap::new(),
            asked: Vec::new(),
            frame: 0,
            capacity: Capacity::default(),
            need: Capacity::default(),
            wanted: Capacity::default(),
            side_follower: Follower::default(),
            pool_followers: Default::default(),
            fates_changed: false,
            scratch: Scratch { pending: vec![Vec::new(); usize::from(max) + 1], ..Scratch::default() },
        }
    }

    /// Grants tiles and slots to the lights of a frame, for `requests` and within `capacity`.
    pub fn update(&mut self, requests: &[Request], capacity: &Capacity) {
        self.frame += 1;
        self.fates_changed = false;
        self.gather(requests);
        let changed = self.settle();
        let capacity = Capacity {
            side: self.atlas.rounded_side(capacity.side),
            pools: capacity.pools.map(|slots| slots.min(MAX_SLOTS)),
        };
        if changed || capacity != self.capacity || self.frame == 1 {
            self.decide(&capacity);
            self.place_tiles(capacity.side);
            self.place_slots(&capacity.pools);
            self.capacity = capacity;
        }
        self.follow();
    }

    /// The grant for the request at index `request` of the last update; `None` if there is no such request.
    pub fn grant(&self, request: usize) -> Option<Grant<'_>> {
        let at = *self.asked.get(request)? as usize;
        let entry = &self.entries[at];
        Some(Grant {
            fate: entry.fate,
            tiles: &entry.tiles[..usize::from(entry.held_tiles)],
            first_slots: entry.first_slots,
        })
    }

    /// The grants of all requests of the last update, in their order.
    pub fn grants(&self) -> impl Iterator<Item = Grant<'_>> {
        (0..self.asked.len()).filter_map(|at| self.grant(at))
    }

    /// The capacity that would be enough for all requests, within the limits of the settings. It rises at once and
    /// falls after some frames.
    pub fn wanted(&self) -> &Capacity {
        &self.wanted
    }

    /// Returns `true` if the last update changed the fate of a light, or if lights came or went.
    pub fn fates_changed(&self) -> bool {
        self.fates_changed
    }

    /// Finds or creates the entry of each request. Merges requests with the same key to the maximum of each value.
    fn gather(&mut self, requests: &[Request]) {
        self.asked.resize(requests.len(), u32::MAX);
        for (at, request) in requests.iter().enumerate() {
            // Most frames have the lights in the order of the frame before; none of its entries is vacant yet.
            let before = self.asked[at];
            let same = self.entries.get(before as usize).is_some_and(|entry| entry.asked.key == request.key);
            let found = if same { Some(before) } else { self.by_key.get(&request.key).copied() };
            let found = found.unwrap_or_else(|| self.insert(request));
            self.asked[at] = found;
            let entry = &mut self.entries[found as usize];
            let (most, tiles) = (&mut entry.asked, request.tiles);
            if entry.seen == self.frame {
                most.importance = most.importance.max(request.importance);
                most.tiles.count = most.tiles.count.max(tiles.count);
                most.tiles.wanted = most.tiles.wanted.max(tiles.wanted);
                most.tiles.min = most.tiles.min.max(tiles.min);
                most.slots.iter_mut().zip(request.slots).for_each(|(max, count)| *max = count.max(*max));
            } else {
                entry.seen = self.frame;
                *most = *request;
            }
        }
    }

    fn insert(&mut self, request: &Request) -> u32 {
        let entry = Entry {
            // Not 0, which a vacant entry has, and not this frame.
            seen: u64::MAX,
            asked: *request,
            settled: None,
            fate: Fate::Granted,
            tiles: [Tile::NONE; MAX_TILES],
            held_class: 0,
            held_tiles: 0,
            held_slots: [0; POOLS],
            first_slots: [0; POOLS],
        };
        let at = self.vacant.pop().unwrap_or(self.entries.len() as u32);
        if at as usize == self.entries.len() {
            self.entries.push(entry);
        } else {
            self.entries[at as usize] = entry;
        }
        self.by_key.insert(request.key, at);
        self.fates_changed = true;
        at
    }

    /// Releases lights without requests, and applies hysteresis to the requests of the others. Returns `true` if
    /// anything changed.
    fn settle(&mut self) -> bool {
        let mut changed = false;
        for at in 0..self.entries.len() {
            let entry = self.entries[at];
            if entry.seen == 0 {
                continue;
            }
            if entry.seen != self.frame {
                self.remove(at);
                changed = true;
                continue;
            }
            let before = entry.settled;
            let unit = self.settings.min_tile;
            let tolerance = self.settings.tolerance;
            let Request { importance, tiles, slots, .. } = entry.asked;
            let min = settle::class_of(tiles.min, unit, self.max);
            let wanted =
                settle::class(before.map(|before| before.wanted), tiles.wanted, unit, self.max, tolerance);
            let settled = Settled {
                importance: settle::importance(before.map(|before| before.importance), importance, tolerance),
                wanted: wanted.max(min),
                min,
                tiles: tiles.count.min(MAX_TILES as u32),
                slots,
            };
            if before != Some(settled) {
                self.entries[at].settled = Some(settled);
                changed = true;
            }
        }
        changed
    }

    fn remove(&mut self, at: usize) {
        self.release_tiles(at);
        for pool in 0..POOLS {
            self.release_slots(at, pool);
        }
        let entry = &mut self.entries[at];
        entry.seen = 0;
        self.by_key.remove(&entry.asked.key);
        self.vacant.push(at as u32);
        self.fates_changed = true;
    }

    /// Decides the fate and the tile size of each light, and computes the capacity that would be enough for all.
    fn decide(&mut self, capacity: &Capacity) {
        let Self { scratch, entries, .. } = self;
        scratch.order.clear();
        scratch.order.extend(entries.iter().enumerate().filter_map(|(at, entry)| {
            let settled = entry.settled.filter(|_| entry.seen != 0)?;
            // Numbers that are not negative are ordered as their bits are.
            Some((!settled.importance.to_bits(), entry.asked.key, at as u32))
        }));
        scratch.order.sort_unstable();
        scratch.candidates.clear();
        scratch.candidates.extend(scratch.order.iter().filter_map(|(_, _, entry)| {
            Some(Candidate { entry: *entry, need: entries[*entry as usize].settled?, verdict: Ok(0) })
        }));
        let unit = self.settings.min_tile;
        let class =
            |side: u32| side.checked_div(unit).filter(|parts| *parts > 0).map(|parts| parts.ilog2() as u8);
        decide(&mut scratch.candidates, class(capacity.side), &capacity.pools);

        let (mut area, mut pools) = (0u64, [0u32; POOLS]);
        for candidate in &scratch.candidates {
            let Settled { wanted, tiles, slots, .. } = candidate.need;
            area = area.saturating_add(candidate.area(wanted));
            for (sum, count) in pools.iter_mut().zip(slots) {
                *sum = sum.saturating_add(count);
            }
            let entry = &mut entries[candidate.entry as usize];
            let fate = match candidate.verdict {
                Ok(class) if tiles > 0 && class < wanted => {
                    Fate::Downsized { from: unit << wanted, to: unit << class }
                }
                Ok(_) => Fate::Granted,
                Err(why) => Fate::Evicted(why),
            };
            self.fates_changed |= entry.fate != fate;
            entry.fate = fate;
        }
        let Settings { min_side, max_side, max_pools, .. } = self.settings;
        let mut side = min_side;
        while side < max_side && u64::from(side / unit).pow(2) < area {
            side *= 2;
        }
        pools.iter_mut().zip(max_pools).for_each(|(count, limit)| *count = limit.min(*count));
        self.need = Capacity { side, pools };
    }

    fn follow(&mut self) {
        let patience = self.settings.patience;
        self.wanted.side = self.side_follower.follow(self.need.side, patience);
        for pool in 0..POOLS {
            self.wanted.pools[pool] = self.pool_followers[pool].follow(self.need.pools[pool], patience);
        }
    }
}
