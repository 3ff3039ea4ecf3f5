//! The variants to prove: what the configurations of pipelines reach, or all that templates can express.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use umbragraph::diagnostic::Diagnostics;
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::document::Document;
use umbragraph::low_level::pipeline::{self, Configurations, Overrides, Surveyed};
use umbragraph::low_level::shader::permutations::Request;
use umbragraph::low_level::shader::{ShaderCache, TargetProfile};
use umbragraph::low_level::source::Span;

use super::shard::{self, Owned};
use super::shared::whole_templates;
use crate::arguments::PermutationsArguments;
use crate::bar::Bar;
use crate::lock::Reaching;
use crate::session::{Session, dry_run, profiles};
use crate::variants::ReachedConfigurations;

/// Returns the variants to validate, and the reachable configurations of each pipeline. `None` if the command line
/// names an unknown profile.
pub(super) fn requests(
    arguments: &PermutationsArguments,
    session: &mut Session,
) -> Option<(Vec<Request>, Vec<ReachedConfigurations>)> {
    let asked = session.profiles_named(&arguments.profiles)?;
    let is_one = arguments.config || !arguments.settings.is_empty();
    let mut requests: Vec<Request> = Vec::new();
    let mut counts = Vec::new();
    let mut claimed: Vec<TargetProfile> = asked.clone();
    let shares = arguments.shard.map(|shard| (shard, shard.pieces(&costs(arguments, session, &asked))));
    let mut pieces = shares.iter().flat_map(|(_, pieces)| pieces);
    let bar = Bar::of_pipelines(arguments.pipelines.len());
    let mut shaders: Option<Arc<ShaderCache>> = None;
    for (at, path) in arguments.pipelines.iter().enumerate() {
        bar.step(at, path);
        let Some(loaded) = session.open(path, &arguments.files.extension) else { continue };
        let Some(understood) = loaded.document().zip(loaded.model()) else { continue };
        let overrides = session.overrides(&arguments.settings, understood.0);
        let profiles = profiles(understood.0, asked.clone());
        claimed.extend(profiles.iter().cloned());
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let begin = requests.len();
        let groups = alike(understood.0, &profiles);
        let mut is_first = true;
        for (at, group) in groups.iter().enumerate() {
            let Some(first) = group.first() else { continue };
            let shares = arguments.shard.zip(pieces.next());
            if shares.is_some_and(|(_, shares)| shares.is_none()) {
                continue;
            }
            let (values, plan) = (Overrides::default(), PlanOptions::new(1280, 720));
            let options = session.check_options(first, &values, &plan);
            let mut diagnostics = Diagnostics::new();
            let configurations = if is_one {
                Configurations::one(&overrides)
            } else {
                Configurations::all(understood, &session.templates, first)
            };
            let before = shaders.take().filter(|one| Arc::ptr_eq(one.templates(), &session.templates));
            let own = Arc::new(match before {
                Some(before) => ShaderCache::beside(&before, first),
                None => ShaderCache::of_survey(&session.templates, first),
            });
            let surveyed =
                Surveyed { configurations: &configurations, shaders: &own, judge: &mut dry_run(first) };
            let reached =
                pipeline::reach(understood, &options, surveyed, session.sources(), &mut diagnostics);
            shaders = Some(own);
            session.add_new(diagnostics);
            // The counts are those of the first profile.
            if std::mem::take(&mut is_first) {
                counts.push(ReachedConfigurations {
                    pipeline: path.display().to_string(),
                    configurations: reached.configurations,
                    loaded: reached.loaded,
                    rejected: reached.rejected,
                    requests: begin..begin,
                    reaching: Vec::new(),
                    places: BTreeMap::new(),
                });
            }
            let Some(own) = counts.last_mut() else { continue };
            let owned = shares.and_then(|(shard, shares)| Some((shard, shares.as_ref()?)));
            let owned = owned.map(|(shard, shares)| shard.owned(shares, &reached.programs, group.len()));
            for program in &reached.programs {
                let of_template = |owned: &Owned<'_>| -> Vec<TargetProfile> {
                    let own = owned.get(program.template.as_str()).into_iter().flatten();
                    own.filter_map(|at| group.get(*at).cloned()).collect()
                };
                let group = &owned.as_ref().map_or_else(|| group.clone(), of_template);
                if group.is_empty() {
                    continue;
                }
                let more = match program.passes.len() {
                    0 | 1 => String::new(),
                    count => format!(" and {} more", count - 1),
                };
                let own_group = if at == 0 { String::new() } else { names(group) };
                let name = format!("{stem}.{}{more}", program.passes.first().map_or("", String::as_str));
                for pass in &program.passes {
                    let place = || place_of(understood.0, pass).unwrap_or(program.place);
                    own.places.entry(pass.clone()).or_insert_with(place);
                }
                for allowed in program.products.iter().cloned() {
                    let mut reach = |request| {
                        own.reaching.push(Reaching {
                            passes: program.passes.clone(),
                            template: program.template.clone(),
                            profiles: group.iter().map(|one| one.name.clone()).collect(),
                            request,
                        });
                    };
                    let is_same = |one: &Request| {
                        one.template == program.template
                            && one.allowed == allowed
                            && one.assumed == program.assumed
                    };
                    let known = requests[begin..].iter_mut().enumerate().find(|(_, one)| is_same(one));
                    if let Some((at, same)) = known {
                        reach(begin + at);
                        let new = group.iter().filter(|one| !same.profiles.contains(one));
                        let new: Vec<_> = new.cloned().collect();
                        same.profiles.extend(new);
                        continue;
                    }
                    reach(requests.len());
                    requests.push(Request {
                        name: name.clone(),
                        group: own_group.clone(),
                        allowed,
                        assumed: program.assumed.clone(),
                        place: program.place.into(),
                        ..Request::all(&program.template, group)
                    });
                }
            }
        }
        if let Some(own) = counts.last_mut().filter(|own| own.requests.start == begin) {
            own.requests.end = requests.len();
        }
    }
    bar.finish();
    if arguments.all || arguments.pipelines.is_empty() {
        let mut unique: Vec<TargetProfile> = Vec::new();
        for profile in claimed {
            if !unique.contains(&profile) {
                unique.push(profile);
            }
        }
        if unique.is_empty() {
            unique.push(TargetProfile::webgpu());
        }
        let templates = if arguments.pipelines.is_empty() {
            whole_templates(session)
        } else {
            let named: BTreeSet<String> = requests.into_iter().map(|request| request.template).collect();
            named.into_iter().collect()
        };
        requests = templates.iter().map(|template| Request::all(template, &unique)).collect();
        // What a pipeline reaches is not looked at.
        for own in &mut counts {
            own.requests = 0..0;
            own.reaching.clear();
        }
    }
    Some((requests, counts))
}

