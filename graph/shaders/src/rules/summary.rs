//! All that callers see of a function, and naga, the rules beyond it and the writers of a caller with them.
//!
//! A function is valid or not by itself and by what it sees of others: of a function that it calls, the signature and this
//! summary. It says in which stages the function can stand, what it does to control flow, and what WGSL's analyses of
//! uniformity and of aliases pass to callers. Two functions with one signature and one summary can stand for each other in
//! any module, but for what adds up over all functions ([`super::uses`]).
//!
//! If pointers to variables of the module are passed, a caller is also judged by the variables that a callee uses; so
//! the summaries of such a module say which variables functions use with all their callees, and how.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{AddressSpace, Module};

use super::uniform_branches::{self, Branches};
use super::uses::{self, Uses};
use super::{aliasing, uniformity};
use crate::written::rejection::Rejection;

/// The summary of a function.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Summary {
    /// In words of its own; equal exactly if the summaries are.
    pub(crate) text: String,
    /// The variables of the module that it and its callees use, where that matters to callers.
    pub(crate) globals: Vec<String>,
    pub(crate) uses: Uses,
    pub(crate) branches: Branches,
}

/// The summaries of the functions and entry points of a validated module by name, and violations of rules of WGSL that
/// naga does not check; browsers reject such modules.
pub(crate) fn summaries(module: &Module, info: &ModuleInfo) -> (BTreeMap<String, Summary>, Vec<Rejection>) {
    let (uniform, mut rejections) = uniformity::analysis(module);
    let (accesses, aliases) = aliasing::analysis(module);
    rejections.extend(aliases);
    let is_whole = passes_variables(module);
    let mut summaries = BTreeMap::new();
    for (handle, function) in module.functions.iter() {
        let info = &info[handle];
        let mut text = of_naga(info);
        // Writing to a string cannot fail.
        let _ =
            write!(text, "\n{}", uniform.get(&handle).map(uniformity::Summary::digest).unwrap_or_default());
        let mut globals = Vec::new();
        if let Some(uses) = accesses.get(&handle) {
            let _ = write!(text, "\n{}", aliasing::digest(module, uses, is_whole));
        }
        if is_whole {
            let used = used(module, info);
            let _ = write!(text, "\n{}", used.join("\n"));
            globals = used.iter().filter_map(|line| line.split(' ').next()).map(str::to_owned).collect();
        }
        let branches = uniform_branches::of(module, function, None);
        let name = function.name.clone().unwrap_or_default();
        let uses = uses::of(module, function, info);
        summaries.insert(name, Summary { text, globals, uses, branches });
    }
    for (at, entry) in module.entry_points.iter().enumerate() {
        let branches = uniform_branches::of(module, &entry.function, Some(entry.stage));
        let uses = uses::of(module, &entry.function, info.get_entry_point(at));
        summaries.insert(entry.name.clone(), Summary { uses, branches, ..Summary::default() });
    }
    (summaries, rejections)
}

/// Whether some function takes a pointer to a variable of the module.
fn passes_variables(module: &Module) -> bool {
    let is_one = |space: AddressSpace| space != AddressSpace::Function;
    let mut arguments = module.functions.iter().flat_map(|(_, function)| &function.arguments);
    arguments.any(|argument| module.types[argument.ty].inner.pointer_space().is_some_and(is_one))
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

/// The variables of the module that a function and its callees use, each with how.
fn used(module: &Module, info: &FunctionInfo) -> Vec<String> {
    let used = module.global_variables.iter().filter(|(handle, _)| !info[*handle].is_empty());
    let line = |(handle, variable): (_, &naga::GlobalVariable)| {
        format!("{} {:?}", variable.name.as_deref().unwrap_or_default(), info[handle])
    };
    let mut lines: Vec<String> = used.map(line).collect();
    lines.sort_unstable();
    lines
}
