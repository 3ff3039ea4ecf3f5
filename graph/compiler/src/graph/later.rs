//! The writers that a reader does not see because they run later, as far as the document says so.
//!
//! Writers of other subresource ranges than those that a version is about are mostly in no order with it, and then
//! seen: which of them the order of the passes puts before the reader would be chance. So a writer is later only if
//! `after` or a version that it reads says so, or if it writes over what is written by the pass that is named, or by
//! another that is later.
//!
//! Cost: for a plain reference a search through what `after` says, if there is a writer that it can lead to. For a
//! reference to a version of which the reader sees more than its pass writes, the writers of the resource.

use std::collections::{HashMap, HashSet};

use crate::graph::access::{PassAccess, Writers};
use crate::graph::ready::{positions, sorted};
use umbragraph_pipeline::pipeline::{Access, Pass, SubresourceRange, TypedPipeline, Version};
use umbragraph_pipeline::work::PassHandle;

/// The writers of a resource that run after a reader, so that it does not read their versions. Ranks are indices into
/// `Writers::list`.
pub(crate) enum Later {
    /// All writers from this rank on.
    From(usize),
    /// The writers whose rank is marked with `true`.
    Some(Vec<bool>),
}

impl Later {
    pub(crate) fn has(&self, rank: usize) -> bool {
        match self {
            Later::From(first) => *first <= rank,
            Later::Some(marks) => marks[rank],
        }
    }

    /// The lowest rank of a writer that may run after the reader.
    pub(crate) fn start(&self) -> usize {
        match self {
            Later::From(first) => *first,
            Later::Some(_) => 0,
        }
    }

    /// The end (exclusive) of the ranks of writers that may run before the reader.
    pub(crate) fn end(&self, writers: &Writers) -> usize {
        match self {
            Later::From(first) => *first,
            Later::Some(_) => writers.list.len(),
        }
    }
}

/// The order of passes that the document states with `after` and with reads of named versions (`resource@pass`).
#[derive(Default)]
pub(crate) struct Stated {
    /// The passes stated to run after each pass, by pass index; empty if the document states no order.
    next: Vec<Vec<PassHandle>>,
    /// The position of each pass, by pass index, in an order that respects `next`. It is `usize::MAX` for a pass in or
    /// after a cycle.
    position: Vec<usize>,
}

impl Stated {
    pub(crate) fn new(pipeline: &TypedPipeline) -> Self {
        let named = |one: &Access| matches!(one.version, Version::WrittenBy(_));
        let has_versions = pipeline.passes.iter().flat_map(Pass::accesses).any(named);
        if !has_versions && pipeline.passes.iter().all(|pass| pass.after.is_empty()) {
            return Self::default();
        }
        let handles = pipeline.pass_handles().filter(|_| has_versions);
        let by_name: HashMap<&str, PassHandle> =
            handles.map(|pass| (pipeline.pass(pass).name.as_str(), pass)).collect();
        let mut next = vec![Vec::new(); pipeline.passes.len()];
        for pass in pipeline.pass_handles() {
            let versions = pipeline.pass(pass).accesses().iter().filter_map(|one| match &one.version {
                Version::WrittenBy(name) => {
                    let named = by_name.get(name.as_str()).copied();
                    named.filter(|named| pipeline.pass(*named).writes(one.resource))
                }
                _ => None,
            });
            for before in pipeline.pass(pass).after.iter().copied().chain(versions) {
                if before != pass {
                    next[before.index()].push(pass);
                }
            }
        }
        let order = sorted(next.len(), |pass| next[pass].iter().copied());
        Self { position: positions(&order, next.len()), next }
    }

    /// Returns the passes in `among` that are stated, directly or through other passes, to run after the pass `of`.
    pub(crate) fn followers(
        &self,
        of: PassHandle,
        among: impl Iterator<Item = PassHandle> + Clone,
    ) -> HashSet<PassHandle> {
        let Some(own) = self.position.get(of.index()) else { return HashSet::new() };
        let last = among.clone().map(|pass| self.position[pass.index()]).max();
        let Some(last) = last.filter(|last| last > own) else { return HashSet::new() };
        let mut followers = Followers::new(self, last);
        followers.add(of);
        among.filter(|pass| followers.known.contains(pass)).collect()
    }

    /// Returns the writers of a resource that are stated to run after the pass `reader`.
    pub(crate) fn behind(&self, list: &[PassAccess<'_>], writers: &Writers, reader: PassHandle) -> Later {
        let passes = writers.list.iter().map(|at| list[*at].pass);
        let followers = self.followers(reader, passes.clone());
        if followers.is_empty() {
            return Later::From(writers.list.len());
        }
        Later::Some(passes.map(|pass| followers.contains(&pass)).collect())
    }

    /// Returns the writers of a resource that run after the version that the pass `named` writes. They are stated to
    /// follow it, or overwrite it or another such writer.
    pub(crate) fn behind_version(
        &self,
        list: &[PassAccess<'_>],
        writers: &Writers,
        named: PassHandle,
    ) -> Later {
        let own = |rank: usize| list[writers.list[rank]].pass == named;
        let ranges = writers.list.iter().map(|at| &list[*at]).filter(|one| one.pass == named);
        let ranges = ranges.map(|one| one.range).collect();
        let mut followers = Followers::new(self, usize::MAX);
        followers.add(named);
        Later::Some(followers.mark(list, writers, ranges, &own))
    }
}

/// Collects the passes that are stated, directly or through other passes, to run after given passes.
struct Followers<'a> {
    stated: &'a Stated,
    /// The greatest position in the stated order at which passes are still collected.
    last: usize,
    known: HashSet<PassHandle>,
}

impl<'a> Followers<'a> {
    fn new(stated: &'a Stated, last: usize) -> Self {
        Self { stated, last, known: HashSet::new() }
    }

    /// Adds the passes that are stated to run after a pass.
    fn add(&mut self, pass: PassHandle) {
        let mut stack = vec![pass];
        while let Some(pass) = stack.pop() {
            for next in self.stated.next.get(pass.index()).into_iter().flatten() {
                if self.stated.position[next.index()] <= self.last && self.known.insert(*next) {
                    stack.push(*next);
                }
            }
        }
    }

    /// Returns for each writer, by rank, whether it follows the named pass. A writer also follows if it comes later and
    /// overwrites ranges of the named pass or of a marked writer.
    fn mark(
        mut self,
        list: &[PassAccess<'_>],
        writers: &Writers,
        mut ranges: Vec<SubresourceRange>,
        is_own: &dyn Fn(usize) -> bool,
    ) -> Vec<bool> {
        let mut marks = vec![false; writers.list.len()];
        let mut is_behind = false;
        for (rank, at) in writers.list.iter().enumerate() {
            let writer = &list[*at];
            if is_own(rank) {
                is_behind = true;
                continue;
            }
            let over = is_behind && ranges.iter().any(|range| range.overlaps(writer.range));
            if over || self.known.contains(&writer.pass) {
                marks[rank] = true;
                self.add(writer.pass);
                if !ranges.contains(&writer.range) {
                    ranges.push(writer.range);
                }
            }
        }
        marks
    }
}
