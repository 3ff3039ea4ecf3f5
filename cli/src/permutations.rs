//! `umbragraph permutations`
//!
//! Three modes: what the configurations of the given pipelines reach; one configuration of them; everything that the
//! templates can express. Each pipeline's configurations are loaded in full besides, so its bindings, and what scenes
//! upload for a geometry named `scene`, are compared with every variant.

use std::collections::BTreeSet;
use std::io::IsTerminal as _;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use umbragraph::diagnostic::{Diagnostics, Place};
use umbragraph::low_level::compiler::PlanOptions;
use umbragraph::low_level::document::Document;
use umbragraph::low_level::pipeline::{self, Configurations, Overrides};
use umbragraph::low_level::shader::TargetProfile;
use umbragraph::low_level::shader::permutations::{self, Keep, Options, Request, Validator};
use umbragraph::low_level::source::FileId;

use crate::arguments::{DiagnosticsFormat, PermutationsArguments};
use crate::axes;
use crate::cache::Cache;
use crate::session::{Session, dry_run, profiles};
use crate::streams::{complain, print, print_json};
use crate::validator::ExternalValidator;
use crate::variants::{Outcome, ReachedConfigurations, proven_now, write};

/// Proves variants; whether there were no errors.
pub(crate) fn run(arguments: &PermutationsArguments) -> bool {
    let mut session = Session::new(&arguments.files);
    let cache = Cache::new(&arguments.cache);
    // What is more than a text for people is made anew.
    let is_text = !arguments.format.is_data()
        && arguments.write.is_none()
        && arguments.also.is_empty()
        // Parameter files are read later than the name is made.
        && arguments.settings.params.is_empty()
        && !arguments.axes
        && !arguments.exhaustive;
    let cached = cache.as_ref().filter(|_| is_text).map(|cache| {
        session.read_all(&arguments.pipelines, &arguments.files.extension);
        (cache, cache.run(session.sources()))
    });
    if let Some(said) = cached.as_ref().and_then(|(cache, name)| cache.said(name)) {
        print(&format!("{}{}", said.text, proven_now(0, 0)));
        complain(&said.diagnostics);
        return true;
    }
    let mut outcome = Outcome::default();
    if let Some((requests, reached)) = requests(arguments, &mut session) {
        outcome.reached = reached;
        if arguments.axes {
            list_axes(arguments, &session, &requests);
            return session.report();
        }
        let external = validators(arguments, &mut session);
        let external: Vec<&dyn Validator> = external.iter().map(|one| one as &dyn Validator).collect();
        outcome.permutations = prove(arguments, &session, &requests, &external, cache.as_ref());
        session.diagnostics.extend(std::mem::take(&mut outcome.permutations.diagnostics));
        if let Some(folder) = &arguments.write
            && let Err(diagnostic) = write(folder, &session.templates, &outcome.permutations.templates)
        {
            session.diagnostics.push(diagnostic);
        }
    }
    let text = outcome.human(arguments.verbose);
    let proven = proven_now(outcome.permutations.proven, outcome.permutations.texts);
    let is_fine = session.report_as(
        arguments.format,
        || format!("{text}{proven}"),
        |diagnostics| outcome.json(diagnostics),
    );
    if let Some((cache, name)) = cached.filter(|_| is_fine) {
        cache.keep(&name, &session.said(arguments.format, text));
    }
    is_fine
}

