//! Branches of fragment stages that uniforms alone decide.
//!
//! Some drivers (Mesa's among them) compile a fragment shader once more for each value of a uniform that decides a
//! branch, so that a shader with `if material.receives` is compiled for each material: seconds before the first frame.
//! A factor in place of the branch, an override, or a condition in which something of the fragment takes part costs
//! nothing like it.
//!
//! Each expression of a function gets the set of its dependencies: uniform buffers, or anything else that differs
//! between invocations or that a driver cannot know when it compiles (inputs, storage, textures). Constants and
//! overrides are neither. A variable depends on every value stored in it and on the conditions of the branches and
//! loops around the stores. Arguments, and results of calls, are left open: a function is looked at once ([`of`]), and
//! what its callers pass is known where functions come together ([`decided`]). An argument depends on what any caller
//! passes. The sets grow to a fixed point. A condition that depends on uniforms alone is reported.
//!
//! Limits: control flow after early returns is not followed; a write through a pointer counts as anything else.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::ops::Range;

use naga::{
    AddressSpace, Block, Expression, Function, Handle, LocalVariable, Module, ShaderStage, Statement,
};

use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;

/// A bit set of sources that a value depends on: [`UNIFORM`] and [`OTHER`].
type Sources = u8;

const UNIFORM: Sources = 1;
const OTHER: Sources = 2;

/// A dependency on a value that only other functions determine: an argument, or the result of a call.
#[derive(Clone, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
enum Open {
    Argument(u32),
    /// The result of a call of the function with this name.
    Result(String),
}

/// The sources that a value depends on: uniforms, other sources, and results that only other functions determine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
struct Dependencies {
    known: Sources,
    /// A bit set of dependencies on other functions: indices into [`Branches::open`].
    open: u64,
}

impl Dependencies {
    fn known(known: Sources) -> Self {
        Self { known, open: 0 }
    }

    fn add(&mut self, other: Self) {
        *self = self.and(other);
    }

    fn and(self, other: Self) -> Self {
        Self { known: self.known | other.known, open: self.open | other.open }
    }
}

/// The branch conditions of a function, and the dependencies of its result and of the arguments that it passes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub(crate) struct Branches {
    /// The dependencies on other functions, indexed by the bits of `Dependencies::open`.
    open: Vec<Open>,
    /// The branch conditions: the dependencies and the byte range in the WGSL of each.
    conditions: Vec<(Dependencies, Range<usize>)>,
    calls: Vec<(String, Vec<Dependencies>)>,
    result: Dependencies,
    arguments: usize,
    /// Whether the function is a fragment entry point.
    is_fragment: bool,
}

impl Branches {
    /// Returns `true` if the function has no branch conditions, no calls and a result without dependencies.
    pub(crate) fn is_empty(&self) -> bool {
        self.conditions.is_empty() && self.calls.is_empty() && self.result == Dependencies::default()
    }

    /// Makes the byte ranges of the conditions relative to byte `offset` of the WGSL.
    pub(crate) fn counted_from(&mut self, offset: usize) {
        for (_, range) in &mut self.conditions {
            *range = range.start.saturating_sub(offset)..range.end.saturating_sub(offset);
        }
    }

    pub(crate) fn place(&self, condition: usize) -> Range<usize> {
        self.conditions.get(condition).map(|(_, range)| range.clone()).unwrap_or_default()
    }
}

/// Analyzes the branches of a function. `stage` is the stage of an entry point, and `None` for other functions.
pub(crate) fn of(module: &Module, function: &Function, stage: Option<ShaderStage>) -> Branches {
    let branches = Branches {
        arguments: function.arguments.len(),
        is_fragment: stage == Some(ShaderStage::Fragment),
        ..Branches::default()
    };
    let is_entry = stage.is_some();
    let mut visit =
        Visit { module, function, is_entry, locals: HashMap::new(), values: Vec::new(), branches };
    loop {
        let before = (visit.locals.clone(), visit.branches.result);
        visit.values.clear();
        visit.branches.conditions.clear();
        visit.branches.calls.clear();
        visit.expressions();
        visit.block(&function.body, Dependencies::default());
        if before == (visit.locals.clone(), visit.branches.result) {
            return visit.branches;
        }
    }
}

