//! Finds the things that have a name.
//!
//! Names are looked up in the document, so that pipelines with errors have them too: `soft.down` is the pass `down` of
//! the subgraph that `soft` uses, `down.0` the first round of the loop `down`, and both may be mixed to any depth. Each
//! step takes a part of the name, so subgraphs that use themselves are no matter. What only the compiler makes (data
//! that a pass publishes, earlier frames) is looked up in the pipeline.

use std::collections::BTreeSet;

use super::origin::{computed, location, origins};
use super::subject::{Kind, Subject};
use super::{Thing, explain, given};
use umbragraph_pipeline::document::{Entry, Value, pointer_join};

const SECTIONS: &[(&str, Kind)] = &[
    ("parameters", Kind::Parameter),
    ("features", Kind::Feature),
    ("derived", Kind::Derived),
    ("toggles", Kind::Toggle),
    ("presets", Kind::Preset),
    ("shared_settings", Kind::SharedSettings),
    ("subgraphs", Kind::Subgraph),
    ("extension_points", Kind::ExtensionPoint),
    ("geometry", Kind::Geometry),
];

/// An entry of the document that has the name to explain.
pub(super) struct Found<'a> {
    pub(super) kind: Kind,
    pub(super) pointer: String,
    pub(super) entry: &'a Entry,
    /// The uses of subgraphs that contain the entry, the outermost first.
    pub(super) uses: Vec<SubgraphUse<'a>>,
}

/// An entry of `passes` that uses a subgraph, with its full name and JSON pointer.
#[derive(Clone)]
pub(super) struct SubgraphUse<'a> {
    pub(super) name: String,
    pub(super) pointer: String,
    pub(super) entry: &'a Entry,
}

/// Explains every part of a pipeline with the name `name`.
pub(super) fn things(subject: &Subject<'_>, name: &str) -> Vec<Thing> {
    let root = &subject.composed.document.root;
    let mut found = Vec::new();
    let segments: Vec<&str> = name.split('.').collect();
    walk(subject, root, "", &segments, String::new(), &[], &mut found);
    for (section, kind) in SECTIONS {
        if let Some(entry) = root.get(section).and_then(|section| section.entry(name)) {
            let pointer = pointer_join(&format!("/{section}"), name);
            found.push(Found { kind: *kind, pointer, entry, uses: Vec::new() });
        }
    }
    let mut things: Vec<Thing> = found.iter().map(|found| thing(subject, name, found)).collect();
    let made = subject.checked.pipeline.as_deref().and_then(|pipeline| {
        let resource = pipeline.resource(pipeline.find_resource(name)?);
        (!found.iter().any(|found| found.kind == Kind::Resource)).then_some(resource)
    });
    if let Some(resource) = made {
        things.insert(
            usize::from(things.first().is_some_and(|thing| thing.kind == Kind::Pass)),
            Thing {
                name: name.to_owned(),
                kind: Kind::Resource,
                what: resource.kind_name().to_owned(),
                description: None,
                declared: location(subject.sources, resource.place),
                value: None,
                given: Vec::new(),
                facts: explain::of_resource(subject, name, &[]),
                // What only a pass names is not written anywhere.
                values: match resource.value.kind {
                    umbragraph_pipeline::document::Kind::Null => Vec::new(),
                    _ => origins(subject, &resource.pointer, &resource.value, ""),
                },
            },
        );
    }
    things
}

fn walk<'a>(
    subject: &Subject<'a>,
    owner: &'a Value,
    pointer: &str,
    segments: &[&str],
    prefix: String,
    uses: &[SubgraphUse<'a>],
    found: &mut Vec<Found<'a>>,
) {
    let Some((head, mut rest)) = segments.split_first() else { return };
    let mut name = format!("{prefix}{head}");
    if let Some(entry) = owner.get("passes").and_then(|passes| passes.entry(head)) {
        let at = pointer_join(&format!("{pointer}/passes"), head);
        let mut is_there = true;
        if entry.value.get("for_each").is_some()
            && let Some((round, behind)) = rest.split_first()
            && round.bytes().all(|byte| byte.is_ascii_digit())
        {
            name = format!("{name}.{round}");
            rest = behind;
            // A round that is switched off cannot be told from one that the loop does not have.
            is_there = subject.checked.plan.is_none() || !explain::instances(subject, &name).is_empty();
        }
        if rest.is_empty() {
            if is_there {
                found.push(Found { kind: Kind::Pass, pointer: at, entry, uses: uses.to_vec() });
            }
        } else if let Some(used) = entry.value.get("use").and_then(Value::text)
            && let Some(subgraph) =
                subject.composed.document.root.get("subgraphs").and_then(|all| all.get(used))
            && is_there
        {
            let mut inner = uses.to_vec();
            inner.push(SubgraphUse { name: name.clone(), pointer: at, entry });
            let below = pointer_join("/subgraphs", used);
            walk(subject, subgraph, &below, rest, format!("{name}."), &inner, found);
        }
    }
    if segments.len() == 1 {
        let sections: &[(&str, Kind)] = if uses.is_empty() {
            &[("resources", Kind::Resource)]
        } else {
            &[
                ("resources", Kind::Resource),
                ("parameters", Kind::Parameter),
                ("derived", Kind::Derived),
                ("inputs", Kind::Input),
            ]
        };
        for (section, kind) in sections {
            if let Some(entry) = owner.get(section).and_then(|section| section.entry(head)) {
                let pointer = pointer_join(&format!("{pointer}/{section}"), head);
                found.push(Found { kind: *kind, pointer, entry, uses: uses.to_vec() });
            }
        }
    }
}

