//! Culling: what leads to an output stays.
//!
//! Roots are passes with side effects and the writers of imported and persistent resources whose version survives the
//! frame. From there every pass whose version is read is kept; an order that is only explicit keeps nothing. A history
//! is no output in itself: a kept pass that reads an earlier frame of it keeps the writers of what survives this one,
//! as they feed that pass some frames later, and so may keep passes that come after itself. Each kept
//! pass remembers the first reason found, breadth first, so that following the reasons leads to an output on a
//! shortest way; each culled one says who would have had to read it.
//!
//! A [coarse](crate::regions::visible) look at the writers of a resource may keep passes of which nothing is visible.
//! Their reasons say so.

use std::collections::{BTreeSet, VecDeque};

use serde::Serialize;

use crate::graph::Graph;
use crate::graph::discards;
use crate::regions::visible::{Effort, View, Write};
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::{Access, SubresourceRange, TypedPipeline};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle, Work};

/// The reason why a pass is kept, with handles or with names ([`Kept`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum KeepReason<Reader = (PassHandle, ResourceHandle), Resource = ResourceHandle> {
    /// The pass declares a side effect.
    SideEffect,
    /// The pass writes a resource that outlives the frame.
    Output(Resource),
    /// A kept pass reads a resource that this pass writes.
    ReadBy(Reader),
    /// A kept pass reads, in a later frame, a history that this pass writes. The value names the reader and the earlier
    /// frame that it reads.
    ReadLater(Reader),
    /// A kept pass may read a resource that this pass writes: the writers' ranges or toggles are too many to
    /// distinguish.
    MayBeReadBy(Reader),
    /// A resource that outlives the frame may keep this pass's writes: the writers' ranges or toggles are too many to
    /// distinguish.
    MayBeLeft(Resource),
}

/// The reason why a pass is kept, with names in place of handles.
pub type Kept = KeepReason<ReaderName, String>;

/// The name of a kept pass with the resource that it reads.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ReaderName {
    /// The name of the reading pass.
    pub pass: String,
    /// The name of the resource that the pass reads.
    pub resource: String,
}

impl KeepReason {
    /// Converts the handles to names.
    pub(crate) fn named(self, pipeline: &TypedPipeline) -> Kept {
        let name = |handle| pipeline.resource(handle).name.clone();
        let reader = |(pass, of)| ReaderName { pass: pipeline.pass(pass).name.clone(), resource: name(of) };
        match self {
            Self::SideEffect => Kept::SideEffect,
            Self::Output(resource) => Kept::Output(name(resource)),
            Self::ReadBy(read) => Kept::ReadBy(reader(read)),
            Self::ReadLater(read) => Kept::ReadLater(reader(read)),
            Self::MayBeReadBy(read) => Kept::MayBeReadBy(reader(read)),
            Self::MayBeLeft(resource) => Kept::MayBeLeft(name(resource)),
        }
    }
}

/// The reason why a pass is culled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CullReason {
    /// The pass writes nothing.
    WritesNothing,
    /// No pass reads the named resources, which this pass writes.
    NothingReads(Vec<String>),
    /// Only the named passes, which are culled, read the resources that this pass writes.
    OnlyCulledRead(Vec<String>),
}

/// Returns the reason for keeping each pass, indexed by pass handle; `None` for culled passes.
pub(crate) fn keep(pipeline: &TypedPipeline, graph: &Graph) -> Vec<Option<KeepReason>> {
    let mut kept: Vec<Option<KeepReason>> = vec![None; pipeline.passes.len()];
    for resource in pipeline.resource_handles().filter(|resource| {
        matches!(pipeline.resource(*resource).lifetime(), Lifetime::Persistent | Lifetime::Imported)
    }) {
        let (writers, is_coarse) = survivors(pipeline, graph, resource);
        let reason = if is_coarse { KeepReason::MayBeLeft } else { KeepReason::Output };
        for writer in writers {
            kept[writer.index()].get_or_insert(reason(resource));
        }
    }
    let mut queue = VecDeque::new();
    for handle in pipeline.pass_handles() {
        if pipeline.pass(handle).side_effect {
            kept[handle.index()] = Some(KeepReason::SideEffect);
        }
        if kept[handle.index()].is_some() {
            queue.push_back(handle);
        }
    }
    let mut read_back: BTreeSet<ResourceHandle> = BTreeSet::new();
    while let Some(pass) = queue.pop_front() {
        let mut producers: Vec<(PassHandle, ResourceHandle)> = graph.producers(pass).collect();
        producers.sort_unstable();
        for (producer, resource) in producers {
            if kept[producer.index()].is_none() {
                let is_coarse = graph.is_coarse(pass, resource);
                let reason = if is_coarse { KeepReason::MayBeReadBy } else { KeepReason::ReadBy };
                kept[producer.index()] = Some(reason((pass, resource)));
                queue.push_back(producer);
            }
        }
        for one in pipeline.pass(pass).accesses() {
            let Some(history) = pipeline.resource(one.resource).history.filter(|history| history.back > 0)
            else {
                continue;
            };
            if read_back.insert(history.of) {
                let (mut writers, is_coarse) = survivors(pipeline, graph, history.of);
                writers.sort_unstable();
                for writer in writers {
                    if kept[writer.index()].is_none() {
                        kept[writer.index()] = Some(if is_coarse {
                            KeepReason::MayBeLeft(history.of)
                        } else {
                            KeepReason::ReadLater((pass, one.resource))
                        });
                        queue.push_back(writer);
                    }
                }
            }
        }
    }
    kept
}

