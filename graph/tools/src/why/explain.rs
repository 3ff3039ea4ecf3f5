//! Facts about a name that the compiler decided, in words.

use std::collections::BTreeSet;

use super::find::{Found, SubgraphUse};
use super::plan_fact::{PlanFact, fact, said};
use super::subject::{Kind, Subject};
use super::{given, reasons};
use umbragraph_compiler::{KeepReason, Physical, Plan, PlannedPass};
use umbragraph_pipeline::document::{Entry, Value};
use umbragraph_pipeline::language::{Lifetime, format_name, node_kind};
use umbragraph_pipeline::model::{DeclarationKind, Id, Model, Text};
use umbragraph_pipeline::pipeline::{Lacking, ResourceKind, TypedPipeline, is_of};
use umbragraph_pipeline::source::Span;
use umbragraph_pipeline::work::PassHandle;

/// The kind of a named part in words, with more detail than [`Kind`], such as "a use of the subgraph blur".
pub(super) fn what(subject: &Subject<'_>, name: &str, found: &Found<'_>) -> String {
    let value = &found.entry.value;
    let pipeline = subject.checked.pipeline.as_deref();
    match found.kind {
        Kind::Pass => {
            if let Some(used) = value.get("use").and_then(Value::text) {
                return format!("a use of the subgraph {used}");
            }
            let pass = instances(subject, name);
            let kind = pipeline
                .and_then(|pipeline| pipeline.passes.iter().find(|one| pass.contains(&one.name.as_str())))
                .map(|pass| pass.kind.as_str());
            let kind = kind.or_else(|| Some(node_kind(value)?.key.as_str()));
            let is_loop = pass.iter().any(|instance| *instance != name);
            let passes = if is_loop { "a loop of passes" } else { "a pass" };
            kind.map_or_else(|| passes.to_owned(), |kind| format!("{passes} of kind {kind}"))
        }
        Kind::Resource => {
            let resource = pipeline
                .and_then(|pipeline| Some(pipeline.resource(pipeline.find_resource(name)?).kind_name()))
                .filter(|kind| *kind != "broken");
            let written = ["texture", "buffer", "data"].into_iter().find(|key| value.get(key).is_some());
            match (resource, written) {
                (Some(kind), _) => kind.to_owned(),
                (None, Some("texture")) => "a texture".to_owned(),
                (None, Some("buffer")) => "a buffer".to_owned(),
                _ => found.kind.name().to_owned(),
            }
        }
        kind => match found.uses.last() {
            Some(used) => format!("{} of {}", kind.name(), used.name),
            None => kind.name().to_owned(),
        },
    }
}

/// The names of the pipeline's passes that a name stands for: one pass, the rounds of a loop, or the passes of a used
/// subgraph.
pub(super) fn instances<'a>(subject: &Subject<'a>, name: &str) -> Vec<&'a str> {
    let passes = subject.checked.pipeline.as_deref().map(|pipeline| pipeline.passes.as_slice());
    let names = passes.unwrap_or_default().iter().map(|pass| pass.name.as_str());
    names.filter(|pass| is_of(pass, name)).collect()
}

