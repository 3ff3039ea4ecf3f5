//! `umbragraph permutations`
//!
//! Three modes: what the configurations of the given pipelines reach; one configuration of them; everything that the
//! templates can express. Each pipeline's configurations are loaded in full besides, so its bindings, and what scenes
//! upload for a geometry named `scene`, are compared with every variant.

mod merge;
mod requests;
mod shard;
mod shared;

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use umbragraph::diagnostic::{Diagnostic, Place};
use umbragraph::low_level::shader::permutations::{self, Keep, Options, Request, Validator};

use crate::annotations::add_summary;
use crate::arguments::{DiagnosticsFormat, PermutationsArguments};
use crate::axes;
use crate::bar::Bar;
use crate::budgets::Budgets;
use crate::cache::{Cache, Said};
use crate::codes;
use crate::junit::Fine;
use crate::lock::{DEFAULT, Lock, LockFile, Shown, hold, update};
use crate::measured::Measured;
use crate::session::Session;
use crate::streams::{complain, print, print_json};
use crate::validator::ExternalValidator;
use crate::variants::{Outcome, proven_now, write};
use requests::requests;
pub(crate) use shard::Shard;
use shared::shared;

/// Validates the shader variants of the given pipelines, or of all templates; `--merge` joins reports instead. Returns
/// `true` if there were no errors.
pub(crate) fn run(arguments: &PermutationsArguments) -> bool {
    let mut session = Session::new(&arguments.files);
    if arguments.merge {
        return merge::run(arguments, &mut session);
    }
    let file = LockFile::new(lock_path(arguments));
    let cache = Cache::new(&arguments.cache);
    // What is more than a text for people is made anew.
    let is_text = !arguments.format.is_data()
        && arguments.write.is_none()
        && arguments.also.is_empty()
        // Parameter files are read later than the name is made.
        && arguments.settings.params.is_empty()
        && arguments.measured.is_none()
        && !arguments.axes
        && !arguments.exhaustive;
    // Parts of what is reached are not all that a budget is about.
    let is_partial = arguments.is_partial();
    let is_budgeted = !is_partial && arguments.shard.is_none() && !arguments.axes;
    let budgets = is_budgeted.then(|| Budgets::read(&mut session, arguments.budgets.as_deref())).flatten();
    session.read_all(&arguments.pipelines, &arguments.files.extension);
    let cached = cache.as_ref().filter(|_| is_text).map(|cache| (cache, cache.run(session.sources())));
    let said = cached.as_ref().and_then(|(cache, name)| cache.said(name));
    let is_known = |said: &Said| {
        // A difference is shown at its pass.
        !arguments.locked || said.lock.as_ref().is_some_and(|lock| file.is_held(lock))
    };
    // Without pipelines there are no lines of theirs.
    let in_full = arguments.verbose || arguments.pipelines.is_empty();
    let end = |proven, texts| if in_full { proven_now(proven, texts) } else { String::new() };
    if let Some(said) = said.filter(is_known) {
        print(&format!("{}{}", said.text, end(0, 0)));
        add_summary(&said.summary);
        complain(&said.diagnostics);
        return said
            .lock
            .filter(|_| arguments.update)
            .is_none_or(|lock| write_lock(arguments, &session, &lock));
    }
    let run = fingerprint(arguments, &session);
    let mut outcome = Outcome { run, shard: arguments.shard, is_partial, ..Outcome::default() };
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
    if let Some(path) = arguments.measured.as_ref().filter(|_| arguments.format != DiagnosticsFormat::Json) {
        let message = "\"--measured\" puts figures into the JSON report, and another form is asked for";
        let diagnostic = Diagnostic::in_file(codes::MEASURED, path.display().to_string(), "", message);
        session.diagnostics.push(diagnostic.help("add --format json"));
    } else if let Some(path) = &arguments.measured {
        // Only the JSON report shows them.
        outcome.measured = Measured::read(&mut session, path, &outcome.permutations.templates);
    }
    // Where something is wrong, it is not known what is reached.
    let is_whole = !session.diagnostics.has_errors();
    session.quiet(arguments.verbose || arguments.format.is_data());
    let templates = session.templates.clone();
    let asked = (arguments.locked || arguments.update) && is_whole;
    let lock = asked.then(|| {
        let (lock, places) = outcome.lock(&file);
        if arguments.locked {
            let expensive = |pipeline: &str, pass: &str| outcome.expensive(&templates, &file, pipeline, pass);
            hold(&mut session, &file, &lock, &Shown { places: &places, expensive: &expensive });
        }
        lock
    });
    if let Some(budgets) = budgets.filter(|_| is_whole) {
        let file = budgets.file();
        let (reached, places) = outcome.lock(&file);
        let expensive = |pipeline: &str, pass: &str| outcome.expensive(&templates, &file, pipeline, pass);
        let shown = Shown { places: &places, expensive: &expensive };
        budgets.hold(&mut session, &reached.pipelines, &shown);
    }
    let text = outcome.human(in_full);
    let proven = end(outcome.permutations.proven, outcome.permutations.texts);
    // Which pipeline an error of a template belongs to is not known.
    let fine = outcome.reached.iter().map(|one| Fine {
        pipeline: one.pipeline.clone(),
        passes: one.reaching.iter().flat_map(|program| program.passes.iter().cloned()).collect(),
    });
    let fine: Vec<Fine> = fine.filter(|_| !session.diagnostics.has_errors()).collect();
    let is_fine = session.report_as(
        arguments.format,
        || format!("{text}{proven}"),
        |diagnostics| outcome.json(diagnostics),
        &fine,
    );
    let is_written = write_if_whole(arguments, &session, lock.as_ref());
    if let Some((cache, name)) = cached.filter(|_| is_fine) {
        cache.keep(&name, &Said { lock, ..session.said(arguments.format, text) });
    }
    is_fine && is_written
}

