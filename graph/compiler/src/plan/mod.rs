//! The plan: everything about a frame that is known before it, as a value.
//!
//! A [`Plan`] is made for one pipeline and one viewport: live passes in order, sizes, formats and usages, which
//! resources share a texture, what each attachment loads and stores, dispatch sizes and the bytes of constant blocks.
//! It is serialisable and the same from run to run. An executor instantiates it; nothing in it knows a device.
//!
//! Steps, each in a file of its own: what is kept (`cull`), what each resource is (`resolved`), the order (`order`),
//! load and store operations (`attachments`), dispatches and blocks (`pass_sizes`), which resources share memory
//! (`allocate`). Planning again for another size (`resize`) repeats only the steps that sizes change.

pub(crate) mod allocate;
pub(crate) mod attachments;
pub(crate) mod core_rules;
pub(crate) mod device_rules;
pub(crate) mod pass_sizes;
pub(crate) mod planned;
pub(crate) mod planner;
pub(crate) mod resize;
pub(crate) mod target_constants;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use crate::contents::uninitialised;
use crate::contents::{LiveResources, toggles};
use crate::graph::Graph;
use crate::memory::history;
use crate::plan::planned::{Fixed, Plan, PlannedPass};
use crate::plan::planner::Planner;
use crate::request::options::PlanOptions;
use crate::resources::resolved::ResolvedResources;
use crate::resources::subresources;
use crate::schedule::cull::{self, CullReason, KeepReason};
use crate::schedule::merge::Merger;
use crate::schedule::order;
use crate::values::settings;
use umbragraph_pipeline::diagnostic::{Diagnostic, Diagnostics, Place, codes};
use umbragraph_pipeline::language::Lifetime;
use umbragraph_pipeline::pipeline::TypedPipeline;
use umbragraph_pipeline::source::Sources;
use umbragraph_pipeline::work::{PassHandle, ResourceHandle};