/// Returns the branch conditions in fragment stages that depend only on uniforms. Each is given by the index of its
/// function in `functions`, and its index in the function.
pub(crate) fn decided(functions: &[(&str, &Branches)]) -> BTreeSet<(usize, usize)> {
    let by_name: HashMap<&str, usize> =
        functions.iter().enumerate().map(|(at, (name, _))| (*name, at)).collect();
    let results = |branches: &Branches| -> Vec<Option<usize>> {
        let result = |open: &Open| match open {
            Open::Argument(_) => None,
            Open::Result(callee) => by_name.get(callee.as_str()).copied(),
        };
        branches.open.iter().map(result).collect()
    };
    let results: Vec<Vec<Option<usize>>> = functions.iter().map(|(_, branches)| results(branches)).collect();
    let callees: Vec<Vec<Option<usize>>> = functions
        .iter()
        .map(|(_, each)| each.calls.iter().map(|(callee, _)| by_name.get(callee.as_str()).copied()).collect())
        .collect();
    // Of the conditions that begin at one place the last is the whole.
    let mut found: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for entry in (0..functions.len()).filter(|at| functions[*at].1.is_fragment) {
        // Of each function that is reached: what its arguments and its result depend on.
        let mut reached: Vec<Option<Reached>> = vec![None; functions.len()];
        reached[entry] = Some(Reached::default());
        let mut open = vec![entry];
        let value = |of: Dependencies, at: usize, reached: &[Option<Reached>]| {
            let known = reached[at].as_ref();
            let mut all = of.known;
            let mut bits = of.open;
            while bits != 0 {
                let bit = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                all |= match (functions[at].1.open.get(bit), results[at].get(bit)) {
                    (Some(Open::Argument(argument)), _) => known
                        .and_then(|known| known.arguments.get(*argument as usize).copied())
                        .unwrap_or(OTHER),
                    (_, Some(Some(callee))) => reached[*callee].as_ref().map_or(0, |callee| callee.result),
                    _ => 0,
                };
            }
            all
        };
        while let Some(at) = open.pop() {
            let branches = functions[at].1;
            for ((_, passed), callee) in branches.calls.iter().zip(&callees[at]) {
                let Some(callee) = *callee else { continue };
                let passed: Vec<Sources> = passed.iter().map(|one| value(*one, at, &reached)).collect();
                let is_new = reached[callee].is_none();
                let of_callee = reached[callee].get_or_insert_with(|| Reached {
                    arguments: vec![0; functions[callee].1.arguments],
                    ..Reached::default()
                });
                if !of_callee.callers.contains(&at) {
                    of_callee.callers.push(at);
                }
                let before = of_callee.arguments.clone();
                of_callee.arguments.iter_mut().zip(passed).for_each(|(known, passed)| *known |= passed);
                if is_new || before != of_callee.arguments {
                    open.push(callee);
                }
            }
            let result = value(branches.result, at, &reached);
            let Some(own) = &mut reached[at] else { continue };
            if own.result | result != own.result {
                own.result |= result;
                open.extend(&own.callers);
            }
        }
        for (at, (_, branches)) in functions.iter().enumerate().filter(|(at, _)| reached[*at].is_some()) {
            for (number, (condition, place)) in branches.conditions.iter().enumerate() {
                if value(*condition, at, &reached) == UNIFORM {
                    let last = found.entry((at, place.start)).or_default();
                    *last = (*last).max(number);
                }
            }
        }
    }
    found.into_iter().map(|((at, _), number)| (at, number)).collect()
}

/// The sources on which the arguments and the result of a function depend, in the calls that one entry point reaches.
#[derive(Clone, Debug, Default)]
struct Reached {
    arguments: Vec<Sources>,
    result: Sources,
    callers: Vec<usize>,
}

/// Returns warnings about the branch conditions in fragment stages that depend only on uniforms.
pub(crate) fn found(functions: &[(&str, &Branches)]) -> Vec<Rejection> {
    let mut places: Vec<Range<usize>> =
        decided(functions).into_iter().map(|(at, number)| functions[at].1.place(number)).collect();
    places.sort_by_key(|range| range.start);
    places.into_iter().map(advice).collect()
}

/// The warning about a branch condition that depends only on uniforms, at a byte range of the WGSL.
pub(crate) fn advice(place: Range<usize>) -> Rejection {
    let message = "uniforms alone decide this branch of a fragment stage";
    let help = "multiply with the value instead, or make it an override: drivers compile the shader once more for \
                each value of such a uniform";
    Rejection::new(codes::UNIFORM_BRANCH, message, place.into()).help(help)
}

/// The state of analyzing one function.
struct Visit<'a> {
    module: &'a Module,
    function: &'a Function,
    is_entry: bool,
    locals: HashMap<Handle<LocalVariable>, Dependencies>,
    /// The dependencies of each expression, indexed by its handle.
    values: Vec<Dependencies>,
    branches: Branches,
}

