//! Every shader permutation, proven.
//!
//! ```text
//! requests ──explore──▶ paths, distinct texts ──compose──▶ refusals ──group──▶ diagnostics, one per root cause
//!              lazily, one rendering per path      each declaration with what it sees is proven once    with what provokes them
//! ```
//!
//! A [`Request`] names a template, the values that its axes can have (all, those that pipelines reach, or one
//! configuration), and the profiles that have to accept it. [`check`] takes every path through the template that these
//! values allow, proves as many of the distinct texts as hold all declarations with all that these see of others
//! (`compose`), and reports: diagnostics, coverage, sizes, what is dead. The outcome does not depend on the number of
//! threads.

mod agree;
mod blame;
mod cache;
mod cause;
mod choices;
mod choose;
mod components;
mod compose;
mod content;
mod costs;
mod cover;
mod dead;
mod declared;
mod edited;
mod explore;
mod failure;
mod interned;
mod kept;
mod learn;
mod modules;
mod overrides;
mod prove;
mod proven;
mod report;
mod request;
mod summary;
mod units;
mod validator;
mod verdicts;

pub use crate::axes::Space;
pub use crate::rules::cost::{Cost, Operations, WEIGHTS, Weight};
pub use cache::ShaderCache;
pub use choices::Choices;

pub use dead::dead;
pub use declared::declares;
pub use edited::{TextEdit, Variant, root_causes, variants};
pub use kept::Keep;
pub use report::{Costs, Permutations, TemplateReport, ValueBytes, VariantReport};
pub use request::Request;
use request::space_of;
pub use umbragraph_text::diagnostic::Count;
pub use validator::{Opinion, Validator};

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use cause::{Causes, Failure, Ground};
use dead::Examined;
pub(crate) use explore::Explorer;
use interned::{Declarations, Id};
use proven::{Explored, Verdict};
use rayon::iter::{IntoParallelRefIterator as _, ParallelIterator as _};

use crate::module::wgsl;
use crate::reflection::Reflection;
use crate::rendering::parts::Parts;
use crate::rendering::templates::TemplateSet;
use crate::written::declarations::Split;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic, Diagnostics};
use umbragraph_text::source::FileId;

/// The options of a permutation check.
pub struct Options<'a> {
    /// The number of threads, at most 256.
    pub threads: usize,
    /// External validators for modules that naga accepts.
    pub external: &'a [&'a dyn Validator],
    /// Whether every distinct module is validated as a whole, instead of by its declarations.
    pub exhaustive: bool,
    /// The store for validation results between runs; `None` to validate everything anew.
    pub keep: Option<&'a dyn Keep>,
    /// Whether to report axes without effect and template text in no variant. Set it only if the requests cover every
    /// configuration of the templates.
    pub report_dead: bool,
    /// Files whose templates are also used outside of the requests; no text in them is reported as unused.
    pub shared: BTreeSet<FileId>,
    /// The progress callback: the number of modules with a result, and the number of known modules. Any thread may call
    /// it.
    pub progress: &'a (dyn Fn(usize, usize) + Sync),
    /// Stops the check before the next module once set; the results must then be discarded.
    pub cancelled: &'a AtomicBool,
}

/// A cancellation flag that is never set.
static NEVER: AtomicBool = AtomicBool::new(false);

impl Default for Options<'_> {
    fn default() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        Self {
            threads,
            external: &[],
            exhaustive: false,
            keep: None,
            report_dead: false,
            shared: BTreeSet::new(),
            progress: &|_, _| {},
            cancelled: &NEVER,
        }
    }
}

impl Options<'_> {
    fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// The maximum number of threads of a check.
const MAX_THREADS: usize = 256;

