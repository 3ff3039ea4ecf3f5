//! The versions that readers read.
//!
//! A plain reference reads the newest version, without the writers that `after` puts behind the
//! reader; a pass that loads what it writes reads the one before its own. A reference to the version of a pass reads
//! what that pass left of what it writes, and of the rest the newest writes that do not have to follow the pass, be it
//! by `after` or since they write over what it, or another such writer, wrote. `name@0` reads what was there before the
//! first write of the frame. Two accesses overlap if their mip and their layer can be the same; a subresource range
//! without a mip (layer) means all of them.
//!
//! **Toggles.** A pass that can be off never covers what is below it for a reader that can run without it: such a
//! reader is connected to the writers below too, as far as it [sees](crate::regions::visible) them in some state. What
//! is left without one is an error, unless the contents of the frame before are there.
//!
//! Cost: each reader looks back only to the first write that covers its subresource range. Up to [`SHOWN_EDGES`]
//! writers before and behind each access, and up to [`DIRECT_READS`] that it reads, have edges also if they could be
//! left out. Writers of different subresource ranges that can be off are looked through as `visible` describes: for
//! many of them, reads can get [coarse](crate::Graph::is_coarse).

use std::cmp::Reverse;
use std::collections::{HashMap, HashSet};

use smallvec::SmallVec;

use super::diagnostics::never_written;
use super::{Builder, Via, named_writers, never_together};
use crate::graph::Hazard;
use crate::graph::access::{PassAccess, Writers};
use crate::graph::conditions::{self, Runs};
use crate::graph::later::Later;
use crate::regions::{Effort, Left, PartialRead, Unmet, View, Write, extents};
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::{Condition, ResourceKind, SubresourceRange, Version};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle};

/// The number of hazard edges of one access that are added even if they follow from other edges.
const SHOWN_EDGES: usize = 16;
/// The number of writers with direct edges to one reader. After that, older writers need no edge if newer writers load
/// and pass on their contents.
const DIRECT_READS: usize = 16;

