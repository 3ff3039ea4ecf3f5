//! The difference of two locks in words: the pass, and the axis or value that grew.

use std::collections::{BTreeMap, BTreeSet};

use umbragraph::diagnostic::counted;

use super::text::{with_values, written};
use super::{Figure, Lock, Pipeline, Texts, is_notable};

/// The maximum number of passes that are named in one line.
const NAMES: usize = 4;

/// One difference between two lock files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Change {
    pub(crate) pipeline: String,
    /// The first affected pass; `None` for a difference of the entire pipeline.
    pub(crate) pass: Option<String>,
    /// The description of the difference, without the pipeline's name.
    pub(crate) message: String,
}

/// The description of a difference of a pass: a verb, and its object.
type Body = (&'static str, String);

/// Returns all differences between two lock files, in the order of pipelines and passes.
pub(crate) fn difference(before: &Lock, after: &Lock) -> Vec<Change> {
    let paths: BTreeSet<&String> = before.pipelines.keys().chain(after.pipelines.keys()).collect();
    let mut changes = Vec::new();
    for path in paths {
        let of_whole = |message| vec![Change { pipeline: path.clone(), pass: None, message }];
        changes.extend(match (before.pipelines.get(path), after.pipelines.get(path)) {
            (Some(before), Some(after)) => of_pipeline(path, before, after),
            (None, Some(new)) => {
                let profiles: Vec<&str> = new.profiles().into_iter().collect();
                of_whole(format!("the pipeline is new, with {} for {}", size(new, None), profiles.join(", ")))
            }
            (Some(old), None) => of_whole(format!("the pipeline is gone, with {}", size(old, None))),
            (None, None) => Vec::new(),
        });
    }
    changes
}

/// Describes the numbers of passes and shader sources, for one profile, or for all if `None`.
fn size(pipeline: &Pipeline, profile: Option<&str>) -> String {
    let is_of = |name: &str| profile.is_none_or(|profile| profile == name);
    let mut passes = BTreeSet::new();
    let mut texts: BTreeMap<&str, usize> = BTreeMap::new();
    for ((pass, _), profiles) in &pipeline.programs {
        for own in profiles.iter().filter(|(name, _)| is_of(name)).map(|(_, own)| own) {
            passes.insert(pass);
            texts.insert(&own.hash, own.texts);
        }
    }
    format!("{} and {}", counted(passes.len(), "pass"), counted(texts.values().sum(), "text"))
}

fn of_pipeline(path: &str, before: &Pipeline, after: &Pipeline) -> Vec<Change> {
    let (old, new) = (before.profiles(), after.profiles());
    let mut changes = Vec::new();
    let mut add = |pass: Option<&str>, message| {
        changes.push(Change { pipeline: path.to_owned(), pass: pass.map(str::to_owned), message });
    };
    for profile in new.difference(&old) {
        add(None, format!("profile {profile} added: {}", size(after, Some(profile))));
    }
    for profile in old.difference(&new) {
        add(None, format!("profile {profile} removed: {}", size(before, Some(profile))));
    }
    let common: BTreeSet<&str> = old.intersection(&new).copied().collect();
    // Passes and profiles with the same difference are named together.
    let mut bodies: BTreeMap<(&str, Body), BTreeSet<&str>> = BTreeMap::new();
    let programs = before.programs.keys().chain(after.programs.keys());
    let passes: BTreeSet<&str> = programs.map(|(pass, _)| pass.as_str()).collect();
    for pass in passes {
        for profile in &common {
            for body in of_pass(programs_of(before, pass, profile), programs_of(after, pass, profile)) {
                bodies.entry((pass, body)).or_default().insert(profile);
            }
        }
    }
    let mut together: BTreeMap<(Body, BTreeSet<&str>), BTreeSet<&str>> = BTreeMap::new();
    for ((pass, body), profiles) in bodies {
        together.entry((body, profiles)).or_default().insert(pass);
    }
    let mut all: Vec<_> = together.into_iter().map(|(what, passes)| (passes, what)).collect();
    all.sort();
    for (passes, ((verb, object), profiles)) in all {
        let is_all = profiles == common && profiles.len() > 1;
        let profiles = if is_all { "all profiles".to_owned() } else { join(&profiles) };
        let message = format!("{}{verb} for {profiles}: {object}", named(&passes));
        add(passes.first().copied(), message);
    }
    changes
}

/// Returns the shader sources of a pass for a profile, by template.
fn programs_of<'p>(pipeline: &'p Pipeline, pass: &str, profile: &str) -> BTreeMap<&'p str, &'p Texts> {
    let first = (pass.to_owned(), String::new());
    let own = pipeline.programs.range(first..).take_while(|((name, _), _)| name == pass);
    own.filter_map(|((_, template), profiles)| Some((template.as_str(), profiles.get(profile)?))).collect()
}

