//! Checks that a plan has the pipeline's passes in an order that the document allows, and culls only passes without
//! effect.

use std::collections::{HashMap, HashSet};

use crate::regions::Flow;
use crate::schedule::Schedule;
use crate::violation::{ViolationKind as Kind, Violations};
use umbragraph_compiler::{CullReason, KeepReason, Kept, Plan};
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::{Access, History, Pass, SubresourceRange, TypedPipeline};
use umbragraph_pipeline::work::{Dispatch, PassHandle, ResourceHandle, Work};

/// The maximum number of writers of a resource, with ranges or toggles, for which a plan must state readers exactly.
const TOLD_APART: usize = 64;

/// Checks the passes of a plan, their order and workgroup counts, and returns the schedule. `None` if a planned pass is
/// not in the pipeline.
pub(crate) fn check(plan: &Plan, violations: &mut Violations) -> Option<Schedule> {
    let passes = &plan.pipeline.passes;
    let mut at = vec![None; passes.len()];
    let mut known = true;
    for (position, planned) in plan.passes.iter().enumerate() {
        let Some(pass) = passes.get(planned.handle.index()) else {
            let message = format!("the plan runs \"{}\", which the pipeline does not have", planned.name);
            violations.add(Kind::PassUnknown, message);
            known = false;
            continue;
        };
        if pass.name != planned.name || pass.kind != planned.kind {
            violations.add(
                Kind::NameWrong,
                format!("the plan calls the pass \"{}\" \"{}\" ({})", pass.name, planned.name, planned.kind),
            );
        }
        if at[planned.handle.index()].replace(position).is_some() {
            violations.add(Kind::PassTwice, format!("the plan runs \"{}\" twice", pass.name));
        }
    }
    let by_name: HashMap<&str, usize> =
        passes.iter().enumerate().map(|(index, pass)| (pass.name.as_str(), index)).collect();
    for name in plan.culled.keys() {
        match by_name.get(name.as_str()) {
            None => violations.add(
                Kind::PassUnknown,
                format!("the plan culls \"{name}\", which the pipeline does not have"),
            ),
            Some(index) if at[*index].is_some() => {
                violations.add(Kind::PassTwice, format!("the plan both runs and culls \"{name}\""));
            }
            Some(_) => {}
        }
    }
    for (index, pass) in passes.iter().enumerate() {
        if at[index].is_none() && !plan.culled.contains_key(&pass.name) {
            violations.add(Kind::PassMissing, format!("the plan neither runs nor culls \"{}\"", pass.name));
        }
    }
    let schedule = known.then_some(Schedule { at })?;
    check_after(plan, &schedule, violations);
    check_workgroups(plan, violations);
    Some(schedule)
}

/// Checks that each pass runs after the passes in its `after`, also those reached through culled passes.
fn check_after(plan: &Plan, schedule: &Schedule, violations: &mut Violations) {
    for planned in &plan.passes {
        let mut seen = HashSet::new();
        let mut stack = plan.pipeline.pass(planned.handle).after.clone();
        while let Some(before) = stack.pop().filter(|_| seen.len() <= plan.pipeline.passes.len()) {
            if !seen.insert(before) {
                continue;
            }
            match schedule.of(before) {
                Some(at) if Some(at) > schedule.of(planned.handle) => violations.add(
                    Kind::AfterViolated,
                    format!(
                        "\"{}\" runs before \"{}\", which it has to follow",
                        planned.name,
                        plan.pipeline.pass(before).name
                    ),
                ),
                Some(_) => {}
                None => stack.extend(&plan.pipeline.pass(before).after),
            }
        }
    }
}

fn check_workgroups(plan: &Plan, violations: &mut Violations) {
    let limit = plan.pipeline.profile.limits.max_compute_workgroups_per_dimension;
    for planned in &plan.passes {
        let is_compute = matches!(
            plan.pipeline.pass(planned.handle).work(),
            Work::Compute(compute) if !matches!(compute.dispatch, Dispatch::Indirect { .. })
        );
        let fits = planned.workgroups.is_none_or(|counts| counts.iter().all(|count| *count <= limit));
        if is_compute != planned.workgroups.is_some() || !fits {
            let message = format!("\"{}\" has the workgroups {:?}", planned.name, planned.workgroups);
            violations.add(Kind::WorkgroupsWrong, message);
        }
    }
}