fn thing(subject: &Subject<'_>, name: &str, found: &Found<'_>) -> Thing {
    let Found { kind, pointer, entry, uses } = found;
    let text = |key: &str| entry.value.get(key).and_then(Value::text).map(str::to_owned);
    let mut given = match kind {
        Kind::Parameter | Kind::Feature if uses.is_empty() => given::given(subject, *kind, entry, pointer),
        _ => Vec::new(),
    };
    if let (Kind::Parameter | Kind::Input, Some(used)) = (kind, uses.last()) {
        if let Some(value) = entry.value.get("default") {
            given::of_document(subject, "default", value, &format!("{pointer}/default"), &mut given);
        }
        if let Some(value) = used.entry.value.get("with").and_then(|with| with.get(&entry.key)) {
            let at = pointer_join(&format!("{}/with", used.pointer), &entry.key);
            given::of_document(subject, &format!("with of {}", used.name), value, &at, &mut given);
        }
    }
    if *kind == Kind::Derived {
        given::of_document(subject, "its expression", &entry.value, pointer, &mut given);
    }
    let facts = match kind {
        Kind::Pass => explain::of_pass(subject, name, found),
        Kind::Resource => explain::of_resource(subject, name, uses),
        _ => explain::of_other(subject, name, found),
    };
    let mut values = origins(subject, pointer, &entry.value, "");
    values.retain(|origin| origin.path != "description");
    for used in uses.iter().filter(|_| matches!(kind, Kind::Pass | Kind::Resource)) {
        if let Some(with) = used.entry.value.get("with") {
            let at = format!("{}/with", used.pointer);
            values.extend(origins(subject, &at, with, &format!("{}.with", used.name)));
        }
    }
    let description = match kind {
        Kind::Input => entry.value.text().map(str::to_owned),
        _ => text("description"),
    };
    if matches!(kind, Kind::Input | Kind::Derived) {
        values.clear();
    }
    let derived = subject.checked.pipeline.as_deref().filter(|_| *kind == Kind::Derived && uses.is_empty());
    let derived = derived.and_then(|pipeline| pipeline.derived.get(name));
    let value = match derived {
        Some(derived) => Some(computed(&derived.value)),
        None => given.last().map(|given| given.value.clone()),
    };
    Thing {
        name: name.to_owned(),
        kind: *kind,
        what: explain::what(subject, name, found),
        description,
        declared: location(subject.sources, entry.key_span),
        value,
        given,
        facts,
        values,
    }
}

/// The names of all parts of a pipeline that have one, to suggest in place of an unknown name.
pub(super) fn names(subject: &Subject<'_>) -> BTreeSet<String> {
    let mut names = resource_names(subject);
    for section in SECTIONS.iter().map(|(section, _)| *section).chain(["passes"]) {
        names.extend(keys(subject, section));
    }
    if let Some(pipeline) = &subject.checked.pipeline {
        names.extend(pipeline.passes.iter().map(|pass| pass.name.clone()));
    }
    names
}

/// The names of all resources, of the document and of the loaded pipeline.
pub(super) fn resource_names(subject: &Subject<'_>) -> BTreeSet<String> {
    let mut names: BTreeSet<String> = keys(subject, "resources").collect();
    if let Some(pipeline) = &subject.checked.pipeline {
        names.extend(pipeline.resources.iter().map(|resource| resource.name.clone()));
    }
    names
}

fn keys<'a>(subject: &Subject<'a>, section: &str) -> impl Iterator<Item = String> + use<'a> {
    subject.composed.document.root.entries_of(section).iter().map(|entry| entry.key.clone())
}