/// Explores all paths of the requests in parallel. Requests with the same template and allowed values share the
/// result. Returns diagnostics for requests that cannot be explored.
fn explore<'a>(
    templates: &'a TemplateSet,
    requests: &'a [Request],
    options: &Options<'_>,
) -> (Vec<Explored<'a>>, Declarations, Vec<Diagnostic>) {
    let (declarations, texts): (Mutex<Declarations>, _) = (Mutex::default(), AtomicUsize::new(0));
    let mut first: HashMap<(&str, String), usize> = HashMap::new();
    let mut distinct: Vec<&'a Request> = Vec::new();
    let shared: Vec<usize> = requests
        .iter()
        .map(|request| {
            let next = distinct.len();
            let at = *first.entry((&request.template, format!("{:?}", request.allowed))).or_insert(next);
            distinct.extend((at == next).then_some(request));
            at
        })
        .collect();
    // Where bindings give way to an author's, a text depends on where each piece of it is from.
    let can_be_joined = !options.report_dead && !templates.has_own_templates();
    let parts: HashMap<&str, OnceLock<Option<Parts>>> = distinct
        .iter()
        .filter(|_| can_be_joined)
        .map(|request| (request.template.as_str(), OnceLock::new()))
        .collect();
    // Requests of one template mostly share texts.
    let known_texts: Mutex<HashMap<[u8; 32], Arc<[Id]>>> = Mutex::default();
    let known = || known_texts.lock().unwrap_or_else(PoisonError::into_inner);
    let work = |request: &&'a Request| {
        let space = Arc::new(space_of(templates, request)?);
        let parts = parts.get(request.template.as_str());
        let mut explorer =
            Explorer::new(templates, &request.template, &space, options.report_dead).of_parts(parts);
        let (mut split, mut before) = (Split::default(), Arc::default());
        while !options.is_cancelled()
            && let Some(text) = explorer.next_text()
        {
            (options.progress)(0, texts.fetch_add(1, Ordering::Relaxed) + 1);
            let Some(new) = explorer.exploration.texts.last_mut() else { continue };
            if let Some(found) = known().get(&new.hash) {
                new.declarations = Some(found.clone());
                continue;
            }
            let Some(common) = split.go_on(text) else { continue };
            let mut declarations = declarations.lock().unwrap_or_else(PoisonError::into_inner);
            let (found, can_be_taken_apart) = declarations.of(&split, common, &before);
            drop(declarations);
            if can_be_taken_apart {
                known().insert(new.hash, found.clone());
                new.declarations = Some(found.clone());
            }
            before = found;
        }
        Ok((space, Arc::new(explorer.finish())))
    };
    let found: Vec<Result<_, Vec<Diagnostic>>> = distinct.par_iter().map(work).collect();
    let (mut explored, mut diagnostics) = (Vec::new(), Vec::new());
    for (at, (request, shared)) in requests.iter().zip(shared).enumerate() {
        match found.get(shared) {
            Some(Ok((space, exploration))) => {
                let (space, exploration) = (space.clone(), exploration.clone());
                explored.push(Explored { request, at, space, exploration, tasks: Vec::new() });
            }
            // At the place of this request.
            _ => diagnostics.extend(space_of(templates, request).err().into_iter().flatten()),
        }
    }
    (explored, declarations.into_inner().unwrap_or_else(PoisonError::into_inner), diagnostics)
}

