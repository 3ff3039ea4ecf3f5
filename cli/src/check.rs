//! `umbragraph check`: validates pipelines in every configuration.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use umbragraph::diagnostic::counted;
use umbragraph::low_level::pipeline::{Cover, MAX_CONFIGURATIONS};
use umbragraph::low_level::session::Surveyed;
use umbragraph::low_level::shader::permutations::Count;

use crate::annotations::add_summary;
use crate::arguments::{CheckArguments, Choices};
use crate::bar::Bar;
use crate::cache::Cache;
use crate::junit::Fine;
use crate::mend::mend;
use crate::parts;
use crate::remarks;
use crate::session::Session;
use crate::show::SCHEME;
use crate::streams::{complain, print};

/// Checks pipelines, after applying fixes if requested. Returns `true` if no errors are left; in a dry run, only if
/// there was also nothing to fix.
pub(crate) fn run(arguments: &CheckArguments) -> bool {
    let mut session = Session::new(&arguments.choices.files);
    if arguments.fix {
        let mended = mend(arguments);
        if mended.is_empty() {
            complain("--fix: nothing is wrong that can be mended in one way only\n");
        } else if arguments.dry_run {
            mended.print_difference();
            return false;
        }
        session.diagnostics.extend(mended.write());
    }
    // Parameter files are read later than the name is made.
    let has_files = !arguments.choices.settings.params.is_empty();
    let is_text = !arguments.fix && !arguments.format.is_data() && !has_files;
    let cache = if is_text { Cache::new(&arguments.cache) } else { None };
    let cached = cache.map(|cache| {
        session.read_all(&arguments.pipelines, &arguments.choices.files.extension);
        let name = cache.run(session.sources());
        (cache, name)
    });
    if let Some(said) = cached.as_ref().and_then(|(cache, name)| cache.said(name)) {
        print(&said.text);
        add_summary(&said.summary);
        complain(&said.diagnostics);
        return true;
    }
    let mut is_sound = true;
    let mut text = String::new();
    let (mut pipelines, mut fine) = (Vec::new(), Vec::new());
    let bar = Bar::of_pipelines(arguments.pipelines.len());
    for (at, path) in arguments.pipelines.iter().enumerate() {
        bar.step(at, path);
        let before = session.diagnostics.error_count();
        if let Some(kind) = session.check_part(path) {
            if session.diagnostics.error_count() == before && !arguments.format.is_data() {
                text.push_str(&parts::summary(path, kind));
            }
            continue;
        }
        let covered = session.check_all(path, &arguments.choices, arguments.config, arguments.verify);
        let Some(covered) = covered else { continue };
        pipelines.push(numbers(path, &covered));
        if session.diagnostics.error_count() == before && covered.coverage.violations.is_empty() {
            fine.push(Fine { pipeline: path.display().to_string(), passes: BTreeSet::new() });
        }
        for violation in &covered.coverage.violations {
            complain(&format!(
                "{}: violation: {violation}\nthis is a defect of the compiler\n",
                path.display()
            ));
            is_sound = false;
        }
        if session.diagnostics.error_count() == before && !arguments.format.is_data() {
            text.push_str(&summary(path, &covered, &mut session, arguments));
            if arguments.verbose {
                text.push_str(&remarks::lines(path, &arguments.choices.files, &covered));
            }
        }
    }
    bar.finish();
    let is_fine = session.report_as(
        arguments.format,
        || text.clone(),
        |diagnostics| {
            format!("{:#}", serde_json::json!({ "diagnostics": diagnostics, "pipelines": pipelines }))
        },
        &fine,
    );
    if let Some((cache, name)) = cached.filter(|_| is_fine && is_sound) {
        cache.keep(&name, &session.said(arguments.format, text));
    }
    is_fine && is_sound
}

