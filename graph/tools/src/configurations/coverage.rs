//! Checks a pipeline in every configuration of a list, all the way to its plan.
//!
//! A diagnostic of several configurations is reported once, with their number and the fewest choices that show it.
//! Warnings are about things that nobody uses. A warning is dropped if some valid configuration does not show it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use crate::check::{CheckOptions, CheckReport, compiled};
use crate::configurations::{Configurations, Loading};
use crate::remarks::Remarks;
use crate::unused::unused;
use umbragraph_compiler::{Plan, PlanOptions};
use umbragraph_pipeline::compose::as_written;
use umbragraph_pipeline::diagnostic::{Code, Diagnostic, Diagnostics, Place, Severity};
use umbragraph_pipeline::document::Document;
use umbragraph_pipeline::model::Model;
use umbragraph_pipeline::shader::{AxisValues, ShaderCache};
use umbragraph_pipeline::source::Sources;

/// The results of checking the configurations of a pipeline.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Coverage {
    /// The report of the first configuration: the caller's, or else the default one.
    pub first: CheckReport,
    /// The shader variants of all configurations, each as template name and axis values.
    pub variants: BTreeSet<(String, AxisValues)>,
    /// The violations that the verifier found in plans, one message each, all of them defects of the compiler. Empty if
    /// no verifier ran.
    pub violations: Vec<String>,
    /// The parts of the document that the plan of the first configuration does not use; empty after errors.
    pub remarks: Remarks,
}

/// A further check of a plan by the caller, such as a dry run. Returns its diagnostics.
pub type Judge<'a> = &'a mut dyn FnMut(&Arc<Plan>) -> Diagnostics;

/// An independent verifier of a plan. Returns the violations that it found, one message each.
pub type Verify = fn(&Plan, &PlanOptions) -> Vec<String>;

/// The inputs of [`check_configurations`], besides the document and the check options.
pub struct Examination<'a> {
    /// The configurations to check.
    pub configurations: &'a Configurations,
    /// The declarations and strings of the document, with the resolved uses of names.
    pub model: &'a Model,
    /// The cache of shader modules, for the templates and the target profile of the check options.
    pub shaders: &'a Arc<ShaderCache>,
    /// The independent verifier that checks each valid plan; `None` to skip it.
    pub verify: Option<Verify>,
    /// A further check of each valid plan, such as a dry run, whose diagnostics are added.
    pub judge: Judge<'a>,
    /// A flag that stops the check before the next configuration once it is `true`.
    pub cancelled: &'a AtomicBool,
}

/// Checks and plans a document in each configuration, and adds each distinct diagnostic once. The configurations give
/// the values of settings; `check_options.overrides` is ignored.
pub fn check_configurations(
    document: &Document,
    check_options: &CheckOptions<'_>,
    examination: Examination<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Coverage {
    let CheckOptions { registry, templates, plan: options, .. } = check_options;
    let Examination { configurations, model, shaders, verify, judge, cancelled } = examination;
    let mut coverage = Coverage::default();
    let mut found = Found::default();
    let mut violations: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let checked = configurations.load(
        document,
        Loading { registry, shaders, is_surveyed: false, cancelled },
        sources,
        |at, _, pipeline, mut own| {
            for program in &pipeline.programs {
                let variants = program.variants.iter();
                coverage
                    .variants
                    .extend(variants.map(|variant| (program.template.clone(), variant.module.axes.clone())));
            }
            let report = compiled(pipeline, options, sources, &mut own);
            // A plan that is made in spite of errors shows what else is wrong; it promises nothing that could be
            // verified.
            if let Some((verify, plan)) = verify.zip(report.plan.as_ref()).filter(|_| !own.has_errors()) {
                for violation in verify(plan, options) {
                    violations.entry(violation).or_default().push(at);
                }
            }
            if let Some(plan) = report.plan.as_ref().filter(|_| !own.has_errors()) {
                own.extend(judge(plan));
            }
            found.add(as_written(document, own), at);
            if at == 0 {
                coverage.first = report;
            }
        },
    );
    if let Err(own_diagnostics) = checked {
        diagnostics.extend(as_written(document, own_diagnostics));
        return coverage;
    }
    let with = |text: String, places: &[usize]| match configurations.describe(places) {
        Some(which) => format!("{text} ({which})"),
        None => text,
    };
    coverage.violations =
        violations.into_iter().map(|(violation, places)| with(violation, &places)).collect();
    // A use that is invalid counts for nothing.
    if found.is_sound() {
        unused(document, model, templates, diagnostics);
        coverage.remarks = Remarks::of(model, &coverage.first);
    }
    diagnostics.extend(found.diagnostics(configurations));
    coverage
}

/// The distinct diagnostics of all configurations in the order of discovery, each with the indices of its
/// configurations.
#[derive(Default)]
struct Found {
    list: Vec<(Diagnostic, Vec<usize>)>,
    known: BTreeMap<(Code, Place, String), usize>,
    sound: usize,
}

impl Found {
    fn is_sound(&self) -> bool {
        self.list.iter().all(|(diagnostic, _)| diagnostic.severity != Severity::Error)
    }

    fn add(&mut self, diagnostics: Diagnostics, at: usize) {
        self.sound += usize::from(!diagnostics.has_errors());
        for diagnostic in diagnostics {
            let position = *self.known.entry(diagnostic.key()).or_insert_with(|| {
                self.list.push((diagnostic, Vec::new()));
                self.list.len() - 1
            });
            if let Some((_, places)) = self.list.get_mut(position)
                && places.last() != Some(&at)
            {
                places.push(at);
            }
        }
    }

    fn diagnostics(self, configurations: &Configurations) -> impl Iterator<Item = Diagnostic> {
        let Self { list, sound, .. } = self;
        list.into_iter()
            .filter(move |(diagnostic, places)| {
                diagnostic.severity == Severity::Error || places.len() >= sound.min(configurations.list.len())
            })
            .map(|(diagnostic, places)| match configurations.describe(&places) {
                Some(which) => diagnostic.related(Place::Nowhere, which),
                None => diagnostic,
            })
    }
}
