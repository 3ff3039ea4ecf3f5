//! `umbragraph permutations --merge`: the JSON reports of shards as one.
//!
//! A template for a profile is whole in one shard, so what is reached adds up. A diagnostic that several shards report
//! is one. Its place is looked up in the file again, so that every format shows it as the shard did.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use umbragraph::diagnostic::{Code, Diagnostic, Place, Severity, counted};
use umbragraph::low_level::compose::{read_bytes, unreadable};
use umbragraph::low_level::shader::permutations::Count;
use umbragraph::low_level::shader::{AxisValue, AxisValues};

use super::{Shard, lock_path, write_if_whole};
use crate::arguments::PermutationsArguments;
use crate::budgets::Budgets;
use crate::codes;
use crate::junit::Fine;
use crate::lock::{Lock, LockFile, PassPlaces, Pipeline, Section, Shown, hold};
use crate::session::Session;

/// The maximum size in bytes of a report, or of a source file that a diagnostic refers to.
const MAX_BYTES: u64 = 1 << 30;

/// A JSON report of one shard, or the joined report.
#[derive(Default, Serialize, Deserialize)]
struct Report {
    /// The fingerprint of the run, equal for all its shards.
    run: String,
    diagnostics: Vec<Value>,
    shard: Option<Shard>,
    partial: bool,
    pipelines: Vec<ReachedPipeline>,
    templates: Vec<Template>,
    combinations: Count,
    texts: usize,
    proven: usize,
    declarations: usize,
}

#[derive(Serialize, Deserialize)]
struct ReachedPipeline {
    pipeline: String,
    configurations: Count,
    loaded: usize,
    rejected: usize,
    reached: Pipeline,
}

/// The report on one validation request: the variants of a template for one or several passes.
#[derive(PartialEq, Serialize, Deserialize)]
struct Template {
    name: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    group: String,
    template: String,
    profiles: Vec<String>,
    configurations: Count,
    covered: Count,
    paths: usize,
    values: BTreeMap<String, BTreeSet<AxisValue>>,
    variants: Vec<Variant>,
    dead_axes: Vec<String>,
    bytes_of_values: Vec<Value>,
}

#[derive(PartialEq, Serialize, Deserialize)]
struct Variant {
    axes: AxisValues,
    paths: usize,
    configurations: Count,
    bytes: usize,
    hash: String,
    valid: bool,
    costs: BTreeMap<String, Value>,
}

impl Report {
    fn add(&mut self, other: Self) {
        self.partial |= other.partial;
        for diagnostic in other.diagnostics {
            match self.diagnostics.iter_mut().find(|known| is_alike(known, &diagnostic)) {
                Some(known) => unite(&mut known["profiles"], &diagnostic["profiles"]),
                None => self.diagnostics.push(diagnostic),
            }
        }
        for own in other.pipelines {
            match self.pipelines.iter_mut().find(|known| known.pipeline == own.pipeline) {
                Some(known) => {
                    let mut sections = Vec::<Section>::from(std::mem::take(&mut known.reached));
                    sections.extend(own.reached.sections());
                    known.reached = sections.into();
                }
                None => self.pipelines.push(own),
            }
        }
        for own in other.templates {
            let is_known = |known: &&mut Template| {
                known.name == own.name
                    && known.template == own.template
                    && known.variants == own.variants
                    && known.configurations == own.configurations
            };
            match self.templates.iter_mut().find(is_known) {
                Some(known) => {
                    known.profiles.extend(own.profiles);
                    known.profiles.sort();
                    known.profiles.dedup();
                }
                None => self.templates.push(own),
            }
        }
        self.proven += other.proven;
        self.declarations += other.declarations;
    }

    /// Returns `true` if the two reports have a pipeline in common.
    fn has_one_of(&self, other: &Self) -> bool {
        let is_known = |own: &ReachedPipeline| other.pipelines.iter().any(|one| one.pipeline == own.pipeline);
        self.pipelines.iter().any(is_known)
    }

    /// Sorts pipelines and templates in an order that does not depend on the shards. Counts the combinations of axis
    /// values and the distinct shader sources.
    fn finish(&mut self) {
        self.pipelines.sort_by(|a, b| a.pipeline.cmp(&b.pipeline));
        let hash = |one: &Template| one.variants.first().map(|first| first.hash.clone());
        self.templates.sort_by(|a, b| (&a.name, &a.template, hash(a)).cmp(&(&b.name, &b.template, hash(b))));
        for covered in self.templates.iter().map(|template| template.covered) {
            self.combinations = self.combinations.plus(covered);
        }
        let texts = self.templates.iter().flat_map(|one| one.variants.iter().map(|each| &each.hash));
        self.texts = texts.collect::<BTreeSet<_>>().len();
    }
}

