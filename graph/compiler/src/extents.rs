//! Parts as boxes.

use crate::pipeline::{Aspect, Part, Run};

/// What a part covers of mips, layers, aspects and bytes: the first, and the first after it. Everything has no end.
pub(super) type Extents = [(u64, u64); 4];

/// The box of a part.
pub(super) fn extents(part: Part) -> Extents {
    let run = |first: Option<u64>, end: Option<u64>| (first.unwrap_or(0), end.unwrap_or(u64::MAX));
    let aspect = match part.aspect {
        Aspect::All => (0, 2),
        Aspect::DepthOnly => (0, 1),
        Aspect::StencilOnly => (1, 2),
    };
    [
        run(part.mip.map(|run| run.first.into()), part.mip.map(Run::end)),
        run(part.layer.map(|run| run.first.into()), part.layer.map(Run::end)),
        aspect,
        run(part.bytes.map(|run| run.first), part.bytes.map(Run::end)),
    ]
}

/// What two boxes have in common.
pub(super) fn common(a: Extents, b: Extents) -> Option<Extents> {
    let both: Extents = std::array::from_fn(|axis| (a[axis].0.max(b[axis].0), a[axis].1.min(b[axis].1)));
    both.iter().all(|(first, end)| first < end).then_some(both)
}
