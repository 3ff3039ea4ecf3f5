//! Differences between two plans, in words: passes, their order and work, resources, variants, bytes.

use std::collections::{BTreeMap, BTreeSet};

use super::model::{AttachmentReport, PassReport, Report, ResourceReport, bytes_in_words};
use super::settings::word;
use super::variants;

/// Returns the differences between two plans, one line each; empty if the plans do not differ.
pub fn diff(before: &Report, after: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    if before.viewport != after.viewport {
        let [old, new] =
            [before, after].map(|report| format!("{}×{}", report.viewport[0], report.viewport[1]));
        lines.push(format!("the viewport is {new}, it was {old}"));
    }
    if before.objective != after.objective {
        lines.push(format!("the order is chosen for {}, it was for {}", after.objective, before.objective));
    }
    passes(before, after, &mut lines);
    order(before, after, &mut lines);
    resources(before, after, &mut lines);
    for (what, old, new) in [
        ("created", before.memory.created, after.memory.created),
        ("used without aliasing", before.memory.without_aliasing, after.memory.without_aliasing),
        ("alive at most", before.memory.peak, after.memory.peak),
    ] {
        if old != new {
            let (sign, change) = if new > old { ("more", new - old) } else { ("less", old - new) };
            lines.push(format!(
                "{} are {what}, {} {sign} than before ({})",
                bytes_in_words(new),
                bytes_in_words(change),
                bytes_in_words(old)
            ));
        }
    }
    lines
}

fn passes(before: &Report, after: &Report, lines: &mut Vec<String>) {
    let by_name = |report: &'_ Report| -> BTreeMap<String, PassReport> {
        report.passes.iter().map(|pass| (pass.name.clone(), pass.clone())).collect()
    };
    let (old, new) = (by_name(before), by_name(after));
    let reason = |pass: &PassReport| pass.why.first().cloned().unwrap_or_default();
    for pass in new.values().filter(|pass| !old.contains_key(&pass.name)) {
        let state = if pass.live { "" } else { ", but culled" };
        lines.push(format!("the pass {} ({}) is new{state}", pass.name, pass.kind));
    }
    for pass in old.values().filter(|pass| !new.contains_key(&pass.name)) {
        lines.push(format!("the pass {} ({}) is gone", pass.name, pass.kind));
    }
    for (name, old) in &old {
        let Some(new) = new.get(name) else { continue };
        match (old.live, new.live) {
            (true, false) => lines.push(format!("the pass {name} is culled now: {}", reason(new))),
            (false, true) => lines.push(format!("the pass {name} is no longer culled: {}", reason(new))),
            _ => {}
        }
        if old.kind != new.kind {
            lines.push(format!("the pass {name} is of the kind {}, it was {}", new.kind, old.kind));
        }
        if old.toggle != new.toggle {
            let words = |toggle: &Option<String>| {
                toggle.as_ref().map_or("no toggle".to_owned(), |toggle| format!("the toggle {toggle}"))
            };
            let (now, before) = (words(&new.toggle), words(&old.toggle));
            lines.push(format!("the pass {name} has {now}, it had {before}"));
        }
        names(&format!("without the pass {name} readers see"), &old.passthrough, &new.passthrough, lines);
        for (verb, old, new) in [("reads", &old.reads, &new.reads), ("writes", &old.writes, &new.writes)] {
            names(&format!("the pass {name} {verb}"), old, new, lines);
        }
        if old.live && new.live {
            attachments(name, &old.attachments, &new.attachments, lines);
            settings(name, &old.settings, &new.settings, lines);
            variants::compare(name, &old.variants, &new.variants, lines);
            if old.workgroups != new.workgroups {
                let words = |counts: Option<[u32; 3]>| {
                    counts.map_or("none".to_owned(), |[x, y, z]| format!("{x}×{y}×{z}"))
                };
                lines.push(format!(
                    "the pass {name} runs {} workgroups, it was {}",
                    words(new.workgroups),
                    words(old.workgroups)
                ));
            }
        }
    }
}

fn names(what: &str, old: &[String], new: &[String], lines: &mut Vec<String>) {
    let (old, new): (BTreeSet<_>, BTreeSet<_>) = (old.iter().collect(), new.iter().collect());
    for name in new.difference(&old) {
        lines.push(format!("{what} {name} now"));
    }
    for name in old.difference(&new) {
        lines.push(format!("{what} {name} no longer"));
    }
}

