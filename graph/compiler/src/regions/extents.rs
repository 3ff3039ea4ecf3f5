//! Subresource ranges as boxes.

use smallvec::SmallVec;

use umbragraph_pipeline::pipeline::{Aspect, IndexRange, SubresourceRange};

/// A box of mips, layers, aspects and bytes that a subresource range covers: the first, and the first after it. A whole
/// range has no end.
pub(crate) type Extents = [(u64, u64); 4];

/// The box of a subresource range.
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

/// The boxes beside one that lies within another, which together with it make up that other.
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

/// The intersection of two boxes.
pub(crate) fn common(a: Extents, b: Extents) -> Option<Extents> {
    let both: Extents = std::array::from_fn(|axis| (a[axis].0.max(b[axis].0), a[axis].1.min(b[axis].1)));
    both.iter().all(|(first, end)| first < end).then_some(both)
}