/// Returns facts about a pass, a loop or a use of a subgraph: whether it runs and why, its order and its accesses to
/// resources.
pub(super) fn of_pass(subject: &Subject<'_>, name: &str, found: &Found<'_>) -> Vec<PlanFact> {
    let mut facts = used(subject, &found.uses);
    let Some(pipeline) = subject.checked.pipeline.as_deref() else {
        facts.push(fact("runs", "not known: the pipeline has errors"));
        return facts;
    };
    let passes = instances(subject, name);
    if passes.is_empty() {
        off(subject, found, &mut facts);
        return facts;
    }
    let plan = subject.checked.plan.as_ref();
    if passes != [name] {
        facts.push(fact("stands for", umbragraph_pipeline::diagnostic::list_of(passes.iter().copied())));
        let Some(plan) = plan else { return facts };
        for pass in passes.iter().take(MOST) {
            // The first step of the way; the whole of it is told of the pass itself.
            let words = state(pipeline, plan, pass).into_iter().take(2).map(|fact| fact.text);
            facts.push(fact("runs", format!("{pass}: {}", words.collect::<Vec<_>>().join(", "))));
        }
        return facts;
    }
    match plan {
        Some(plan) => facts.extend(state(pipeline, plan, name)),
        None => facts.push(fact("runs", "not known: the pipeline has errors")),
    }
    let Some(handle) = pipeline.find_pass(name) else { return facts };
    let pass = pipeline.pass(handle);
    if let Some(condition) = pass.condition {
        let on = pipeline.condition_name(condition);
        facts.push(fact("toggle", format!("runs in frames with {on}")));
    }
    for before in &pass.after {
        facts.push(fact("after", &*pipeline.pass(*before).name));
    }
    for one in pass.accesses() {
        let resource = &pipeline.resource(one.resource).name;
        let about = match (one.usage.reads(), one.usage.writes()) {
            (true, true) => "reads, writes",
            (false, true) => "writes",
            _ => "reads",
        };
        let text = format!("{resource} ({})", one.usage.name());
        facts.push(said(subject, about, text, one.place));
    }
    facts
}

/// The maximum number of passes of a loop or a used subgraph that are listed one by one.
const MOST: usize = 64;

/// Returns the position of a pass in execution order and the reason why it is kept, or the reason why it is culled.
fn state(pipeline: &TypedPipeline, plan: &Plan, name: &str) -> Vec<PlanFact> {
    let Some(handle) = pipeline.find_pass(name) else { return Vec::new() };
    match plan.position(handle) {
        Some(position) => {
            let runs = fact("runs", format!("as number {} of {}", position + 1, plan.passes.len()));
            std::iter::once(runs).chain(kept(plan, handle)).collect()
        }
        None => {
            let mut facts = vec![fact("runs", "never: it is culled")];
            facts.extend(reasons::why_culled(plan, name).map(|step| fact("culled", step)));
            facts
        }
    }
}

/// Returns the reason why a pass is kept, one fact for each step from the pass through its readers to an output.
fn kept(plan: &Plan, handle: PassHandle) -> Vec<PlanFact> {
    let step = |(at, planned): (usize, &PlannedPass)| {
        let (name, words) = (&planned.name, reasons::kept(plan, planned));
        let words = match planned.reason {
            KeepReason::SideEffect => format!("{name} has a side effect"),
            KeepReason::Output(_) => format!("{name} {words}"),
            _ => words,
        };
        fact("kept", format!("{} {words}", if at == 0 { "because" } else { "and" }))
    };
    plan.why_kept(handle).enumerate().map(step).collect()
}

/// Adds the reason why a pass is not in the pipeline: its `when` is false, or that of a use of a subgraph around it.
fn off(subject: &Subject<'_>, found: &Found<'_>, facts: &mut Vec<PlanFact>) {
    let own = (found.entry, String::new());
    let outer = found.uses.iter().map(|used| (used.entry, format!(" of {}", used.name)));
    let conditions: Vec<(&Value, String)> =
        outer.chain([own]).filter_map(|(entry, of_what)| Some((entry.value.get("when")?, of_what))).collect();
    if conditions.is_empty() {
        let text = if subject.checked.plan.is_some() {
            "never: its loop has no round"
        } else {
            "not known: it has errors"
        };
        facts.push(fact("runs", text));
        return;
    }
    facts.push(fact("runs", "never: it is switched off in this configuration"));
    for (when, of_what) in conditions {
        let bare = |text: &str| text.strip_prefix('=').unwrap_or(text).to_owned();
        let expression = when.text().map_or_else(|| super::origin::json(when), bare);
        facts.push(said(subject, "when", format!("\"when\"{of_what} is {expression}"), when.span));
        let text = subject.model.texts().iter().find(|text| text.place == when.span);
        values_of(subject, text.into_iter(), "when", facts);
    }
}

