//! Versions that passes name, against the passes that write.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use crate::access::version::Version;
use crate::pipeline::located::Located as _;
use crate::pipeline::names::{Environment, Instance, is_of};
use crate::pipeline::pass::{Access, Pass};
use crate::pipeline::resource::History;
use crate::pipeline::resource::ResourceKind;
use crate::pipeline::state::shared::Shared;
use crate::pipeline::toggle::Passthrough;
use crate::work::ResourceHandle;
use umbragraph_text::diagnostic::{Diagnostic, codes, list_of};
use umbragraph_text::document::Entry;
use umbragraph_text::expression::ExpressionKind;
use umbragraph_text::language::{Expr, Written};
use umbragraph_text::source::Span;

/// Resolves versions that name a loop or a use of a subgraph to its last writer. This is the writer in the last
/// iteration of a loop, or the writer in a subgraph that follows all other writers. Reports versions without a unique
/// last writer.
pub(super) fn name_last_writers(
    passes: &mut [Pass],
    passthroughs: &mut BTreeMap<ResourceHandle, Passthrough>,
    shared: &mut Shared,
) {
    let known: BTreeSet<&str> = passes.iter().map(|pass| pass.name.as_str()).collect();
    let group_of = |version: &Version| match version {
        Version::WrittenBy(name) if !known.contains(name.as_str()) => Some(name.clone()),
        _ => None,
    };
    let mut wanted: BTreeMap<(String, ResourceHandle), (Span, String)> = BTreeMap::new();
    for one in passes.iter().flat_map(Pass::accesses) {
        if let Some(group) = group_of(&one.version) {
            wanted.entry((group, one.resource)).or_insert((one.place, one.pointer.clone()));
        }
    }
    for passthrough in passthroughs.values() {
        if let Some(group) = group_of(&passthrough.version) {
            wanted
                .entry((group, passthrough.fallback))
                .or_insert((passthrough.place, passthrough.pointer.clone()));
        }
    }
    if wanted.is_empty() {
        return;
    }
    let mut last = BTreeMap::new();
    for ((group, resource), (place, pointer)) in wanted {
        match last_writer(passes, &group, resource) {
            Ok(Some(writer)) => {
                last.insert((group, resource), writer);
            }
            Ok(None) => {}
            Err(writers) => {
                let named = &shared.resources[resource.index()].name;
                let message =
                    format!("several passes of \"{group}\" write \"{named}\", and none is the last");
                let diagnostic = Diagnostic::error(codes::BAD_REFERENCE, place, message).pointer(pointer);
                let help = format!("name one of them: {}", list_of(writers.iter().map(String::as_str)));
                shared.diagnostics.push(diagnostic.help(help));
                // Which one is meant is open, but not that there is one.
                last.extend(writers.into_iter().last().map(|writer| ((group, resource), writer)));
            }
        }
    }
    let rename = |version: &mut Version, resource: ResourceHandle| {
        if let Version::WrittenBy(name) = version
            && let Some(writer) = last.get(&(name.clone(), resource))
        {
            name.clone_from(writer);
        }
    };
    for one in passes.iter_mut().flat_map(|pass| &mut pass.accesses) {
        rename(&mut one.version, one.resource);
    }
    for passthrough in passthroughs.values_mut() {
        rename(&mut passthrough.version, passthrough.fallback);
    }
}

/// Returns the name of the last writer of a resource among the passes of a group; `None` if no pass of the group writes
/// it.
///
/// # Errors
/// Returns the names of the writers if none of them is the last.
fn last_writer(
    passes: &[Pass],
    group: &str,
    resource: ResourceHandle,
) -> Result<Option<String>, Vec<String>> {
    let rest = |name: &str| name.strip_prefix(group)?.strip_prefix('.').map(str::to_owned);
    let members = passes.iter().enumerate().filter_map(|(at, pass)| Some((at, pass, rest(&pass.name)?)));
    let writers: Vec<_> = members.filter(|(_, pass, _)| pass.writes(resource)).collect();
    // The rounds of one loop come one after the other.
    let rounds: Option<Vec<u32>> = writers.iter().map(|(_, _, rest)| rest.parse().ok()).collect();
    if let Some(rounds) = rounds {
        let last = writers.iter().zip(rounds).max_by_key(|(_, round)| *round);
        return Ok(last.map(|((_, pass, _), _)| pass.name.clone()));
    }
    let follows = |later: &Pass, earlier: usize| {
        let name = &passes[earlier].name;
        let reads = |one: &Access| matches!(&one.version, Version::WrittenBy(other) if other == name);
        later.after.iter().any(|handle| handle.index() == earlier)
            || later.accesses().iter().any(|one| one.resource == resource && reads(one))
    };
    let is_last = |(at, pass, _): &&(usize, &Pass, String)| {
        writers.iter().all(|(other, _, _)| other == at || follows(pass, *other))
    };
    match (&writers[..], writers.iter().find(is_last)) {
        ([], _) => Ok(None),
        (_, Some((_, last, _))) => Ok(Some(last.name.clone())),
        _ => Err(writers.iter().map(|(_, pass, _)| pass.name.clone()).collect()),
    }
}