/// Checks that kept passes have an effect, culled passes have none, and the stated reasons are true.
pub(crate) fn check_reasons(plan: &Plan, schedule: &Schedule, flow: &Flow, violations: &mut Violations) {
    let pipeline = &plan.pipeline;
    let mut needed: HashSet<PassHandle> = flow.lasting.iter().copied().collect();
    needed.extend(pipeline.pass_handles().filter(|pass| pipeline.pass(*pass).side_effect));
    let mut feeders: HashMap<PassHandle, Vec<PassHandle>> = HashMap::new();
    for (writer, reader, _) in &flow.feeds {
        feeders.entry(*reader).or_default().push(*writer);
    }
    for planned in &plan.passes {
        match planned.reason {
            KeepReason::MayBeReadBy((reader, resource))
                if may_feed(plan, planned.handle, reader, resource) =>
            {
                feeders.entry(reader).or_default().push(planned.handle);
            }
            KeepReason::MayBeLeft(resource) if may_leave(plan, planned.handle, resource) => {
                needed.insert(planned.handle);
            }
            _ => {}
        }
    }
    let mut stack: Vec<PassHandle> = needed.iter().copied().collect();
    while let Some(pass) = stack.pop() {
        // What earlier frames are read of, those feed that write this frame of it.
        let earlier =
            pipeline.pass(pass).accesses().iter().filter_map(|one| earlier_frame(plan, one.resource));
        let carried = earlier.flat_map(|history| flow.carried.get(&history.of)).flatten();
        for writer in feeders.get(&pass).into_iter().flatten().chain(carried) {
            if needed.insert(*writer) {
                stack.push(*writer);
            }
        }
    }
    for planned in &plan.passes {
        if !needed.contains(&planned.handle) {
            let message = format!("\"{}\" leads to no output, but is kept", planned.name);
            violations.add(Kind::KeptWithoutReason, message);
        }
        if !reason_holds(plan, schedule, flow, planned.handle, planned.reason)
            || !says(plan, planned.reason, &planned.kept)
        {
            violations
                .add(Kind::WrongReason, format!("the reason for keeping \"{}\" does not hold", planned.name));
        }
    }
    for pass in pipeline.pass_handles().filter(|pass| schedule.of(*pass).is_none()) {
        let declared = pipeline.pass(pass);
        if declared.side_effect {
            let message = format!("\"{}\" has a side effect, but is culled", declared.name);
            violations.add(Kind::CulledButNeeded, message);
        }
        if let Some(reason) = plan.culled.get(&declared.name)
            && !cull_holds(plan, pass, reason)
        {
            let message = format!("the reason for culling \"{}\" does not hold", declared.name);
            violations.add(Kind::WrongCullReason, message);
        }
    }
}

fn reason_holds(plan: &Plan, schedule: &Schedule, flow: &Flow, pass: PassHandle, reason: KeepReason) -> bool {
    match reason {
        KeepReason::SideEffect => plan.pipeline.pass(pass).side_effect,
        KeepReason::Output(resource) => {
            let lasts = plan
                .pipeline
                .resources
                .get(resource.index())
                .is_some_and(|one| matches!(one.lifetime(), Lifetime::Persistent | Lifetime::Imported));
            lasts && flow.lasting.contains(&pass)
        }
        KeepReason::ReadBy((reader, resource)) => {
            schedule.of(reader) > schedule.of(pass) && flow.feeds.contains(&(pass, reader, resource))
        }
        KeepReason::MayBeReadBy((reader, resource)) => {
            schedule.of(reader) > schedule.of(pass) && may_feed(plan, pass, reader, resource)
        }
        KeepReason::MayBeLeft(resource) => may_leave(plan, pass, resource),
        KeepReason::ReadLater((reader, resource)) => {
            let read = plan.pipeline.passes.get(reader.index()).is_some_and(|reader| {
                reader.accesses().iter().any(|one| one.resource == resource && one.usage.reads())
            });
            let carries = earlier_frame(plan, resource)
                .and_then(|history| flow.carried.get(&history.of))
                .is_some_and(|writers| writers.contains(&pass));
            schedule.of(reader).is_some() && read && carries
        }
    }
}

