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

/// The results of checking a pipeline, as far as its diagnostics allow.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct CheckReport {
    /// The pipeline.
    pub pipeline: Option<Arc<TypedPipeline>>,
    /// The graph.
    pub graph: Option<Arc<Graph>>,
    /// The plan.
    pub plan: Option<Arc<Plan>>,
}

impl CheckReport {
    /// Plans the same pipeline with other options: another viewport, or sizes that blackboard data wants
    /// ([`PlanOptions::data_sizes`]). Where nothing but sizes changes, the rest of the plan is taken over
    /// ([`Plan::resized`]).
    ///
    /// # Errors
    /// The diagnostics of the plan; nothing but warnings where there is no graph to plan.
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
    /// The node kinds that passes can name.
    pub registry: &'a Registry,
    /// The templates.
    pub templates: &'a Arc<TemplateSet>,
    /// The target profile.
    pub profile: &'a TargetProfile,
    /// Values of parameters and features.
    pub overrides: &'a Overrides,
    /// The viewport and the host's textures.
    pub plan: &'a PlanOptions,
}

/// Plans a registered text that refers to no other file. Adds to `diagnostics`.
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

/// Plans a document, which may be composed of several files. Adds to `diagnostics`.
pub fn check_document(
    document: &Document,
    options: &CheckOptions<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> CheckReport {
    let shaders = Arc::new(ShaderCache::new(options.templates, options.profile));
    check_sharing(document, options, sources, diagnostics, (&shaders, None))
}

/// Plans a document with the shader modules of earlier checks that had the same templates and profile. `schema` is
/// what [`pipeline::check_schema`] reports of the document, if known.
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

/// Plans a pipeline, without checks of what the device of the options lacks.
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