/// Validates every variant of the requests, and reports one diagnostic per root cause.
pub fn check(templates: &TemplateSet, requests: &[Request], options: &Options<'_>) -> Permutations {
    let mut diagnostics = Diagnostics::new();
    let work = || {
        let (explored, declarations, rejected) = explore(templates, requests, options);
        let mut composition = compose::compose(templates, explored, declarations);
        // Validators of others and `exhaustive` want the texts themselves.
        let keep = options.keep.filter(|_| options.external.is_empty() && !options.exhaustive);
        keep.into_iter().for_each(|keep| composition.recall(keep));
        composition.prove(options);
        let keep = keep.filter(|_| !options.is_cancelled());
        keep.into_iter().for_each(|keep| composition.remember(keep));
        (composition, rejected)
    };
    let threads = options.threads.clamp(1, MAX_THREADS);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(wgsl::STACK_BYTES).build();
    // Where no thread can be started, as in a browser, the caller does it alone.
    let (composition, rejected) = match pool {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    };
    if options.is_cancelled() {
        return Permutations { diagnostics, ..Permutations::default() };
    }
    diagnostics.extend(rejected);
    let failures = composition.failures();
    let (mut reflections, mut costs) = (HashSet::new(), HashSet::new());

    let mut causes = Causes::default();
    let mut reports = Vec::new();
    for (each, found) in composition.explored.iter().zip(failures) {
        diagnostics.extend(each.exploration.diagnostics.iter().cloned());
        let ground = Ground {
            template: &each.request.template,
            space: &each.space,
            leaves: &each.exploration.leaves,
            assumed: &each.request.assumed,
            profiles: each.request.profiles.iter().map(|profile| profile.name.clone()).collect(),
        };
        // Including a template that does not parse is no diagnostic of its own.
        let broken = |diagnostic: &Diagnostic| {
            templates.templates.values().any(|each| each.broken.as_ref() == Some(diagnostic))
        };
        let mut failures = Vec::new();
        for (leaf, diagnostic) in &each.exploration.failures {
            if broken(diagnostic) {
                diagnostics.push(diagnostic.clone());
            } else {
                failures.push(Failure {
                    diagnostic: diagnostic.clone(),
                    leaves: [*leaf].into(),
                    profiles: BTreeSet::new(),
                    excess: None,
                    overrides: AxisValues::new(),
                });
            }
        }
        failures.extend(found);
        causes.add(&ground, failures);
        let wanted = composition.wanted(each);
        let verdict = |text: &usize| {
            let verdict = shared(composition.verdict(wanted, *text), &mut reflections);
            let costs = verdict.reflection.as_ref().map(|_| composition.costs(*text, &mut costs));
            Verdict { costs: costs.unwrap_or_default(), ..verdict }
        };
        let verdicts = each.tasks.iter().map(verdict).collect();
        reports.push(summary::report_on(templates, each, &composition.declarations, verdicts));
    }
    diagnostics.extend(agree::disagreements(templates, &composition.explored, &reports));
    diagnostics.extend(composition.unavailable(options));
    diagnostics.extend(causes.diagnostics());
    if options.report_dead {
        let examined = composition.explored.iter().zip(&reports).map(|(each, report)| Examined {
            template: &each.request.template,
            exploration: &each.exploration,
            dead_axes: report.variants.iter().all(|variant| variant.valid).then_some(&report.dead_axes[..]),
        });
        let examined: Vec<Examined<'_>> = examined.collect();
        diagnostics.extend(dead::diagnostics(templates, &examined, &options.shared));
    }
    diagnostics.sort();
    let (texts, proven) = (composition.texts.len(), composition.proven);
    let declarations = composition.units.all.len();
    Permutations { diagnostics, templates: reports, texts, proven, declarations }
}

/// Returns the number of paths of a request; `None` if it exceeds `max` or the request cannot be explored.
#[cfg(test)]
pub(crate) fn paths(templates: &TemplateSet, request: &Request, max: usize) -> Option<usize> {
    let space = Arc::new(space_of(templates, request).ok()?);
    let mut explorer = Explorer::new(templates, &request.template, &space, false);
    let is_all = explorer.take_all(max);
    is_all.then_some(explorer.exploration.leaves.len())
}

/// Replaces the verdict's reflection by an equal one from `known`, so that equal reflections share memory.
fn shared(mut verdict: Verdict, known: &mut HashSet<Arc<Reflection>>) -> Verdict {
    if let Some(reflection) = &mut verdict.reflection {
        match known.get(reflection) {
            Some(known) => *reflection = known.clone(),
            None => drop(known.insert(reflection.clone())),
        }
    }
    verdict
}