fn says(plan: &Plan, reason: KeepReason, words: &Kept) -> bool {
    let TypedPipeline { resources, passes, .. } = &*plan.pipeline;
    let is_of = |handle: ResourceHandle, name: &String| {
        resources.get(handle.index()).is_some_and(|resource| resource.name == *name)
    };
    match (reason, words) {
        (KeepReason::SideEffect, Kept::SideEffect) => true,
        (KeepReason::Output(handle), Kept::Output(name))
        | (KeepReason::MayBeLeft(handle), Kept::MayBeLeft(name)) => is_of(handle, name),
        (KeepReason::ReadBy((reader, handle)), Kept::ReadBy(names))
        | (KeepReason::ReadLater((reader, handle)), Kept::ReadLater(names))
        | (KeepReason::MayBeReadBy((reader, handle)), Kept::MayBeReadBy(names)) => {
            let is_reader = passes.get(reader.index()).is_some_and(|pass| pass.name == names.pass);
            is_reader && is_of(handle, &names.resource)
        }
        _ => false,
    }
}

/// Returns `true` if a resource has more than [`TOLD_APART`] writers with ranges or toggles, so that a plan may treat
/// them coarsely.
fn has_many_writers(plan: &Plan, resource: ResourceHandle) -> bool {
    let writes = |pass: &&Pass| {
        let written = |one: &Access| one.resource == resource && one.usage.writes();
        pass.accesses()
            .iter()
            .any(|one| written(one) && (pass.condition.is_some() || one.range != SubresourceRange::WHOLE))
    };
    plan.pipeline.passes.iter().filter(writes).nth(TOLD_APART).is_some()
}

/// Returns `true` if a pass writes a subresource range that overlaps what a reader reads, and the resource has many
/// writers.
fn may_feed(plan: &Plan, pass: PassHandle, reader: PassHandle, resource: ResourceHandle) -> bool {
    let (pass, reader) =
        match (plan.pipeline.passes.get(pass.index()), plan.pipeline.passes.get(reader.index())) {
            (Some(pass), Some(reader)) => (pass, reader),
            _ => return false,
        };
    let read = reader.accesses().iter().filter(|one| one.resource == resource && one.usage.reads());
    let meets = |read: &Access| {
        let written = |one: &&Access| one.resource == resource && one.usage.writes();
        pass.accesses().iter().filter(written).any(|one| one.range.overlaps(read.range))
    };
    has_many_writers(plan, resource) && read.into_iter().any(meets)
}

/// Returns `true` if a pass writes a resource that outlives the frame and has many writers.
fn may_leave(plan: &Plan, pass: PassHandle, resource: ResourceHandle) -> bool {
    let writes = |one: &Access| one.resource == resource && one.usage.writes();
    plan.pipeline.resources.get(resource.index()).is_some_and(|one| one.lifetime() != Lifetime::Transient)
        && plan.pipeline.passes.get(pass.index()).is_some_and(|pass| pass.accesses().iter().any(writes))
        && has_many_writers(plan, resource)
}

/// Returns the position of a resource in its history; `None` unless the resource is an earlier frame.
fn earlier_frame(plan: &Plan, resource: ResourceHandle) -> Option<History> {
    plan.pipeline.resources.get(resource.index())?.history.filter(|history| history.back > 0)
}

fn cull_holds(plan: &Plan, pass: PassHandle, reason: &CullReason) -> bool {
    let accesses = plan.pipeline.pass(pass).accesses();
    let writes = |name: &String| {
        accesses.iter().any(|one| one.usage.writes() && plan.pipeline.resource(one.resource).name == *name)
    };
    match reason {
        CullReason::WritesNothing => !accesses.iter().any(|one| one.usage.writes()),
        CullReason::NothingReads(resources) => !resources.is_empty() && resources.iter().all(writes),
        CullReason::OnlyCulledRead(readers) => {
            !readers.is_empty() && readers.iter().all(|reader| plan.culled.contains_key(reader))
        }
    }
}