/// Plans a frame. Returns `None` after an error.
///
/// Reports impossible sizes and dispatches, formats that do not support their usages, and imports used in ways that
/// their usages do not allow. Also reports values that do not fit their block, and attachments that do not match one
/// another or the shader's outputs.
pub fn plan(
    pipeline: &Arc<TypedPipeline>,
    graph: &Graph,
    options: &PlanOptions,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Option<Plan> {
    if options.viewport.contains(&0) {
        let [width, height] = options.viewport;
        let message = format!("a picture of {width} by {height} texels has none");
        let diagnostic = Diagnostic::error(codes::SIZE_LIMIT, Place::Nowhere, message);
        diagnostics.push(
            diagnostic.help("plan when there is something to draw, such as a window that is not minimised"),
        );
        return None;
    }
    let before = diagnostics.error_count();
    let kept = cull::keep(pipeline, graph);
    let mut live: Vec<PassHandle> =
        graph.order.iter().copied().filter(|pass| kept[pass.index()].is_some()).collect();
    if live.is_empty() && !pipeline.passes.is_empty() && pipeline.uncertain.is_empty() {
        diagnostics.push(no_output(pipeline));
    }
    let mut own_diagnostics = Vec::new();
    let is_live = |pass: PassHandle| kept[pass.index()].is_some();
    let conditional = toggles::conditional(pipeline, graph, &is_live);
    let resolved =
        ResolvedResources::new(pipeline, options, sources, &live, &conditional, &mut own_diagnostics);
    let resources = LiveResources { resolved: &resolved, graph, is_live: &is_live };
    check(resources, &mut own_diagnostics);
    let report = order::choose(graph, &resolved, options.objective, &mut live);
    let planner = Planner::new(&resolved, &live);
    let mut passes: Vec<PlannedPass> = Vec::with_capacity(live.len());
    let mut merger = Merger::new(&resolved);
    for (at, handle) in live.iter().enumerate() {
        let Some(reason) = kept[handle.index()] else { continue };
        let mut planned = planner.pass(at, *handle, reason, &mut own_diagnostics);
        let joins = merger.push(*handle);
        planned.group = passes.last().map_or(0, |last| last.group + usize::from(!joins));
        passes.push(planned);
    }
    resolved.check_all_sizes();
    diagnostics.extend(resolved.sizes.take_diagnostics());
    diagnostics.extend(own_diagnostics);
    if diagnostics.error_count() > before {
        return None;
    }
    let culled = pipeline.pass_handles().filter(|pass| kept[pass.index()].is_none());
    let mut positions = vec![None; pipeline.passes.len()];
    for (at, pass) in passes.iter().enumerate() {
        positions[pass.handle.index()] = Some(at);
    }
    let mut plan = Plan {
        name: pipeline.name.clone(),
        viewport: options.viewport,
        culled: culled
            .map(|pass| (pipeline.pass(pass).name.clone(), cull::cull_reason(pipeline, graph, &kept, pass)))
            .collect(),
        filters: filters(pipeline, &passes),
        resources: BTreeMap::new(),
        histories: BTreeMap::new(),
        textures: Vec::new(),
        buffers: Vec::new(),
        bytes_without_aliasing: 0,
        bytes: 0,
        bytes_bound: 0,
        bytes_peak: 0,
        data_sizes: options.data_sizes.clone(),
        toggles: pipeline.toggles.iter().map(|one| (one.name.clone(), one.default)).collect(),
        parameters: settings::planned(pipeline),
        order: report,
        pipeline: pipeline.clone(),
        passes,
        fixed: Arc::new(Fixed {
            positions,
            spans: planner.spans(),
            conditional,
            resolved: resolved.list.clone(),
            import_kinds: options.import_kinds(),
            aliasing: options.aliasing,
            copyable_state: options.copyable_state,
        }),
    };
    allocate::allocate(&mut plan, &resolved);
    let broken = device_rules::check(&plan);
    let fine = broken.is_empty();
    diagnostics.extend(broken);
    fine.then_some(plan)
}

/// Reports accesses that are invalid with the resolved sizes: missing subresources, invalid initial values, unsuitable
/// fallbacks, and contents that are never written.
pub(crate) fn check(live: LiveResources<'_, '_>, diagnostics: &mut Vec<Diagnostic>) {
    let resolved = live.resolved;
    let beyond = subresources::beyond(resolved.pipeline, &resolved.sizes);
    diagnostics.extend(beyond.into_iter().map(|(_, diagnostic)| diagnostic));
    history::check_initial(resolved, diagnostics);
    toggles::check_passthroughs(live, diagnostics);
    toggles::check_outputs(live, diagnostics);
    uninitialised::check(live, diagnostics);
}

fn no_output(pipeline: &TypedPipeline) -> Diagnostic {
    let place = pipeline.passes[0].place;
    let message = format!("nothing comes out of \"{}\": every pass is culled", pipeline.name);
    let is_written = |one: &ResourceHandle| pipeline.passes.iter().any(|pass| pass.writes(*one));
    let mut unwritten =
        pipeline.resource_handles().filter(|one| !is_written(one)).map(|one| pipeline.resource(one));
    let imported = unwritten.find(|one| one.lifetime() == Lifetime::Imported);
    let diagnostic = Diagnostic::error(codes::NO_OUTPUT, place, message).pointer("/passes");
    match imported {
        Some(output) => diagnostic
            .related(output.place, "the output, which no pass writes")
            .help(format!("let a pass write \"{}\", which is \"lifetime\": \"imported\"", output.name)),
        None => diagnostic.help(
            "let a pass write a resource with \"lifetime\": \"imported\", or give one \"side_effect\": true",
        ),
    }
}

/// Returns the draw filters of passes that draw the host's meshes, by the name of the geometry contract.
fn filters(pipeline: &TypedPipeline, passes: &[PlannedPass]) -> BTreeMap<String, BTreeSet<String>> {
    let mut filters: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for scene in passes.iter().filter_map(|planned| pipeline.pass(planned.handle).work().scene()) {
        filters.entry(scene.geometry.clone()).or_default().insert(scene.filter.clone());
    }
    filters
}

impl Plan {
    /// Returns the passes on the path from a live pass to an output, beginning with the pass itself; empty for a culled
    /// pass. The field `kept` of each holds its reason.
    pub fn why_kept(&self, pass: PassHandle) -> impl Iterator<Item = &PlannedPass> {
        let next = |planned: &&PlannedPass| match planned.reason {
            KeepReason::ReadBy((reader, _))
            | KeepReason::ReadLater((reader, _))
            | KeepReason::MayBeReadBy((reader, _)) => self.pass(reader),
            KeepReason::SideEffect | KeepReason::Output(_) | KeepReason::MayBeLeft(_) => None,
        };
        // A way has no cycle; the limit only bounds what a plan changed by hand can do.
        std::iter::successors(self.pass(pass), next).take(self.passes.len() + 1)
    }

    /// Returns a culled pass with its reason, then the first culled reader with its reason, and so on; empty for a live
    /// pass.
    pub fn why_culled<'a>(&'a self, pass: &str) -> impl Iterator<Item = (&'a str, &'a CullReason)> {
        let mut next = Some(pass);
        let mut seen = BTreeSet::new();
        let mut way = Vec::new();
        // Culled passes that read one another over frames lead back to where they began.
        while let Some((name, reason)) = next.and_then(|name| self.culled.get_key_value(name))
            && seen.insert(name)
        {
            way.push((name.as_str(), reason));
            next = match reason {
                CullReason::OnlyCulledRead(readers) => readers.first().map(String::as_str),
                CullReason::WritesNothing | CullReason::NothingReads(_) => None,
            };
        }
        way.into_iter()
    }
}
