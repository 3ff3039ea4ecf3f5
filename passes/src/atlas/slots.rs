//! An allocator of runs of slots: layers of an array, cubes, descriptors, views.
//!
//! One bit for each slot. A run is the first one that is long enough, so that the same calls always give the same runs,
//! and slots are few enough for a walk over 64 of them a step.
//!
//! Limits: at most [`MAX_SLOTS`]; a request can fail although enough slots are free, since runs are never moved here
//! (see [`super::placement`]).

/// The maximum number of slots of a row.
pub const MAX_SLOTS: u32 = 1 << 16;

/// A row of slots.
#[derive(Clone, Debug, Default)]
pub struct SlotAllocator {
    /// A set bit is a slot in use.
    words: Vec<u64>,
    capacity: u32,
    used: u32,
}

impl SlotAllocator {
    /// So many free slots.
    pub fn new(capacity: u32) -> Self {
        let mut new = Self::default();
        new.set_capacity(capacity);
        new
    }

    /// Makes the row longer or shorter, up to [`MAX_SLOTS`]. Runs stay where they are; those beyond the end are
    /// forgotten.
    pub fn set_capacity(&mut self, capacity: u32) {
        let capacity = capacity.min(MAX_SLOTS);
        for at in capacity..self.capacity {
            self.set(at, false);
        }
        self.capacity = capacity;
        self.words.resize((capacity as usize).div_ceil(64), 0);
    }

    fn is_used(&self, at: u32) -> bool {
        self.words[at as usize / 64] & (1 << (at % 64)) != 0
    }

    fn set(&mut self, at: u32, used: bool) {
        if self.is_used(at) != used {
            self.words[at as usize / 64] ^= 1 << (at % 64);
            self.used = if used { self.used + 1 } else { self.used - 1 };
        }
    }

    /// Takes `count` slots in a row and returns the first; `None` where there is no such run, or for no slots.
    #[must_use]
    pub fn allocate(&mut self, count: u32) -> Option<u32> {
        if count == 0 || count > self.capacity - self.used {
            return None;
        }
        let (mut first, mut at) = (0, 0);
        while at < self.capacity {
            if at % 64 == 0 && self.words[at as usize / 64] == u64::MAX {
                at += 64;
                first = at;
                continue;
            }
            if self.is_used(at) {
                first = at + 1;
            } else if at + 1 - first == count {
                (first..=at).for_each(|at| self.set(at, true));
                return Some(first);
            }
            at += 1;
        }
        None
    }

    /// Gives a run back. False, with nothing changed, where not all of it is in use.
    pub fn release(&mut self, first: u32, count: u32) -> bool {
        let end = first.saturating_add(count);
        if end > self.capacity || !(first..end).all(|at| self.is_used(at)) {
            return false;
        }
        (first..end).for_each(|at| self.set(at, false));
        true
    }

    /// Gives all slots back.
    pub fn clear(&mut self) {
        self.words.fill(0);
        self.used = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(slots.used as usize, oracle.iter().filter(|used| **used).count());
        }
    }

    #[test]
    fn misuse_changes_nothing() {
        let mut slots = SlotAllocator::new(3);
        assert_eq!((slots.allocate(0), slots.allocate(4), slots.allocate(u32::MAX)), (None, None, None));
        assert!(!slots.release(0, 1) && !slots.release(2, u32::MAX) && !slots.release(3, 1));
        assert_eq!(slots.allocate(2), Some(0));
        slots.set_capacity(1);
        assert_eq!((slots.used, slots.allocate(1)), (1, None));
        slots.set_capacity(3);
        assert_eq!(slots.allocate(2), Some(1));
        assert_eq!(SlotAllocator::new(0).allocate(1), None);
        assert_eq!(SlotAllocator::new(u32::MAX).capacity, MAX_SLOTS);
    }
}
