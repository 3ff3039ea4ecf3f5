//! Branches of fragment stages that uniforms alone decide.
//!
//! Some drivers (Mesa's among them) compile a fragment shader once more for each value of a uniform that decides a branch,
//! so that a shader with `if material.receives` is compiled for each material: seconds before the first frame. A factor in
//! place of the branch, an override, or a condition in which something of the fragment takes part costs nothing like it.
//!
//! Each expression of the fragment entry point and of its callees gets the set of its dependencies: uniform buffers, or
//! anything else that differs between invocations or that a driver cannot know when it compiles (inputs, storage,
//! textures). Constants and overrides are neither. A variable depends on every value stored in it and on the conditions
//! of the branches and loops around the stores; an argument depends on what any caller passes. The sets grow to a fixed
//! point. A condition that depends on uniforms alone is reported.
//!
//! Limits: control flow after early returns is not followed; a write through a pointer counts as anything else.

use std::collections::{BTreeMap, HashMap};

use naga::{
    AddressSpace, Block, Expression, Function, Handle, LocalVariable, Module, ShaderStage, Span, Statement,
};

use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;

/// The dependencies of a value, as bits.
type Sources = u8;

const UNIFORM: Sources = 1;
const OTHER: Sources = 2;

/// The dependencies inside a function, joined over all of its callers.
#[derive(Clone, Debug, Default, PartialEq)]
struct Known {
    arguments: Vec<Sources>,
    locals: HashMap<Handle<LocalVariable>, Sources>,
    result: Sources,
    reached: bool,
}

/// The conditions of fragment stages that uniforms alone decide.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    let mut places: BTreeMap<usize, Span> = BTreeMap::new();
    for entry in module.entry_points.iter().filter(|entry| entry.stage == ShaderStage::Fragment) {
        let mut known: HashMap<Handle<Function>, Known> = module
            .functions
            .iter()
            .map(|(handle, function)| {
                (handle, Known { arguments: vec![0; function.arguments.len()], ..Known::default() })
            })
            .collect();
        let mut own = Known { arguments: vec![OTHER; entry.function.arguments.len()], ..Known::default() };
        let conditions = loop {
            let before = (known.clone(), own.clone());
            let mut conditions = Visit::new(module, &entry.function, &mut own, &mut known).conditions();
            for (handle, function) in module.functions.iter() {
                let Some(mut one) = known.get(&handle).filter(|one| one.reached).cloned() else { continue };
                conditions.extend(Visit::new(module, function, &mut one, &mut known).conditions());
                known.insert(handle, one);
            }
            if before == (known.clone(), own.clone()) {
                break conditions;
            }
        };
        for (sources, span) in conditions {
            if sources == UNIFORM {
                places.insert(span.to_range().map_or(0, |range| range.start), span);
            }
        }
    }
    let rejection = |span| {
        let message = "uniforms alone decide this branch of a fragment stage";
        let help = "multiply with the value instead, or make it an override: drivers compile the shader once more for \
                    each value of such a uniform";
        Rejection::new(codes::UNIFORM_BRANCH, message, span).help(help)
    };
    places.into_values().map(rejection).collect()
}

/// A walk through one function.
struct Visit<'a> {
    module: &'a Module,
    function: &'a Function,
    own: &'a mut Known,
    known: &'a mut HashMap<Handle<Function>, Known>,
    /// The dependencies of each expression.
    sources: Vec<Sources>,
    conditions: Vec<(Sources, Span)>,
}

impl<'a> Visit<'a> {
    fn new(
        module: &'a Module,
        function: &'a Function,
        own: &'a mut Known,
        known: &'a mut HashMap<Handle<Function>, Known>,
    ) -> Self {
        let sources = vec![0; function.expressions.len()];
        Self { module, function, own, known, sources, conditions: Vec::new() }
    }

    /// Every condition, with what it depends on.
    fn conditions(mut self) -> Vec<(Sources, Span)> {
        self.expressions();
        self.block(&self.function.body, 0);
        self.conditions
    }

    fn of(&self, expression: Handle<Expression>) -> Sources {
        self.sources.get(expression.index()).copied().unwrap_or(OTHER)
    }

    fn of_all(&self, expressions: impl IntoIterator<Item = Handle<Expression>>) -> Sources {
        expressions.into_iter().fold(0, |all, one| all | self.of(one))
    }

    /// Expressions stand after those that they are made of.
    fn expressions(&mut self) {
        for (handle, expression) in self.function.expressions.iter() {
            let sources = match expression {
                Expression::CallResult(callee) => self.known.get(callee).map_or(OTHER, |known| known.result),
                Expression::FunctionArgument(at) => {
                    self.own.arguments.get(*at as usize).copied().unwrap_or(OTHER)
                }
                Expression::GlobalVariable(variable) => match self.module.global_variables[*variable].space {
                    AddressSpace::Uniform => UNIFORM,
                    _ => OTHER,
                },
                Expression::LocalVariable(variable) => {
                    let initial = self.function.local_variables[*variable].init;
                    self.own.locals.get(variable).copied().unwrap_or(0)
                        | initial.map_or(0, |initial| self.of(initial))
                }
                Expression::AtomicResult { .. } | Expression::WorkGroupUniformLoadResult { .. } => OTHER,
                _ => ir::operands(expression).map_or(OTHER, |all| self.of_all(all)),
            };
            self.sources[handle.index()] = sources;
        }
    }

