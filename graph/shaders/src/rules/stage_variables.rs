//! Variables and inputs that an entry point cannot have in its stage.
//!
//! Workgroup memory belongs to compute stages, a vertex stage writes no storage, and a compute stage has built-in
//! inputs alone and no result. WGSL counts every mention in the functions that an entry point reaches, whether it is
//! evaluated or not; naga does not look.
//!
//! Source: *WebGPU Shading Language*, "Address Spaces" and "Resource interface of a shader".

use std::collections::HashMap;

use naga::{
    AddressSpace, Binding, Expression, Function, GlobalVariable, Handle, ImageClass, Module, ShaderStage,
    Span, Statement, StorageAccess, TypeInner,
};

use crate::codes;
use crate::written::ir;
use crate::written::rejection::{Rejection, Scope};

/// The first workgroup variable, and the first writable storage buffer or texture, that a function or its callees
/// mention. Each is `None` if there is none.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Mentions {
    workgroup: Option<Handle<GlobalVariable>>,
    writable: Option<Handle<GlobalVariable>>,
}

impl Mentions {
    /// Returns a string that states whether a workgroup variable and a writable variable are mentioned, for comparing
    /// functions.
    pub(crate) fn digest(self) -> String {
        format!("{} {}", self.workgroup.is_some(), self.writable.is_some())
    }
}

/// Returns, for each function of a module, the workgroup and writable variables that it or its callees mention.
pub(crate) fn analysis(module: &Module) -> HashMap<Handle<Function>, Mentions> {
    let mut known = HashMap::new();
    for (handle, function) in module.functions.iter() {
        let mentions = of(module, function, &known);
        known.insert(handle, mentions);
    }
    known
}

/// Returns rejections of entry points with variables or inputs that their stage does not allow.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    let known = analysis(module);
    let mut found = Vec::new();
    for entry in &module.entry_points {
        let name = &entry.name;
        let mentions = of(module, &entry.function, &known);
        let mut reject = |message: String, place: Span, help: &str| {
            let scope = Scope::EntryPoint(name.clone());
            found.push(Rejection::new(codes::WGSL_INVALID, message, place).help(help).of(scope));
        };
        let stage = match entry.stage {
            ShaderStage::Vertex => "a vertex stage",
            ShaderStage::Fragment => "a fragment stage",
            _ => "a compute stage",
        };
        let variable = |handle: Handle<GlobalVariable>| {
            let variable = &module.global_variables[handle];
            (variable.name.as_deref().unwrap_or_default(), module.global_variables.get_span(handle))
        };
        if let (ShaderStage::Vertex | ShaderStage::Fragment, Some(workgroup)) =
            (entry.stage, mentions.workgroup)
        {
            let (variable, place) = variable(workgroup);
            let message = format!("\"{name}\", {stage}, uses \"{variable}\", which is memory of a workgroup");
            reject(message, place, "only compute stages have workgroups: use a private variable");
        }
        if let (ShaderStage::Vertex, Some(writable)) = (entry.stage, mentions.writable) {
            let (variable, place) = variable(writable);
            let message = format!("\"{name}\", {stage}, uses \"{variable}\", which can be written");
            reject(message, place, "declare it with the access \"read\", or use it in another stage");
        }
        if entry.stage == ShaderStage::Compute {
            let inputs = ir::inputs(module, &entry.function);
            let located = inputs.iter().find(|input| matches!(input.binding, Binding::Location { .. }));
            if let Some(input) = located {
                let message =
                    format!("\"{name}\", {stage}, has the input \"{}\" with a location", input.name);
                let place = input.owner.map_or(Span::UNDEFINED, |owner| module.types.get_span(owner));
                reject(message, place, "a compute stage takes built-in values alone: read a buffer");
            }
            if let Some(result) = &entry.function.result {
                let message = format!("\"{name}\", {stage}, returns a value");
                let place = module.types.get_span(result.ty);
                reject(message, place, "a compute stage has no outputs: write the value to a buffer");
            }
        }
    }
    found
}

fn of(module: &Module, function: &Function, known: &HashMap<Handle<Function>, Mentions>) -> Mentions {
    let mut mentions = Mentions::default();
    for (_, expression) in function.expressions.iter() {
        let Expression::GlobalVariable(handle) = *expression else { continue };
        let variable = &module.global_variables[handle];
        match variable.space {
            AddressSpace::WorkGroup => drop(mentions.workgroup.get_or_insert(handle)),
            AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => {
                mentions.writable.get_or_insert(handle);
            }
            AddressSpace::Handle => {
                if let TypeInner::Image { class: ImageClass::Storage { access, .. }, .. } =
                    module.types[variable.ty].inner
                    && access.contains(StorageAccess::STORE)
                {
                    mentions.writable.get_or_insert(handle);
                }
            }
            _ => {}
        }
    }
    let mut blocks = vec![&function.body];
    while let Some(block) = blocks.pop() {
        for statement in block {
            blocks.extend(ir::blocks(statement));
            let Statement::Call { function, .. } = statement else { continue };
            let Some(of_callee) = known.get(function) else { continue };
            mentions.workgroup = mentions.workgroup.or(of_callee.workgroup);
            mentions.writable = mentions.writable.or(of_callee.writable);
        }
    }
    mentions
}
