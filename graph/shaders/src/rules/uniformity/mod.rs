//! Uniform control flow, as WGSL demands it.
//!
//! Derivatives, sampling with an implicit level, barriers, `workgroupUniformLoad` and subgroup operations have meaning
//! only where all invocations of a quad, workgroup or subgroup come together. WGSL has an analysis that decides, from
//! the text alone, whether they do (<https://www.w3.org/TR/WGSL/#uniformity>); a browser rejects a module that fails
//! it. naga looks at barriers and similar only, and not at fragment stages.
//!
//! Functions are visited callees first. A graph of each function (`flow_graph`) records the dependencies of control
//! flow and values (`walk`, `expressions`). A value that must be uniform and depends on something that may differ
//! between invocations is reported. If it depends on the control flow of the call or on an argument, it becomes a
//! demand on the callers (`summary`), with the path that it took.
//!
//! The source structure that naga's intermediate form drops does not matter here: `&&` and `||` are branches, `while`
//! and `for` are loops. Block variables, which naga lifts to the function, are not used outside of their blocks. Local
//! variables are taken whole, not by their members.
//!
//! Limits, besides those of WGSL's own analysis: naga takes no `@diagnostic` at blocks and statements. The result of a
//! subgroup operation counts as different in each invocation, even if it is the same within the subgroup. A second
//! subgroup operation that depends on it is rejected; that is stricter than `tint`.

mod expressions;
mod flow_graph;
mod summary;
#[cfg(test)]
mod tests;
mod walk;

use std::collections::HashMap;

use naga::{Expression, Function, Handle, Module, SampleLevel, ShaderStage, Span};

use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;
use summary::Finding;
pub(crate) use summary::Summary;
use walk::Walk;

/// The maximum number of places in the code that one message names as reasons.
const REASONS: usize = 6;

/// Returns the violations of WGSL's uniformity rules in source order. They are warnings if the module lowers their
/// severity.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    if demands(module) { analysis(module).1 } else { Vec::new() }
}

/// Returns the summary of each function for its callers, and all violations of WGSL's uniformity rules.
pub(crate) fn analysis(module: &Module) -> (HashMap<Handle<Function>, Summary>, Vec<Rejection>) {
    let mut summaries: HashMap<_, Summary> = HashMap::new();
    let mut findings = Vec::new();
    for (handle, function) in module.functions.iter() {
        let (summary, own) = Walk::new(module, function, None, &summaries).summary();
        summaries.insert(handle, summary);
        findings.extend(own);
    }
    for entry in &module.entry_points {
        findings.extend(Walk::new(module, &entry.function, Some(entry.stage), &summaries).summary().1);
    }
    let start = |span: Span| span.to_range().map_or((0, 0), |range| (range.start, range.end));
    findings.sort_by_key(|finding| (start(finding.need.place), finding.need.warning));
    findings.dedup_by_key(|finding| start(finding.need.place));
    (summaries, findings.into_iter().map(rejection).collect())
}

/// Returns `true` if the module may contain an operation that needs uniform control flow.
fn demands(module: &Module) -> bool {
    let has_stage = |stage| module.entry_points.iter().any(|each| each.stage == stage);
    has_stage(ShaderStage::Compute)
        || ir::functions(module).any(|function| {
            function.expressions.iter().any(|(_, expression)| match expression {
                Expression::Derivative { .. } => true,
                Expression::ImageSample { level, .. } => {
                    matches!(level, SampleLevel::Auto | SampleLevel::Bias(_))
                }
                Expression::SubgroupBallotResult | Expression::SubgroupOperationResult { .. } => true,
                _ => false,
            })
        })
}

fn rejection(finding: Finding) -> Rejection {
    let Finding { need, reasons } = finding;
    let mut rejection =
        Rejection::new(codes::NON_UNIFORM, need.message(), need.place).help(need.operation.help());
    rejection.warning = need.warning;
    let mut notes = need.way;
    notes.extend(reasons);
    if notes.len() > REASONS {
        // The last one is where the difference comes from.
        notes.drain(REASONS - 1..notes.len() - 1);
    }
    rejection.labels =
        notes.into_iter().filter_map(|note| Some((note.span.to_range()?, note.text))).collect();
    rejection
}
