//! All that callers see of a function, and naga, the rules beyond it and the writers of a caller with them.
//!
//! A function is valid or not by itself and by what it sees of others: of a function that it calls, the signature and this
//! summary. It says in which stages the function can stand, what it does to control flow, which variables of the module it
//! and its callees use and how, which textures are sampled with which samplers, and what WGSL's analyses of uniformity and
//! of aliases pass to callers. Two functions with one signature and one summary can stand for each other in any module.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fmt::Write as _;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{Block, Expression, Function, Handle, Module, Statement};

use super::uniform_branches::{self, Branches};
use super::{aliasing, uniformity};
use crate::written::ir;
use crate::written::rejection::Rejection;

/// The summary of a function.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Summary {
    /// In words of its own; equal exactly if the summaries are.
    pub(crate) text: String,
    /// The variables of the module that it and its callees use.
    pub(crate) globals: Vec<String>,
    pub(crate) branches: Branches,
}

/// The summaries of the functions and entry points of a validated module by name, and violations of rules of WGSL that
/// naga does not check; browsers reject such modules.
pub(crate) fn summaries(module: &Module, info: &ModuleInfo) -> (BTreeMap<String, Summary>, Vec<Rejection>) {
    let (uniform, mut rejections) = uniformity::analysis(module);
    let (accesses, aliases) = aliasing::analysis(module);
    rejections.extend(aliases);
    let mut sampled: HashMap<Handle<Function>, BTreeSet<Sampled>> = HashMap::new();
    let mut summaries = BTreeMap::new();
    for (handle, function) in module.functions.iter() {
        let pairs = sampled_together(module, function, &sampled);
        let info = &info[handle];
        let (mut text, globals) = of_naga(module, info);
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "\n{pairs:?}\n{}\n{}",
            uniform.get(&handle).map(uniformity::Summary::digest).unwrap_or_default(),
            accesses.get(&handle).map(|uses| aliasing::digest(module, uses)).unwrap_or_default(),
        );
        sampled.insert(handle, pairs);
        let branches = uniform_branches::of(module, function, None);
        let name = function.name.clone().unwrap_or_default();
        summaries.insert(name, Summary { text, globals, branches });
    }
    for entry in &module.entry_points {
        let branches = uniform_branches::of(module, &entry.function, Some(entry.stage));
        summaries.insert(entry.name.clone(), Summary { branches, ..Summary::default() });
    }
    (summaries, rejections)
}

fn of_naga(module: &Module, info: &FunctionInfo) -> (String, Vec<String>) {
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
    let mut text = format!(
        "{available_stages:?} {is_uniform} {requirements:?} {may_kill} {dual_source_blending} {immediate_slots_used:?}"
    );
    let mut globals = Vec::new();
    for (handle, variable) in module.global_variables.iter().filter(|(handle, _)| !info[*handle].is_empty()) {
        let name = variable.name.clone().unwrap_or_default();
        globals.push(format!("{name} {:?}", info[handle]));
    }
    globals.sort_unstable();
    let _ = write!(text, "\n{}", globals.join("\n"));
    let name = |line: &String| line.split(' ').next().unwrap_or_default().to_owned();
    (text, globals.iter().map(name).collect())
}

/// A texture and a sampler: names of variables, or numbers of arguments.
type Sampled = (String, String);

fn sampled_together(
    module: &Module,
    function: &Function,
    known: &HashMap<Handle<Function>, BTreeSet<Sampled>>,
) -> BTreeSet<Sampled> {
    let root = |part: Handle<Expression>| match function.expressions[ir::base(function, part)] {
        Expression::GlobalVariable(variable) => {
            module.global_variables[variable].name.clone().unwrap_or_default()
        }
        Expression::FunctionArgument(at) => at.to_string(),
        _ => "?".to_owned(),
    };
    let mut found = BTreeSet::new();
    for (_, expression) in function.expressions.iter() {
        if let Expression::ImageSample { image, sampler, .. } = expression {
            found.insert((root(*image), root(*sampler)));
        }
    }
    let mut blocks: Vec<&Block> = vec![&function.body];
    while let Some(block) = blocks.pop() {
        for statement in block {
            blocks.extend(ir::blocks(statement));
            let Statement::Call { function: callee, arguments, .. } = statement else { continue };
            let passed = |of: &String| match of.parse::<usize>() {
                Ok(at) => arguments.get(at).map_or_else(|| of.clone(), |argument| root(*argument)),
                Err(_) => of.clone(),
            };
            let pairs = known.get(callee).into_iter().flatten();
            found.extend(pairs.map(|(image, sampler)| (passed(image), passed(sampler))));
        }
    }
    found
}
