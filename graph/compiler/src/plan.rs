//! The plan: everything about a frame that is known before it, as a value.
//!
//! A [`Plan`] is made for one pipeline and one viewport: live passes in order, sizes, formats and usages, which
//! resources share a texture, what each attachment loads and stores, dispatch sizes and the bytes of constant blocks.
//! It is serialisable and the same from run to run. An executor instantiates it; nothing in it knows a device.
//!
//! Steps, each in a file of its own: what is kept (`cull`), what each resource is (`resolved`), the order (`order`),
//! load and store operations (`attachments`), dispatches and blocks (`pass_sizes`), which resources share memory
//! (`allocate`). Planning again for another size (`resize`) repeats only the steps that sizes change.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::allocate;
use super::cull::{self, CullReason, KeepReason};
use super::device_rules;
use super::graph::Graph;
use super::merge::Merger;
use super::options::PlanOptions;
use super::order;
use super::parameters;
use super::planned::{Fixed, Plan, PlannedPass};
use super::planner::Planner;
use super::resolved_resources::ResolvedResources;
use super::toggles;
use super::uninitialised;
use super::{history, subresources};
use crate::diagnostic::{Diagnostic, Diagnostics, codes};
use crate::pipeline::Pipeline;
use crate::source::Sources;
use crate::work::{PassHandle, ResourceHandle};

/// Plans a frame.
///
/// Diagnostics: impossible sizes, formats that do not support their usages, attachments that do not fit together or the
/// shader's outputs, impossible dispatches, values that do not fit their block, imports used beyond their usage.
/// `None` after an error.
pub fn plan(
    pipeline: &Arc<Pipeline>,
    graph: &Graph,
    options: &PlanOptions,
    sources: &Sources,
    diagnostics: &mut Diagnostics,
) -> Option<Plan> {
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
    check(&resolved, graph, &is_live, &mut own_diagnostics);
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
        parameters: parameters::planned(pipeline),
        order: report,
        pipeline: pipeline.clone(),
        passes,
        fixed: Arc::new(Fixed {
            positions,
            spans: planner.spans(),
            conditional,
            resolved: resolved.list.clone(),
            import_formats: options.import_formats(),
            import_usages: options.import_usages.clone(),
            aliasing: options.aliasing,
        }),
    };
    allocate::allocate(&mut plan, &resolved);
    let broken = device_rules::check(&plan);
    let fine = broken.is_empty();
    diagnostics.extend(broken);
    fine.then_some(plan)
}

/// Finds what is wrong with accesses, now that sizes are known.
pub(super) fn check(
    resolved: &ResolvedResources<'_>,
    graph: &Graph,
    is_live: &dyn Fn(PassHandle) -> bool,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let beyond = subresources::beyond(resolved.pipeline, &resolved.sizes);
    diagnostics.extend(beyond.into_iter().map(|(_, diagnostic)| diagnostic));
    history::check_initial(resolved, diagnostics);
    toggles::check_passthroughs(resolved, is_live, diagnostics);
    toggles::check_outputs(resolved, graph, is_live, diagnostics);
    uninitialised::check(resolved, graph, is_live, diagnostics);
}

fn no_output(pipeline: &Pipeline) -> Diagnostic {
    let place = pipeline.passes[0].place;
    let message = format!("nothing comes out of \"{}\": every pass is culled", pipeline.name);
    Diagnostic::error(codes::NO_OUTPUT, place, message).pointer("/passes").help(
        "let a pass write a resource with \"lifetime\": \"imported\", or give one \"side_effect\": true",
    )
}

impl Plan {
    /// The way from a live pass to an output, in words; empty for a culled pass.
    pub fn why_kept(&self, pass: PassHandle) -> Vec<String> {
        self.why_kept_within(pass, usize::MAX)
    }

    /// The first steps of that way.
    pub fn why_kept_within(&self, pass: PassHandle, steps: usize) -> Vec<String> {
        let resource = |handle: ResourceHandle| &self.pipeline.resource(handle).name;
        let mut words = Vec::new();
        let mut next = self.pass(pass);
        while let Some(planned) = next {
            let (step, then) = match planned.reason {
                KeepReason::SideEffect => ("it has a side effect".to_owned(), None),
                KeepReason::Output(handle) => (format!("writes the output {}", resource(handle)), None),
                KeepReason::ReadBy((reader, handle)) => (
                    format!("{} reads {}", self.pipeline.pass(reader).name, resource(handle)),
                    self.pass(reader),
                ),
                KeepReason::MayBeReadBy((reader, handle)) => (
                    format!(
                        "{} reads {}, perhaps nothing of it: it has more writers of different subresource ranges, or with \
                         different toggles, than are told apart",
                        self.pipeline.pass(reader).name,
                        resource(handle)
                    ),
                    self.pass(reader),
                ),
                KeepReason::MayBeLeft(handle) => (
                    format!(
                        "something of it may be left in {}, which has more writers of different subresource ranges, or with \
                         different toggles, than are told apart",
                        resource(handle)
                    ),
                    None,
                ),
                KeepReason::ReadLater((reader, handle)) => {
                    let back = self.pipeline.resource(handle).history.map_or(1, |history| history.back);
                    let when = if back == 1 {
                        "in the next frame".to_owned()
                    } else {
                        format!("{back} frames later")
                    };
                    let reader_name = &self.pipeline.pass(reader).name;
                    (format!("{reader_name} reads {} {when}", resource(handle)), self.pass(reader))
                }
            };
            words.push(step);
            // A way has no cycle; the limit only bounds what a plan changed by hand can do.
            next = then.filter(|_| words.len() < steps && words.len() <= self.passes.len());
        }
        words
    }

    /// Why a pass is culled, and those of its readers in turn, in words; empty for a live pass.
    pub fn why_culled(&self, pass: &str) -> Vec<String> {
        self.why_culled_within(pass, usize::MAX)
    }

    /// The first steps of that way.
    pub fn why_culled_within(&self, pass: &str, steps: usize) -> Vec<String> {
        let mut words = Vec::new();
        let mut next = Some(pass.to_owned());
        let mut seen = BTreeSet::new();
        // Culled passes that read one another over frames lead back to where they began.
        while let Some(name) = next.take().filter(|name| words.len() < steps && seen.insert(name.clone())) {
            match self.culled.get(&name) {
                Some(CullReason::WritesNothing) => {
                    words.push(format!("{name} writes nothing and has no side effect"));
                }
                Some(CullReason::NothingReads(resources)) => {
                    words.push(format!("nothing reads what {name} writes: {}", resources.join(", ")));
                }
                Some(CullReason::OnlyCulledRead(readers)) => {
                    words.push(format!("only culled passes read what {name} writes: {}", readers.join(", ")));
                    next = readers.first().cloned();
                }
                None => {}
            }
        }
        words
    }
}