/// Returns the passes whose writes to a resource survive to the end of the frame. A later attachment that is cleared or
/// discarded replaces earlier writes. Copies, and storage writes that do not declare a full replacement, never count as
/// covering. Writes to a discarded attachment do not survive.
pub fn surviving_writers(
    pipeline: &TypedPipeline,
    graph: &Graph,
    resource: ResourceHandle,
) -> Vec<PassHandle> {
    survivors(pipeline, graph, resource).0
}

/// Returns the passes whose writes survive to the end of the frame, and `true` if some of these writes may not survive.
fn survivors(pipeline: &TypedPipeline, graph: &Graph, resource: ResourceHandle) -> (Vec<PassHandle>, bool) {
    let discards = |range: SubresourceRange, writer: PassHandle| match pipeline.pass(writer).work() {
        Work::Render(render) => discards::discards(render, resource, range),
        _ => false,
    };
    let clears = |range: SubresourceRange, writer: PassHandle| {
        let whole = range.layer.is_some() || single_layer(pipeline, resource);
        let replaces = |one: &Access| {
            let all = whole || !one.usage.is_attachment();
            one.resource == resource && one.range == range && one.usage.replaces_contents() && all
        };
        pipeline.pass(writer).accesses().iter().any(replaces) || whole && discards(range, writer)
    };
    let condition = |writer: PassHandle| pipeline.pass(writer).condition;
    let mut writers = Vec::new();
    if graph.versions_of(resource).all(|(range, writer)| condition(writer).is_none() && range.is_plain()) {
        let mut covered: BTreeSet<SubresourceRange> = BTreeSet::new();
        for (range, writer) in graph.versions_of(resource).rev() {
            let is_covered = range.plain_around().iter().any(|around| covered.contains(around));
            if !discards(range, writer) && !is_covered {
                writers.push(writer);
            }
            if clears(range, writer) {
                covered.insert(range);
            }
        }
        return (writers, false);
    }
    let mut effort = Effort::default();
    let mut view = View::new(SubresourceRange::WHOLE, &[], &mut effort);
    for (range, writer) in graph.versions_of(resource).rev() {
        if view.sees(range, condition(writer)) && !discards(range, writer) {
            writers.push(writer);
        }
        if clears(range, writer) {
            view.cover(Write { range, condition: condition(writer), writer: (), passes_on: false });
        }
    }
    (writers, view.is_coarse)
}

/// Returns `true` if a resource is declared without layers, so that all its attachments are the same layer.
pub(crate) fn single_layer(pipeline: &TypedPipeline, resource: ResourceHandle) -> bool {
    pipeline.resource(resource).texture().is_some_and(|texture| texture.layers.is_none())
}

/// Returns the reason for culling a pass.
pub(crate) fn cull_reason(
    pipeline: &TypedPipeline,
    graph: &Graph,
    kept: &[Option<KeepReason>],
    pass: PassHandle,
) -> CullReason {
    let sorted = |names: &mut dyn Iterator<Item = &String>| {
        let names: BTreeSet<&String> = names.collect();
        names.into_iter().cloned().collect::<Vec<_>>()
    };
    let accesses = pipeline.pass(pass).accesses();
    let mut written =
        accesses.iter().filter(|one| one.usage.writes()).map(|one| &pipeline.resource(one.resource).name);
    let written = sorted(&mut written);
    if written.is_empty() {
        return CullReason::WritesNothing;
    }
    // What it reads of itself some frames later keeps nothing alive, and so is no reason.
    let later = readers_later(pipeline, kept, pass);
    let readers = graph.consumers(pass).map(|(reader, _)| reader).chain(later);
    let readers = sorted(&mut readers.map(|reader| &pipeline.pass(reader).name));
    if readers.is_empty() { CullReason::NothingReads(written) } else { CullReason::OnlyCulledRead(readers) }
}

/// Returns the other culled passes that read earlier frames of the histories that a pass writes.
fn readers_later(pipeline: &TypedPipeline, kept: &[Option<KeepReason>], pass: PassHandle) -> Vec<PassHandle> {
    let history = |one: &Access| pipeline.resource(one.resource).history;
    let writes = pipeline.pass(pass).accesses().iter().filter(|one| one.usage.writes());
    let written: BTreeSet<ResourceHandle> = writes.filter_map(|one| Some(history(one)?.of)).collect();
    if written.is_empty() {
        return Vec::new();
    }
    let reads = |reader: &PassHandle| {
        let accesses = pipeline.pass(*reader).accesses();
        accesses.iter().filter_map(history).any(|history| history.back > 0 && written.contains(&history.of))
    };
    let culled = pipeline.pass_handles().filter(|reader| kept[reader.index()].is_none());
    culled.filter(|reader| *reader != pass && reads(reader)).collect()
}
