//! Every shader permutation, proven.
//!
//! ```text
//! requests ──explore──▶ paths, distinct texts ──prove──▶ refusals ──group──▶ findings, one per root cause
//!              lazily, one rendering per path     once per text, on threads          with what provokes them
//! ```
//!
//! A [`Request`] names a template, the values that its axes can have (all, those that pipelines reach, or one
//! configuration), and the profiles that have to accept it. [`check`] takes every path through the template that these
//! values allow, proves each distinct text once, and reports: findings, coverage, sizes, what is dead. The outcome does
//! not depend on the number of threads.

mod cause;
mod dead;
mod explore;
mod external;
mod prove;
mod report;
mod space;

pub use external::{CommandError, ExternalValidator};
pub use report::{Permutations, TemplateReport, ValueBytes, VariantReport};
pub use space::Count;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use cause::{Causes, Failure, Ground};
use dead::{Coverage, Marked};
use explore::Exploration;
use external::Opinion;
use prove::{Proof, Task};
pub(crate) use space::Space;

use super::compile::{template_values, unknown_axis};
use super::interface;
use super::markers::MarkedTemplates;
use super::profile::TargetProfile;
use super::render::{self, Placement};
use super::text_map::Origin;
use super::value::{AxisValue, AxisValues, describe};
use super::wgsl_error::{Refusal, Stage};
use super::{TemplateSet, codes};
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use crate::source::Span;

/// A template that is to be proven.
#[derive(Clone, Debug)]
pub struct Request {
    /// How reports call it: the name of a pass, for one.
    pub name: String,
    /// The template.
    pub template: String,
    /// The values that axes can have; an axis that is not named can have all of its values.
    pub allowed: BTreeMap<String, Vec<AxisValue>>,
    /// The profiles that have to accept every variant.
    pub profiles: Vec<TargetProfile>,
    /// Where a finding about the request itself belongs.
    pub place: Place,
    /// Whether all variants are used side by side, with one layout: the variants of one configured pass, as meshes need
    /// them. Variants of different configurations never meet, and may differ.
    pub one_interface: bool,
}

impl Request {
    /// Everything that a template can express.
    pub fn all(template: &str, profiles: &[TargetProfile]) -> Self {
        Self {
            name: template.to_owned(),
            template: template.to_owned(),
            allowed: BTreeMap::new(),
            profiles: profiles.to_vec(),
            place: Place::Nowhere,
            one_interface: false,
        }
    }

    /// The same request for variants that are used side by side, with one layout.
    #[must_use]
    pub fn with_one_interface(self) -> Self {
        Self { one_interface: true, ..self }
    }

    /// One configuration; axes that `values` does not name have their defaults.
    pub fn one(
        templates: &TemplateSet,
        template: &str,
        values: &AxisValues,
        profiles: &[TargetProfile],
    ) -> Self {
        let mut allowed: BTreeMap<String, Vec<AxisValue>> = BTreeMap::new();
        let defaults = templates.axes(template).map(super::Axes::defaults).unwrap_or_default();
        for (name, value) in defaults.iter().chain(values) {
            allowed.insert(name.clone(), vec![value.clone()]);
        }
        Self { allowed, ..Self::all(template, profiles) }
    }
}

/// How to check.
pub struct Options<'a> {
    /// The number of threads.
    pub threads: usize,
    /// Further validators, for texts that naga accepts.
    pub external: &'a [ExternalValidator],
    /// Whether axes without effect and text in no variant are findings. They are wherever the requests are all that there
    /// is; what one pipeline does not reach, another may.
    pub report_dead: bool,
    /// Called with the texts done and all texts, from any thread.
    pub progress: &'a (dyn Fn(usize, usize) + Sync),
}

impl Default for Options<'_> {
    fn default() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        Self { threads, external: &[], report_dead: false, progress: &|_, _| {} }
    }
}

/// A request that can be explored, with what came of it.
struct Explored<'a> {
    request: &'a Request,
    space: Arc<Space>,
    exploration: Exploration,
    /// The index of each distinct text among all tasks.
    tasks: Vec<usize>,
}

