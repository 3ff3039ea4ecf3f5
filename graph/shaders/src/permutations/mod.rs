//! Every shader permutation, proven.
//!
//! ```text
//! requests ──explore──▶ paths, distinct texts ──prove──▶ rejections ──group──▶ diagnostics, one per root cause
//!              lazily, one rendering per path     once per text, on threads          with what provokes them
//!              └──────────── at the same time ───────────────┘
//! ```
//!
//! A [`Request`] names a template, the values that its axes can have (all, those that pipelines reach, or one
//! configuration), and the profiles that have to accept it. [`check`] takes every path through the template that these
//! values allow, proves each distinct text once, and reports: diagnostics, coverage, sizes, what is dead. The outcome
//! does not depend on the number of threads.

mod agree;
mod blame;
mod cache;
mod cause;
mod dead;
mod declared;
mod explore;
mod failure;
mod overrides;
mod prove;
mod proven;
mod report;
mod request;
mod summary;
mod validator;

pub use crate::axes::Space;
pub use cache::ShaderCache;
pub use dead::dead;
pub use declared::declares;
pub use report::{Permutations, TemplateReport, ValueBytes, VariantReport};
pub use request::Request;
use request::space_of;
pub use umbragraph_text::diagnostic::Count;
pub use validator::{Opinion, Validator};

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use cause::{Causes, Failure, Ground};
use dead::Examined;
use explore::Explorer;
use prove::{Subject, Task};
use proven::{Explored, Proven};
use rayon::iter::{ParallelBridge, ParallelIterator};

use super::{Reflection, TemplateSet};
use crate::module::wgsl;
use umbragraph_text::diagnostic::{AxisValues, Diagnostic, Diagnostics};
use umbragraph_text::source::FileId;

/// The options of a check.
pub struct Options<'a> {
    /// The number of threads.
    pub threads: usize,
    /// Further validators, for texts that naga accepts.
    pub external: &'a [&'a dyn Validator],
    /// Whether axes without effect and text in no variant are diagnostics. They are where the requests are all that a
    /// template can express; what one pipeline does not reach, another may.
    pub report_dead: bool,
    /// The files that others than the requests use as well: nothing in them is called dead, since these may need it.
    pub shared: BTreeSet<FileId>,
    /// Called with the texts done and all texts that are known by then, from any thread.
    pub progress: &'a (dyn Fn(usize, usize) + Sync),
    /// Ends the check before the next text, once it is set: its results are of no use then.
    pub cancelled: &'a AtomicBool,
}

/// Never set.
static NEVER: AtomicBool = AtomicBool::new(false);

impl Default for Options<'_> {
    fn default() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        Self {
            threads,
            external: &[],
            report_dead: false,
            shared: BTreeSet::new(),
            progress: &|_, _| {},
            cancelled: &NEVER,
        }
    }
}

/// The maximum number of threads that are worth their stacks.
const MAX_THREADS: usize = 256;

/// The index of each distinct text among all tasks.
type TextsByHash = HashMap<[u8; 32], usize>;