/// Returns `true` if two diagnostics have the same code, severity, message and place.
fn is_alike(a: &Value, b: &Value) -> bool {
    ["code", "severity", "message", "place"].iter().all(|key| a[key] == b[key])
}

fn unite(known: &mut Value, new: &Value) {
    let (Some(known), Some(new)) = (known.as_array_mut(), new.as_array()) else { return };
    for profile in new {
        if !known.contains(profile) {
            known.push(profile.clone());
        }
    }
}

/// Joins the reports of shards. Returns `true` if the reports contain no error.
pub(super) fn run(arguments: &PermutationsArguments, session: &mut Session) -> bool {
    let mut joined = Report::default();
    let mut shards: Vec<Option<Shard>> = Vec::new();
    for path in &arguments.pipelines {
        match read(path) {
            Ok(report) if !shards.is_empty() && report.shard.is_some() && report.run != joined.run => {
                let first =
                    arguments.pipelines.first().map_or("", |first| first.to_str().unwrap_or_default());
                let name = path.display().to_string();
                let message =
                    format!("\"{name}\" is of other files, options or another version than \"{first}\"");
                let help = "make all reports of the same files, with the same options and the same program";
                session.diagnostics.push(Diagnostic::in_file(codes::SHARDS, name, "", message).help(help));
            }
            Ok(report)
                if report.shard.is_none()
                    && shards.iter().all(Option::is_none)
                    && joined.has_one_of(&report) =>
            {
                let name = path.display().to_string();
                let message = format!("a report before \"{name}\" has its pipelines, too");
                let help = "give one report of each pipeline, or the reports of all shards";
                session.diagnostics.push(Diagnostic::in_file(codes::SHARDS, name, "", message).help(help));
            }
            Ok(report) => {
                joined.run.clone_from(&report.run);
                if report.partial && (arguments.locked || arguments.update) {
                    let name = path.display().to_string();
                    let message = format!(
                        "\"{name}\" is of a part of what is reached, or of more: a lock has exactly that"
                    );
                    let help = "make the report without --config, --set, --feature, --preset, --params, --profile and --all";
                    session
                        .diagnostics
                        .push(Diagnostic::in_file(codes::SHARDS, name, "", message).help(help));
                }
                shards.push(report.shard);
                joined.add(report);
            }
            Err(diagnostic) => session.diagnostics.push(diagnostic),
        }
    }
    if session.diagnostics.has_errors() {
        return session.report();
    }
    if let Err(message) = are_whole(&shards) {
        let name = arguments.pipelines.first().map_or_else(String::new, |path| path.display().to_string());
        let help = "give the reports of all shards, each once";
        session.diagnostics.push(Diagnostic::in_file(codes::SHARDS, name, "", message).help(help));
        return session.report();
    }
    joined.finish();
    for value in &joined.diagnostics {
        let diagnostic = diagnostic(session, value);
        session.diagnostics.push(diagnostic);
    }
    let file = LockFile::new(lock_path(arguments));
    let mut lock = Lock::default();
    for one in &joined.pipelines {
        lock.pipelines.insert(file.name_of(Path::new(&one.pipeline)), one.reached.clone());
    }
    let is_whole = !session.diagnostics.has_errors();
    // Places and texts are not in reports.
    let nothing = Shown { places: &PassPlaces::new(), expensive: &|_, _| Vec::new() };
    session.quiet(arguments.verbose || arguments.format.is_data());
    if arguments.locked && is_whole {
        let before = session.diagnostics.len();
        hold(session, &file, &lock, &nothing);
        let new: Vec<Value> = session.diagnostics.iter().skip(before).map(|one| session.json(one)).collect();
        joined.diagnostics.extend(new);
    }
    if is_whole
        && !joined.partial
        && let Some(budgets) = Budgets::read(session, arguments.budgets.as_deref())
    {
        let file = budgets.file();
        let name = |one: &ReachedPipeline| (file.name_of(Path::new(&one.pipeline)), one.reached.clone());
        let reached: BTreeMap<String, Pipeline> = joined.pipelines.iter().map(name).collect();
        let before = session.diagnostics.len();
        budgets.hold(session, &reached, &nothing);
        let new: Vec<Value> = session.diagnostics.iter().skip(before).map(|one| session.json(one)).collect();
        joined.diagnostics.extend(new);
    }
    let line = |one: &ReachedPipeline| {
        let texts: BTreeSet<(String, usize)> =
            one.reached.sections().into_iter().map(|one| (one.texts.hash, one.texts.texts)).collect();
        let profiles: Vec<&str> = one.reached.profiles().into_iter().collect();
        let passes: BTreeSet<&String> = one.reached.programs.keys().map(|(pass, _)| pass).collect();
        let texts = counted(texts.iter().map(|(_, texts)| texts).sum(), "text");
        format!("{}: {}, {texts}, for {}\n", one.pipeline, counted(passes.len(), "pass"), profiles.join(", "))
    };
    let text: String = joined.pipelines.iter().map(line).collect();
    let fine = joined.pipelines.iter().map(|one| Fine {
        pipeline: one.pipeline.clone(),
        passes: one.reached.programs.keys().map(|(pass, _)| pass.clone()).collect(),
    });
    let fine: Vec<Fine> = fine.filter(|_| !session.diagnostics.has_errors()).collect();
    let is_fine = session.report_as(
        arguments.format,
        || text,
        |_| serde_json::to_string_pretty(&joined).unwrap_or_default(),
        &fine,
    );
    let is_written = write_if_whole(arguments, session, Some(&lock).filter(|_| is_whole));
    is_fine && is_written
}

