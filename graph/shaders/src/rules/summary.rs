//! Summary of a function: all that naga, the rules beyond it and the writers need to know of it to judge a caller.
//!
//! A function is valid or not by itself and by what it sees of others: of a function that it calls, the signature and
//! this summary. It says in which stages the function can stand, what it does to control flow, and what WGSL's analyses
//! of uniformity and of aliases pass to callers. Two functions with one signature and one summary can stand for each
//! other in any module, but for what adds up over all functions ([`super::uses`]).

use std::collections::BTreeMap;
use std::fmt::Write as _;

use naga::Module;
use naga::valid::{FunctionInfo, ModuleInfo};

use super::cost::{self, Spent};
use super::uniform_branches::{self, Branches};
use super::uses::{self, Uses};
use super::{aliasing, stage_variables, uniformity};
use crate::written::rejection::Rejection;

/// The properties of a function that affect the validity and the cost of its callers.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Summary {
    /// The properties that affect the validity of callers, as a string. Equal strings mean equal properties. Empty for
    /// entry points.
    pub(crate) text: String,
    pub(crate) uses: Uses,
    pub(crate) branches: Branches,
    pub(crate) cost: Spent<String>,
}

/// Returns the summaries of a validated module's functions and entry points by name. Also returns violations of WGSL
/// rules that naga does not check.
pub(crate) fn summaries(module: &Module, info: &ModuleInfo) -> (BTreeMap<String, Summary>, Vec<Rejection>) {
    let (uniform, mut rejections) = uniformity::analysis(module);
    let (accesses, aliases) = aliasing::analysis(module);
    rejections.extend(aliases);
    let mentions = stage_variables::analysis(module);
    let mut summaries = BTreeMap::new();
    for (handle, function) in module.functions.iter() {
        let info = &info[handle];
        let mut text = of_naga(info);
        // Writing to a string cannot fail.
        let _ =
            write!(text, "\n{}", uniform.get(&handle).map(uniformity::Summary::digest).unwrap_or_default());
        let _ = write!(text, "\n{}", mentions.get(&handle).copied().unwrap_or_default().digest());
        if let Some(uses) = accesses.get(&handle) {
            let _ = write!(text, "\n{}", aliasing::digest(uses));
        }
        let branches = uniform_branches::of(module, function, None);
        let name = function.name.clone().unwrap_or_default();
        let uses = uses::of(module, function, info);
        let cost = cost::of(module, function, info);
        summaries.insert(name, Summary { text, uses, branches, cost });
    }
    for (at, entry) in module.entry_points.iter().enumerate() {
        let branches = uniform_branches::of(module, &entry.function, Some(entry.stage));
        let info = info.get_entry_point(at);
        let (uses, cost) = (uses::of(module, &entry.function, info), cost::of(module, &entry.function, info));
        summaries.insert(entry.name.clone(), Summary { uses, branches, cost, ..Summary::default() });
    }
    (summaries, rejections)
}

fn of_naga(info: &FunctionInfo) -> String {
    let FunctionInfo {
        available_stages,
        uniformity,
        may_kill,
        dual_source_blending,
        immediate_slots_used,
        ..
    } = info;
    let is_uniform = uniformity.non_uniform_result.is_none();
    let requirements = uniformity.requirements;
    format!(
        "{available_stages:?} {is_uniform} {requirements:?} {may_kill} {dual_source_blending} {immediate_slots_used:?}"
    )
}