/// Takes all paths of the requests, and proves each distinct text while others are still being found: whichever thread
/// is free takes the paths up to the next new text, so that none waits in memory. What comes out is in the order of
/// diagnostic. Diagnostics are those about requests that cannot be explored.
fn explore_and_prove<'a>(
    templates: &'a TemplateSet,
    requests: &'a [Request],
    options: &Options<'_>,
) -> (Vec<Explored<'a>>, Vec<Diagnostic>, Vec<Proven>) {
    let (mut explored, mut diagnostics) = (Vec::new(), Vec::new());
    // The distinct texts by hash, apart by what they are proven for.
    let mut known: HashMap<(&str, Vec<&str>), TextsByHash> = HashMap::new();
    let (found, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let mut rest = requests.iter();
    let mut current: Option<Current<'_, '_>> = None;
    let tasks = std::iter::from_fn(|| {
        loop {
            if options.cancelled.load(Ordering::Relaxed) {
                return None;
            }
            if let Some(Current { subject, explorer, tasks, request, .. }) = &mut current {
                let profiles = request.profiles.iter().map(|profile| profile.name.as_str()).collect();
                let known = known.entry((&request.template, profiles)).or_default();
                while !options.cancelled.load(Ordering::Relaxed)
                    && let Some(source) = explorer.next_text()
                {
                    let text = explorer.exploration.texts.last()?;
                    let new = found.load(Ordering::Relaxed);
                    let index = *known.entry(text.hash).or_insert(new);
                    tasks.push(index);
                    if index == new {
                        found.store(new + 1, Ordering::Relaxed);
                        return Some((index, Task { source, subject: subject.clone() }));
                    }
                }
            }
            if let Some(Current { request, space, explorer, tasks, .. }) = current.take() {
                explored.push(Explored { request, space, exploration: explorer.finish(), tasks });
            }
            let request = rest.next()?;
            match (space_of(templates, request), templates.axes(&request.template)) {
                (Ok(space), Some(axes)) => {
                    let space = Arc::new(space);
                    let subject = Arc::new(Subject::new(axes, &request.profiles));
                    let explorer = Explorer::new(templates, &request.template, &space, options.report_dead);
                    current = Some(Current { request, space, subject, explorer, tasks: Vec::new() });
                }
                (rejected, _) => diagnostics.extend(rejected.err().into_iter().flatten()),
            }
        }
    });
    // Texts have few distinct reflections. Equal ones are found where they are made, so that nothing small stays behind
    // in the midst of what a proof frees.
    let reflections: Mutex<HashSet<Arc<Reflection>>> = Mutex::default();
    let work = |(index, task): (usize, Task<'a>)| {
        let mut proof = prove::prove(&task);
        if let Some(reflection) = &mut proof.reflection {
            let mut known = reflections.lock().unwrap_or_else(PoisonError::into_inner);
            match known.get(reflection) {
                Some(known) => *reflection = known.clone(),
                None => drop(known.insert(reflection.clone())),
            }
        }
        let opinions = failure::judge(&task, &proof, options.external);
        let quiet = proof.rejections.is_empty() && proof.advice.is_empty();
        let accepted = quiet && opinions.iter().all(|each| *each == Opinion::Accepts);
        let proven = Proven { proof, opinions, source: (!accepted).then_some(task.source) };
        (options.progress)(done.fetch_add(1, Ordering::Relaxed) + 1, found.load(Ordering::Relaxed));
        (index, proven)
    };
    let prove = || tasks.par_bridge().map(work).collect::<Vec<_>>();
    let threads = options.threads.clamp(1, MAX_THREADS);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).stack_size(wgsl::STACK_BYTES).build();
    // Where no thread can be started, as in a browser, the caller does it alone.
    let mut proven = match pool {
        Ok(pool) => pool.install(prove),
        Err(_) => prove(),
    };
    proven.sort_unstable_by_key(|(index, _)| *index);
    (explored, diagnostics, proven.into_iter().map(|(_, proven)| proven).collect())
}

/// The request whose paths are being taken.
struct Current<'a, 'p> {
    request: &'a Request,
    space: Arc<Space>,
    subject: Arc<Subject<'a>>,
    explorer: Explorer<'p>,
    /// The index of each distinct text among all tasks.
    tasks: Vec<usize>,
}

/// Proves every variant of the requests.
pub fn check(templates: &TemplateSet, requests: &[Request], options: &Options<'_>) -> Permutations {
    let mut diagnostics = Diagnostics::new();
    let (explored, rejected, proven) = explore_and_prove(templates, requests, options);
    if options.cancelled.load(Ordering::Relaxed) {
        return Permutations { diagnostics, templates: Vec::new(), proven: proven.len() };
    }
    diagnostics.extend(rejected);

    let mut causes = Causes::default();
    let mut reports = Vec::new();
    for each in &explored {
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
        failures.extend(failure::rejections(templates, each, &proven, options.external));
        causes.add(&ground, failures);
        reports.push(summary::report_on(templates, each, &proven));
    }
    diagnostics.extend(agree::disagreements(templates, &explored, &reports));
    diagnostics.extend(failure::unavailable(&proven, options.external));
    diagnostics.extend(causes.diagnostics());
    if options.report_dead {
        let examined = explored.iter().zip(&reports).map(|(each, report)| Examined {
            template: &each.request.template,
            exploration: &each.exploration,
            dead_axes: report.variants.iter().all(|variant| variant.valid).then_some(&report.dead_axes[..]),
        });
        let examined: Vec<Examined<'_>> = examined.collect();
        diagnostics.extend(dead::diagnostics(templates, &examined, &options.shared));
    }
    diagnostics.sort();
    Permutations { diagnostics, templates: reports, proven: proven.len() }
}