fn attachments(pass: &str, old: &[AttachmentReport], new: &[AttachmentReport], lines: &mut Vec<String>) {
    for new in new {
        let Some(old) = old.iter().find(|old| old.resource == new.resource && old.kind == new.kind) else {
            continue;
        };
        if (&old.load, &old.store) != (&new.load, &new.store) {
            lines.push(format!(
                "the pass {pass} does {} and {} with {}, it was {} and {}",
                new.load, new.store, new.resource, old.load, old.store
            ));
        }
    }
}

fn settings(
    pass: &str,
    old: &BTreeMap<String, String>,
    new: &BTreeMap<String, String>,
    lines: &mut Vec<String>,
) {
    let all: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    for setting in all {
        match (old.get(setting), new.get(setting)) {
            (Some(old), Some(new)) if old != new => {
                lines.push(format!("the pass {pass} has the {setting} {new}, it was {old}"));
            }
            (None, Some(new)) => lines.push(format!("the pass {pass} has the {setting} {new}, it had none")),
            (Some(old), None) => lines.push(format!("the pass {pass} has no {setting}, it was {old}")),
            _ => {}
        }
    }
}

/// Adds lines that name the passes of both plans whose order differs.
fn order(before: &Report, after: &Report, lines: &mut Vec<String>) {
    let live = |report: &Report| -> Vec<String> {
        report.passes.iter().filter(|pass| pass.live).map(|pass| pass.name.clone()).collect()
    };
    let (old, new) = (live(before), live(after));
    let positions: BTreeMap<&String, usize> = old.iter().enumerate().map(|(at, name)| (name, at)).collect();
    let common: Vec<(&String, usize)> =
        new.iter().filter_map(|name| Some((name, *positions.get(name)?))).collect();
    // The passes outside a longest run in the old order are those that moved.
    let stayed: BTreeSet<usize> =
        longest_increasing(&common.iter().map(|(_, at)| *at).collect::<Vec<_>>()).into_iter().collect();
    for (at, (name, position)) in common.iter().enumerate() {
        if !stayed.contains(position) {
            match at.checked_sub(1).map(|before| common[before].0) {
                Some(before) => lines.push(format!("the pass {name} runs after {before} now")),
                None => lines.push(format!("the pass {name} runs first now")),
            }
        }
    }
}

/// Returns a longest increasing subsequence of distinct numbers, found by patience sorting.
fn longest_increasing(list: &[usize]) -> Vec<usize> {
    let mut tails: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = vec![None; list.len()];
    for (at, value) in list.iter().enumerate() {
        let place = tails.partition_point(|tail| list[*tail] < *value);
        before[at] = place.checked_sub(1).map(|previous| tails[previous]);
        if place == tails.len() { tails.push(at) } else { tails[place] = at }
    }
    let mut run = Vec::new();
    let mut next = tails.last().copied();
    while let Some(at) = next {
        run.push(list[at]);
        next = before[at];
    }
    run.reverse();
    run
}

fn resources(before: &Report, after: &Report, lines: &mut Vec<String>) {
    let by_name = |report: &Report| -> BTreeMap<String, ResourceReport> {
        report.resources.iter().filter(|one| one.live).map(|one| (one.name.clone(), one.clone())).collect()
    };
    let (old, new) = (by_name(before), by_name(after));
    for resource in new.values().filter(|one| !old.contains_key(&one.name)) {
        lines.push(format!("the resource {} is new: {}", resource.name, resource.description));
    }
    for resource in old.values().filter(|one| !new.contains_key(&one.name)) {
        lines.push(format!(
            "the resource {} is gone, {} with it",
            resource.name,
            bytes_in_words(resource.bytes)
        ));
    }
    for (name, old) in &old {
        let Some(new) = new.get(name) else { continue };
        if old.description != new.description {
            lines.push(format!("the resource {name} is {}, it was {}", new.description, old.description));
        }
        if let (Some(old), Some(new)) = (old.frames, new.frames)
            && old != new
        {
            lines.push(format!("the resource {name} keeps {new} earlier frames, it was {old}"));
        }
        if old.lifetime != new.lifetime {
            let [old, new] = [old, new].map(|one| word(&one.lifetime));
            lines.push(format!("the resource {name} is {new}, it was {old}"));
        }
        names(&format!("the resource {name} shares memory with"), &old.shares_with, &new.shares_with, lines);
    }
}

#[cfg(test)]
mod tests {
    use super::longest_increasing;

    #[test]
    fn what_moved_is_what_a_longest_run_leaves_out() {
        assert_eq!(longest_increasing(&[0, 3, 1, 2, 4]), [0, 1, 2, 4]);
        assert_eq!(longest_increasing(&[2, 1, 0]).len(), 1);
        assert!(longest_increasing(&[]).is_empty());
    }
}