fn of_pass(before: BTreeMap<&str, &Texts>, after: BTreeMap<&str, &Texts>) -> Vec<Body> {
    let of = |(template, texts): (&&str, &&Texts)| format!("{} of {template}", counted(texts.texts, "text"));
    let all = |programs: &BTreeMap<&str, &Texts>| programs.iter().map(of).collect::<Vec<_>>().join(", ");
    if before.is_empty() || after.is_empty() {
        let added = (!after.is_empty()).then(|| (" added", all(&after)));
        let removed = (!before.is_empty()).then(|| (" removed", all(&before)));
        return added.into_iter().chain(removed).collect();
    }
    let new: Vec<_> = after.iter().filter(|(template, _)| !before.contains_key(*template)).collect();
    let gone: Vec<_> = before.iter().filter(|(template, _)| !after.contains_key(*template)).collect();
    let both = before.iter().filter_map(|(template, before)| Some((before, after.get(template)?)));
    let mut bodies: Vec<Body> =
        both.filter_map(|(before, after)| Some(("", of_texts(before, after)?))).collect();
    if let ([(old, before)], [(new, after)]) = (&gone[..], &new[..]) {
        let texts = match (before.texts, after.texts) {
            (old, new) if old == new => format!("{} as before", counted(new, "text")),
            (old, new) => format!("{old} -> {new} texts"),
        };
        bodies.push(("", format!("template {old} -> {new}: {texts}")));
    } else {
        bodies.extend(new.into_iter().map(|new| ("", format!("template added: {}", of(new)))));
        bodies.extend(gone.into_iter().map(|old| ("", format!("template removed: {}", of(old)))));
    }
    bodies
}

/// Describes the difference between the shader sources of a template; `None` if they are equal.
fn of_texts(before: &Texts, after: &Texts) -> Option<String> {
    if before == after {
        return None;
    }
    let mut clauses = Vec::new();
    let axes: BTreeSet<&String> = before.axes.keys().chain(after.axes.keys()).collect();
    for axis in axes {
        match (before.axes.get(axis), after.axes.get(axis)) {
            (Some(old), Some(new)) => {
                let said = [("gained", new - old), ("lost", old - new)];
                let said = said.into_iter().filter(|(_, values)| !values.is_empty());
                let said: Vec<String> =
                    said.map(|(verb, values)| format!("{verb} {}", written(&values))).collect();
                if !said.is_empty() {
                    clauses.push(format!("axis {axis} {}", said.join(", ")));
                }
            }
            (None, Some(new)) => {
                clauses.push(format!("axis {axis} added with {}", written(new)));
            }
            (Some(_), None) => clauses.push(format!("axis {axis} removed")),
            (None, None) => {}
        }
    }
    let (old, new) = (before.worst.cost, after.worst.cost);
    if is_notable(old, new) || is_notable(new, old) {
        clauses.push(format!("cost {old} -> {new}{}", with_values(&after.worst.values)));
    }
    let grows = |old: String, new: String, noun: &str| format!("{old} -> {new} {noun}");
    let bytes = || match (before.bytes, after.bytes) {
        (old, new) if old == new => format!("{old} bytes as before"),
        (old, new) => grows(old.to_string(), new.to_string(), "bytes"),
    };
    let size = if before.texts != after.texts {
        grows(before.texts.to_string(), after.texts.to_string(), "texts")
    } else if clauses.is_empty() && before.hash != after.hash {
        // Nothing but their contents.
        let what = if after.texts == 1 { "the text differs" } else { "texts differ" };
        format!("{what}: {}", bytes())
    } else if clauses.is_empty() && before.combinations != after.combinations {
        grows(before.combinations.clone(), after.combinations.clone(), "combinations")
    } else if clauses.is_empty() {
        let figures: [Figure; 5] = [
            ("declarations", |texts| texts.declarations as u64),
            ("bytes in the largest text", |texts| texts.largest as u64),
            ("bindings", |texts| texts.bindings as u64),
            ("registers", |texts| texts.registers),
            ("of cost", |texts| texts.worst.cost),
        ];
        let differs = figures.into_iter().find(|(_, of)| of(before) != of(after));
        let said = differs.map(|(noun, of)| grows(of(before).to_string(), of(after).to_string(), noun));
        said.unwrap_or_else(|| "the values that cause the cost differ".to_owned())
    } else {
        format!("{} as before", counted(after.texts, "text"))
    };
    if clauses.is_empty() {
        return Some(size);
    }
    Some(format!("{}: {size}", clauses.join("; ")))
}

fn named(passes: &BTreeSet<&str>) -> String {
    let names: Vec<String> = passes.iter().take(NAMES).map(|name| format!("\"{name}\"")).collect();
    let noun = if passes.len() == 1 { "pass" } else { "passes" };
    let more = passes.len().saturating_sub(NAMES);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{noun} {}{more}", names.join(", "))
}

fn join(names: &BTreeSet<&str>) -> String {
    names.iter().copied().collect::<Vec<&str>>().join(", ")
}