/// Adds a fact for each setting that strings name: its value and the source of the value.
fn values_of<'m>(
    subject: &Subject<'m>,
    texts: impl Iterator<Item = &'m Text>,
    about: &'static str,
    facts: &mut Vec<PlanFact>,
) {
    let (root, model) = (&subject.composed.document.root, subject.model);
    let mut seen = BTreeSet::new();
    for id in texts.flat_map(|text| model.named_in(text)).filter(|id| seen.insert(*id)) {
        let named = model.declaration(id);
        let name = named.name.as_str();
        let (section, kind) = match named.kind {
            DeclarationKind::Feature => ("features", Kind::Feature),
            DeclarationKind::Parameter => ("parameters", Kind::Parameter),
            DeclarationKind::Derived => ("derived", Kind::Derived),
            _ => continue,
        };
        let entry = root.get(section).and_then(|all| all.entry(name)).filter(|_| named.owner.is_none());
        let Some(entry) = entry else { continue };
        if kind == Kind::Derived {
            let pipeline = subject.checked.pipeline.as_deref();
            let value = pipeline
                .and_then(|pipeline| pipeline.derived.get(name))
                .map(|one| super::origin::computed(&one.value));
            let Some(value) = value else { continue };
            let text = format!("{name} is {value}, by its expression");
            facts.push(said(subject, about, text, entry.value.span));
        } else if let Some(last) = given::given(subject, kind, entry, &named.pointer).pop() {
            let text = format!("{name} is {}, by {}", last.value, last.by);
            facts.push(PlanFact { about, text, at: Some(last.at) });
        }
    }
}

fn used(subject: &Subject<'_>, uses: &[SubgraphUse<'_>]) -> Vec<PlanFact> {
    let one = |used: &SubgraphUse<'_>| {
        let subgraph = used.entry.value.get("use").and_then(Value::text).unwrap_or_default();
        let text = format!("{}, a use of the subgraph {subgraph}", used.name);
        said(subject, "part of", text, used.entry.key_span)
    };
    uses.iter().rev().map(one).collect()
}

/// Returns facts about a resource: the passes that read or write it, its lifetime, its size in bytes and its memory.
pub(super) fn of_resource(subject: &Subject<'_>, name: &str, uses: &[SubgraphUse<'_>]) -> Vec<PlanFact> {
    let mut facts = used(subject, uses);
    let Some(pipeline) = subject.checked.pipeline.as_deref() else {
        facts.push(fact("memory", "not known: the pipeline has errors"));
        return facts;
    };
    let Some(handle) = pipeline.find_resource(name) else {
        facts.push(fact("memory", "none: the use of the subgraph is switched off, or has errors"));
        return facts;
    };
    let plan = subject.checked.plan.as_ref();
    for pass in &pipeline.passes {
        for one in pass.accesses().iter().filter(|one| one.resource == handle) {
            let about = if one.usage.writes() { "written by" } else { "read by" };
            let culled = plan.is_some_and(|plan| plan.culled.contains_key(&pass.name));
            let culled = if culled { ", culled" } else { "" };
            let text = format!("{} ({}{culled})", pass.name, one.usage.name());
            facts.push(said(subject, about, text, one.place));
        }
    }
    // Writers before readers, each in the order of the document.
    facts.sort_by_key(|fact| match fact.about {
        "part of" => 0,
        "written by" => 1,
        _ => 2,
    });
    let lifetime = match pipeline.resource(handle).declared_lifetime() {
        Lifetime::Transient if pipeline.resource(handle).is_exposed() => {
            Some("exposed: the host looks at it between frames, so it shares memory with nothing")
        }
        Lifetime::Transient => None,
        Lifetime::Imported => Some("imported: it is the host's own"),
        _ => Some("it outlives the frame"),
    };
    facts.extend(lifetime.map(|text| fact("lifetime", text)));
    let Some(plan) = plan else {
        facts.push(fact("memory", "not known: the pipeline has errors"));
        return facts;
    };
    let Some(planned) = plan.resources.get(name) else {
        facts.push(fact("memory", "none: no pass that runs uses it"));
        return facts;
    };
    let pass = |at: usize| plan.passes.get(at).map_or("", |pass| pass.name.as_str());
    facts.push(fact("alive", format!("from {} to {}", pass(planned.first), pass(planned.last))));
    if let (Some(format), Some(size)) = (planned.format, planned.size) {
        let mut text = format!("{}, {} by {} texels", format_name(format), size.width, size.height);
        for (count, what) in [(size.layers, "layers"), (size.mips, "mips"), (size.samples, "samples")] {
            if count > 1 {
                text += &format!(", {count} {what}");
            }
        }
        facts.push(fact("texture", format!("{text}, {} bytes", planned.bytes)));
    } else if planned.bytes > 0 {
        facts.push(fact("buffer", format!("{} bytes", planned.bytes)));
    }
    let shares = plan
        .resources
        .iter()
        .filter(|(other, resource)| *other != name && resource.physical == planned.physical)
        .map(|(other, _)| other.as_str());
    let text = match planned.physical {
        Physical::Imported => "the host's own".to_owned(),
        Physical::Blackboard => "data on the CPU".to_owned(),
        Physical::Texture(index) | Physical::Buffer(index) => {
            let kind = if matches!(planned.physical, Physical::Texture(_)) { "texture" } else { "buffer" };
            match umbragraph_pipeline::diagnostic::list_of(shares) {
                none if none.is_empty() => format!("{kind} {index} of the plan, for itself"),
                others => format!("{kind} {index} of the plan, shared with {others}"),
            }
        }
    };
    facts.push(fact("memory", text));
    if let ResourceKind::Data(Some(shape)) = &pipeline.resource(handle).kind {
        for (size, initial) in &shape.sizes {
            facts.push(fact("publishes", format!("{size}: a size, {initial} at first")));
        }
        for value in &shape.values {
            let about = if value.description.is_empty() { "" } else { ", " };
            facts.push(fact(
                "publishes",
                format!("{}: {}{about}{}", value.name, value.value_type, value.description),
            ));
        }
    }
    facts
}

