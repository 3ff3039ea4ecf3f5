//! The whole way from a file to a plan.

use std::sync::Arc;

use umbragraph_compiler::{Graph, Plan, PlanOptions};
use umbragraph_pipeline::compose;
use umbragraph_pipeline::diagnostic::Diagnostics;
use umbragraph_pipeline::document::{self, Document};
use umbragraph_pipeline::node::Registry;
use umbragraph_pipeline::pipeline::{self, LoadOptions, Overrides, TypedPipeline};
use umbragraph_pipeline::shader::{ShaderCache, TargetProfile, TemplateSet};
use umbragraph_pipeline::source::{FileId, Sources};

/// The results of checking a pipeline; later results are absent after errors.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct CheckReport {
    /// The typed pipeline; `None` after errors in the document.
    pub pipeline: Option<Arc<TypedPipeline>>,
    /// The dependency graph of the passes; `None` after errors.
    pub graph: Option<Arc<Graph>>,
    /// The plan; `None` after errors.
    pub plan: Option<Arc<Plan>>,
}

impl CheckReport {
    /// Plans the same pipeline with other options: another viewport, or other sizes published by blackboard data
    /// ([`PlanOptions::data_sizes`]). If only sizes change, the rest of the plan is reused ([`Plan::resized`]).
    ///
    /// # Errors
    ///
    /// Returns the diagnostics of the plan; no diagnostics if there is no graph to plan.
    pub fn plan_again(&self, options: &PlanOptions, sources: &Sources) -> Result<Plan, Diagnostics> {
        let mut diagnostics = Diagnostics::new();
        let (Some(pipeline), Some(graph)) = (&self.pipeline, &self.graph) else { return Err(diagnostics) };
        if let Some(plan) = &self.plan {
            return plan.resized(graph, options, sources);
        }
        umbragraph_compiler::plan(pipeline, graph, options, sources, &mut diagnostics).ok_or(diagnostics)
    }
}

/// The options of a check.
#[derive(Clone, Copy, Debug)]
pub struct CheckOptions<'a> {
    /// The node kinds that passes can use.
    pub registry: &'a Registry,
    /// The WGSL shader templates.
    pub templates: &'a Arc<TemplateSet>,
    /// The target profile: the features and limits of the device.
    pub profile: &'a TargetProfile,
    /// The values given for parameters and features.
    pub overrides: &'a Overrides,
    /// The planning options: the viewport, the host's textures and the objective.
    pub plan: &'a PlanOptions,
}

/// Checks and plans a registered file that includes no other file. Adds to `diagnostics`.
pub fn check(
    file: FileId,
    options: &CheckOptions<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> CheckReport {
    match document::parse(sources, file).valid() {
        Ok(mut document) => {
            compose::share(&mut document, diagnostics);
            check_document(&document, options, sources, diagnostics)
        }
        Err(own_diagnostics) => {
            diagnostics.extend(own_diagnostics);
            CheckReport::default()
        }
    }
}

/// Checks and plans a document that may be composed of several files. Adds to `diagnostics`.
pub fn check_document(
    document: &Document,
    options: &CheckOptions<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> CheckReport {
    let shaders = Arc::new(ShaderCache::new(options.templates, options.profile));
    check_sharing(document, options, sources, diagnostics, (&shaders, None))
}

/// Checks and plans a document, reusing shader modules of earlier checks with the same templates and profile. `schema`
/// holds the result of [`pipeline::check_schema`] for the document, if already computed.
pub fn check_sharing(
    document: &Document,
    options: &CheckOptions<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
    (shaders, schema): (&Arc<ShaderCache>, Option<&Diagnostics>),
) -> CheckReport {
    let mut own = Diagnostics::new();
    let CheckOptions { registry, overrides, plan: options, .. } = options;
    let load = LoadOptions { schema, ..LoadOptions::new(registry, shaders, overrides) };
    let pipeline = pipeline::load(document, &load, sources, &mut own);
    let checked = pipeline.map(|pipeline| compiled(pipeline, options, sources, &mut own)).unwrap_or_default();
    diagnostics.extend(compose::as_written(document, own));
    checked
}

/// Takes passes that use missing subresources out of a typed pipeline, then builds its graph and its plan.
pub(crate) fn compiled(
    mut pipeline: TypedPipeline,
    options: &PlanOptions,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> CheckReport {
    umbragraph_compiler::set_aside(&mut pipeline, options, sources, diagnostics);
    let pipeline = Arc::new(pipeline);
    let graph = umbragraph_compiler::build(&pipeline, diagnostics);
    let plan = |graph| umbragraph_compiler::plan(&pipeline, graph, options, sources, diagnostics);
    let plan = graph.as_ref().and_then(plan).map(Arc::new);
    CheckReport { plan, graph: graph.map(Arc::new), pipeline: Some(pipeline) }
}
