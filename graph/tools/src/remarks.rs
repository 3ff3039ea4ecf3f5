//! Remarks on parts of a pipeline that a plan of it does not use: no defect, but worth a line.
//!
//! Culled passes, with the reason; dispatches of fewer invocations than a texture that they write has texels; entry
//! points of the shaders that no pass runs; parameters that nothing of the plan follows from. The last are found by
//! their uses, as unused settings are (`unused`), but in what the plan keeps: its passes, resources and what these name
//! in turn, and the conditions of all passes. So one that only a setting of another scheme reads is named; one that is
//! only multiplied by zero is not.

use std::collections::BTreeSet;

use crate::check::CheckReport;
use crate::why::why_culled;
use umbragraph_compiler::Plan;
use umbragraph_pipeline::model::{Declaration, DeclarationKind as Kind, Id, Model, Text};
use umbragraph_pipeline::pipeline::{TypedPipeline, Usage};
use umbragraph_pipeline::shader::Stage;
use umbragraph_pipeline::work::{Dispatch, Work};

/// The parts of a pipeline document that a plan does not use.
#[derive(Clone, Debug, Default)]
pub struct Remarks {
    /// The culled passes by name, each with the first step of the reason for culling.
    pub culled: Vec<(String, String)>,
    /// Dispatches with explicit workgroup counts and fewer invocations than texels in a written texture. Each entry is
    /// the pass, its invocations, the texture and the texture's size in texels.
    pub small_dispatches: Vec<(String, [u32; 2], String, [u32; 2])>,
    /// The shader entry points that no pass runs, as template name and entry point name.
    pub entry_points: Vec<(String, String)>,
    /// The names of parameters that do not affect the plan.
    pub parameters: Vec<String>,
}

impl Remarks {
    /// Collects the remarks on the plan of a checked pipeline; empty without a plan.
    pub(crate) fn of(model: &Model, checked: &CheckReport) -> Self {
        let (Some(pipeline), Some(plan)) = (&checked.pipeline, &checked.plan) else { return Self::default() };
        let reason = |name: &String| why_culled(plan, name).next().unwrap_or_default();
        Self {
            culled: plan.culled.keys().map(|name| (name.clone(), reason(name))).collect(),
            small_dispatches: small_dispatches(pipeline, plan),
            entry_points: entry_points(pipeline),
            parameters: parameters(model, pipeline, plan),
        }
    }
}

/// Finds dispatches with explicit workgroup counts and fewer invocations than texels in a written texture. Dispatches
/// sized by a texture (`over`) are skipped.
fn small_dispatches(pipeline: &TypedPipeline, plan: &Plan) -> Vec<(String, [u32; 2], String, [u32; 2])> {
    let mut found = Vec::new();
    for planned in &plan.passes {
        let Work::Compute(work) = pipeline.pass(planned.handle).work() else { continue };
        let (Dispatch::Workgroups(_), Some([x, y, z])) = (&work.dispatch, planned.workgroups) else {
            continue;
        };
        let variant = pipeline.program(work.program).variants.first();
        let Some(entry) = variant.and_then(|variant| variant.entry_point(Stage::Compute)) else { continue };
        let [width, height, depth] = entry.workgroup_size;
        let invocations = [x * width, y * height];
        let all = u64::from(invocations[0]) * u64::from(invocations[1]) * u64::from(z) * u64::from(depth);
        for access in pipeline.pass(planned.handle).accesses() {
            let resource = pipeline.resource(access.resource);
            let is_written = matches!(access.usage, Usage::StorageWrite | Usage::StorageReplace);
            let Some(size) = plan.resources.get(&resource.name).and_then(|one| one.size) else { continue };
            let mip = access.range.mip.map_or(0, |mips| mips.first);
            let texels = [size.width, size.height].map(|side| (side >> mip).max(1));
            if is_written && all < u64::from(texels[0]) * u64::from(texels[1]) {
                found.push((planned.name.clone(), invocations, resource.name.clone(), texels));
            }
        }
    }
    found
}

fn entry_points(pipeline: &TypedPipeline) -> Vec<(String, String)> {
    let (mut run, mut all) = (BTreeSet::new(), BTreeSet::new());
    for pass in &pipeline.passes {
        let stages: &[Stage] = match pass.work() {
            Work::Render(_) => &[Stage::Vertex, Stage::Fragment],
            _ => &[Stage::Compute],
        };
        let Some(program) = pass.work().program() else { continue };
        let program = pipeline.program(program);
        for variant in &program.variants {
            let name = |entry: &umbragraph_pipeline::shader::EntryPoint| {
                (program.template.clone(), entry.name.clone())
            };
            all.extend(variant.module.reflection.entry_points.iter().map(name));
            run.extend(stages.iter().filter_map(|stage| variant.entry_point(*stage)).map(name));
        }
    }
    all.difference(&run).cloned().collect()
}

fn parameters(model: &Model, pipeline: &TypedPipeline, plan: &Plan) -> Vec<String> {
    let at_the_top =
        |kind| model.declarations().filter(move |(_, one)| one.kind == kind && one.owner.is_none());
    let kept: BTreeSet<&str> = plan
        .passes
        .iter()
        .filter_map(|planned| pipeline.pass(planned.handle).pointer.strip_prefix("/passes/"))
        .map(|rest| rest.split('/').next().unwrap_or(rest))
        .collect();
    let mut named: BTreeSet<Id> = BTreeSet::new();
    for (id, pass) in at_the_top(Kind::Pass) {
        let is_whole = kept.contains(pass.name.as_str()) || model.node_kind(id).is_none();
        let decides = |text: &&Text| text.keys.first().is_some_and(|key| key == "when" || key == "for_each");
        let texts = model.texts_in(id).filter(|text| is_whole || decides(text));
        named.extend(texts.flat_map(|text| model.named_in(text)));
    }
    let mut axes = BTreeSet::new();
    for planned in &plan.passes {
        let Some(program) = pipeline.pass(planned.handle).work().program() else { continue };
        for variant in &pipeline.program(program).variants {
            axes.extend(variant.module.axes.keys().chain(variant.module.constants.keys()).cloned());
        }
    }
    let in_all = |id| model.parts_of(id).flat_map(|part| model.uses_in(part)).map(|one| one.declaration);
    for kind in [Kind::Constraint, Kind::Subgraph] {
        named.extend(at_the_top(kind).flat_map(|(id, _)| in_all(id)));
    }
    // What is named names others in turn; what nothing names says nothing.
    let mut waiting: Vec<(Id, &Declaration)> =
        [Kind::Resource, Kind::Derived, Kind::Feature].into_iter().flat_map(at_the_top).collect();
    loop {
        let before = waiting.len();
        waiting.retain(|(id, one)| {
            let is_named =
                named.contains(id) || axes.contains(&one.name) || plan.resources.contains_key(&one.name);
            if is_named {
                named.extend(in_all(*id));
            }
            !is_named
        });
        if waiting.len() == before {
            break;
        }
    }
    let declared = at_the_top(Kind::Parameter);
    declared
        .filter(|(id, one)| !named.contains(id) && !axes.contains(&one.name))
        .map(|(_, one)| one.name.clone())
        .collect()
}