/// Proves every variant of the requests.
pub fn check(templates: &TemplateSet, requests: &[Request], options: &Options<'_>) -> Permutations {
    let mut findings = Diagnostics::new();
    let placement = Placement::new(templates);
    let mut explored = Vec::new();
    for request in requests {
        match space_of(templates, request) {
            Ok(space) => {
                let space = Arc::new(space);
                let exploration =
                    explore::explore(templates, &placement, &request.template, &space, options.report_dead);
                explored.push(Explored { request, space, exploration, tasks: Vec::new() });
            }
            Err(found) => findings.extend(found),
        }
    }
    let tasks = collect_tasks(templates, &mut explored);
    let progress = |done| (options.progress)(done, tasks.len());
    let proofs = prove::in_parallel(tasks.len(), options.threads, &progress, &|at| prove::prove(&tasks[at]));
    let opinions = judge(&tasks, &proofs, options);

    let mut marked = None;
    let mut causes = Causes::default();
    let mut reports = Vec::new();
    for each in &explored {
        findings.extend(each.exploration.findings.iter().cloned());
        let ground = Ground {
            template: &each.request.template,
            space: &each.space,
            leaves: &each.exploration.leaves,
            profiles: each.request.profiles.iter().map(|profile| profile.name.clone()).collect(),
        };
        // Including a template that does not parse is no finding of its own.
        let broken = |finding: &Diagnostic| {
            templates.templates.values().any(|each| each.broken.as_ref() == Some(finding))
        };
        let failed = each.exploration.failures.iter();
        findings.extend(
            failed.clone().filter(|(_, finding)| broken(finding)).map(|(_, finding)| finding.clone()),
        );
        let mut failures: Vec<Failure> = failed
            .filter(|(_, finding)| !broken(finding))
            .map(|(leaf, finding)| Failure {
                finding: finding.clone(),
                leaves: [*leaf].into(),
                profiles: BTreeSet::new(),
            })
            .collect();
        failures.extend(refusals(templates, each, &proofs, &mut Marked(&mut marked)));
        failures.extend(disagreements(
            templates,
            each,
            &opinions,
            options.external,
            &mut Marked(&mut marked),
        ));
        causes.add(&ground, failures);
        let (report, conflicts) = report_on(templates, &placement, each, &proofs);
        findings.extend(conflicts);
        reports.push(report);
    }
    findings.extend(unavailable(&opinions, options.external));
    findings.extend(causes.findings());
    if options.report_dead {
        dead_findings(templates, &explored, &reports, &mut marked, &mut findings);
    }
    findings.sort();
    Permutations { findings, templates: reports, proven: tasks.len() }
}

fn space_of(templates: &TemplateSet, request: &Request) -> Result<Space, Vec<Diagnostic>> {
    let template = &request.template;
    let Some(axes) = templates.axes(template) else {
        return Err(vec![templates.unknown(template, request.place.clone())]);
    };
    if let Some(broken) = templates.templates.get(template).and_then(|template| template.broken.clone()) {
        return Err(vec![broken]);
    }
    let mut findings = templates.axes_findings(template).to_vec();
    for (name, values) in &request.allowed {
        match axes.get(name) {
            None => findings.push(unknown_axis(axes, template, name, request.place.clone())),
            Some(axis) => {
                findings.extend(values.iter().filter(|value| !axis.kind.contains(value)).map(|value| {
                    Diagnostic::error(
                        codes::AXIS_VALUE,
                        request.place.clone(),
                        format!("{value} is no value of the axis \"{name}\""),
                    )
                    .help(format!("the values are {}", axis.kind.describe()))
                    .related(axis.span, "declared here")
                }));
            }
        }
    }
    if !findings.is_empty() {
        return Err(findings);
    }
    let space = Space::new(axes, &request.allowed);
    if space.possible(&AxisValues::new()) {
        return Ok(space);
    }
    let clash = space.clash();
    let place = match clash.first() {
        Some(constraint) => Place::Span(constraint.span),
        None => request.place.clone(),
    };
    let fixed: AxisValues = request
        .allowed
        .iter()
        .filter_map(|(name, values)| match values.as_slice() {
            [value] if clash.iter().any(|constraint| constraint.axes().contains(name.as_str())) => {
                Some((name.clone(), value.clone()))
            }
            _ => None,
        })
        .collect();
    let mut message = format!("the constraints of \"{template}\" leave no configuration");
    if !fixed.is_empty() {
        message.push_str(&format!(" with {}", describe(&fixed)));
    }
    let mut finding = Diagnostic::error(codes::CONSTRAINTS_CONTRADICT, place, message);
    for constraint in &clash {
        finding = finding.related(constraint.span, constraint.to_string());
    }
    Err(vec![finding.help("without any one of these constraints there would be a configuration")])
}

