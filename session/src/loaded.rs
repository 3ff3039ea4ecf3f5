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

/// The maximum number of plans, one per configuration, that are cached for one pipeline.
const KEPT: usize = 8;

/// A pipeline composed from its files as they were at one moment, with the shader templates for planning it. Clones
/// share their data.
#[derive(Clone, Debug)]
pub struct Loaded(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    composition: Arc<Composition>,
    templates: Arc<Templates>,
    registry: Arc<Registry>,
    plans: Mutex<Vec<Planned>>,
}

/// The results of planning one configuration of a pipeline, as far as errors allow.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Planned {
    /// The typed pipeline, its pass graph and the plan. Each is `None` if errors prevent it.
    pub report: CheckReport,
    /// The diagnostics of this configuration, besides those of [`Loaded::diagnostics`].
    pub diagnostics: Diagnostics,
    configuration: Configuration,
    options: PlanOptions,
}

impl PartialEq for Loaded {
    /// Returns `true` if both are clones of the same load.
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

    /// The node kinds that the pipeline can use.
    pub fn registry(&self) -> &Registry {
        &self.0.registry
    }

    /// The composed document, with the places of values that files overrode. `None` if a file is broken or missing.
    pub fn composed(&self) -> Option<&Arc<Composed>> {
        self.0.composition.composed.as_ref()
    }

    /// The document composed from the pipeline's files; `None` if a file is broken or missing.
    pub fn document(&self) -> Option<&Document> {
        self.composed().map(|composed| &composed.document)
    }

    /// The composed document without its broken and missing parts; `None` if the first file cannot be read.
    pub fn understood(&self) -> Option<&Arc<Composed>> {
        self.0.composition.understood.as_ref()
    }

    /// The index of all declarations and strings in the document of [`Loaded::understood`]. `None` if the first file
    /// cannot be read.
    pub fn model(&self) -> Option<&Model> {
        self.0.composition.model()
    }

    /// The set of all shader templates that the session had when it loaded the pipeline.
    pub fn templates(&self) -> &Arc<TemplateSet> {
        &self.0.templates.set
    }

    /// The contents of the files, as they were when the pipeline was loaded.
    pub fn sources(&self) -> &Sources {
        &self.0.composition.sources
    }

    /// The paths of the files that were read, or searched for and not found. Shader templates are not included.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.0.composition.reads.iter().map(|read| read.path.as_path())
    }

    /// The diagnostics of the shader templates and of composing the pipeline's files.
    pub fn diagnostics(&self) -> Diagnostics {
        let mut diagnostics = self.0.templates.diagnostics.clone();
        diagnostics.extend(self.0.composition.diagnostics.clone());
        diagnostics
    }

    /// Returns the files in the order in which they were read, those of shader templates first.
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
    /// Plans the configuration again with other options. If only sizes differ, the rest of the plan is reused.
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
