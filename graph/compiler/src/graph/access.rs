//! Accesses: what each pass does to each subresource range of each resource, and the writers of a resource by
//! subresource range.
//!
//! The accesses of a pairwise disjoint subresource range are independent. Most writers name one subresource (one mip,
//! one layer) or everything; [`Writers`] keeps the first kind in lists by subresource, so that the writers before and
//! after a point that touch one subresource are found without looking at the others.
//!
//! Cost: linear in accesses. Accesses of one resource inside one pass are compared in pairs.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, codes};
use umbragraph_pipeline::pipeline::{
    Access, Aspect, Located as _, ResourceKind, SubresourceRange, TypedPipeline, Version,
};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle, Work};

/// One pass's access to a subresource range of a resource.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PassAccess<'a> {
    pub(crate) pass: PassHandle,
    pub(crate) range: SubresourceRange,
    pub(crate) reads: bool,
    pub(crate) writes: bool,
    pub(crate) version: &'a Version,
    pub(crate) one: &'a Access,
    /// The index of the access in the access list of its pass.
    pub(crate) at: usize,
}

/// Returns the accesses of each resource, by resource index and in pass order; equal reads of one pass are listed once.
/// Reports passes that read a resource while they write it, once for all rounds of a loop, and adds such resources to
/// `unclear`: nothing else can be said of their contents.
pub(crate) fn accesses<'a>(
    pipeline: &'a TypedPipeline,
    unclear: &mut BTreeSet<ResourceHandle>,
    diagnostics: &mut Diagnostics,
) -> Vec<Vec<PassAccess<'a>>> {
    let mut told = BTreeSet::new();
    let mut accesses: Vec<Vec<PassAccess<'a>>> = vec![Vec::new(); pipeline.resources.len()];
    for handle in pipeline.pass_handles() {
        for (at, one) in pipeline.pass(handle).accesses().iter().enumerate() {
            let list = &mut accesses[one.resource.index()];
            let own = list.iter().rev().take_while(|access| access.pass == handle);
            let mut known = false;
            for other in own {
                let writes = other.writes || one.usage.writes();
                // Devices keep depth and stencil of one texel in one state: while one of them is written, a shader
                // can see neither.
                let bound = |one: &Access| !one.usage.is_attachment();
                let shared = bound(other.one) != bound(one)
                    && other.range.aspect(Aspect::All).overlaps(one.range.aspect(Aspect::All));
                // Depth and stencil of what has one of the two only: the format is the diagnostic.
                let beside = (other.one.usage.is_depth() && one.usage.is_stencil())
                    || (other.one.usage.is_stencil() && one.usage.is_depth());
                // A usage scope counts a buffer as a whole, whichever bytes are bound.
                let scoped = is_scoped(pipeline, handle, one) && other.writes != one.usage.writes();
                if writes && !beside && (other.range.overlaps(one.range) || shared || scoped) {
                    unclear.insert(one.resource);
                    let of_loop = without_rounds(&pipeline.pass(handle).name);
                    if told.insert((of_loop, other.one.place, one.place)) {
                        diagnostics.push(feedback(pipeline, handle, other.one, one));
                    }
                }
                known |= other.range == one.range
                    && other.version == &one.version
                    && other.one.when == one.when
                    && !other.writes
                    && !one.usage.writes();
            }
            if !known {
                let (reads, writes) = (one.usage.reads(), one.usage.writes());
                list.push(PassAccess {
                    pass: handle,
                    range: one.range,
                    reads,
                    writes,
                    version: &one.version,
                    one,
                    at,
                });
            }
        }
    }
    accesses
}

/// Returns the name of a pass without the rounds of loops: `down` for `down.2`.
fn without_rounds(name: &str) -> Vec<&str> {
    name.split('.').filter(|part| !umbragraph_pipeline::pipeline::is_round(part)).collect()
}

/// Returns `true` if a render or compute pass accesses a buffer, which WebGPU then tracks as one unit.
fn is_scoped(pipeline: &TypedPipeline, pass: PassHandle, access: &Access) -> bool {
    matches!(pipeline.pass(pass).work(), Work::Render(_) | Work::Compute(_)) && is_buffer(pipeline, access)
}

fn is_buffer(pipeline: &TypedPipeline, access: &Access) -> bool {
    matches!(pipeline.resource(access.resource).kind, ResourceKind::Buffer(_))
}