/// Returns the estimated, unitless cost of validating each pair of a pipeline and a group of like profiles, in loading
/// order.
fn costs(arguments: &PermutationsArguments, session: &mut Session, asked: &[TargetProfile]) -> Vec<u128> {
    let mut costs = Vec::new();
    for path in &arguments.pipelines {
        let Some(loaded) = session.open(path, &arguments.files.extension) else { continue };
        let Some(understood) = loaded.document().zip(loaded.model()) else { continue };
        let passes = understood.0.root.entries_of("passes").len();
        for first in
            alike(understood.0, &profiles(understood.0, asked.to_vec())).iter().filter_map(|all| all.first())
        {
            let configurations = Configurations::all(understood, &session.templates, first);
            costs.push(shard::cost(configurations.list.len(), passes));
        }
    }
    costs
}

/// Returns the place of a pass in the document. For a pass of a loop or a subgraph, the place of the loop or the
/// subgraph use.
fn place_of(document: &Document, pass: &str) -> Option<Span> {
    let entries = document.root.entries_of("passes").iter();
    let is_of =
        |name: &str| pass.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    let own = entries.filter(|entry| is_of(&entry.key));
    own.max_by_key(|entry| entry.key.len()).map(|entry| entry.key_span)
}

fn names(profiles: &[TargetProfile]) -> String {
    profiles.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Groups the profiles that lack the same features, and so reach the same variants.
fn alike(document: &Document, profiles: &[TargetProfile]) -> Vec<Vec<TargetProfile>> {
    let features = document.root.entries_of("features");
    let mut groups: Vec<(Vec<bool>, Vec<TargetProfile>)> = Vec::new();
    for profile in profiles {
        let lacks: Vec<bool> =
            features.iter().map(|entry| pipeline::lacking(entry, features, profile).is_some()).collect();
        match groups.iter_mut().find(|(known, _)| *known == lacks) {
            Some((_, group)) => group.push(profile.clone()),
            None => groups.push((lacks, vec![profile.clone()])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}