impl Builder<'_> {
    /// Adds the read and hazard edges of a resource. `order` holds its writers in write order, as indices into its
    /// accesses.
    pub(super) fn connect(
        &mut self,
        resource: ResourceHandle,
        order: SmallVec<[usize; 2]>,
        diagnostics: &mut Diagnostics,
    ) {
        let list = &self.accesses[resource.index()];
        let writers = Writers::new(list, order);
        for (rank, at) in writers.list.iter().enumerate() {
            let current = list[*at];
            let condition = |access: &PassAccess<'_>| self.pipeline.pass(access.pass).condition;
            let after = condition(&current);
            let mut hazards = Hazards::new(current.range, after);
            for earlier in writers.before(rank, current.range) {
                let earlier = list[writers.list[earlier]];
                let before = condition(&earlier);
                if never_together(before, after) {
                    continue;
                }
                if hazards.shows(earlier.range, before) {
                    self.add(earlier.pass, current.pass, Via::Order(Hazard::WriteAfterWrite(resource)));
                    let covers =
                        earlier.range.contains(current.range) && (before.is_none() || before == after);
                    if covers || hazards.are_done() {
                        break;
                    }
                }
            }
        }
        let names = if list.iter().any(|access| matches!(access.version, Version::WrittenBy(_))) {
            named_writers(self.pipeline, list, writers.list.iter().copied())
        } else {
            HashMap::new()
        };
        let is_toggled = |at: &usize| self.pipeline.pass(list[*at].pass).condition.is_some();
        let simple = writers.are_plain && !writers.list.iter().any(is_toggled);
        let mut in_view =
            WritersInView { writers: &writers, simple, covers: HashMap::new(), effort: Effort::default() };
        for (rank, at) in writers.list.iter().enumerate().rev().filter(|_| !simple) {
            let access = &list[*at];
            if let Some(condition) = self.pipeline.pass(access.pass).condition.filter(|_| !access.reads) {
                in_view.covers.insert(condition, rank);
            }
        }
        for reader in list.iter().filter(|access| access.reads) {
            let later = match reader.version {
                Version::WrittenBy(name) => {
                    let Some(named) = names.get(name.as_str()).map(|at| &list[*at]) else { continue };
                    match writers.rank(list, named.pass, named.range) {
                        Some(rank) if named.range.contains(reader.range) => Later::From(rank + 1),
                        _ => self.stated.behind_version(list, &writers, named.pass),
                    }
                }
                Version::Newest => match writers.rank(list, reader.pass, reader.range) {
                    Some(rank) if reader.writes => Later::From(rank),
                    _ => self.stated.behind(list, &writers, reader.pass),
                },
                Version::Before => Later::From(0),
            };
            self.connect_reader(resource, reader, &mut in_view, &later, diagnostics);
        }
        self.ordered[resource.index()] = Some(writers);
    }

    /// Adds the edge for a read of a version. `rank` is the rank of the writer among the writers of the resource.
    fn feed(&mut self, resource: ResourceHandle, rank: usize, writer: PassHandle, reader: PassHandle) {
        self.add(writer, reader, Via::Data(resource));
        self.reads[reader.index()].push((resource, rank as u32));
    }

    /// Connects one reader to the writers whose versions it reads, and to the later writers that overwrite these
    /// versions.
    fn connect_reader(
        &mut self,
        resource: ResourceHandle,
        reader: &PassAccess<'_>,
        in_view: &mut WritersInView<'_>,
        later: &Later,
        diagnostics: &mut Diagnostics,
    ) {
        let pipeline = self.pipeline;
        let writers = in_view.writers;
        let list = &self.accesses[resource.index()];
        let Some(known) = conditions::known(pipeline.pass(reader.pass), reader.one) else {
            // It never happens: the pass runs only in frames in which the fallback is seen.
            return;
        };
        let mut written = false;
        let mut missing: Option<(usize, Condition)> = None;
        let (mut left, mut toggled, mut open) = (None, Vec::new(), Vec::new());
        // Pieces of one subresource or of everything hide one another one by one, those of a range only together.
        if in_view.simple && reader.range.is_plain() {
            // What was written since of what is read: an older write of it is not there any more.
            let mut newer: HashSet<SubresourceRange> = HashSet::new();
            let mut covered = false;
            for rank in writers.before(later.end(writers), reader.range).filter(|rank| !later.has(*rank)) {
                let writer = &list[writers.list[rank]];
                if writer.pass == reader.pass || !writer.range.overlaps(reader.range) {
                    continue;
                }
                let read = common_of_plain(writer.range, reader.range);
                if !newer.is_empty() && read.plain_around().iter().any(|around| newer.contains(around)) {
                    continue;
                }
                self.feed(resource, rank, writer.pass, reader.pass);
                written = true;
                // Most reads end at the first write, which covers them, and need no set.
                covered = writer.range.contains(reader.range);
                if covered {
                    break;
                }
                newer.insert(read);
            }
            if !covered && !newer.is_empty() {
                left = Some(Left::AllBut(newer.into_iter().collect()));
            }
        } else {
            let mut view = View::new(reader.range, &known, &mut in_view.effort);
            let mut count = 0;
            for rank in writers.before(later.end(writers), reader.range).filter(|rank| !later.has(*rank)) {
                let writer = &list[writers.list[rank]];
                let (range, condition) = (writer.range, pipeline.pass(writer.pass).condition);
                if writer.pass == reader.pass || !writer.range.overlaps(reader.range) {
                    continue;
                }
                if view.sees(range, condition) {
                    self.feed(resource, rank, writer.pass, reader.pass);
                    written = true;
                    count += 1;
                }
                let loads = writer.reads && writer.one.when.is_empty() && *writer.version == Version::Newest;
                let covered = |condition| in_view.covers.get(&condition).is_some_and(|oldest| *oldest < rank);
                let passes_on = loads && condition.is_some_and(|condition| !covered(condition));
                view.cover(Write { range, condition, writer: rank, passes_on });
                if count == DIRECT_READS {
                    view.pass_on();
                }
                if view.is_covered() {
                    break;
                }
            }
            missing = view.missing();
            toggled = view.toggled();
            open = view.open();
            let unwritten = view.unwritten();
            left = (!unwritten.is_empty()).then_some(Left::Boxes(unwritten));
            if view.is_coarse {
                self.coarse.insert((reader.pass, resource));
            }
        }
        let declared = pipeline.resource(resource);
        let partial = |left| PartialRead { reader: reader.pass, at: reader.at, left };
        let own_memory = match declared.declared_lifetime() {
            Lifetime::Transient => true,
            // Before this frame writes it, it holds what was left so long ago that it has no name any more.
            Lifetime::History => !declared.is_earlier_frame(),
            Lifetime::Persistent | Lifetime::Imported => false,
        };
        let needs = !reader.one.usage.keeps_what_is_there();
        if !own_memory || pipeline.uncertain.contains(&resource) {
        } else if !needs {
            // What is between rows of texels is only told to who reads it.
            let unfilled = if written { open } else { vec![extents(reader.range)] };
            if !unfilled.is_empty() {
                self.partial.push(partial(Left::BetweenRows(unfilled)));
            }
        } else {
            if !written {
                // Data that nobody publishes has its diagnostic from the load.
                if !matches!(pipeline.resource(resource).kind, ResourceKind::Data(None))
                    && !self.leaves_out(resource)
                {
                    let behind = writers.after(later.start(), reader.range).filter(|rank| later.has(*rank));
                    let behind = behind
                        .map(|rank| &list[writers.list[rank]])
                        .find(|writer| writer.pass != reader.pass && writer.range.overlaps(reader.range));
                    diagnostics.push(never_written(pipeline, resource, reader, list, behind));
                }
            } else if let Some((rank, condition)) = missing {
                let writer = &list[writers.list[rank]];
                let (writer, place) = (writer.pass, writer.one.place);
                let (reader, one) = (reader.pass, reader.one);
                diagnostics.push(conditions::taken_away(pipeline, reader, one, writer, place, condition, ""));
            } else {
                toggled.sort_by_key(|(_, rank, _)| Reverse(*rank));
                let toggled = toggled.into_iter().map(|(extents, rank, condition)| {
                    let writer = &list[writers.list[rank]];
                    (extents, writer.pass, writer.one.place, condition)
                });
                let toggled: Vec<_> = toggled.collect();
                let toggled = (!toggled.is_empty()).then_some(Left::Toggled(toggled));
                let left = left.into_iter().chain(toggled);
                self.partial.extend(left.map(partial));
            }
        }
        let mut hazards = Hazards::new(reader.range, None);
        for rank in writers.after(later.start(), reader.range).filter(|rank| later.has(*rank)) {
            let writer = &list[writers.list[rank]];
            let condition = match conditions::runs(pipeline.pass(writer.pass), &known) {
                Runs::Never => continue,
                Runs::Always => None,
                Runs::Sometimes(condition) => Some(condition),
            };
            if writer.pass != reader.pass && hazards.shows(writer.range, condition) {
                self.add(reader.pass, writer.pass, Via::Order(Hazard::WriteAfterRead(resource)));
                if writer.range.contains(reader.range) && condition.is_none() || hazards.are_done() {
                    break;
                }
            }
        }
    }
}

