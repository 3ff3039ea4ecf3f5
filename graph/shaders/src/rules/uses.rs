//! Uses that add up over the functions that an entry point reaches: variables of the module, and textures with
//! samplers.
//!
//! A function says what it uses itself and what it calls with which arguments; the rest follows where functions come
//! together, without looking at any of them again.

use std::collections::BTreeSet;

use naga::valid::FunctionInfo;
use naga::{Block, Expression, Function, Handle, Module, Statement};

use crate::written::ir;

/// The origin of a texture, sampler or passed argument: the name of a module-scope variable or the index of an
/// argument; `?` for other values.
type Root = String;

/// The module-scope variables, sampled pairs and calls in a function's own body, without those of the functions that it
/// calls.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Uses {
    /// The names of the module-scope variables that are used.
    pub(crate) globals: BTreeSet<String>,
    /// The pairs of texture and sampler that are sampled together.
    pub(crate) sampled: BTreeSet<(Root, Root)>,
    /// The called functions with the origins of their arguments.
    pub(crate) calls: BTreeSet<(String, Vec<Root>)>,
}

/// Collects the module-scope variables, sampled pairs and calls in the own body of a validated function.
pub(crate) fn of(module: &Module, function: &Function, info: &FunctionInfo) -> Uses {
    let name = |variable: Handle<naga::GlobalVariable>| {
        module.global_variables[variable].name.clone().unwrap_or_default()
    };
    let root = |part: Handle<Expression>| match function.expressions[ir::base(function, part)] {
        Expression::GlobalVariable(variable) => name(variable),
        Expression::FunctionArgument(at) => at.to_string(),
        _ => "?".to_owned(),
    };
    let mut uses = Uses::default();
    for (handle, expression) in function.expressions.iter() {
        match expression {
            Expression::GlobalVariable(variable) if info[handle].ref_count > 0 => {
                uses.globals.insert(name(*variable));
            }
            Expression::ImageSample { image, sampler, .. } => {
                uses.sampled.insert((root(*image), root(*sampler)));
            }
            _ => {}
        }
    }
    let mut blocks: Vec<&Block> = vec![&function.body];
    while let Some(block) = blocks.pop() {
        for statement in block {
            blocks.extend(ir::blocks(statement));
            let Statement::Call { function: callee, arguments, .. } = statement else { continue };
            let callee = module.functions[*callee].name.clone().unwrap_or_default();
            uses.calls.insert((callee, arguments.iter().map(|argument| root(*argument)).collect()));
        }
    }
    uses
}