    /// Follows the statements of a block that runs, or not, depending on `around`.
    fn block(&mut self, block: &Block, around: Sources) {
        for statement in block {
            let mut within = around | ir::condition(statement).map_or(0, |each| self.condition(each));
            if matches!(statement, Statement::Loop { .. }) {
                // How often the body runs depends on every condition in it.
                within |= self.deciding(statement);
            }
            ir::blocks(statement).for_each(|inner| self.block(inner, within));
            match statement {
                Statement::Store { pointer, value } => self.store(*pointer, self.of(*value) | around),
                Statement::Return { value: Some(value) } => self.own.result |= self.of(*value) | around,
                Statement::Call { function, arguments, .. } => {
                    let passed: Vec<Sources> = arguments.iter().map(|one| self.of(*one)).collect();
                    for argument in arguments {
                        self.store(*argument, OTHER);
                    }
                    if let Some(callee) = self.known.get_mut(function) {
                        callee.reached = true;
                        callee
                            .arguments
                            .iter_mut()
                            .zip(passed)
                            .for_each(|(known, sources)| *known |= sources);
                    }
                }
                _ => {}
            }
        }
    }

    fn condition(&mut self, condition: Handle<Expression>) -> Sources {
        let sources = self.of(condition);
        self.conditions.push((sources, self.function.expressions.get_span(condition)));
        sources
    }

    /// The joined dependencies of all conditions within a statement.
    fn deciding(&self, statement: &Statement) -> Sources {
        let own = self.of_all(ir::condition(statement));
        ir::blocks(statement).flatten().fold(own, |all, inner| all | self.deciding(inner))
    }

    /// Adds to the dependencies of the variable behind a pointer. Pointers to anything else are ignored.
    fn store(&mut self, pointer: Handle<Expression>, sources: Sources) {
        let variable = ir::base(self.function, pointer);
        if let Expression::LocalVariable(variable) = self.function.expressions[variable] {
            *self.own.locals.entry(variable).or_default() |= sources;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::found;

    fn conditions(body: &str) -> usize {
        let text = format!(
            "struct Block {{ flag: u32, count: u32, numbers: array<vec4<u32>, 4> }}
             @group(0) @binding(0) var<uniform> block: Block;
             @group(0) @binding(1) var<storage, read> list: array<u32>;
             override chosen: bool = true;
             fn twice(value: u32) -> u32 {{ return value * 2u; }}
             fn decide(value: u32) -> f32 {{ if value > 1u {{ return 1.0; }} return 0.0; }}
             @fragment fn shade(@location(0) @interpolate(flat) input: u32) -> @location(0) vec4<f32> {{
                 var sum = 0.0;
                 {body}
                 return vec4<f32>(sum);
             }}"
        );
        found(&naga::front::wgsl::parse_str(&text).expect("WGSL")).len()
    }

    #[test]
    fn conditions_on_uniforms_alone_are_found() {
        for body in [
            "if block.flag != 0u { sum = 1.0; }",
            "if (block.flag & block.count) != 0u && chosen { sum = 1.0; }",
            "switch block.flag { case 1u: { sum = 1.0; } default: {} }",
            "for (var at = 0u; at < block.count; at++) { sum += 1.0; }",
            "let flag = twice(block.flag); if flag > 3u { sum = 1.0; }",
            "sum = decide(block.flag);",
            "var flag = 1u; if chosen { flag = block.numbers[1].x; } if flag > 0u { sum = 1.0; }",
        ] {
            assert_eq!(conditions(body), 1, "{body}");
        }
    }

    #[test]
    fn conditions_in_which_something_else_takes_part_are_not() {
        for body in [
            "if input != 0u { sum = 1.0; }",
            "if chosen { sum = 1.0; }",
            "if block.flag + input != 0u { sum = 1.0; }",
            "if block.numbers[input].x != 0u { sum = 1.0; }",
            "if list[0] != 0u { sum = 1.0; }",
            "for (var at = 0u; at < 4u; at++) { sum += 1.0; }",
            "for (var at = 0u; at < min(block.count, input); at++) { if block.numbers[at].x > 1u { sum += 1.0; } }",
            "sum = decide(block.flag) + decide(input);",
            "var flag = block.flag; if input > 2u { flag = 3u; } if flag > 1u { sum = 1.0; }",
            "sum = select(0.0, 1.0, block.flag != 0u);",
        ] {
            assert_eq!(conditions(body), 0, "{body}");
        }
    }

    #[test]
    fn other_stages_are_left_alone() {
        let text = "@group(0) @binding(0) var<uniform> flag: u32;
            @group(0) @binding(1) var<storage, read_write> out: u32;
            @compute @workgroup_size(1) fn main() { if flag != 0u { out = 1u; } }";
        assert!(found(&naga::front::wgsl::parse_str(text).expect("WGSL")).is_empty());
    }
}