/// One task per distinct text of a template and profiles, over all requests.
fn collect_tasks<'a>(templates: &'a TemplateSet, explored: &mut [Explored<'a>]) -> Vec<Task<'a>> {
    let mut known: BTreeMap<(&str, [u8; 32], Vec<&str>), usize> = BTreeMap::new();
    let mut tasks: Vec<Task<'a>> = Vec::new();
    for each in explored {
        let request = each.request;
        let Some(axes) = templates.axes(&request.template) else { continue };
        let profiles: Vec<&str> = request.profiles.iter().map(|profile| profile.name.as_str()).collect();
        for text in &each.exploration.texts {
            let next = tasks.len();
            let at = *known.entry((&request.template, text.hash, profiles.clone())).or_insert(next);
            if at == next {
                tasks.push(Task { wgsl: text.wgsl.clone(), axes, profiles: &request.profiles });
            }
            each.tasks.push(at);
        }
    }
    tasks
}

/// What each external validator says of each text that naga accepts.
fn judge(tasks: &[Task<'_>], proofs: &[Proof], options: &Options<'_>) -> Vec<Vec<Opinion>> {
    if options.external.is_empty() {
        return Vec::new();
    }
    prove::in_parallel(tasks.len(), options.threads, &|_| {}, &|at| {
        let accepted = proofs.get(at).is_some_and(|proof| proof.refusals.is_empty());
        let validators = options.external.iter();
        validators.map(|each| if accepted { each.judge(&tasks[at].wgsl) } else { Opinion::Accepts }).collect()
    })
}

fn unavailable(opinions: &[Vec<Opinion>], validators: &[ExternalValidator]) -> Vec<Diagnostic> {
    let found = validators.iter().enumerate().filter_map(|(at, _)| {
        opinions.iter().find_map(|each| match each.get(at) {
            Some(Opinion::Unavailable(message)) => Some(message.clone()),
            _ => None,
        })
    });
    found.map(|message| Diagnostic::error(codes::EXTERNAL_UNAVAILABLE, Place::Nowhere, message)).collect()
}

fn refusals(
    templates: &TemplateSet,
    each: &Explored<'_>,
    proofs: &[Proof],
    marked: &mut Marked<'_>,
) -> Vec<Failure> {
    let mut failures = Vec::new();
    for (text, task) in each.tasks.iter().enumerate() {
        for (refusal, profiles) in proofs.get(*task).into_iter().flat_map(|proof| &proof.refusals) {
            let names = profiles.iter().filter_map(|at| each.request.profiles.get(*at));
            failures.push(Failure {
                finding: place_refusal(templates, each, text, refusal, marked),
                leaves: each.exploration.leaves_of(text),
                profiles: names.map(|profile| profile.name.clone()).collect(),
            });
        }
    }
    failures
}

fn disagreements(
    templates: &TemplateSet,
    each: &Explored<'_>,
    opinions: &[Vec<Opinion>],
    validators: &[ExternalValidator],
    marked: &mut Marked<'_>,
) -> Vec<Failure> {
    let mut failures = Vec::new();
    for (text, task) in each.tasks.iter().enumerate() {
        let Some(wgsl) = each.exploration.texts.get(text).map(|text| &text.wgsl) else { continue };
        for (opinion, validator) in opinions.get(*task).into_iter().flatten().zip(validators) {
            let refusal = match opinion {
                Opinion::Accepts | Opinion::Unavailable(_) => continue,
                Opinion::Refuses { message, place } => {
                    let message = format!("{} refuses this: {message}", validator.name());
                    let range =
                        place.map(|(line, column)| offset_of(wgsl, line, column)).map(|at| at..at + 1);
                    Refusal { range, ..Refusal::new(Stage::External, message, naga::Span::UNDEFINED) }
                }
                Opinion::TimedOut => Refusal::new(
                    Stage::ExternalTimeout,
                    format!("{} does not come to an end on this template", validator.name()),
                    naga::Span::UNDEFINED,
                ),
            };
            failures.push(Failure {
                finding: place_refusal(templates, each, text, &refusal, marked),
                leaves: each.exploration.leaves_of(text),
                profiles: BTreeSet::new(),
            });
        }
    }
    failures
}

fn offset_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (start + column.saturating_sub(1)).min(text.len())
}

/// The finding for a refusal of a text: by the plain map, or by markers where captured text hides the place.
fn place_refusal(
    templates: &TemplateSet,
    each: &Explored<'_>,
    text: usize,
    refusal: &Refusal,
    marked: &mut Marked<'_>,
) -> Diagnostic {
    let template = &each.request.template;
    let Some(found) = each.exploration.texts.get(text) else {
        return templates.unknown(template, Place::Nowhere);
    };
    let file = templates.templates.get(template).map(|template| template.file);
    let Some(file) = file else { return templates.unknown(template, Place::Nowhere) };
    let start = refusal.range.as_ref().map(|range| range.start);
    let captured = start.is_some_and(|start| matches!(found.map.origin(start), Some(Origin::Tag(_)) | None));
    if captured
        && let Some(leaf) = each.exploration.leaves.get(found.leaf)
        && let Some(exact) = marked.get(templates).map(template, &leaf.decided, &found.wgsl)
    {
        let mut finding = refusal.to_diagnostic(&found.wgsl, &exact.map, file);
        for span in start.into_iter().flat_map(|start| exact.trail(start)).take(8) {
            finding = finding.related(span, "written out here");
        }
        return finding;
    }
    refusal.to_diagnostic(&found.wgsl, &found.map, file)
}

fn report_on(
    templates: &TemplateSet,
    placement: &Placement<'_>,
    each: &Explored<'_>,
    proofs: &[Proof],
) -> (TemplateReport, Vec<Diagnostic>) {
    let Explored { request, space, exploration, tasks } = each;
    let mut variants = Vec::new();
    let mut covered = Count::ZERO;
    for (at, text) in exploration.texts.iter().enumerate() {
        let leaves = exploration.leaves_of(at);
        let mut configurations = Count::ZERO;
        for leaf in leaves.iter().filter_map(|leaf| exploration.leaves.get(*leaf)) {
            configurations = configurations.plus(space.count(&leaf.decided));
        }
        covered = covered.plus(configurations);
        let proof = tasks.get(at).and_then(|task| proofs.get(*task));
        variants.push(VariantReport {
            axes: exploration.leaves.get(text.leaf).map(|leaf| leaf.decided.clone()).unwrap_or_default(),
            paths: leaves.len(),
            configurations,
            bytes: text.wgsl.len(),
            hash: blake3::Hash::from_bytes(text.hash).to_string(),
            valid: proof.is_some_and(|proof| proof.refusals.is_empty()),
            wgsl: text.wgsl.clone(),
            map: text.map.clone(),
            reflection: proof.and_then(|proof| proof.reflection.clone()),
        });
    }
    let (interface, conflicts) = unite(templates, request, &variants);
    let report = TemplateReport {
        name: request.name.clone(),
        template: request.template.clone(),
        profiles: request.profiles.iter().map(|profile| profile.name.clone()).collect(),
        configurations: space.count(&AxisValues::new()),
        covered,
        paths: exploration.leaves.len(),
        dead_axes: dead_axes(templates, each, &variants),
        bytes_of_values: bytes_of_values(templates, placement, each),
        variants,
        interface,
    };
    (report, conflicts)
}

fn unite(
    templates: &TemplateSet,
    request: &Request,
    variants: &[VariantReport],
) -> (Vec<super::Binding>, Vec<Diagnostic>) {
    let reflected: Vec<&VariantReport> =
        variants.iter().filter(|variant| variant.reflection.is_some()).collect();
    let (bindings, conflicts) =
        interface::unite(reflected.iter().filter_map(|variant| variant.reflection.as_deref()));
    let place = |variant: &VariantReport, name: &str| {
        let at = declaration_of(&variant.wgsl, name).and_then(|range| variant.map.span(range));
        at.or_else(|| templates.file(&request.template).map(|file| Span::new(file, 0..0)))
            .map_or(Place::Nowhere, Place::Span)
    };
    let mut findings: Vec<Diagnostic> = Vec::new();
    for conflict in conflicts.into_iter().filter(|_| request.one_interface) {
        let (Some(first), Some(second)) = (reflected.get(conflict.first), reflected.get(conflict.second))
        else {
            continue;
        };
        let message = format!("two variants of \"{}\" disagree: {}", request.name, conflict.message);
        if findings.iter().any(|known| known.message == message) {
            continue;
        }
        findings.push(
            Diagnostic::error(codes::INTERFACE_CONFLICT, place(second, &conflict.name), message)
                .related(place(first, &conflict.name), format!("the one is {}", describe(&first.axes)))
                .related(place(second, &conflict.name), format!("the other is {}", describe(&second.axes))),
        );
    }
    (bindings, findings)
}

/// The name in the declaration of a module-scope variable.
fn declaration_of(wgsl: &str, name: &str) -> Option<std::ops::Range<usize>> {
    let is_word = |byte: Option<&u8>| byte.is_some_and(|byte| byte.is_ascii_alphanumeric() || *byte == b'_');
    let bytes = wgsl.as_bytes();
    wgsl.match_indices(name).map(|(at, name)| at..at + name.len()).find(|range| {
        let statement = wgsl[..range.start].rfind([';', '}']).map_or(0, |end| end + 1);
        let before = &wgsl[statement..range.start];
        let whole = !is_word(bytes.get(range.end))
            && !is_word(range.start.checked_sub(1).and_then(|at| bytes.get(at)));
        whole && before.contains("@binding") && before.contains("var")
    })
}

fn dead_axes(templates: &TemplateSet, each: &Explored<'_>, variants: &[VariantReport]) -> Vec<String> {
    let effective = dead::effective_axes(&each.exploration);
    let overrides: BTreeSet<&str> = variants
        .iter()
        .filter_map(|variant| variant.reflection.as_ref())
        .flat_map(|each| &each.overrides)
        .map(String::as_str)
        .collect();
    let axes = templates.axes(&each.request.template).into_iter().flat_map(super::Axes::iter);
    axes.filter(|axis| {
        let choice = each.request.allowed.get(&axis.name).is_none_or(|values| values.len() > 1);
        choice && !effective.contains(&axis.name) && !overrides.contains(axis.name.as_str())
    })
    .map(|axis| axis.name.clone())
    .collect()
}

/// What each value of a small axis adds to the text of all defaults.
fn bytes_of_values(
    templates: &TemplateSet,
    placement: &Placement<'_>,
    each: &Explored<'_>,
) -> Vec<ValueBytes> {
    const MAXIMUM_VALUES: u64 = 16;
    let template = &each.request.template;
    let size = |values: &AxisValues| -> Option<i64> {
        let values = template_values(templates, template, &each.space.complete(values)?);
        render::render_with(templates, placement, template, render::fixed_context(&values))
            .ok()
            .map(|(text, _)| text.len() as i64)
    };
    let Some(plain) = size(&AxisValues::new()) else { return Vec::new() };
    let mut found = Vec::new();
    for name in &each.exploration.read {
        let Some(domain) = each.space.variable(name).filter(|domain| domain.count() <= MAXIMUM_VALUES) else {
            continue;
        };
        for value in (0..domain.count()).filter_map(|at| domain.value(at)) {
            if each.space.default_of(name) == Some(&value) {
                continue;
            }
            if let Some(bytes) = size(&[(name.clone(), value.clone())].into()) {
                found.push(ValueBytes { axis: name.clone(), value, bytes: bytes - plain });
            }
        }
    }
    found
}

fn dead_findings(
    templates: &TemplateSet,
    explored: &[Explored<'_>],
    reports: &[TemplateReport],
    marked: &mut Option<MarkedTemplates>,
    findings: &mut Diagnostics,
) {
    let sound =
        |each: &Explored<'_>| each.exploration.failures.is_empty() && each.exploration.findings.is_empty();
    // An axis is dead where no template that has it depends on it; a template with other findings says nothing.
    let mut axes: BTreeMap<Span, (String, bool)> = BTreeMap::new();
    for (each, report) in explored.iter().zip(reports) {
        let valid = sound(each) && report.variants.iter().all(|variant| variant.valid);
        for axis in templates.axes(&each.request.template).into_iter().flat_map(super::Axes::iter) {
            let entry = axes.entry(axis.span).or_insert_with(|| (axis.name.clone(), true));
            entry.1 &= valid && report.dead_axes.contains(&axis.name);
        }
    }
    for (span, (name, _)) in axes.into_iter().filter(|(_, (_, dead))| *dead) {
        let message = format!("no text depends on the axis \"{name}\"");
        findings.push(Diagnostic::warning(codes::AXIS_DEAD, span, message).help("remove it, or use it"));
    }
    let mut coverage = Coverage::default();
    for each in explored {
        coverage.add(templates, &each.request.template, &each.exploration, &mut Marked(marked));
    }
    if explored.iter().all(sound) {
        findings.extend(coverage.dead(templates).into_iter().map(|span| {
            Diagnostic::warning(codes::LINES_DEAD, span, "no variant contains this text")
                .help("its condition can never hold under the declared axes and constraints; remove it")
        }));
    }
}