/// The writers of a resource, with shared state of the searches for the versions that its readers read.
struct WritersInView<'a> {
    writers: &'a Writers,
    /// Whether no writer has a toggle, and the subresource range of each writer is plain (`Writers::are_plain`).
    simple: bool,
    /// The rank of the oldest writer that does not load, for each toggle condition.
    covers: HashMap<Condition, usize>,
    effort: Effort,
}

/// Decides which writers before, or after, one access need a hazard edge to it.
struct Hazards {
    range: SubresourceRange,
    unmet: Unmet,
    shown: usize,
}

impl Hazards {
    fn new(range: SubresourceRange, condition: Option<Condition>) -> Self {
        Self { range, unmet: Unmet::new(range, condition), shown: 0 }
    }

    /// Returns `true` if the next writer, of a subresource range and toggle condition, needs an edge. Counts that edge.
    fn shows(&mut self, range: SubresourceRange, condition: Option<Condition>) -> bool {
        let shows = range.overlaps(self.range)
            && (self.shown < SHOWN_EDGES || self.unmet.has_to_meet(range, condition));
        if shows {
            self.unmet.meet(range, condition);
            self.shown += 1;
        }
        shows
    }

    /// Returns `true` if the orders with all further writers follow from the edges so far.
    fn are_done(&self) -> bool {
        self.shown >= SHOWN_EDGES && self.unmet.is_empty()
    }
}

/// Returns the intersection of two plain subresource ranges that overlap.
fn common_of_plain(a: SubresourceRange, b: SubresourceRange) -> SubresourceRange {
    SubresourceRange { mip: a.mip.or(b.mip), layer: a.layer.or(b.layer), ..SubresourceRange::WHOLE }
}
