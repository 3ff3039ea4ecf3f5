//! Backward search for the writes that reach a read, for resources with too many toggles to play every state.
//!
//! The search starts at a read of a region, or at the end of the frame, and visits the earlier writers, last first. It
//! carries the toggle conditions of its path. A writer that contradicts them is skipped. Any other writer that stores
//! reaches the read. If the writer can be off, the search continues past it under the condition that it is off.
//!
//! Cost: for each planned pass that claims a reader, the regions that both touch, until one proves the claim; at worst
//! all writers of these regions. For contents that outlive the frame, all writers of all regions.

use std::collections::HashSet;

use rustc_hash::FxHashSet;

use crate::regions::{Flow, Uses};
use umbragraph_compiler::KeepReason;
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::Condition;
use umbragraph_pipeline::work::PassHandle;

/// Adds the data flow of one resource to `flow`: reads that the reasons of planned passes state, and writes that
/// outlive the frame.
pub(crate) fn search(uses: &Uses<'_>, flow: &mut Flow) {
    let (plan, handle, regions) = (uses.plan, uses.handle, uses.regions.count());
    let mut writers: Vec<Vec<usize>> = vec![Vec::new(); regions];
    for (at, event) in uses.planned().iter().enumerate().filter(|(_, event)| event.one.usage.writes()) {
        for region in &event.regions {
            writers[*region].push(at);
        }
    }
    let conditions = uses.events.iter().map(|event| uses.conditions(event).collect()).collect();
    let search = BackwardSearch { uses, conditions, writers };
    for planned in &plan.passes {
        let KeepReason::ReadBy((reader, resource)) = planned.reason else { continue };
        if resource == handle && search.is_seen(planned.handle, reader) {
            flow.feeds.insert((planned.handle, reader, handle));
        }
    }
    let resource = plan.pipeline.resource(handle);
    if resource.lifetime() != Lifetime::Transient {
        let left = (0..regions).flat_map(|region| search.left(region));
        match resource.history {
            Some(_) => flow.carried.entry(handle).or_default().extend(left),
            None => flow.lasting.extend(left),
        }
    }
}

struct BackwardSearch<'a> {
    uses: &'a Uses<'a>,
    /// The toggle conditions of each access, indexed as `uses.events`.
    conditions: Vec<Vec<Condition>>,
    /// For each region, the accesses that write it, in execution order, as indices into `uses.events`.
    writers: Vec<Vec<usize>>,
}

/// The toggle conditions that are known to hold on the path of a search.
struct Known(FxHashSet<Condition>);

impl Known {
    /// Returns `true` if an access with these conditions cannot happen on the path.
    fn contradicts(&self, conditions: &[Condition]) -> bool {
        conditions.iter().any(|one| self.0.contains(&one.opposite()))
    }

    /// Assumes that an access with these conditions does not happen; returns `true` if frames without it exist.
    fn pass(&mut self, conditions: &[Condition]) -> bool {
        let open: Vec<&Condition> = conditions.iter().filter(|one| !self.0.contains(one)).collect();
        if let [one] = open[..] {
            self.0.insert(one.opposite());
        }
        !open.is_empty()
    }
}

impl BackwardSearch<'_> {
    /// Returns `true` if a write of one pass reaches a read of another in some toggle state.
    fn is_seen(&self, writer: PassHandle, reader: PassHandle) -> bool {
        let limit = self.uses.schedule.of(reader);
        let written: HashSet<usize> = self
            .uses
            .events
            .iter()
            .filter(|event| event.pass == writer && event.one.usage.writes())
            .flat_map(|event| event.regions.iter().copied())
            .collect();
        let reads = (0..self.uses.events.len())
            .filter(|at| self.uses.events[*at].pass == reader && self.uses.events[*at].one.usage.reads());
        for at in reads {
            let (read, conditions) = (&self.uses.events[at], &self.conditions[at]);
            for region in read.regions.iter().filter(|region| written.contains(region)) {
                let mut known = Known(conditions.iter().copied().collect());
                if known.contradicts(conditions) {
                    break;
                }
                let list = &self.writers[*region];
                let before =
                    list.partition_point(|at| self.uses.schedule.of(self.uses.events[*at].pass) < limit);
                for at in list[..before].iter().rev() {
                    let (event, conditions) = (&self.uses.events[*at], &self.conditions[*at]);
                    if known.contradicts(conditions) {
                        continue;
                    }
                    if event.pass == writer && !self.uses.drops(event) {
                        return true;
                    }
                    if !known.pass(conditions) {
                        break;
                    }
                }
            }
        }
        false
    }

    /// Returns the passes whose writes to a region remain at the end of the frame in some toggle state.
    fn left(&self, region: usize) -> Vec<PassHandle> {
        let mut known = Known(FxHashSet::default());
        let mut left = Vec::new();
        let list = &self.writers[region];
        let loads: Vec<(PassHandle, bool)> = list
            .iter()
            .map(|at| (self.uses.events[*at].pass, self.uses.events[*at].one.usage.reads()))
            .collect();
        for at in list.iter().rev() {
            let (event, conditions) = (&self.uses.events[*at], &self.conditions[*at]);
            if known.contradicts(conditions) {
                continue;
            }
            let is_dropped = self.uses.drops(event);
            if !is_dropped {
                left.push(event.pass);
            }
            let hides = is_dropped || self.uses.covers(event.pass, &loads);
            if hides && !known.pass(conditions) {
                break;
            }
        }
        left
    }
}
