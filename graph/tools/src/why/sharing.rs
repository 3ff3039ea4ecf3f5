//! The words of why two resources share memory, or do not.

use umbragraph_compiler::{Physical, Plan, PlannedResource};
use umbragraph_pipeline::language::{Lifetime, format_name};

/// The reason why two named resources share memory, or every reason why they do not.
pub fn why_apart(plan: &Plan, first: &str, second: &str) -> Vec<String> {
    let (Some(a), Some(b)) = (plan.resources.get(first), plan.resources.get(second)) else {
        let missing = if plan.resources.contains_key(first) { second } else { first };
        return vec![format!("no pass that runs uses {missing}, so it has no memory at all")];
    };
    if first != second
        && a.physical == b.physical
        && matches!(a.physical, Physical::Texture(_) | Physical::Buffer(_))
    {
        return vec![format!(
            "{first} and {second} share memory: they are of one class, and never alive together"
        )];
    }
    let mut reasons = Vec::new();
    for (name, one) in [(first, a), (second, b)] {
        match (one.physical, one.lifetime) {
            (Physical::Imported, _) => reasons.push(format!("{name} is the host's own")),
            (Physical::Blackboard, _) => reasons.push(format!("{name} is data on the CPU")),
            (_, Lifetime::Transient) if one.conditional => reasons.push(format!(
                "a toggle can switch off what writes {name} first, so it has memory of its own"
            )),
            (_, Lifetime::Transient) => {}
            _ => reasons.push(format!("{name} outlives the frame")),
        }
    }
    differences(plan, first, a, second, b, &mut reasons);
    if a.first <= b.last && b.first <= a.last {
        let at = a.first.max(b.first);
        let pass = plan.passes.get(at).map_or_else(String::new, |pass| format!(", at {} for one", pass.name));
        reasons.push(format!("{first} and {second} are alive together{pass}"));
    }
    if reasons.is_empty() {
        reasons.push(format!("{first} and {second} could share, but each shares with others, and fewer textures are not possible"));
    }
    reasons
}

fn differences(
    plan: &Plan,
    first: &str,
    a: &PlannedResource,
    second: &str,
    b: &PlannedResource,
    reasons: &mut Vec<String>,
) {
    if let (Some(x), Some(y)) = (a.format, b.format) {
        if x != y {
            let (x, y) = (format_name(x), format_name(y));
            reasons.push(format!("{first} is {x}, {second} is {y}"));
        }
    } else if a.format.is_some() != b.format.is_some() {
        reasons.push(format!("{first} and {second} are not both textures"));
    } else if a.bytes.checked_next_power_of_two() != b.bytes.checked_next_power_of_two() {
        let (x, y) = (a.bytes, b.bytes);
        reasons.push(format!(
            "{first} has {x} bytes, {second} has {y}: buffers share up to the same power of two"
        ));
    }
    if let (Some(x), Some(y)) = (a.size, b.size) {
        let pairs = [
            ("a width of", x.width, y.width),
            ("a height of", x.height, y.height),
            ("layers:", x.layers, y.layers),
            ("mips:", x.mips, y.mips),
            ("samples:", x.samples, y.samples),
        ];
        for (what, x, y) in pairs.into_iter().filter(|(_, x, y)| x != y) {
            reasons.push(format!("{first} has {what} {x}, {second} {y}"));
        }
    }
    let textures = a.usages.zip(b.usages).is_some_and(|(x, y)| x != y);
    let buffer = |one: &PlannedResource| match one.physical {
        Physical::Buffer(index) => plan.buffers.get(index).map(|buffer| buffer.usages),
        _ => None,
    };
    let buffers = buffer(a).zip(buffer(b)).is_some_and(|(x, y)| x != y);
    if textures || buffers {
        let what = if textures { "texture" } else { "buffer" };
        reasons.push(format!(
            "{first} and {second} are used in different ways, and a {what} is created for its usages"
        ));
    }
}
