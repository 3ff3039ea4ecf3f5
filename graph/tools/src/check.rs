//! The whole way from a file to a plan.

use std::path::Path;
use std::sync::Arc;

use crate::compiler::{self, Graph, Plan, PlanOptions};
use crate::compose::{self, read_source};
use crate::diagnostic::Diagnostics;
use crate::document::{self, Document};
use crate::node::Registry;
use crate::pipeline::{self, Choice, Pipeline};
use crate::shader::{TargetProfile, TemplateSet};
use crate::source::{FileId, Sources};

/// What a pipeline text came to, as far as its diagnostics let it.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// The pipeline.
    pub pipeline: Option<Arc<Pipeline>>,
    /// The graph.
    pub graph: Option<Graph>,
    /// The plan.
    pub plan: Option<Plan>,
}

impl Checked {
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
        compiler::plan(pipeline, graph, options, sources, &mut diagnostics).ok_or(diagnostics)
    }
}

/// What a pipeline is checked with.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// The node kinds that passes can name.
    pub registry: &'a Registry,
    /// The templates.
    pub templates: &'a Arc<TemplateSet>,
    /// What shaders and sizes may rely on.
    pub profile: &'a TargetProfile,
    /// Values of parameters and features.
    pub choice: &'a Choice,
    /// The viewport and the host's textures.
    pub options: &'a PlanOptions,
}

/// Takes a registered text, which stands alone, all the way to a plan. Every diagnostic goes to `diagnostics`.
pub fn check(file: FileId, job: &Job<'_>, sources: &Sources, diagnostics: &mut Diagnostics) -> Checked {
    match document::parse(sources, file) {
        Ok(mut document) => {
            compose::share(&mut document, diagnostics);
            check_document(&document, job, sources, diagnostics)
        }
        Err(own_diagnostics) => {
            diagnostics.extend(own_diagnostics);
            Checked::default()
        }
    }
}

/// Takes a pipeline file, with the files that it extends, includes and uses, all the way to a plan. Every diagnostic
/// goes to `diagnostics`. What it names lies below the working folder or its own; further folders, or files that are
/// not on a disk: [`crate::compose::compose`], then [`check_document`].
pub fn check_path(
    path: &Path,
    job: &Job<'_>,
    sources: &mut Sources,
    diagnostics: &mut Diagnostics,
) -> Checked {
    let file = match read_source(path, sources) {
        Ok(file) => file,
        Err(diagnostic) => {
            diagnostics.push(diagnostic);
            return Checked::default();
        }
    };
    compose::compose(file, path, &mut compose::Disk(compose::Roots::of(path)), sources, diagnostics)
        .map(|composed| check_document(&composed.document, job, sources, diagnostics))
        .unwrap_or_default()
}

/// Takes a document, perhaps composed of several files, all the way to a plan. Every diagnostic goes to `diagnostics`.
pub fn check_document(
    document: &Document,
    job: &Job<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Checked {
    let mut own = Diagnostics::new();
    let checked = check_own(document, job, sources, &mut own);
    diagnostics.extend(pipeline::as_written(document, compose::with_users(document, own)));
    checked
}

fn check_own(
    document: &Document,
    job: &Job<'_>,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Checked {
    let mut checked = Checked::default();
    let Job { registry, templates, profile, choice, options } = job;
    let Some(mut pipeline) =
        pipeline::load(document, registry, templates, profile, choice, sources, diagnostics)
    else {
        return checked;
    };
    compiler::set_aside(&mut pipeline, options, sources, diagnostics);
    let pipeline = Arc::new(pipeline);
    checked.pipeline = Some(pipeline.clone());
    let Some(graph) = compiler::build(&pipeline, diagnostics) else { return checked };
    checked.plan = compiler::plan(&pipeline, &graph, options, sources, diagnostics);
    checked.graph = Some(graph);
    checked
}
