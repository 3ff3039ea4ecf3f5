//! Few texts that together hold all of many parts (greedily, as Chvátal 1979: the text with most new parts first).

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashSet};

/// Selects a small set of modules that together contain every part. Takes pairs of a module's index and its parts.
/// Returns the selected indices in ascending order.
pub(super) fn cover(texts: &[(usize, Vec<u64>)]) -> Vec<usize> {
    let mut held: HashSet<u64> = HashSet::new();
    // Gains only fall, so the best is known as soon as it is still the best after its gain is worked out again.
    let mut queue: BinaryHeap<(usize, Reverse<usize>)> =
        texts.iter().enumerate().map(|(at, (_, parts))| (parts.len(), Reverse(at))).collect();
    let mut chosen = Vec::new();
    while let Some((before, Reverse(at))) = queue.pop() {
        let Some((text, parts)) = texts.get(at) else { continue };
        let gain = parts.iter().filter(|part| !held.contains(part)).count();
        if gain == 0 {
            continue;
        }
        if gain < before {
            queue.push((gain, Reverse(at)));
            continue;
        }
        held.extend(parts);
        chosen.push(*text);
    }
    chosen.sort_unstable();
    chosen
}

#[cfg(test)]
mod tests {
    use super::cover;

    #[test]
    fn few_texts_hold_all_parts() {
        let texts = [(7, vec![1, 2]), (8, vec![1, 2, 3]), (9, vec![3]), (10, vec![4]), (11, Vec::new())];
        assert_eq!(cover(&texts), [8, 10]);
    }
}
