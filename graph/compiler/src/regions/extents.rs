//! Subresource ranges as boxes.

use smallvec::SmallVec;

use umbragraph_pipeline::pipeline::{Aspect, IndexRange, SubresourceRange};

/// A box over the axes mip levels, layers, aspects and bytes: first index and end (exclusive) on each. An unbounded
/// axis ends at `u64::MAX`.
pub(crate) type Extents = [(u64, u64); 4];

/// Returns the box that a subresource range covers.
pub(crate) fn extents(range: SubresourceRange) -> Extents {
    let run = |first: Option<u64>, end: Option<u64>| (first.unwrap_or(0), end.unwrap_or(u64::MAX));
    let aspect = match range.aspect {
        Aspect::All => (0, 2),
        Aspect::DepthOnly => (0, 1),
        Aspect::StencilOnly => (1, 2),
    };
    [
        run(range.mip.map(|run| run.first.into()), range.mip.map(IndexRange::end)),
        run(range.layer.map(|run| run.first.into()), range.layer.map(IndexRange::end)),
        aspect,
        run(range.bytes.map(|run| run.first), range.bytes.map(IndexRange::end)),
    ]
}

/// Splits the rest of the box `all` outside of `inside` into disjoint boxes. `inside` must lie within `all`.
pub(crate) fn beside(mut all: Extents, inside: Extents) -> SmallVec<[Extents; 8]> {
    let mut boxes = SmallVec::new();
    for axis in 0..all.len() {
        let (first, end) = all[axis];
        for rest in [(first, inside[axis].0), (inside[axis].1, end)] {
            if rest.0 < rest.1 {
                all[axis] = rest;
                boxes.push(all);
            }
        }
        all[axis] = inside[axis];
    }
    boxes
}

/// Returns the intersection of two boxes; `None` if it is empty.
pub(crate) fn common(a: Extents, b: Extents) -> Option<Extents> {
    let both: Extents = std::array::from_fn(|axis| (a[axis].0.max(b[axis].0), a[axis].1.min(b[axis].1)));
    both.iter().all(|(first, end)| first < end).then_some(both)
}