impl Visit<'_> {
    fn of(&self, expression: Handle<Expression>) -> Dependencies {
        self.values.get(expression.index()).copied().unwrap_or(Dependencies::known(OTHER))
    }

    fn of_all(&self, expressions: impl IntoIterator<Item = Handle<Expression>>) -> Dependencies {
        expressions.into_iter().fold(Dependencies::default(), |all, one| all.and(self.of(one)))
    }

    /// Returns the dependency on an argument or on the result of a call. Only 64 of these per function fit into the bit
    /// set; any further one counts as [`OTHER`].
    fn open(&mut self, open: Open) -> Dependencies {
        let all = &mut self.branches.open;
        let at = all.iter().position(|known| *known == open).unwrap_or_else(|| {
            all.push(open);
            all.len() - 1
        });
        let bit = 1_u64.checked_shl(at as u32);
        bit.map_or(Dependencies::known(OTHER), |open| Dependencies { known: 0, open })
    }

    /// Computes the dependencies of all expressions in order; operands precede the expressions that use them.
    fn expressions(&mut self) {
        for (_, expression) in self.function.expressions.iter() {
            let value = match expression {
                Expression::CallResult(callee) => {
                    let callee = self.name(*callee);
                    self.open(Open::Result(callee))
                }
                Expression::FunctionArgument(_) if self.is_entry => Dependencies::known(OTHER),
                Expression::FunctionArgument(at) => self.open(Open::Argument(*at)),
                Expression::GlobalVariable(variable) => {
                    let is_uniform = self.module.global_variables[*variable].space == AddressSpace::Uniform;
                    Dependencies::known(if is_uniform { UNIFORM } else { OTHER })
                }
                Expression::LocalVariable(variable) => {
                    let initial = self.function.local_variables[*variable].init;
                    let stored = self.locals.get(variable).copied().unwrap_or_default();
                    stored.and(self.of_all(initial))
                }
                Expression::AtomicResult { .. } | Expression::WorkGroupUniformLoadResult { .. } => {
                    Dependencies::known(OTHER)
                }
                _ => match ir::operands(expression) {
                    Some(all) => self.of_all(all),
                    None => Dependencies::known(OTHER),
                },
            };
            self.values.push(value);
        }
    }

    fn name(&self, callee: Handle<Function>) -> String {
        self.module.functions[callee].name.clone().unwrap_or_default()
    }

    /// Analyzes the statements of a block. `around` holds the dependencies of the conditions that enclose the block.
    fn block(&mut self, block: &Block, around: Dependencies) {
        for statement in block {
            let mut within = around;
            if let Some(condition) = ir::condition(statement) {
                let value = self.of(condition);
                within.add(value);
                let place = self.function.expressions.get_span(condition).to_range();
                self.branches.conditions.push((value, place.unwrap_or_default()));
            }
            if matches!(statement, Statement::Loop { .. }) {
                // How often the body runs depends on every condition in it.
                within.add(self.deciding(statement));
            }
            ir::blocks(statement).for_each(|inner| self.block(inner, within));
            match statement {
                Statement::Store { pointer, value } => {
                    let value = self.of(*value).and(around);
                    self.store(*pointer, value);
                }
                Statement::Return { value: Some(value) } => {
                    let value = self.of(*value).and(around);
                    self.branches.result.add(value);
                }
                Statement::Call { function, arguments, .. } => {
                    let passed = arguments.iter().map(|one| self.of(*one)).collect();
                    for argument in arguments {
                        self.store(*argument, Dependencies::known(OTHER));
                    }
                    let callee = self.name(*function);
                    self.branches.calls.push((callee, passed));
                }
                _ => {}
            }
        }
    }

    /// The combined dependencies of all branch and loop conditions within a statement.
    fn deciding(&self, statement: &Statement) -> Dependencies {
        let own = self.of_all(ir::condition(statement));
        ir::blocks(statement).flatten().fold(own, |all, inner| all.and(self.deciding(inner)))
    }

    /// Adds dependencies to the local variable that a pointer refers to. Pointers to other memory are ignored.
    fn store(&mut self, pointer: Handle<Expression>, value: Dependencies) {
        let variable = ir::base(self.function, pointer);
        if let Expression::LocalVariable(variable) = self.function.expressions[variable] {
            self.locals.entry(variable).or_default().add(value);
        }
    }
}

#[cfg(test)]
mod tests {

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
        found(&text)
    }

    fn found(text: &str) -> usize {
        let module = naga::front::wgsl::parse_str(text).expect("WGSL");
        let functions = module.functions.iter().map(|(_, each)| (each, None));
        let entries = module.entry_points.iter().map(|each| (&each.function, Some(each.stage)));
        let name = |each: &naga::Function, entry: Option<_>| match entry {
            Some(_) => "the entry point".to_owned(),
            None => each.name.clone().unwrap_or_default(),
        };
        let all: Vec<_> = functions
            .chain(entries)
            .map(|(each, stage)| (name(each, stage), super::of(&module, each, stage)))
            .collect();
        let all: Vec<_> = all.iter().map(|(name, branches)| (name.as_str(), branches)).collect();
        super::found(&all).len()
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
        assert_eq!(found(text), 0);
    }
}
