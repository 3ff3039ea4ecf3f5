//! Which resources share one physical resource.
//!
//! A lifetime runs from the first to the last pass of the order that uses a resource. Two resources of one class
//! (descriptors that wgpu can exchange for one another) share if their lifetimes do not touch: taking resources by
//! their start, and the physical resource of the class that has been free the longest, needs exactly as many as are
//! ever alive at once, which no assignment can beat (interval graphs are perfect).
//!
//! Cost: each resource is pushed and popped once in a heap of its class: linear but for the logarithm.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A resource that wants a place: its class and the first and last pass that use it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Want {
    /// What can be exchanged for one another: classes are numbered from 0.
    pub(super) class: usize,
    /// The first pass of the order that uses it.
    pub(super) first: usize,
    /// The last one.
    pub(super) last: usize,
}

/// The index of the physical resource of each wanted one. Physical resources are numbered by their first use.
pub(super) fn assign(wants: &[Want]) -> Vec<usize> {
    let mut by_start: Vec<usize> = (0..wants.len()).collect();
    by_start.sort_by_key(|at| (wants[*at].first, *at));
    let classes = wants.iter().map(|want| want.class + 1).max().unwrap_or(0);
    // For each class the physical resources in use, the one that is free the earliest on top.
    let mut busy: Vec<BinaryHeap<Reverse<(usize, usize)>>> = vec![BinaryHeap::new(); classes];
    let mut assigned = vec![0; wants.len()];
    let mut count = 0;
    for at in by_start {
        let want = &wants[at];
        let heap = &mut busy[want.class];
        let physical = match heap.peek() {
            Some(Reverse((last, physical))) if *last < want.first => {
                let physical = *physical;
                heap.pop();
                physical
            }
            _ => {
                count += 1;
                count - 1
            }
        };
        heap.push(Reverse((want.last, physical)));
        assigned[at] = physical;
    }
    assigned
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn want(class: usize, first: usize, last: usize) -> Want {
        Want { class, first, last }
    }

    #[test]
    fn touching_lifetimes_do_not_share_and_disjoint_ones_do() {
        assert_eq!(assign(&[want(0, 1, 2), want(0, 2, 3), want(0, 3, 4)]), [0, 1, 0]);
        assert_eq!(assign(&[want(0, 1, 2), want(0, 4, 5), want(0, 4, 6)]), [0, 0, 1]);
        assert_eq!(assign(&[want(0, 1, 1), want(1, 2, 2)]), [0, 1]);
    }

    proptest! {
        #[test]
        fn the_count_is_the_peak_and_nothing_overlaps(
            list in proptest::collection::vec((0usize..3, 0usize..40, 0usize..10), 0..60)
        ) {
            let wants: Vec<_> = list.iter().map(|(class, first, length)| want(*class, *first, first + length)).collect();
            let assigned = assign(&wants);
            for a in 0..wants.len() {
                for b in 0..a {
                    if assigned[a] == assigned[b] {
                        prop_assert_eq!(wants[a].class, wants[b].class);
                        prop_assert!(wants[a].last < wants[b].first || wants[b].last < wants[a].first);
                    }
                }
            }
            let peak: usize = (0usize..3)
                .map(|class| {
                    (0..60).map(|t| wants.iter().filter(|w| w.class == class && w.first <= t && t <= w.last).count()).max().unwrap_or(0)
                })
                .sum();
            prop_assert_eq!(assigned.iter().max().map_or(0, |most| most + 1), peak);
        }
    }
}