/// Returns facts about any other named part, such as the users of a subgraph, or whether a preset is selected.
pub(super) fn of_other(subject: &Subject<'_>, name: &str, found: &Found<'_>) -> Vec<PlanFact> {
    let root = &subject.composed.document.root;
    match found.kind {
        Kind::Preset => {
            let places: Vec<Span> = settings(&found.entry.value).map(|entry| entry.key_span).collect();
            let chosen = &subject.overrides;
            let taken = chosen.parameters.iter().chain(&chosen.features);
            let taken = taken.filter(|setting| places.contains(&setting.place)).count() > 0;
            vec![fact("taken", if taken { "yes" } else { "no" })]
        }
        Kind::Subgraph => users(subject, root, |entry| {
            entry.value.get("use").and_then(Value::text).is_some_and(|used| used == name)
        }),
        Kind::SharedSettings => {
            let groups = subject.model.declarations().filter(|(_, one)| one.place == found.entry.key_span);
            let users: BTreeSet<Span> = groups.flat_map(|(id, _)| places_using(subject.model, id)).collect();
            self::users(subject, root, |entry| users.contains(&entry.key_span))
        }
        Kind::Derived if found.uses.is_empty() => {
            let mut facts = Vec::new();
            let own = subject.model.find(DeclarationKind::Derived, name);
            values_of(
                subject,
                own.into_iter().flat_map(|id| subject.model.texts_in(id)),
                "follows from",
                &mut facts,
            );
            facts.extend(mentions(subject, own, name));
            facts
        }
        Kind::Toggle => {
            let mut facts = Vec::new();
            if let Some(pipeline) = subject.checked.pipeline.as_deref() {
                let of_toggle = |condition: &umbragraph_pipeline::pipeline::Condition| {
                    pipeline.toggles.get(condition.toggle).is_some_and(|toggle| toggle.name == name)
                };
                for pass in
                    pipeline.passes.iter().filter(|pass| pass.condition.as_ref().is_some_and(of_toggle))
                {
                    let without = pass.condition.is_some_and(|condition| !condition.on);
                    let text = format!("{}{}", pass.name, if without { ", while it is off" } else { "" });
                    facts.push(said(subject, "switches", text, pass.place));
                }
            }
            facts
        }
        Kind::Feature | Kind::Parameter if found.uses.is_empty() => {
            let lacking = given::lacking_in(subject, found.kind, found.entry).map(|(profile, lacking)| {
                let Lacking { required, guaranteed, .. } = &lacking;
                let text = format!("the feature requires {required}, {} has {guaranteed}", profile.name);
                said(subject, "unavailable", text, lacking.place)
            });
            let live = change(subject, found.kind, name);
            let kind = match found.kind {
                Kind::Feature => DeclarationKind::Feature,
                _ => DeclarationKind::Parameter,
            };
            let own = subject.model.find(kind, name);
            lacking.into_iter().chain(live).chain(mentions(subject, own, name)).collect()
        }
        _ => used(subject, &found.uses),
    }
}

