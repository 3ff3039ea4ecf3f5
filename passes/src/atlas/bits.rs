//! A set of small integers that knows its lowest member.
//!
//! One bit for each integer, and above them one bit for each non-empty word, repeated up to a single word. Insertion,
//! removal and the lowest member cost one step per level; 2²⁴ integers need four levels.

/// A set of integers from 0 to a fixed limit, with fast access to the lowest member.
#[derive(Clone, Debug)]
pub(super) struct Bits {
    /// Bits in 64-bit words. Level 0 has a bit for each possible member; each further level has a bit for each nonzero
    /// word of the level before.
    levels: Vec<Vec<u64>>,
}

impl Bits {
    pub(super) fn new(length: usize) -> Self {
        let mut levels = Vec::new();
        let mut words = length.div_ceil(64).max(1);
        levels.push(vec![0; words]);
        while words > 1 {
            words = words.div_ceil(64);
            levels.push(vec![0; words]);
        }
        Self { levels }
    }

    pub(super) fn contains(&self, at: usize) -> bool {
        self.levels[0].get(at / 64).is_some_and(|word| word & (1 << (at % 64)) != 0)
    }

    pub(super) fn insert(&mut self, mut at: usize) {
        for level in &mut self.levels {
            let word = &mut level[at / 64];
            let was_empty = *word == 0;
            *word |= 1 << (at % 64);
            if !was_empty {
                return;
            }
            at /= 64;
        }
    }

    pub(super) fn remove(&mut self, mut at: usize) {
        for level in &mut self.levels {
            let word = &mut level[at / 64];
            *word &= !(1 << (at % 64));
            if *word != 0 {
                return;
            }
            at /= 64;
        }
    }

    /// Returns the lowest member; `None` for an empty set.
    pub(super) fn first(&self) -> Option<usize> {
        let mut at = 0;
        for level in self.levels.iter().rev() {
            let word = level[at];
            if word == 0 {
                return None;
            }
            at = at * 64 + word.trailing_zeros() as usize;
        }
        Some(at)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn the_lowest_member_is_that_of_an_ordered_set() {
        let length = 70_000;
        let (mut bits, mut set) = (Bits::new(length), BTreeSet::new());
        let mut random = umbragraph_test_support::random::Random(1);
        for _ in 0..60_000 {
            let at = random.below(length);
            if random.one_in(2) {
                bits.insert(at);
                set.insert(at);
            } else {
                let at = set.range(at..).next().copied().unwrap_or(at);
                bits.remove(at);
                set.remove(&at);
            }
            assert_eq!(bits.first(), set.first().copied());
            assert_eq!(bits.contains(at), set.contains(&at));
        }
        for at in set {
            bits.remove(at);
        }
        assert_eq!(bits.first(), None);
    }
}