/// Returns the hash of everything that determines the outcome of a run, except its shard: version, file contents and
/// options.
fn fingerprint(arguments: &PermutationsArguments, session: &Session) -> String {
    let PermutationsArguments { profiles, all, config, settings, exhaustive, also, .. } = arguments;
    let mut hash = blake3::Hasher::new();
    let version = env!("CARGO_PKG_VERSION");
    hash.update(
        format!(
            "{version} {profiles:?} {all} {config} {settings:?} {exhaustive} {}",
            also.iter().map(|one| one.text.as_str()).collect::<Vec<_>>().join(" ")
        )
        .as_bytes(),
    );
    for (_, file) in session.sources().iter() {
        hash.update(blake3::hash(file.text().as_bytes()).as_bytes());
    }
    hash.finalize().to_hex().as_str().chars().take(16).collect()
}

/// Returns the path of the lock file.
fn lock_path(arguments: &PermutationsArguments) -> &Path {
    arguments.lock.as_deref().unwrap_or(Path::new(DEFAULT))
}

/// Writes the lock file if requested. Returns `false` if that failed, or if errors left the reachable shaders unknown.
fn write_if_whole(arguments: &PermutationsArguments, session: &Session, lock: Option<&Lock>) -> bool {
    match lock {
        _ if !arguments.update => true,
        Some(lock) => write_lock(arguments, session, lock),
        None => {
            complain(&format!("{} is left as it is, because of errors\n", lock_path(arguments).display()));
            false
        }
    }
}

/// Writes the lock file and prints the differences. Returns `true` if it could be written.
fn write_lock(arguments: &PermutationsArguments, session: &Session, lock: &Lock) -> bool {
    match update(&LockFile::new(lock_path(arguments)), lock) {
        Ok(said) => {
            let say = if arguments.format.is_data() { complain } else { print };
            say(&said);
            true
        }
        Err(diagnostic) => session.fail(diagnostic),
    }
}

fn list_axes(arguments: &PermutationsArguments, session: &Session, requests: &[Request]) {
    let names: BTreeSet<&String> = requests.iter().map(|request| &request.template).collect();
    match arguments.format {
        DiagnosticsFormat::Json => print_json(&format!("{:#}\n", axes::json(&session.templates, names))),
        _ => print(&axes::human(&session.templates, names)),
    }
}

/// Returns the additional validators, each with its place on the command line.
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
    let bar = Bar::of_texts();
    let progress = |done: usize, all: usize| bar.reach(done, all);
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
    bar.finish();
    outcome
}
