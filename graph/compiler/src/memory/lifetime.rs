//! Aliasing: the resources that share one physical resource, and the size of each physical resource.
//!
//! A lifetime runs from the first to the last pass of the order that uses a resource. Two resources of one class
//! (descriptors that wgpu can exchange for one another) share if their lifetimes do not touch: taking resources by
//! their start, and a physical resource of the class that is free wherever there is one, needs exactly as many as are
//! ever alive at once, which no assignment can beat (interval graphs are perfect).
//!
//! A physical resource is as large as its largest alias. Members of a class of textures are of one size; those of a
//! class of buffers are not, and which of the free ones is taken decides about bytes: the smallest that is large
//! enough, else the largest, which has to grow least; among equals the one that has been free the longest. Together
//! they never have more bytes than their aliases. The fewest bytes with as few buffers are NP-hard to find
//! (max-coloring of interval graphs: Pemmaraju, Raman and Varadarajan, "Buffer minimization using max-coloring", SODA
//! 2004); what is left above the bytes that are alive at once is less than half, since sizes of a class are within a
//! factor of two.
//!
//! Cost: each resource enters and leaves a heap and an ordered set of its class once: linear but for the logarithm.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// A resource that needs memory: its compatibility class, its bytes, and the first and last pass that use it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AllocationRequest {
    /// The index of the compatibility class; only resources of one class share memory.
    pub(crate) class: usize,
    /// The size in bytes.
    pub(crate) bytes: u64,
    /// The position in execution order of the first pass that uses the resource.
    pub(crate) first: usize,
    /// The position in execution order of the last pass that uses the resource.
    pub(crate) last: usize,
}

/// The physical resource assigned to each request.
#[derive(Debug, Default)]
pub(crate) struct Assignment {
    /// The index of the physical resource for each request; physical resources are numbered by first use.
    pub(crate) places: Vec<usize>,
    /// The size of each physical resource in bytes.
    pub(crate) bytes: Vec<u64>,
}

/// The physical resources of one compatibility class during assignment.
#[derive(Clone, Default)]
struct CompatibilityClass {
    /// The physical resources in use as (position of the last pass, index), the earliest last pass on top.
    busy: BinaryHeap<Reverse<(usize, usize)>>,
    /// The free physical resources as (bytes, position of the last pass, index).
    free: BTreeSet<(u64, usize, usize)>,
}

/// Returns the indices of the requests, sorted by the start of their lifetimes.
pub(crate) fn by_start(requests: &[AllocationRequest]) -> Vec<usize> {
    let mut by_start: Vec<usize> = (0..requests.len()).collect();
    by_start.sort_by_key(|at| requests[*at].first);
    by_start
}

/// Assigns a physical resource to each request. Requests of one class share a physical resource if their lifetimes do
/// not overlap.
pub(crate) fn assign(requests: &[AllocationRequest]) -> Assignment {
    let count = requests.iter().map(|request| request.class + 1).max().unwrap_or(0);
    let mut classes = vec![CompatibilityClass::default(); count];
    let mut assignment = Assignment { places: vec![0; requests.len()], bytes: Vec::new() };
    for at in by_start(requests) {
        let request = &requests[at];
        let CompatibilityClass { busy, free } = &mut classes[request.class];
        while let Some(Reverse((last, place))) =
            busy.peek().copied().filter(|Reverse((last, _))| *last < request.first)
        {
            busy.pop();
            free.insert((assignment.bytes[place], last, place));
        }
        let fits = free.range((request.bytes, 0, 0)..).next().copied();
        let taken = fits.or_else(|| {
            let (max, ..) = *free.last()?;
            free.range((max, 0, 0)..).next().copied()
        });
        let place = match taken {
            Some(found) => {
                free.remove(&found);
                found.2
            }
            None => {
                assignment.bytes.push(0);
                assignment.bytes.len() - 1
            }
        };
        assignment.bytes[place] = assignment.bytes[place].max(request.bytes);
        busy.push(Reverse((request.last, place)));
        assignment.places[at] = place;
    }
    assignment
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use umbragraph_test_support::property;

    fn request(class: usize, first: usize, last: usize) -> AllocationRequest {
        AllocationRequest { class, bytes: 1, first, last }
    }

    fn sized(bytes: u64, first: usize, last: usize) -> AllocationRequest {
        AllocationRequest { class: 0, bytes, first, last }
    }

    #[test]
    fn touching_lifetimes_do_not_share_and_disjoint_ones_do() {
        assert_eq!(assign(&[request(0, 1, 2), request(0, 2, 3), request(0, 3, 4)]).places, [0, 1, 0]);
        assert_eq!(assign(&[request(0, 1, 2), request(0, 4, 5), request(0, 4, 6)]).places, [0, 0, 1]);
        assert_eq!(assign(&[request(0, 1, 1), request(1, 2, 2)]).places, [0, 1]);
    }

    #[test]
    fn the_smallest_fitting_buffer_is_reused_or_the_largest_grows() {
        let three = [sized(70, 0, 1), sized(100, 0, 1), sized(80, 0, 1)];
        let with = |requests: &[AllocationRequest]| assign(&[&three, requests].concat());
        assert_eq!(with(&[sized(75, 2, 2)]).places[3..], [2]);
        assert_eq!(with(&[sized(70, 2, 2), sized(70, 2, 2)]).places[3..], [0, 2]);
        let grown = with(&[sized(110, 2, 2)]);
        assert_eq!((&grown.places[3..], &grown.bytes[..]), (&[1][..], &[70, 110, 80][..]));
        // Among equals the one that has been free the longest.
        let equals = assign(&[sized(64, 0, 3), sized(64, 0, 1), sized(64, 5, 5)]);
        assert_eq!(equals.places, [0, 1, 1]);
    }

    proptest! {
        #![proptest_config(property::config(256))]

        #[test]
        fn the_count_is_the_peak_and_nothing_overlaps(
            list in proptest::collection::vec((0usize..3, 0usize..40, 0usize..10, 65u64..129), 0..60)
        ) {
            let requests: Vec<_> = list
                .iter()
                .map(|(class, first, length, bytes)| AllocationRequest { class: *class, bytes: *bytes, first: *first, last: first + length })
                .collect();
            let Assignment { places, bytes } = assign(&requests);
            for a in 0..requests.len() {
                for b in 0..a {
                    if places[a] == places[b] {
                        prop_assert_eq!(requests[a].class, requests[b].class);
                        prop_assert!(requests[a].last < requests[b].first || requests[b].last < requests[a].first);
                    }
                }
            }
            let alive = |class: usize, at: usize| requests.iter().filter(move |w| w.class == class && w.first <= at && at <= w.last);
            let max = |of: &dyn Fn(usize, usize) -> u64| (0usize..3).map(|class| (0..60).map(|at| of(class, at)).max().unwrap_or(0)).sum::<u64>();
            prop_assert_eq!(bytes.len() as u64, max(&|class, at| alive(class, at).count() as u64));
            for (place, own) in bytes.iter().enumerate() {
                let aliases = (0..requests.len()).filter(|at| places[*at] == place);
                prop_assert_eq!(Some(*own), aliases.map(|at| requests[at].bytes).max());
            }
            let created: u64 = bytes.iter().sum();
            let bound = max(&|class, at| alive(class, at).map(|request| request.bytes).sum());
            prop_assert!(bound <= created && created <= requests.iter().map(|request| request.bytes).sum::<u64>());
            prop_assert!(bound == 0 || created < 2 * bound);
        }
    }
}
