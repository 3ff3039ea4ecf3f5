//! `permutations.budgets.json`: how many texts, bytes and bindings, and how much cost, passes may have.
//!
//! ```json
//! { "pipelines/p.json": { "texts": 400, "passes": { "*": { "cost": 4000 }, "shade": { "cost": 9000, "bindings": 24 } } } }
//! ```
//!
//! A pipeline is named by its path from the folder of the file, as in a lock. `"*"` is the budget of every pass that names
//! none for a figure. Figures are those of the lock, counted by the prover without a GPU; each profile keeps to the budget. A
//! figure above its budget is an error at the budget.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use umbragraph::diagnostic::{Diagnostic, Place, list_of, suggested_name};
use umbragraph::low_level::document::{Entry, Kind, Value};
use umbragraph::low_level::source::Span;

use crate::codes;
use crate::lock::{Figure, LockFile, Pipeline, Shown, Texts, with_values};
use crate::session::Session;

/// The key of the budget for all passes that have no budget of their own.
const OTHERS: &str = "*";

const FIGURES: [Figure; 6] = [
    ("texts", |texts| texts.texts as u64),
    ("bytes", |texts| texts.bytes as u64),
    ("largest", |texts| texts.largest as u64),
    ("bindings", |texts| texts.bindings as u64),
    ("registers", |texts| texts.registers),
    ("cost", |texts| texts.worst.cost),
];
/// The names of the figures that a budget can limit for a pipeline, besides for each pass.
const OF_PIPELINE: [&str; 2] = ["texts", "bytes"];
const PASSES: &str = "passes";

/// A parsed file of shader budgets.
pub(crate) struct Budgets {
    root: Value,
    path: PathBuf,
}

/// The path of the budgets file if the command line names none.
const DEFAULT: &str = "permutations.budgets.json";

impl Budgets {
    /// Reads the given budgets file, or the default one in the working folder. Returns `None` if no default file exists
    /// or after an error, which the session records.
    pub(crate) fn read(session: &mut Session, given: Option<&Path>) -> Option<Self> {
        let path = given.unwrap_or(Path::new(DEFAULT));
        if given.is_none() && !path.exists() {
            return None;
        }
        match session.read_figures(path) {
            Ok(document) => Some(Self { root: document.root, path: path.to_owned() }),
            Err(diagnostics) => {
                session.diagnostics.extend(diagnostics);
                None
            }
        }
    }

    /// The path of the budgets file. Pipeline names in the file are relative to its folder.
    pub(crate) fn file(&self) -> LockFile<'_> {
        LockFile::new(&self.path)
    }

    /// Compares the reachable shaders with their budgets. Adds a diagnostic for each exceeded figure, and for each
    /// budget of an unknown name.
    pub(crate) fn hold(
        &self,
        session: &mut Session,
        reached: &BTreeMap<String, Pipeline>,
        shown: &Shown<'_>,
    ) {
        let (mut found, file) = (Vec::new(), self.file());
        let Some(pipelines) = self.root.entries() else {
            let message = format!("budgets are an object of pipelines, not {}", self.root.kind_name());
            session.diagnostics.push(Diagnostic::error(codes::BUDGET_INVALID, self.root.span, message));
            return;
        };
        for own in pipelines {
            match reached.get(&own.key) {
                Some(pipeline) => {
                    let hold = Hold { path: &own.key, pipeline, shown };
                    hold.pipeline(&own.value, &mut found);
                }
                None => {
                    let named = file.usual(&own.key);
                    if !file.exists(&own.key) {
                        let message = format!("there is no pipeline \"{}\"", own.key);
                        let is_it = |path: &&String| {
                            Path::new(path.as_str()).file_stem().is_some_and(|stem| stem == own.key.as_str())
                        };
                        let meant = reached.keys().find(is_it).map(String::as_str);
                        let meant =
                            meant.or_else(|| suggested_name(&own.key, reached.keys().map(String::as_str)));
                        let help = match meant {
                            Some(path) => format!("did you mean \"{path}\"?"),
                            None => "name it by its path from the folder of this file".to_owned(),
                        };
                        found
                            .push(Diagnostic::error(codes::BUDGET_INVALID, own.key_span, message).help(help));
                    } else if named != own.key {
                        let message = format!("the pipeline \"{named}\" is written as \"{}\"", own.key);
                        let help = format!("write \"{named}\"");
                        found
                            .push(Diagnostic::error(codes::BUDGET_INVALID, own.key_span, message).help(help));
                    }
                }
            }
        }
        session.diagnostics.extend(found);
    }
}

struct Hold<'a> {
    path: &'a str,
    pipeline: &'a Pipeline,
    shown: &'a Shown<'a>,
}

/// An upper limit and its place in the file.
type Limit = (u64, Span);