/// Reports versions that no pass writes. All resources of the passes that read an unwritten version are added to
/// `uncertain`, because order and contents are not known.
pub(super) fn check_versions(
    passes: &[Pass],
    absent: &BTreeSet<String>,
    gaps: &[(String, &Entry)],
    uncertain: &mut BTreeSet<ResourceHandle>,
    shared: &mut Shared,
) {
    let is_named = |one: &Access| matches!(one.version, Version::WrittenBy(_));
    if !passes.iter().any(|pass| pass.accesses().iter().any(is_named)) {
        return;
    }
    let mut writers_of: HashMap<ResourceHandle, BTreeSet<&str>> = HashMap::new();
    for pass in passes {
        for one in pass.accesses().iter().filter(|one| one.usage.writes()) {
            writers_of.entry(one.resource).or_default().insert(&pass.name);
        }
    }
    let nobody = BTreeSet::new();
    for pass in passes {
        for one in pass.accesses() {
            let Version::WrittenBy(writer) = &one.version else { continue };
            let resource = &shared.resources[one.resource.index()].name;
            let writers = writers_of.get(&one.resource).unwrap_or(&nobody);
            if writers.contains(writer.as_str()) || is_gap(gaps, writer) {
                continue;
            }
            uncertain.extend(pass.accesses().iter().map(|each| each.resource));
            let why = if is_absent(absent, writer) { ", which is switched off here" } else { "" };
            let message = format!("no pass \"{writer}\" writes \"{resource}\"{why}");
            // Names as they are inside of the subgraph where the version is written.
            let inside = |name: &str| pass.environment.pass_inside(name).unwrap_or_default().to_owned();
            let names: Vec<String> = writers.iter().map(|name| inside(name)).collect();
            let name = inside(writer);
            let written = version_in(shared.sources.text(one.place), &name);
            let written = written.map(|range| one.place.inside(range));
            let diagnostic = one.error(codes::UNKNOWN_PASS, message);
            let known = names.iter().map(String::as_str).filter(|name| !name.is_empty());
            shared.diagnostics.push(diagnostic.suggest(&name, known, written, |_| match writers.len() {
                0 => format!("nothing writes \"{resource}\""),
                _ => format!("it is written by {}", list_of(writers.iter().copied())),
            }));
        }
    }
}

/// The byte range of a version's pass name in the quoted text of a reference; `None` if the name is not written
/// literally.
fn version_in(raw: &str, pass: &str) -> Option<std::ops::Range<usize>> {
    let at = raw.find('@')? + 1;
    let end = raw.len().checked_sub(1)?;
    (raw.get(at..end)? == pass).then_some(at..end)
}

/// Returns `true` if a pass, or a loop or use of a subgraph that contains it, is absent.
pub(super) fn is_absent(absent: &BTreeSet<String>, name: &str) -> bool {
    let mut name = name;
    loop {
        if absent.contains(name) {
            return true;
        }
        match name.rsplit_once('.') {
            Some((head, _)) => name = head,
            None => return false,
        }
    }
}

/// Returns `true` if a pass, one that contains it, or one within it could not be declared.
pub(super) fn is_gap(gaps: &[(String, &Entry)], name: &str) -> bool {
    gaps.iter().any(|(gap, _)| is_of(name, gap) || is_of(gap, name))
}

/// The resources whose uses are not fully known: broken resources, and resources that passes with errors mention in any
/// reference. With `unreadable`, all resources: a pass that does not fit the schema may lack the key that names a
/// resource.
pub(super) fn uncertain(
    gaps: &[(String, &Entry)],
    instances: &[Instance<'_>],
    unreadable: bool,
    shared: &Shared,
) -> BTreeSet<ResourceHandle> {
    let all = (0..shared.resources.len() as u32).map(ResourceHandle);
    let broken =
        |handle: &ResourceHandle| matches!(shared.resources[handle.index()].kind, ResourceKind::Broken);
    let mut found: BTreeSet<ResourceHandle> = all.filter(|handle| unreadable || broken(handle)).collect();
    let lacking: BTreeSet<&str> = gaps.iter().map(|(name, _)| name.as_str()).collect();
    let known = instances.iter().filter(|each| lacking.contains(each.name.as_str()));
    let environments: HashMap<&str, &Environment> =
        known.map(|each| (each.name.as_str(), &*each.environment)).collect();
    for (pass, gap) in gaps {
        let environment = environments.get(pass.as_str());
        let mut mention = |name: &str| {
            // In a subgraph a name is that of an input, or of a resource of its own.
            found.extend(environment.and_then(|inside| shared.find(&inside.resource(name))));
            found.extend(shared.find(name));
        };
        gap.value.for_each_text(&mut |text| match (Written::of(text), Expr::parse_text(text)) {
            (Written::Plain(text), _) => mention(text.split('@').next().unwrap_or(text)),
            (_, Ok(expression)) => expression.visit(&mut |inner| {
                if let ExpressionKind::Reference(reference) = &inner.kind {
                    mention(&reference.resource);
                }
            }),
            (_, Err(_)) => {}
        });
    }
    let histories: Vec<_> =
        found.iter().filter_map(|handle| shared.resources[handle.index()].history).collect();
    found.extend(histories.into_iter().flat_map(History::members));
    found
}
