//! Whether readers use what stands in for a bypassed resource in just the frames without it, and whether that fits.

use super::{FaultKind, Faults};
use crate::compiler::Plan;
use crate::language::TextureShape;
use crate::pipeline::{Condition, Pass, Version};
use crate::work::ResourceHandle;

/// Checks the stated toggles and bypasses, the accesses of stand-ins, and that they fit.
pub(super) fn check(plan: &Plan, faults: &mut Faults) {
    let stated: Vec<(&String, bool)> = plan.toggles.iter().map(|(name, on)| (name, *on)).collect();
    if stated != plan.pipeline.toggles.iter().map(|one| (&one.name, one.default)).collect::<Vec<_>>() {
        let message = "the plan has other toggles than the pipeline".to_owned();
        faults.add(FaultKind::ToggleWrong, message);
    }
    for planned in &plan.passes {
        let pass = plan.pipeline.pass(planned.handle);
        let toggle = pass.condition.map(|condition| {
            let name = plan.pipeline.toggles.get(condition.toggle).map_or("", |toggle| toggle.name.as_str());
            if condition.on { name.to_owned() } else { format!("!{name}") }
        });
        if planned.toggle != toggle || !states_bypasses(plan, pass, &planned.bypass) {
            let message = format!("the plan is wrong about the toggle or the bypass of \"{}\"", planned.name);
            faults.add(FaultKind::ToggleWrong, message);
        }
        for one in pass.accesses().iter().filter(|one| !one.usage.writes()) {
            let Some(bypass) = plan.pipeline.bypasses.get(&one.resource) else { continue };
            if pass.condition == Some(bypass.condition) {
                continue;
            }
            let name = &plan.pipeline.resource(one.resource).name;
            if !one.when.contains(&bypass.condition) {
                let message = format!("\"{}\" uses \"{name}\" also in frames without it", pass.name);
                faults.add(FaultKind::BypassMissing, message);
            }
            // Without this resource, and in what other states the access happens.
            let otherwise = |condition: &Condition| {
                if *condition == bypass.condition {
                    Condition { toggle: condition.toggle, on: !condition.on }
                } else {
                    *condition
                }
            };
            let wanted: Vec<Condition> = one.when.iter().map(otherwise).collect();
            let found = pass.accesses().iter().any(|other| {
                other.resource == bypass.stand_in
                    && other.version == bypass.version
                    && (other.usage, other.range) == (one.usage, one.range)
                    && happens_where(plan, &other.when, bypass.stand_in, &wanted)
            });
            if !found {
                let message = format!("\"{}\" reads nothing in place of \"{name}\"", pass.name);
                faults.add(FaultKind::BypassMissing, message);
            }
        }
    }
    for (resource, bypass) in &plan.pipeline.bypasses {
        if !fits(plan, *resource, bypass.stand_in) {
            let message = format!(
                "\"{}\" cannot stand in for \"{}\"",
                plan.pipeline.resource(bypass.stand_in).name,
                plan.pipeline.resource(*resource).name
            );
            faults.add(FaultKind::BypassMisfit, message);
        }
    }
}

/// Whether an access of a stand-in happens in every state that is wanted, but for those in which it is bypassed itself.
fn happens_where(plan: &Plan, when: &[Condition], stand_in: ResourceHandle, wanted: &[Condition]) -> bool {
    let own = plan.pipeline.bypasses.get(&stand_in).map(|bypass| bypass.condition);
    when.iter().all(|condition| wanted.contains(condition) || Some(*condition) == own)
}

fn states_bypasses(plan: &Plan, pass: &Pass, stated: &std::collections::BTreeMap<String, String>) -> bool {
    let mut count = 0;
    for (resource, bypass) in &plan.pipeline.bypasses {
        if !pass.accesses().iter().any(|one| one.resource == *resource && one.usage.writes()) {
            continue;
        }
        let mut stand_in = plan.pipeline.resource(bypass.stand_in).name.clone();
        match &bypass.version {
            Version::WrittenBy(writer) => stand_in.extend(["@", writer]),
            Version::Before => stand_in.push_str("@0"),
            Version::Newest => {}
        }
        if stated.get(&plan.pipeline.resource(*resource).name) != Some(&stand_in) {
            return false;
        }
        count += 1;
    }
    stated.len() == count
}

fn fits(plan: &Plan, resource: ResourceHandle, stand_in: ResourceHandle) -> bool {
    let name = |handle: ResourceHandle| &plan.pipeline.resource(handle).name;
    let (Some(own), Some(other)) = (plan.resources.get(name(resource)), plan.resources.get(name(stand_in)))
    else {
        return true;
    };
    let shape = |handle: ResourceHandle| {
        let view = plan.pipeline.resource(handle).texture().and_then(|texture| texture.view);
        view.unwrap_or(TextureShape::D2)
    };
    match (own.size, other.size) {
        (Some(a), Some(b)) => {
            (a.samples, a.layers, shape(resource)) == (b.samples, b.layers, shape(stand_in))
        }
        (None, None) => other.bytes >= own.bytes,
        _ => false,
    }
}