impl Hold<'_> {
    fn pipeline(&self, value: &Value, found: &mut Vec<Diagnostic>) {
        let known: Vec<&str> = OF_PIPELINE.into_iter().chain([PASSES]).collect();
        let mut by_hash: BTreeMap<&str, &Texts> = BTreeMap::new();
        by_hash
            .extend(self.pipeline.programs.values().flat_map(|of| of.values()).map(|own| (&*own.hash, own)));
        for entry in members(value, found) {
            if entry.key == PASSES {
                self.passes(&entry.value, found);
                continue;
            }
            let figure = figure(entry, &OF_PIPELINE, &known, found);
            let Some(((name, of), (limit, place))) = figure else { continue };
            let sum: u64 = by_hash.values().map(|own| of(own)).sum();
            if sum > limit {
                let message = format!("the pipeline has {sum} {name}; its budget is {limit}");
                found.push(Diagnostic::error(codes::BUDGET, place, message).help(HELP));
            }
        }
    }

    fn passes(&self, value: &Value, found: &mut Vec<Diagnostic>) {
        let passes: BTreeSet<&str> = self.pipeline.programs.keys().map(|(pass, _)| pass.as_str()).collect();
        let all: Vec<&str> = FIGURES.iter().map(|(name, _)| *name).collect();
        let mut limits: BTreeMap<(&str, &str), Limit> = BTreeMap::new();
        for own in members(value, found) {
            if own.key != OTHERS && !passes.contains(own.key.as_str()) {
                let message = format!("no pass \"{}\" is reached by {}", own.key, self.path);
                let known = suggested_name(&own.key, passes.iter().copied())
                    .map_or_else(|| quoted(&passes), |one| format!("\"{one}\""));
                let help = format!("its passes with shaders: {known}; \"*\" is every other one");
                found.push(Diagnostic::error(codes::BUDGET_INVALID, own.key_span, message).help(help));
                continue;
            }
            for entry in members(&own.value, found) {
                if let Some(((name, _), limit)) = figure(entry, &all, &all, found) {
                    limits.insert((&own.key, name), limit);
                }
            }
        }
        // Passes with the same texts are one cause.
        for section in self.pipeline.sections() {
            for (name, of) in FIGURES {
                let mut alike: BTreeMap<Limit, BTreeSet<&str>> = BTreeMap::new();
                for pass in &section.passes {
                    let limit = limits.get(&(pass.as_str(), name)).or_else(|| limits.get(&(OTHERS, name)));
                    if let Some(limit) = limit.filter(|(limit, _)| of(&section.texts) > *limit) {
                        alike.entry(*limit).or_default().insert(pass);
                    }
                }
                for (limit, passes) in alike {
                    let over = Over { name, value: of(&section.texts), limit, passes };
                    found.push(self.over(over, &section.texts, &section.profiles));
                }
            }
        }
    }

    fn over(&self, over: Over<'_>, texts: &Texts, profiles: &BTreeSet<String>) -> Diagnostic {
        let Over { name, value, limit: (limit, place), passes } = over;
        let first = passes.first().copied().unwrap_or_default();
        let named = quoted(&passes);
        let profiles = profiles.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        let figure = match name {
            "cost" => format!("{named} costs {value}{}", with_values(&texts.worst.values)),
            "largest" => format!("{named} has a text of {value} bytes"),
            _ => format!("{named} has {value} {name}"),
        };
        let message = format!("{figure} for {profiles}; the budget is {limit}");
        let mut diagnostic = Diagnostic::error(codes::BUDGET, place, message).help(HELP);
        if let Some(place) = self.shown.places.get(&(self.path.to_owned(), first.to_owned())) {
            diagnostic = diagnostic.related(*place, "this pass");
        }
        if name == "cost" {
            diagnostic = self.shown.with_lines(diagnostic, self.path, first);
        }
        diagnostic
    }
}

fn quoted(names: &BTreeSet<&str>) -> String {
    list_of(names.iter().map(|name| format!("\"{name}\"")))
}

/// A figure above its limit, with the passes that exceed it.
struct Over<'a> {
    name: &'static str,
    value: u64,
    limit: Limit,
    passes: BTreeSet<&'a str>,
}

const HELP: &str = "raise the budget if it is meant; a lock (`umbragraph permutations PIPELINE... --update`) has all figures";

/// Returns the members of an object; for any other value, adds a diagnostic and returns an empty slice.
fn members<'v>(value: &'v Value, found: &mut Vec<Diagnostic>) -> &'v [Entry] {
    value.entries().unwrap_or_else(|| {
        let message = format!("a budget is an object of figures, not {}", value.kind_name());
        found.push(Diagnostic::error(codes::BUDGET_INVALID, value.span, message));
        &[]
    })
}

/// Parses one member of a budget as a known figure with its limit; after an error, adds a diagnostic and returns
/// `None`.
fn figure(
    entry: &Entry,
    names: &[&str],
    known: &[&str],
    found: &mut Vec<Diagnostic>,
) -> Option<(Figure, Limit)> {
    let figure = FIGURES.into_iter().find(|(name, _)| names.contains(name) && *name == entry.key);
    let Some(figure) = figure else {
        let message = format!("there is no figure \"{}\"", entry.key);
        let help = match suggested_name(&entry.key, known.iter().copied()) {
            Some(name) => format!("did you mean \"{name}\"?"),
            None => format!("figures are {}", list_of(known)),
        };
        found.push(Diagnostic::error(codes::BUDGET_INVALID, entry.key_span, message).help(help));
        return None;
    };
    let limit = match &entry.value.kind {
        Kind::Number(_) => entry.value.decode::<u64>().ok(),
        _ => None,
    };
    if limit.is_none() {
        let found_value = serde_json::to_string(&entry.value.to_json()).unwrap_or_default();
        let message = format!("\"{}\" is {found_value}; a budget is a whole number from 0 on", entry.key);
        found.push(Diagnostic::error(codes::BUDGET_INVALID, Place::Span(entry.value.span), message));
    }
    Some((figure, (limit?, entry.value.span)))
}
