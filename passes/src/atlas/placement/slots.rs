//! The slots that lights hold in the arrays of each pool.
//!
//! A light has a run of slots. A run that its light keeps does not move. If no gap is long enough for a new run, all
//! runs of the pool move down in their order.

use super::{Placement, Scratch};
use crate::atlas::decide::Candidate;
use crate::atlas::request::{Pool, PoolCounts};

impl Placement {
    /// Allocates the slots of each admitted light, and releases the slots of evicted lights.
    pub(super) fn place_slots(&mut self, capacity: &PoolCounts) {
        let mut scratch = std::mem::take(&mut self.scratch);
        for pool in Pool::ALL.map(|pool| pool as usize) {
            let limit = capacity[pool];
            for candidate in &scratch.candidates {
                let at = candidate.entry as usize;
                let count = if candidate.verdict.is_ok() { candidate.need.slots[pool] } else { 0 };
                let entry = &self.entries[at];
                let held = entry.held_slots[pool];
                if held != count || entry.first_slots[pool] + held > limit {
                    self.release_slots(at, pool);
                }
            }
            self.pools[pool].set_capacity(limit);
            for at in 0..scratch.candidates.len() {
                let Candidate { entry, need, verdict } = scratch.candidates[at];
                let (at, count) = (entry as usize, need.slots[pool]);
                if verdict.is_err() || self.entries[at].held_slots[pool] == count {
                    continue;
                }
                let first = self.pools[pool].allocate(count).or_else(|| {
                    self.close_gaps(pool, &mut scratch);
                    self.pools[pool].allocate(count)
                });
                if let Some(first) = first {
                    self.hold_slots(at, pool, first, count);
                }
            }
        }
        self.scratch = scratch;
    }

    fn hold_slots(&mut self, at: usize, pool: usize, first: u32, count: u32) {
        let entry = &mut self.entries[at];
        entry.first_slots[pool] = first;
        entry.held_slots[pool] = count;
    }

    /// Moves all runs of a pool towards slot 0, in their order, so that the free slots are contiguous.
    fn close_gaps(&mut self, pool: usize, scratch: &mut Scratch) {
        scratch.runs.clear();
        scratch.runs.extend(
            self.entries
                .iter()
                .enumerate()
                .map(|(at, entry)| (entry.first_slots[pool], entry.asked.key, at as u32)),
        );
        scratch.runs.sort_unstable();
        self.pools[pool].clear();
        for (before, _, entry) in &scratch.runs {
            let (at, count) = (*entry as usize, self.entries[*entry as usize].held_slots[pool]);
            if let Some(first) = self.pools[pool].allocate(count)
                && first != *before
            {
                self.hold_slots(at, pool, first, count);
            }
        }
    }

    pub(super) fn release_slots(&mut self, at: usize, pool: usize) {
        let entry = &mut self.entries[at];
        self.pools[pool].release(entry.first_slots[pool], entry.held_slots[pool]);
        entry.held_slots[pool] = 0;
        entry.first_slots[pool] = 0;
    }
}
