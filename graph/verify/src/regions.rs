//! The regions of a resource, cut by its accesses, and the data flow between them.

use std::collections::{BTreeSet, HashMap, HashSet};

use crate::schedule::Schedule;
use umbragraph_compiler::{Plan, StoreOperation};
use umbragraph_pipeline::pipeline::{Access, Aspect, Condition, IndexRange, SubresourceRange, Usage};
use umbragraph_pipeline::work::{PassHandle, ResourceHandle};

/// The data flow between passes: the writes that reach reads, later frames or the host.
pub(crate) struct Flow {
    /// The data edges as writer, reader and resource.
    pub(crate) feeds: HashSet<(PassHandle, PassHandle, ResourceHandle)>,
    /// The passes with writes that outlive the frame.
    pub(crate) lasting: BTreeSet<PassHandle>,
    /// For each history, the passes whose writes remain for later frames.
    pub(crate) carried: HashMap<ResourceHandle, BTreeSet<PassHandle>>,
}

/// One access with its pass and the regions that it covers.
pub(crate) struct Event<'a> {
    pub(crate) pass: PassHandle,
    pub(crate) one: &'a Access,
    pub(crate) regions: Vec<usize>,
}

/// The accesses of one resource.
pub(crate) struct Uses<'a> {
    pub(crate) plan: &'a Plan,
    pub(crate) schedule: &'a Schedule,
    pub(crate) handle: ResourceHandle,
    /// The accesses by planned passes in execution order, then those by culled passes.
    pub(crate) events: Vec<Event<'a>>,
    pub(crate) regions: Regions,
}

/// The division of one resource into regions, by mips, layers, aspects and bytes. Each access covers whole regions.
pub(crate) struct Regions {
    axes: [Axis; 4],
}

/// One dimension of a resource (mips, layers, aspects or bytes), cut at each position where an access begins or ends.
struct Axis {
    cuts: Vec<u64>,
}

impl Axis {
    fn new(runs: impl Iterator<Item = Option<(u64, u64)>>) -> Self {
        let cuts: BTreeSet<u64> = runs.flatten().flat_map(|(first, end)| [first, end]).collect();
        Self { cuts: cuts.into_iter().collect() }
    }

    /// Returns the number of pieces: those between cuts, and one more for the rest.
    fn count(&self) -> usize {
        self.cuts.len().max(1)
    }

    /// Returns the extents of a piece as half-open ranges; the last piece covers all that no access names.
    fn piece(&self, at: usize) -> Vec<(u64, u64)> {
        match (self.cuts.get(at), self.cuts.get(at + 1)) {
            (Some(first), Some(end)) => vec![(*first, *end)],
            (Some(last), None) => vec![(0, self.cuts[0]), (*last, u64::MAX)],
            _ => vec![(0, u64::MAX)],
        }
    }

    fn of(&self, run: Option<(u64, u64)>) -> std::ops::Range<usize> {
        let at = |cut: u64| self.cuts.partition_point(|known| *known < cut);
        run.map_or(0..self.count(), |(first, end)| at(first)..at(end))
    }
}

/// Returns the half-open extents of a subresource range in mips, layers, aspects and bytes; `None` covers the whole
/// dimension.
pub(crate) fn extents(range: SubresourceRange) -> [Option<(u64, u64)>; 4] {
    let aspect = match range.aspect {
        Aspect::All => None,
        Aspect::DepthOnly => Some((0, 1)),
        Aspect::StencilOnly => Some((1, 2)),
    };
    [
        range.mip.map(|run| (u64::from(run.first), run.end())),
        range.layer.map(|run| (u64::from(run.first), run.end())),
        aspect,
        range.bytes.map(|run| (run.first, run.end())),
    ]
}

impl Regions {
    pub(crate) fn new<'a>(accesses: impl Iterator<Item = &'a Access> + Clone) -> Self {
        let axis = |at: usize| Axis::new(accesses.clone().map(move |one| extents(one.range)[at]));
        let mut axes = [axis(0), axis(1), axis(2), axis(3)];
        // Beside depth and stencil there is nothing: the second piece is the rest.
        if !axes[2].cuts.is_empty() {
            axes[2].cuts = vec![0, 1];
        }
        Self { axes }
    }

    pub(crate) fn count(&self) -> usize {
        self.axes.iter().map(Axis::count).product()
    }

    /// Returns the half-open extents of a region in mips, layers, aspects and bytes.
    pub(crate) fn pieces(&self, mut region: usize) -> [Vec<(u64, u64)>; 4] {
        let mut pieces = [const { Vec::new() }; 4];
        for (axis, pieces) in self.axes.iter().zip(&mut pieces).rev() {
            *pieces = axis.piece(region % axis.count());
            region /= axis.count();
        }
        pieces
    }

    pub(crate) fn of(&self, range: SubresourceRange) -> Vec<usize> {
        let mut regions = vec![0];
        for (axis, extent) in self.axes.iter().zip(extents(range)) {
            let pieces = axis.of(extent);
            regions = regions
                .into_iter()
                .flat_map(|region| pieces.clone().map(move |piece| region * axis.count() + piece))
                .collect();
        }
        regions
    }
}

impl<'a> Uses<'a> {
    /// Returns the accesses by planned passes, in execution order.
    pub(crate) fn planned(&self) -> &[Event<'a>] {
        let is_planned = |event: &Event<'_>| self.schedule.of(event.pass).is_some();
        &self.events[..self.events.partition_point(is_planned)]
    }

    /// Returns the toggle conditions of an access: the condition of its pass, and its own conditions.
    pub(crate) fn conditions(&self, event: &Event<'_>) -> impl Iterator<Item = Condition> {
        self.plan.pipeline.pass(event.pass).condition.into_iter().chain(event.one.when.iter().copied())
    }

    /// Returns `true` if an access is an attachment that the plan does not store.
    pub(crate) fn drops(&self, event: &Event<'_>) -> bool {
        if !event.one.usage.is_attachment() {
            return false;
        }
        let Some(planned) = self.schedule.of(event.pass).and_then(|at| self.plan.passes.get(at)) else {
            return false;
        };
        let (depth, stencil) = (event.one.usage.is_depth(), event.one.usage.is_stencil());
        let color = planned.color.iter().filter(|_| !depth && !stencil);
        let depth = planned.depth.iter().filter(|_| depth);
        color.chain(depth).chain(planned.stencil.iter().filter(|_| stencil)).any(|attachment| {
            attachment.target.resource == event.one.resource
                && event.one.range.mip == Some(IndexRange::one(attachment.target.mip))
                && event.one.range.layer == attachment.target.layer.map(IndexRange::one)
                && attachment.store == StoreOperation::Discard
        })
    }

    /// Returns `true` if a pass clears or discards a region at its start, or declares that it replaces the region.
    /// `writers` are those of the region, each with `true` if it loads.
    pub(crate) fn covers(&self, pass: PassHandle, writers: &[(PassHandle, bool)]) -> bool {
        let loads = writers.iter().any(|(writer, loads)| *writer == pass && *loads);
        let attached = self.plan.pipeline.pass(pass).accesses().iter().any(|one| {
            let texture = self.plan.pipeline.resource(self.handle).texture();
            let one_layer =
                one.range.layer.is_some() || texture.is_some_and(|texture| texture.layers.is_none());
            let attached = one.usage.writes() && one.usage.is_attachment() && one_layer;
            one.resource == self.handle && (attached || one.usage == Usage::StorageReplace)
        });
        !loads && attached
    }
}