/// Returns the coverage of a pipeline's check as JSON.
fn numbers(path: &Path, covered: &Surveyed) -> serde_json::Value {
    let configurations = &covered.configurations;
    let unchecked = covered.coverage.first.pipeline.as_ref().map_or(0, |pipeline| pipeline.gaps.len());
    serde_json::json!({
        "pipeline": path.display().to_string(),
        "unchecked": unchecked,
        "configurations": configurations.list.len(),
        "reachable": whole(configurations.number.number),
        "cover": match configurations.cover {
            Cover::All => "all",
            Cover::Passes => "passes",
            Cover::Pairs => "pairs",
            Cover::Some => "some",
        },
        "profiles": covered.profiles,
        "left": remarks::left(covered),
        "culled": covered.coverage.remarks.culled.iter().cloned().collect::<BTreeMap<_, _>>(),
        "small_dispatches": covered.coverage.remarks.small_dispatches,
        "unused_entry_points": covered.coverage.remarks.entry_points,
        "without_effect": covered.coverage.remarks.parameters,
    })
}

/// Returns a whole number as JSON; a string if it exceeds 64 bits.
fn whole(number: u128) -> serde_json::Value {
    match u64::try_from(number) {
        Ok(number) => number.into(),
        Err(_) => number.to_string().into(),
    }
}

/// Returns the note that most of the checked variants are of bundled templates, with the way to check fewer; empty if
/// most are not, or if there are few.
fn of_library(path: &PathBuf, covered: &Surveyed, session: &mut Session, choices: &Choices) -> String {
    let variants = &covered.coverage.variants;
    let own = variants.iter().filter(|(template, _)| session.is_own_template(template)).count();
    let is_bundled = |path: &Path| path.to_string_lossy().starts_with(SCHEME);
    if is_bundled(path) || variants.len() < MANY_VARIANTS || own * 2 > variants.len() {
        return String::new();
    }
    let paths = session.paths(std::slice::from_ref(path), &choices.files.extension);
    if !paths.iter().any(|path| is_bundled(path)) {
        return String::new();
    }
    match own {
        0 => " (all of bundled templates; --config checks one configuration)".to_owned(),
        own => format!(" ({own} of your templates; --config checks one configuration)"),
    }
}

/// The number of shader variants below which it does not matter whose they are.
const MANY_VARIANTS: usize = 32;

/// Returns one line about a pipeline without errors; empty if the pipeline has no plan.
fn summary(path: &PathBuf, covered: &Surveyed, session: &mut Session, arguments: &CheckArguments) -> String {
    let Some(plan) = &covered.coverage.first.plan else { return String::new() };
    let unchecked = covered.coverage.first.pipeline.as_ref().map_or(0, |pipeline| pipeline.gaps.len());
    let passes = plan.passes.len() + plan.culled.len() + unchecked;
    if unchecked > 0 {
        let path = path.display();
        return format!("{path}: {unchecked} of {passes} passes could not be checked, because of errors\n");
    }
    let checked = covered.configurations.list.len();
    let configurations = match (checked, covered.configurations.cover) {
        (1, _) => "1 configuration".to_owned(),
        (_, Cover::All) => format!("{checked} configurations"),
        (_, cover) => {
            let Count { number, exact } = covered.configurations.number;
            let min = if exact { "" } else { "at least " };
            let what = match cover {
                Cover::Some => "not every pair of values",
                _ => "every value of a feature with every value of each other",
            };
            format!("{checked} configurations of {min}{number} (more than {MAX_CONFIGURATIONS}, so {what})")
        }
    };
    format!(
        "{}: {} ({} culled), {}, {}{}, {configurations}{}, valid for {}\n",
        path.display(),
        counted(passes, "pass"),
        plan.culled.len(),
        counted(plan.resources.len(), "resource"),
        counted(covered.coverage.variants.len(), "shader variant"),
        of_library(path, covered, session, &arguments.choices),
        if arguments.verify { ", plans verified" } else { "" },
        covered.profiles.join(", ")
    )
}
