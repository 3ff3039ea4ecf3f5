//! [`Loaded`]: a pipeline as its files were at one time, to be planned; and [`Planned`].

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use crate::choice::{Choice, Configuration};
use crate::composition::Composition;
use crate::done::Done;
use crate::exposed::exposing;
use crate::graph::compiler::PlanOptions;
use crate::graph::compose::Composed;
use crate::graph::diagnostic::Diagnostics;
use crate::graph::document::Document;
use crate::graph::model::Model;
use crate::graph::node::Registry;
use crate::graph::pipeline::check_schema;
use crate::graph::shader::TemplateSet;
use crate::graph::source::{FileId, Sources};
use crate::graph::{CheckOptions, CheckReport, check_sharing};
use crate::templates::Templates;

/// Plans of this many configurations are kept of one pipeline.
const KEPT: usize = 8;

/// A pipeline as its files were at one time. Clones are the same.
#[derive(Clone, Debug)]
pub struct Loaded(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    composition: Arc<Composition>,
    templates: Arc<Templates>,
    registry: Arc<Registry>,
    plans: Mutex<Vec<Planned>>,
}

/// One configuration of a pipeline, as far as its diagnostics allow. Clones are the same.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Planned {
    /// Pipeline, graph and plan.
    pub report: CheckReport,
    /// The diagnostics of this configuration, besides those of [`Loaded`].
    pub diagnostics: Diagnostics,
    configuration: Configuration,
    options: PlanOptions,
}

impl PartialEq for Loaded {
    /// Whether both are of one load.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Loaded {
    pub(crate) fn new(
        composition: Arc<Composition>,
        templates: Arc<Templates>,
        registry: Arc<Registry>,
    ) -> Self {
        Self(Arc::new(Inner { composition, templates, registry, plans: Mutex::default() }))
    }

    pub(crate) fn composition(&self) -> &Arc<Composition> {
        &self.0.composition
    }

    pub(crate) fn kept_templates(&self) -> &Arc<Templates> {
        &self.0.templates
    }

    /// The registered node kinds.
    pub fn registry(&self) -> &Registry {
        &self.0.registry
    }

    /// The document with what its files replaced of one another; `None` where they are too broken for one.
    pub fn composed(&self) -> Option<&Arc<Composed>> {
        self.0.composition.composed.as_ref()
    }

    /// The composed document.
    pub fn document(&self) -> Option<&Document> {
        self.composed().map(|composed| &composed.document)
    }

    /// The understood part of the files, broken ones too; `None` where the first of them cannot be read.
    pub fn understood(&self) -> Option<&Arc<Composed>> {
        self.0.composition.understood.as_ref()
    }

    /// The index of all names and strings of the document, by which they are looked up; `None` if the document could not
    /// be composed.
    pub fn model(&self) -> Option<&Model> {
        self.0.composition.model()
    }

    /// The set of all templates.
    pub fn templates(&self) -> &Arc<TemplateSet> {
        &self.0.templates.set
    }

    /// The texts that the pipeline was loaded from.
    pub fn sources(&self) -> &Sources {
        &self.0.composition.sources
    }

    /// The paths that were read or looked for.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.0.composition.reads.iter().map(|read| read.path.as_path())
    }

    /// The diagnostics of the templates and of the files.
    pub fn diagnostics(&self) -> Diagnostics {
        let mut diagnostics = self.0.templates.diagnostics.clone();
        diagnostics.extend(self.0.composition.diagnostics.clone());
        diagnostics
    }

    /// Its files in the order in which they were read, those of templates first.
    pub(crate) fn files(&self) -> impl Iterator<Item = FileId> + '_ {
        self.0.templates.files.iter().chain(&self.0.composition.files).copied()
    }

    /// Plans one configuration, or returns the plan made before. If only sizes differ from a plan without
    /// diagnostics, the rest of that plan is reused.
    pub fn plan(&self, choice: &Choice) -> Planned {
        self.plan_with(choice, self.sources(), &mut Done::default())
    }

    pub(crate) fn plan_with(&self, choice: &Choice, sources: &Sources, done: &mut Done) -> Planned {
        let configuration = choice.configuration();
        let is_it = |known: &Planned| known.configuration == configuration;
        let known = self.plans(|plans| plans.iter().find(|known| is_it(known)).cloned());
        let same = |known: &Planned| known.options == choice.plan;
        let planned = match known {
            Some(known) if same(&known) => return known,
            Some(known) if known.diagnostics.is_empty() && known.report.plan.is_some() => {
                done.planned += 1;
                known.resized(&choice.plan, sources)
            }
            _ => self.plan_new(choice, configuration.clone(), sources, done),
        };
        self.plans(|plans| {
            plans.retain(|known| !is_it(known));
            plans.insert(0, planned.clone());
            plans.truncate(KEPT);
        });
        planned
    }

    fn plans<T>(&self, work: impl FnOnce(&mut Vec<Planned>) -> T) -> T {
        work(&mut self.0.plans.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn plan_new(
        &self,
        choice: &Choice,
        configuration: Configuration,
        sources: &Sources,
        done: &mut Done,
    ) -> Planned {
        let Inner { composition, templates, registry, .. } = &*self.0;
        let Choice { profile, overrides, plan, exposed } = choice;
        let mut diagnostics = Diagnostics::new();
        let report = match self.document() {
            None => CheckReport::default(),
            Some(document) => {
                let document = exposing(document, exposed, &mut diagnostics);
                let options = CheckOptions { registry, templates: &templates.set, profile, overrides, plan };
                done.loaded += 1;
                let shaders = templates.shaders(profile);
                let rendered = shaders.rendered();
                // Exposed resources change nothing that the schema speaks of.
                let schema = composition.schema.get_or_init(|| check_schema(&document, registry));
                let kept = (&shaders, Some(schema));
                let report = check_sharing(&document, &options, sources, &mut diagnostics, kept);
                done.rendered += shaders.rendered() - rendered;
                report
            }
        };
        done.planned += usize::from(report.plan.is_some());
        Planned { report, diagnostics, configuration, options: plan.clone() }
    }
}

impl Planned {
    /// Replaces sizes in a plan that otherwise stays as it is.
    fn resized(self, options: &PlanOptions, sources: &Sources) -> Self {
        let Self { mut report, mut diagnostics, configuration, .. } = self;
        report.plan = match report.plan_again(options, sources) {
            Ok(plan) => Some(Arc::new(plan)),
            Err(found) => {
                diagnostics = found;
                None
            }
        };
        Self { report, diagnostics, configuration, options: options.clone() }
    }
}
