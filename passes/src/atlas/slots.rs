//! An allocator of runs of slots: layers of an array, cubes, descriptors, views.
//!
//! A run is the first one that is long enough, so that the same calls always give the same runs. Runs are no more than
//! lights, which are few enough for a walk over all of them.
//!
//! Limits: at most [`MAX_SLOTS`]; a request can fail although enough slots are free, since runs are never moved here
//! (see [`super::placement`]).

use std::collections::BTreeMap;

/// The maximum number of slots of a row.
pub const MAX_SLOTS: u32 = 1 << 16;

/// A row of slots.
#[derive(Clone, Debug, Default)]
pub struct SlotAllocator {
    /// The runs in use: the first slot of each, and the one behind its last.
    runs: BTreeMap<u32, u32>,
    capacity: u32,
}

impl SlotAllocator {
    /// So many free slots.
    pub fn new(capacity: u32) -> Self {
        Self { runs: BTreeMap::new(), capacity: capacity.min(MAX_SLOTS) }
    }

    /// Makes the row longer or shorter, up to [`MAX_SLOTS`]. Runs stay where they are; those beyond the end are
    /// forgotten.
    pub fn set_capacity(&mut self, capacity: u32) {
        self.capacity = capacity.min(MAX_SLOTS);
        drop(self.runs.split_off(&self.capacity));
        for end in self.runs.values_mut() {
            *end = self.capacity.min(*end);
        }
    }

    /// Takes `count` slots in a row and returns the first; `None` where there is no such run, or for no slots.
    #[must_use]
    pub fn allocate(&mut self, count: u32) -> Option<u32> {
        let mut first = 0;
        for (start, end) in &self.runs {
            if start - first >= count {
                break;
            }
            first = *end;
        }
        let end = first.checked_add(count).filter(|end| count > 0 && *end <= self.capacity)?;
        self.runs.insert(first, end);
        Some(first)
    }

    /// Gives a run back. False, with nothing changed, where there is no such run.
    pub fn release(&mut self, first: u32, count: u32) -> bool {
        let is_run = self.runs.get(&first).is_some_and(|end| end - first == count);
        is_run && self.runs.remove(&first).is_some()
    }

    /// Gives all slots back.
    pub fn clear(&mut self) {
        self.runs.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl SlotAllocator {
        fn used(&self) -> u32 {
            self.runs.iter().map(|(first, end)| end - first).sum()
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
