//! Admission of lights to the atlas and their sizes: a function of numbers, without geometry and without history.
//!
//! 1. From the most important light on, each is let in that fits, at its smallest size, beside those let in before it,
//!    and finds slots in every pool. A light that does not fit is evicted; a less important one that needs less may
//!    still fit.
//! 2. All start at the size wanted. While that is too much, the lights are halved one after the other, the least
//!    important first, none below its smallest size; when all have been halved it begins again from the least
//!    important.
//! 3. Halving a large tile can free more than was needed. From the most important on, whoever has been halved is
//!    doubled again as long as there is room.
//!
//! Areas count smallest tiles.

use super::request::{Eviction, POOLS, Pool, PoolCounts};
use super::settle::Settled;

/// A light that competes for tiles and slots, with the decision on its request.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    /// The index of the light's entry in the placement.
    pub(super) entry: u32,
    /// The importance of the light, and the tiles and slots that it needs.
    pub(super) need: Settled,
    /// The size class of the granted tiles (0 for a light without tiles), or the reason of the eviction.
    pub(super) verdict: Result<u8, Eviction>,
}

impl Candidate {
    pub(super) fn area(&self, class: u8) -> u64 {
        u64::from(self.need.tiles) << (2 * class)
    }
}

/// Decides for each candidate whether it is admitted, and with which size class. The candidates are sorted by
/// importance, the most important first. `side` is the size class of the atlas; `None` for no atlas.
pub(super) fn decide(candidates: &mut [Candidate], side: Option<u8>, capacity: &PoolCounts) {
    let room = side.map_or(0, |side| 1u64 << (2 * side));
    let (mut min, mut taken) = (0, [0u32; POOLS]);
    for candidate in candidates.iter_mut() {
        candidate.verdict = admit(candidate, side, room, min, capacity, &taken);
        if candidate.verdict.is_ok() {
            min += candidate.area(candidate.need.min);
            taken.iter_mut().zip(candidate.need.slots).for_each(|(taken, count)| *taken += count);
        }
    }
    let mut area =
        candidates.iter().filter_map(|candidate| Some(candidate.area(candidate.verdict.ok()?))).sum::<u64>();
    if area <= room {
        return;
    }
    // Where all are at their smallest it is not too much, as the first step has made sure.
    while area > room {
        for candidate in candidates.iter_mut().rev() {
            if area <= room {
                break;
            }
            if let Ok(class) = candidate.verdict
                && class > candidate.need.min
            {
                area -= candidate.area(class) - candidate.area(class - 1);
                candidate.verdict = Ok(class - 1);
            }
        }
    }
    for candidate in candidates.iter_mut() {
        while let Ok(class) = candidate.verdict
            && class < side.map_or(0, |side| candidate.need.wanted.min(side))
        {
            let larger = area - candidate.area(class) + candidate.area(class + 1);
            if larger > room {
                break;
            }
            area = larger;
            candidate.verdict = Ok(class + 1);
        }
    }
}

fn admit(
    candidate: &Candidate,
    side: Option<u8>,
    room: u64,
    min: u64,
    capacity: &PoolCounts,
    taken: &PoolCounts,
) -> Result<u8, Eviction> {
    for pool in Pool::ALL {
        let (count, capacity) = (candidate.need.slots[pool as usize], capacity[pool as usize]);
        if count > capacity {
            return Err(Eviction::PoolTooSmall(pool));
        }
        if count > capacity - taken[pool as usize] {
            return Err(Eviction::PoolFull(pool));
        }
    }
    if candidate.need.tiles == 0 {
        return Ok(0);
    }
    let area = candidate.area(candidate.need.min);
    match side {
        Some(side) if area <= room => {
            if area <= room - min {
                Ok(candidate.need.wanted.clamp(candidate.need.min, side))
            } else {
                Err(Eviction::AtlasFull)
            }
        }
        _ => Err(Eviction::AtlasTooSmall),
    }
}