/// Returns `true` if the subresource ranges of two writers overlap, so that they need an order. `writers` holds indices
/// into `list`.
pub(crate) fn in_conflict(list: &[PassAccess<'_>], writers: &[usize]) -> bool {
    let mut exact = BTreeSet::new();
    let mut wide: BTreeSet<SubresourceRange> = BTreeSet::new();
    for at in writers {
        let range = list[*at].range;
        let new = if is_exact(range) {
            exact.insert(range)
        } else {
            wide.iter().all(|other| !other.overlaps(range)) && wide.insert(range)
        };
        if !new {
            return true;
        }
    }
    !wide.is_empty() && exact.iter().any(|range| wide.iter().any(|other| other.overlaps(*range)))
}

fn is_exact(range: SubresourceRange) -> bool {
    range.is_plain() && range.mip.is_some() && range.layer.is_some()
}

/// The writers of one resource in write order, with an index to find writers that overlap a subresource range.
#[derive(Debug, Default)]
pub(crate) struct Writers {
    /// The writers as indices into the accesses of the resource, in write order. A rank is an index into this list.
    pub(crate) list: SmallVec<[usize; 2]>,
    /// Whether the subresource range of every writer is plain: one or all mip levels and layers, all aspects, all
    /// bytes.
    pub(crate) are_plain: bool,
    /// The ranks by subresource range and pass; `None` for fewer than two writers.
    index: Option<Box<Index>>,
}

/// The ranks of the writers of one resource, by subresource range and by pass.
#[derive(Debug, Default)]
struct Index {
    all: Vec<usize>,
    wide: Vec<usize>,
    exact: FxHashMap<SubresourceRange, Vec<usize>>,
    by_pass: FxHashMap<(PassHandle, SubresourceRange), usize>,
}

impl Writers {
    /// Indexes writers that are already in write order.
    pub(crate) fn new(accesses: &[PassAccess<'_>], list: SmallVec<[usize; 2]>) -> Self {
        let are_plain = list.iter().all(|at| accesses[*at].range.is_plain());
        if list.len() < 2 {
            return Self { list, are_plain, index: None };
        }
        let mut index = Index { all: (0..list.len()).collect(), ..Index::default() };
        for (rank, at) in list.iter().enumerate() {
            let access = &accesses[*at];
            if is_exact(access.range) {
                index.exact.entry(access.range).or_default().push(rank);
            } else {
                index.wide.push(rank);
            }
            index.by_pass.insert((access.pass, access.range), rank);
        }
        Self { list, are_plain, index: Some(Box::new(index)) }
    }

    /// Returns the rank of the write of a pass to exactly this subresource range; `None` if there is no such write.
    pub(crate) fn rank(
        &self,
        accesses: &[PassAccess<'_>],
        pass: PassHandle,
        range: SubresourceRange,
    ) -> Option<usize> {
        match &self.index {
            Some(index) => index.by_pass.get(&(pass, range)).copied(),
            None => {
                self.list.iter().position(|at| (accesses[*at].pass, accesses[*at].range) == (pass, range))
            }
        }
    }

    fn lists(&self, range: SubresourceRange) -> (&[usize], &[usize]) {
        match &self.index {
            None => (&[], if self.list.is_empty() { &[] } else { &[0] }),
            Some(index) if is_exact(range) => {
                (index.exact.get(&range).map_or(&[], Vec::as_slice), &index.wide)
            }
            Some(index) => (&[], &index.all),
        }
    }

    /// Returns the ranks below `limit` of writers whose subresource ranges may overlap `range`, in descending order.
    pub(crate) fn before(&self, limit: usize, range: SubresourceRange) -> impl Iterator<Item = usize> + '_ {
        let (a, b) = self.lists(range);
        let mut a = a[..a.partition_point(|rank| *rank < limit)].iter().rev().copied().peekable();
        let mut b = b[..b.partition_point(|rank| *rank < limit)].iter().rev().copied().peekable();
        std::iter::from_fn(move || if a.peek() > b.peek() { a.next() } else { b.next() })
    }

    /// Returns the ranks from `start` on of writers whose subresource ranges may overlap `range`, in ascending order.
    pub(crate) fn after(&self, start: usize, range: SubresourceRange) -> impl Iterator<Item = usize> + '_ {
        let (a, b) = self.lists(range);
        let mut a = a[a.partition_point(|rank| *rank < start)..].iter().copied().peekable();
        let mut b = b[b.partition_point(|rank| *rank < start)..].iter().copied().peekable();
        std::iter::from_fn(move || match (a.peek(), b.peek()) {
            (Some(first), Some(second)) if first < second => a.next(),
            (Some(_), None) => a.next(),
            _ => b.next(),
        })
    }
}

fn feedback(pipeline: &TypedPipeline, pass: PassHandle, first: &Access, second: &Access) -> Diagnostic {
    let name = &pipeline.resource(second.resource).name;
    let message = format!(
        "the pass \"{}\" uses \"{name}\" as {} and as {} at once",
        pipeline.pass(pass).name,
        first.usage.name(),
        second.usage.name()
    );
    let help = if is_buffer(pipeline, second) {
        "a pass reads no part of a buffer of which it writes another: use a second buffer"
    } else {
        "no device can read what the same pass writes: use another mip or layer, or let those that write it before write a second texture, which is read here"
    };
    second.error(codes::FEEDBACK, message).related(first.place, "the other access").help(help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Assembly;

    #[test]
    fn writers_of_one_subresource_are_found_among_all_others() {
        let mut assembly = Assembly::new("writers");
        let texture = assembly.texture("a");
        let ranges = [Some((0, 0)), Some((0, 1)), None, Some((0, 1)), Some((0, 0)), None];
        for (at, range) in ranges.into_iter().enumerate() {
            let range = range
                .map_or(SubresourceRange::WHOLE, |(mip, layer)| SubresourceRange::of(Some(mip), Some(layer)));
            assembly.pass(&format!("p{at}")).writes_range(texture, range);
        }
        let (pipeline, _) = assembly.finish();
        let accesses = accesses(&pipeline, &mut BTreeSet::new(), &mut Diagnostics::new());
        let writers = Writers::new(&accesses[0], (0..6).collect());
        let range = SubresourceRange::of(Some(0), Some(1));
        assert_eq!(writers.before(5, range).collect::<Vec<_>>(), [3, 2, 1]);
        assert_eq!(writers.after(2, range).collect::<Vec<_>>(), [2, 3, 5]);
        assert_eq!(writers.before(3, SubresourceRange::WHOLE).collect::<Vec<_>>(), [2, 1, 0]);
        assert!(in_conflict(&accesses[0], &[0, 3, 4]));
        assert!(in_conflict(&accesses[0], &[1, 2]));
        assert!(!in_conflict(&accesses[0], &[0, 1]));
    }
}