fn read(path: &Path) -> Result<Report, Diagnostic> {
    let name = path.display().to_string();
    let invalid = |reason: &dyn std::fmt::Display| {
        let message = format!("\"{name}\" is not a report: {reason}");
        let help = "print one with `umbragraph permutations PIPELINE... --shard 1/2 --format json`";
        Diagnostic::in_file(codes::SHARDS, &*name, "", message).help(help)
    };
    let bytes = read_bytes(path, MAX_BYTES).map_err(|error| unreadable(&name, &error))?;
    let bytes = bytes.ok_or_else(|| invalid(&"it is too large"))?;
    serde_json::from_slice(&bytes).map_err(|error| invalid(&error))
}

const MIXED: &str = "a report of a whole run cannot be joined with reports of shards";

/// Checks that the reports are all shards of one run, or all of complete runs.
fn are_whole(shards: &[Option<Shard>]) -> Result<(), String> {
    let Some(Some(Shard { of, .. })) = shards.first() else {
        let is_mixed = shards.iter().any(Option::is_some);
        return if is_mixed { Err(MIXED.to_owned()) } else { Ok(()) };
    };
    let mut missing: BTreeSet<u32> = (1..=*of).collect();
    for shard in shards {
        match shard {
            None => return Err(MIXED.to_owned()),
            Some(shard) if shard.of != *of => {
                return Err(format!("shards of {of} and of {} do not belong together", shard.of));
            }
            Some(shard) if !missing.remove(&shard.index) => {
                return Err(format!("shard {}/{of} is there twice", shard.index));
            }
            Some(_) => {}
        }
    }
    let list: Vec<String> = missing.iter().take(8).map(|index| format!("{index}/{of}")).collect();
    if list.is_empty() { Ok(()) } else { Err(format!("these shards are missing: {}", list.join(", "))) }
}

/// Parses a diagnostic of a JSON report.
fn diagnostic(session: &mut Session, value: &Value) -> Diagnostic {
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let id = text(&value["code"]);
    let code: Option<Code> =
        umbragraph::codes().into_iter().chain(codes::ALL.iter().copied()).find(|code| code.id == id);
    let code = code.unwrap_or(codes::SHARDS);
    let place = place(session, &value["place"]);
    let mut diagnostic = Diagnostic::error(code, place, text(&value["message"]));
    diagnostic = match value["severity"].as_str() {
        Some("warning") => diagnostic.severity(Severity::Warning),
        Some("note") => diagnostic.severity(Severity::Note),
        _ => diagnostic,
    };
    for related in value["related"].as_array().into_iter().flatten() {
        let place = self::place(session, &related["place"]);
        diagnostic = diagnostic.related(place, text(&related["message"]));
    }
    match value["help"].as_str() {
        Some(help) => diagnostic.help(help),
        None => diagnostic,
    }
}

fn place(session: &mut Session, value: &Value) -> Place {
    let Some(file) = value["file"].as_str() else { return Place::Nowhere };
    let number = |key: &str| value[key].as_u64().and_then(|number| usize::try_from(number).ok());
    let in_file = Place::File { path: file.to_owned(), locator: String::new() };
    let bytes = read_bytes(Path::new(file), MAX_BYTES).ok().flatten();
    let Some(text) = bytes.and_then(|bytes| String::from_utf8(bytes).ok()) else { return in_file };
    // Lines and columns count from 1, columns in characters.
    let offset = |line: usize, column: usize| {
        let start = text.split_inclusive('\n').take(line.checked_sub(1)?).map(str::len).sum::<usize>();
        let rest = text.get(start..)?;
        let inside = rest.char_indices().nth(column.checked_sub(1)?).map_or(rest.len(), |(at, _)| at);
        Some(start + inside)
    };
    let at = |line, column| offset(number(line)?, number(column)?);
    let (Some(start), Some(end)) = (at("line", "column"), at("end_line", "end_column")) else {
        return in_file;
    };
    Place::Span(session.text_of(file, &text).inside(start..end.max(start)))
}