/// The variants to prove; `None` if the command line names something that does not exist.
fn requests(
    arguments: &PermutationsArguments,
    session: &mut Session,
) -> Option<(Vec<Request>, Vec<ReachedConfigurations>)> {
    let asked = session.profiles_named(&arguments.profiles)?;
    let is_one = arguments.config || !arguments.settings.is_empty();
    let mut requests: Vec<Request> = Vec::new();
    let mut counts = Vec::new();
    let mut claimed: Vec<TargetProfile> = asked.clone();
    for path in &arguments.pipelines {
        let Some(loaded) = session.open(path, &arguments.files.extension) else { continue };
        let Some(understood) = loaded.document().zip(loaded.model()) else { continue };
        let overrides = session.overrides(&arguments.settings, understood.0);
        let profiles = profiles(understood.0, asked.clone());
        claimed.extend(profiles.iter().cloned());
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let begin = requests.len();
        for (at, group) in alike(understood.0, &profiles).iter().enumerate() {
            let Some(first) = group.first() else { continue };
            let (values, plan) = (Overrides::default(), PlanOptions::new(1280, 720));
            let options = session.check_options(first, &values, &plan);
            let mut diagnostics = Diagnostics::new();
            let configurations = if is_one {
                Configurations::one(&overrides)
            } else {
                Configurations::all(understood, &session.templates, first)
            };
            let mut judge = dry_run(first);
            let reached = pipeline::reach(
                understood,
                &options,
                (&configurations, &mut judge),
                session.sources(),
                &mut diagnostics,
            );
            session.add_new(diagnostics);
            // The counts are those of the first profile.
            if at == 0 {
                counts.push(ReachedConfigurations {
                    pipeline: path.display().to_string(),
                    configurations: reached.configurations,
                    loaded: reached.loaded,
                    rejected: reached.rejected,
                    requests: begin..begin,
                });
            }
            for program in reached.programs {
                let more = match program.passes.len() {
                    0 | 1 => String::new(),
                    count => format!(" and {} more", count - 1),
                };
                let on = if at == 0 { String::new() } else { format!(" on {}", names(group)) };
                let name = format!("{stem}.{}{more}{on}", program.passes.first().map_or("", String::as_str));
                for allowed in program.products {
                    let is_same = |one: &&mut Request| {
                        one.template == program.template
                            && one.allowed == allowed
                            && one.assumed == program.assumed
                    };
                    if let Some(same) = requests[begin..].iter_mut().find(is_same) {
                        let new = group.iter().filter(|one| !same.profiles.contains(one));
                        let new: Vec<_> = new.cloned().collect();
                        same.profiles.extend(new);
                        continue;
                    }
                    requests.push(Request {
                        name: name.clone(),
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
    }
    Some((requests, counts))
}

fn names(profiles: &[TargetProfile]) -> String {
    profiles.iter().map(|one| one.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Profiles in groups that lack the same features, and so reach the same variants.
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

/// The templates that stand alone: those of which no other names.
fn whole_templates(session: &Session) -> Vec<String> {
    let named: BTreeSet<&str> = session.templates.names().flat_map(|name| named_in(session, name)).collect();
    let is_part = |name: &str| name.starts_with("lib/") || named.contains(name);
    session.templates.names().filter(|name| !is_part(name)).map(str::to_owned).collect()
}

/// The templates that the text of one names, in quotes.
fn named_in<'s>(session: &'s Session, name: &str) -> Vec<&'s str> {
    let file = session.templates.file(name).and_then(|file| session.sources().get(file));
    let text = file.map(|file| file.text().clone()).unwrap_or_else(|| "".into());
    let quoted = |other: &str| {
        let before_and_after =
            |at: usize| (text[..at].chars().next_back(), text[at + other.len()..].chars().next());
        text.match_indices(other)
            .any(|(at, _)| matches!(before_and_after(at), (Some('"'), Some('"')) | (Some('\''), Some('\''))))
    };
    session.templates.names().filter(|other| *other != name && quoted(other)).collect()
}

/// The files in which nothing is called dead, whatever the templates of these names need of them: those that another
/// template which stands alone uses as well, and all that come with this program where there is a folder of others.
fn shared(session: &Session, names: &BTreeSet<String>) -> BTreeSet<FileId> {
    let files = |name: &str| {
        let templates = &session.templates;
        [templates.file(name), templates.axes_file(name)].into_iter().flatten()
    };
    let mut open = whole_templates(session);
    open.retain(|name| !names.contains(name));
    let mut used: BTreeSet<String> = open.iter().cloned().collect();
    while let Some(name) = open.pop() {
        for other in named_in(session, &name) {
            if used.insert(other.to_owned()) {
                open.push(other.to_owned());
            }
        }
    }
    let mut shared: BTreeSet<FileId> = used.iter().flat_map(|name| files(name)).collect();
    if let Some(own) = &session.own_files {
        shared.extend(session.templates.names().flat_map(files).filter(|file| !own.contains(file)));
    }
    shared
}

fn list_axes(arguments: &PermutationsArguments, session: &Session, requests: &[Request]) {
    let names: BTreeSet<&String> = requests.iter().map(|request| &request.template).collect();
    match arguments.format {
        DiagnosticsFormat::Json => print_json(&format!("{:#}\n", axes::json(&session.templates, names))),
        _ => print(&axes::human(&session.templates, names)),
    }
}

/// The further validators, each with its place on the command line.
fn validators(arguments: &PermutationsArguments, session: &mut Session) -> Vec<ExternalValidator> {
    let time_limit = Duration::from_secs(arguments.also_time_limit);
    let mut placed = |validator: &ExternalValidator| {
        let place = Place::Span(session.on_command_line(&validator.text));
        ExternalValidator { time_limit, place, ..validator.clone() }
    };
    arguments.also.iter().map(&mut placed).collect()
}

fn prove(
    arguments: &PermutationsArguments,
    session: &Session,
    requests: &[Request],
    external: &[&dyn Validator],
    cache: Option<&Cache>,
) -> permutations::Permutations {
    let bar = std::io::stderr().is_terminal().then(|| {
        let bar = ProgressBar::new(0);
        match ProgressStyle::with_template("{bar:40} {pos} of {len} texts, {eta} left") {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    });
    let progress = |done: usize, all: usize| {
        if let Some(bar) = &bar {
            // Threads may report out of their order.
            let (done, all) = (done as u64, all as u64);
            bar.update(|state| {
                state.set_pos(done.max(state.pos()));
                state.set_len(all.max(state.len().unwrap_or(0)));
            });
        }
    };
    let defaults = Options::default();
    let names: BTreeSet<String> = requests.iter().map(|request| request.template.clone()).collect();
    let everything = arguments.all || arguments.pipelines.is_empty();
    let has_own = session.own_files.is_some();
    let shared = if everything || has_own { shared(session, &names) } else { BTreeSet::new() };
    let options = Options {
        threads: arguments.threads.map_or(defaults.threads, usize::from),
        external,
        exhaustive: arguments.exhaustive,
        keep: cache.map(|cache| cache as &dyn Keep),
        // An error elsewhere, such as a word that an axis never is, may be why.
        report_dead: everything && !session.diagnostics.has_errors(),
        shared: shared.clone(),
        progress: &progress,
        ..defaults
    };
    let mut outcome = permutations::check(&session.templates, requests, &options);
    // What a pipeline reaches says nothing of what is dead; in files of the user's own, all that they express does.
    if !everything && has_own && !outcome.diagnostics.has_errors() && !session.diagnostics.has_errors() {
        outcome.diagnostics.extend(permutations::dead(&session.templates, &names, &shared));
    }
    if let Some(bar) = &bar {
        bar.finish_and_clear();
    }
    outcome
}