/// Returns a fact about a parameter: it can change between frames, or a named value that depends on it needs another
/// plan. `None` for a feature or without a loaded pipeline.
fn change(subject: &Subject<'_>, kind: Kind, name: &str) -> Option<PlanFact> {
    let pipeline = subject.checked.pipeline.as_deref().filter(|_| kind == Kind::Parameter)?;
    Some(match &pipeline.parameters.get(name)?.structural {
        None => fact("live", "it can change from frame to frame, without another plan"),
        Some(structural) => {
            let text = format!("another value is another plan: {} follows from it", structural.pointer);
            said(subject, "structural", text, structural.place)
        }
    })
}

fn settings(preset: &Value) -> impl Iterator<Item = &Entry> {
    let of = |section: &str| preset.entries_of(section);
    of("parameters").iter().chain(of("features"))
}

/// The source places of the names of all declarations that use a declaration.
fn places_using(model: &Model, id: Id) -> impl Iterator<Item = Span> {
    model.uses_of(id).map(|one| model.declaration(one.within).place)
}

/// Returns a fact for each user of a parameter, feature or derived value. A user is an entry that names it, or a pass
/// whose shader has an axis of that name.
fn mentions(subject: &Subject<'_>, own: Option<Id>, name: &str) -> Vec<PlanFact> {
    let root = &subject.composed.document.root;
    let users: BTreeSet<Span> = own.into_iter().flat_map(|id| places_using(subject.model, id)).collect();
    let is_user = |entry: &Entry| users.contains(&entry.key_span);
    let mut facts = self::users(subject, root, |entry| is_user(entry) || has_axis(subject, &entry.key, name));
    for (section, what) in [("resources", "the resource"), ("derived", "the derived value")] {
        let entries = root.entries_of(section).iter().filter(|entry| is_user(entry));
        facts.extend(
            entries.map(|entry| said(subject, "used by", format!("{what} {}", entry.key), entry.key_span)),
        );
    }
    facts
}

/// Returns `true` if the shader of a pass, or of one of its rounds, has an axis with the name `name`.
fn has_axis(subject: &Subject<'_>, pass: &str, name: &str) -> bool {
    let Some(pipeline) = subject.checked.pipeline.as_deref() else { return false };
    let instances = instances(subject, pass);
    let passes = pipeline.passes.iter().filter(|one| instances.contains(&one.name.as_str()));
    let mut programs = passes.filter_map(|one| one.work().program());
    programs.any(|handle| pipeline.program(handle).axes.iter().any(|(axis, _)| axis == name))
}

/// Returns a fact for each pass of the document and of its subgraphs for which `holds` returns `true`.
fn users(subject: &Subject<'_>, root: &Value, holds: impl Fn(&Entry) -> bool) -> Vec<PlanFact> {
    let mut facts = Vec::new();
    let subgraphs = root.entries_of("subgraphs").iter();
    let subgraphs = subgraphs.map(|entry| (&entry.value, format!(" of the subgraph {}", entry.key)));
    for (owner, of_what) in std::iter::once((root, String::new())).chain(subgraphs) {
        for pass in owner.entries_of("passes").iter().filter(|entry| holds(entry)) {
            facts.push(said(subject, "used by", format!("{}{of_what}", pass.key), pass.key_span));
        }
    }
    facts
}
