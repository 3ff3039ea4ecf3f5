//! Whether readers use the fallback of a resource with a passthrough in just the frames without it, and whether that
//! fits.

use crate::violation::{ViolationKind as Kind, Violations};
use umbragraph_compiler::Plan;
use umbragraph_pipeline::language::TextureShape;
use umbragraph_pipeline::pipeline::{Condition, Pass, Version};
use umbragraph_pipeline::work::ResourceHandle;

/// Checks the toggles and passthroughs in the plan, and the accesses and properties of fallbacks.
pub(crate) fn check(plan: &Plan, violations: &mut Violations) {
    let stated: Vec<(&String, bool)> = plan.toggles.iter().map(|(name, on)| (name, *on)).collect();
    if stated != plan.pipeline.toggles.iter().map(|one| (&one.name, one.default)).collect::<Vec<_>>() {
        let message = "the plan has other toggles than the pipeline".to_owned();
        violations.add(Kind::ToggleWrong, message);
    }
    for planned in &plan.passes {
        let pass = plan.pipeline.pass(planned.handle);
        let toggle = pass.condition.map(|condition| {
            let name = plan.pipeline.toggles.get(condition.toggle).map_or("", |toggle| toggle.name.as_str());
            if condition.on { name.to_owned() } else { format!("!{name}") }
        });
        if planned.toggle != toggle || !states_passthroughs(plan, pass, &planned.passthrough) {
            let message =
                format!("the plan is wrong about the toggle or the passthrough of \"{}\"", planned.name);
            violations.add(Kind::ToggleWrong, message);
        }
        for one in pass.accesses().iter().filter(|one| !one.usage.writes()) {
            let Some(passthrough) = plan.pipeline.passthroughs.get(&one.resource) else { continue };
            if pass.condition == Some(passthrough.condition) {
                continue;
            }
            let name = &plan.pipeline.resource(one.resource).name;
            if !one.when.contains(&passthrough.condition) {
                let message = format!("\"{}\" uses \"{name}\" also in frames without it", pass.name);
                violations.add(Kind::PassthroughMissing, message);
            }
            // Without this resource, and in what other states the use happens, if there are any such frames.
            let mut wanted = one.when.clone();
            if let Some(at) = wanted.iter().position(|condition| *condition == passthrough.condition) {
                wanted[at] = passthrough.condition.opposite();
            }
            let known: Vec<Condition> = wanted.iter().chain(&pass.condition).copied().collect();
            if known.iter().any(|condition| known.contains(&condition.opposite())) {
                continue;
            }
            let found = pass.accesses().iter().any(|other| {
                other.resource == passthrough.fallback
                    && other.version == passthrough.version
                    && (other.usage, other.range) == (one.usage, one.range)
                    && happens_where(plan, &other.when, passthrough.fallback, &wanted)
            });
            if !found {
                let message = format!("\"{}\" reads nothing in place of \"{name}\"", pass.name);
                violations.add(Kind::PassthroughMissing, message);
            }
        }
    }
    for (resource, passthrough) in &plan.pipeline.passthroughs {
        if !fits(plan, *resource, passthrough.fallback) {
            let message = format!(
                "\"{}\" cannot be the fallback of \"{}\"",
                plan.pipeline.resource(passthrough.fallback).name,
                plan.pipeline.resource(*resource).name
            );
            violations.add(Kind::PassthroughMisfit, message);
        }
    }
}

/// Returns `true` if an access of a fallback with the conditions `when` happens in every toggle state that satisfies
/// `wanted`. States in which the fallback's own passthrough applies are excepted.
fn happens_where(plan: &Plan, when: &[Condition], fallback: ResourceHandle, wanted: &[Condition]) -> bool {
    let own = plan.pipeline.passthroughs.get(&fallback).map(|passthrough| passthrough.condition);
    when.iter().all(|condition| wanted.contains(condition) || Some(*condition) == own)
}

fn states_passthroughs(
    plan: &Plan,
    pass: &Pass,
    stated: &std::collections::BTreeMap<String, String>,
) -> bool {
    let mut count = 0;
    for (resource, passthrough) in &plan.pipeline.passthroughs {
        if !pass.accesses().iter().any(|one| one.resource == *resource && one.usage.writes()) {
            continue;
        }
        let mut fallback = plan.pipeline.resource(passthrough.fallback).name.clone();
        match &passthrough.version {
            Version::WrittenBy(writer) => fallback.extend(["@", writer]),
            Version::Before => fallback.push_str("@0"),
            Version::Newest => {}
        }
        if stated.get(&plan.pipeline.resource(*resource).name) != Some(&fallback) {
            return false;
        }
        count += 1;
    }
    stated.len() == count
}

fn fits(plan: &Plan, resource: ResourceHandle, fallback: ResourceHandle) -> bool {
    let name = |handle: ResourceHandle| &plan.pipeline.resource(handle).name;
    let (Some(own), Some(other)) = (plan.resources.get(name(resource)), plan.resources.get(name(fallback)))
    else {
        return true;
    };
    let shape = |handle: ResourceHandle| {
        let view = plan.pipeline.resource(handle).texture().and_then(|texture| texture.view_dimension);
        view.unwrap_or(TextureShape::D2)
    };
    match (own.size, other.size) {
        (Some(a), Some(b)) => {
            (a.samples, a.layers, shape(resource)) == (b.samples, b.layers, shape(fallback))
        }
        (None, None) => other.bytes >= own.bytes,
        _ => false,
    }
}
