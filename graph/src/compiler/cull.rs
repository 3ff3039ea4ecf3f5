//! Culling: what leads to an output stays.
//!
//! Roots are passes with side effects and the writers of imported and persistent resources whose version survives the
//! frame. From there every pass whose version is read is kept; an order that is only explicit keeps nothing. Each kept
//! pass remembers the first reason found, breadth first, so that following the reasons leads to an output on a
//! shortest way; each culled one says who would have had to read it.

use std::collections::VecDeque;

use serde::Serialize;

use super::graph::Graph;
use crate::language::Lifetime;
use crate::pipeline::Pipeline;
use crate::work::{PassHandle, ResourceHandle};

/// Why a pass is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeepReason {
    /// It says that it has a side effect.
    SideEffect,
    /// It writes a resource that outlives the frame.
    Output(ResourceHandle),
    /// A kept pass reads what it writes.
    ReadBy(PassHandle, ResourceHandle),
}

/// Why a pass is culled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CullReason {
    /// It writes nothing.
    WritesNothing,
    /// Nothing reads the resources that it writes.
    NothingReads(Vec<String>),
    /// Only culled passes read what it writes.
    OnlyCulledRead(Vec<String>),
}

/// For each pass why it is kept, or `None` if it is not.
pub(super) fn keep(pipeline: &Pipeline, graph: &Graph) -> Vec<Option<KeepReason>> {
    let mut kept: Vec<Option<KeepReason>> = vec![None; pipeline.passes.len()];
    let mut queue = VecDeque::new();
    for handle in pipeline.pass_handles() {
        let pass = pipeline.pass(handle);
        let output = pass.uses.iter().filter(|one| one.usage.writes()).map(|one| one.resource).find(|resource| {
            pipeline.resource(*resource).lifetime() != Lifetime::Transient
        });
        let reason = if pass.side_effect { Some(KeepReason::SideEffect) } else { output.map(KeepReason::Output) };
        if let Some(reason) = reason {
            kept[handle.index()] = Some(reason);
            queue.push_back(handle);
        }
    }
    while let Some(pass) = queue.pop_front() {
        let mut producers: Vec<(PassHandle, ResourceHandle)> = graph.producers(pass).collect();
        producers.sort_unstable();
        for (producer, resource) in producers {
            if kept[producer.index()].is_none() {
                kept[producer.index()] = Some(KeepReason::ReadBy(pass, resource));
                queue.push_back(producer);
            }
        }
    }
    kept
}

/// Why a pass is culled.
pub(super) fn cull_reason(pipeline: &Pipeline, graph: &Graph, pass: PassHandle) -> CullReason {
    let mut written: Vec<String> = pipeline
        .pass(pass)
        .uses
        .iter()
        .filter(|one| one.usage.writes())
        .map(|one| pipeline.resource(one.resource).name.clone())
        .collect();
    written.sort();
    written.dedup();
    if written.is_empty() {
        return CullReason::WritesNothing;
    }
    let mut readers: Vec<String> = pipeline
        .pass_handles()
        .filter(|reader| graph.producers(*reader).any(|(producer, _)| producer == pass))
        .map(|reader| pipeline.pass(reader).name.clone())
        .collect();
    readers.sort();
    if readers.is_empty() { CullReason::NothingReads(written) } else { CullReason::OnlyCulledRead(readers) }
}
