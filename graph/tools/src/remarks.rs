//! What a pipeline has and a plan of it does not use: no defect, but worth a line.
//!
//! Culled passes, with the reason; dispatches of fewer invocations than a texture that they write has texels; entry points of the shaders that no pass runs; parameters that nothing of the plan
//! follows from. The last are found by words, as unused settings are (`unused`), but in what the plan keeps: its passes,
//! resources and what these name in turn, and the conditions of all passes. So one that only a setting of another scheme
//! reads is named; one that is only multiplied by zero is not.

use std::collections::BTreeSet;

use crate::check::CheckReport;
use crate::unused::Mentioned;
use crate::why::why_culled;
use umbragraph_compiler::Plan;
use umbragraph_pipeline::document::{Document, Entry};
use umbragraph_pipeline::pipeline::{Pipeline, Usage};
use umbragraph_pipeline::shader::Stage;
use umbragraph_pipeline::work::{Dispatch, Work};

/// What a plan does not use.
#[derive(Clone, Debug, Default)]
pub struct Remarks {
    /// The culled passes, each with the first step of the reason.
    pub culled: Vec<(String, String)>,
    /// The dispatches of so many workgroups that have fewer invocations than a texture that they write has texels: the
    /// pass, the invocations, the texture and its size.
    pub small_dispatches: Vec<(String, [u32; 2], String, [u32; 2])>,
    /// The entry points that no pass runs, as template and name.
    pub entry_points: Vec<(String, String)>,
    /// The parameters from which nothing of the plan follows.
    pub parameters: Vec<String>,
}

impl Remarks {
    /// What the plan of a checked pipeline does not use; nothing where there is no plan.
    pub(crate) fn of(document: &Document, checked: &CheckReport) -> Self {
        let (Some(pipeline), Some(plan)) = (&checked.pipeline, &checked.plan) else { return Self::default() };
        let reason = |name: &String| why_culled(plan, name).next().unwrap_or_default();
        Self {
            culled: plan.culled.keys().map(|name| (name.clone(), reason(name))).collect(),
            small_dispatches: small_dispatches(pipeline, plan),
            entry_points: entry_points(pipeline),
            parameters: parameters(document, pipeline, plan),
        }
    }
}

/// Dispatches that leave out texels of what they write, if each invocation writes one: as one with `over` does, whose
/// number of workgroups follows from the texture.
fn small_dispatches(pipeline: &Pipeline, plan: &Plan) -> Vec<(String, [u32; 2], String, [u32; 2])> {
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

fn entry_points(pipeline: &Pipeline) -> Vec<(String, String)> {
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

fn parameters(document: &Document, pipeline: &Pipeline, plan: &Plan) -> Vec<String> {
    let root = &document.root;
    let entries = |section: &str| root.entries_of(section);
    let kept: BTreeSet<&str> = plan
        .passes
        .iter()
        .filter_map(|planned| pipeline.pass(planned.handle).pointer.strip_prefix("/passes/"))
        .map(|rest| rest.split('/').next().unwrap_or(rest))
        .collect();
    let mut mentioned = Mentioned::default();
    let mut axes = BTreeSet::new();
    for entry in entries("passes") {
        if kept.contains(entry.key.as_str()) || entry.value.get("use").is_some() {
            mentioned.read(&entry.value);
        } else {
            let conditions = ["when", "for_each"].into_iter().filter_map(|key| entry.value.get(key));
            conditions.for_each(|condition| mentioned.read(condition));
        }
    }
    for planned in &plan.passes {
        let Some(program) = pipeline.pass(planned.handle).work().program() else { continue };
        for variant in &pipeline.program(program).variants {
            axes.extend(variant.module.axes.keys().chain(variant.module.constants.keys()).cloned());
        }
    }
    // What is named names others in turn; what nothing names says nothing.
    for section in ["constraints", "geometry", "subgraphs", "shared_settings"] {
        root.get(section).into_iter().for_each(|section| mentioned.read(section));
    }
    let mut waiting: Vec<&Entry> =
        ["resources", "derived", "features"].into_iter().flat_map(entries).collect();
    loop {
        let before = waiting.len();
        waiting.retain(|entry| {
            let is_named = mentioned.words.contains(entry.key.as_str())
                || axes.contains(&entry.key)
                || plan.resources.contains_key(&entry.key);
            if is_named {
                mentioned.read(&entry.value);
            }
            !is_named
        });
        if waiting.len() == before {
            break;
        }
    }
    let declared = entries("parameters").iter().map(|entry| &entry.key);
    declared
        .filter(|name| !mentioned.words.contains(name.as_str()) && !axes.contains(*name))
        .cloned()
        .collect()
}
