//! An allocator of runs of slots: layers of an array, cubes, descriptors, views, spots.
//!
//! An allocation takes the first gap that is long enough, so that the same calls always give the same runs. The free
//! runs are kept in order: a request visits gaps, not used slots.
//!
//! Limits: at most [`MAX_SLOTS`]; a request can fail although enough slots are free, since runs are never moved here
//! (see [`super::placement`]).

use std::collections::BTreeMap;

/// The maximum number of slots of an allocator.
pub const MAX_SLOTS: u32 = 1 << 16;

/// An allocator of contiguous runs of slots, which have the indices 0 to the capacity minus 1.
#[derive(Clone, Debug, Default)]
pub struct SlotAllocator {
    /// The free runs, no two of them adjacent: the first slot of each run, and the slot after its last.
    free: BTreeMap<u32, u32>,
    capacity: u32,
}

impl SlotAllocator {
    /// Creates an allocator with `capacity` free slots, at most [`MAX_SLOTS`].
    pub fn new(capacity: u32) -> Self {
        let mut slots = Self::default();
        slots.set_capacity(capacity);
        slots
    }

    /// Changes the number of slots, up to [`MAX_SLOTS`]. Allocated runs stay in place; slots beyond the new end are
    /// dropped.
    pub fn set_capacity(&mut self, capacity: u32) {
        let capacity = capacity.min(MAX_SLOTS);
        if capacity > self.capacity {
            self.set_free(self.capacity, capacity);
        } else {
            drop(self.free.split_off(&capacity));
            if let Some(mut last) = self.free.last_entry() {
                let end = capacity.min(*last.get());
                last.insert(end);
            }
        }
        self.capacity = capacity;
    }

    /// Allocates `count` contiguous slots and returns the first. Returns `None` if no free run is long enough, or if
    /// `count` is 0.
    #[must_use]
    pub fn allocate(&mut self, count: u32) -> Option<u32> {
        let mut runs = self.free.iter().map(|(first, end)| (*first, *end));
        let (first, end) = runs.find(|(first, end)| count > 0 && end - first >= count)?;
        self.free.remove(&first);
        if first + count < end {
            self.free.insert(first + count, end);
        }
        Some(first)
    }

    /// Releases `count` slots from `first` on. Returns `false`, and changes nothing, if one of them is not in use or
    /// `count` is 0.
    pub fn release(&mut self, first: u32, count: u32) -> bool {
        let end = first.saturating_add(count);
        let before = self.free.range(..end).next_back();
        if count == 0 || end > self.capacity || before.is_some_and(|(_, behind)| *behind > first) {
            return false;
        }
        self.set_free(first, end);
        true
    }

    /// Releases all slots.
    pub fn clear(&mut self) {
        *self = Self::new(self.capacity);
    }

    /// Marks the slots from `first` to before `end` as free, and merges them with adjacent free runs.
    fn set_free(&mut self, first: u32, end: u32) {
        let end = self.free.remove(&end).unwrap_or(end);
        match self.free.range_mut(..first).next_back() {
            Some((_, behind)) if *behind == first => *behind = end,
            _ => drop(self.free.insert(first, end)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl SlotAllocator {
        fn used(&self) -> u32 {
            self.capacity - self.free.iter().map(|(first, end)| end - first).sum::<u32>()
        }
    }

    #[test]
    fn runs_do_not_overlap_and_the_first_that_fits_is_taken() {
        let mut slots = SlotAllocator::new(200);
        let mut oracle = [false; 200];
        let mut runs: Vec<(u32, u32)> = Vec::new();
        let mut numbers = umbragraph_test_support::random::Random(7);
        for _ in 0..20_000 {
            let random = numbers.next() as u32;
            if random.is_multiple_of(2) && !runs.is_empty() {
                let (first, count) = runs.swap_remove(random as usize / 2 % runs.len());
                assert!(slots.release(first, count) && !slots.release(first, count));
                oracle[first as usize..(first + count) as usize].fill(false);
            } else {
                let count = 1 + random / 2 % 9;
                let expected = oracle.windows(count as usize).position(|run| run.iter().all(|used| !used));
                let got = slots.allocate(count);
                assert_eq!(got, expected.map(|first| first as u32));
                if let Some(first) = got {
                    oracle[first as usize..(first + count) as usize].fill(true);
                    runs.push((first, count));
                }
            }
            assert_eq!(slots.used() as usize, oracle.iter().filter(|used| **used).count());
        }
    }

    #[test]
    fn misuse_changes_nothing() {
        let mut slots = SlotAllocator::new(3);
        assert_eq!((slots.allocate(0), slots.allocate(4), slots.allocate(u32::MAX)), (None, None, None));
        assert!(!slots.release(0, 1) && !slots.release(2, u32::MAX) && !slots.release(3, 1));
        assert_eq!(slots.allocate(2), Some(0));
        slots.set_capacity(1);
        assert_eq!((slots.used(), slots.allocate(1)), (1, None));
        slots.set_capacity(3);
        assert_eq!(slots.allocate(2), Some(1));
        assert_eq!(SlotAllocator::new(0).allocate(1), None);
        assert_eq!(SlotAllocator::new(u32::MAX).capacity, MAX_SLOTS);
    }
}
