//! Memory that a function accesses under two names.
//!
//! WGSL forbids calls in which one variable is passed by two pointers, or passed by a pointer and used by name in the
//! callee, if one of the two accesses writes (<https://www.w3.org/TR/WGSL/#alias-analysis>). Browsers reject such a
//! module; naga does not check. Functions are visited callees first. Each gets the set of pointer arguments and module
//! variables that it reads and writes. Variables are taken whole.

use std::collections::HashMap;

use naga::{Block, Expression, Function, GlobalVariable, Handle, LocalVariable, Module, Span, Statement};

use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;

/// The variable or pointer argument that a pointer is derived from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Root {
    Argument(u32),
    Local(Handle<LocalVariable>),
    Global(Handle<GlobalVariable>),
}

/// `true` if a variable or the target of a pointer argument is written, `false` if it is only read.
pub(crate) type Written = bool;

/// The accesses of a function to its pointer arguments and to module-scope variables.
pub(crate) type Uses = HashMap<Root, Written>;

/// Returns the accesses of each function, and rejections of the calls that violate WGSL's aliasing rule.
pub(crate) fn analysis(module: &Module) -> (HashMap<Handle<Function>, Uses>, Vec<Rejection>) {
    let mut known: HashMap<Handle<Function>, Uses> = HashMap::new();
    let mut rejections = Vec::new();
    for (handle, function) in module.functions.iter() {
        let uses =
            Visit { module, function, known: &known, uses: Uses::new(), rejections: &mut rejections }.uses();
        known.insert(handle, uses);
    }
    for entry in &module.entry_points {
        let function = &entry.function;
        Visit { module, function, known: &known, uses: Uses::new(), rejections: &mut rejections }.uses();
    }
    (known, rejections)
}

/// Returns the accesses to pointer arguments as a string, for comparing functions. Accesses to module-scope variables
/// are left out, since modules with pointers to such variables are not validated in parts.
pub(crate) fn digest(uses: &Uses) -> String {
    let of_argument = |(root, is_written): (&Root, &Written)| match root {
        Root::Argument(at) => Some(format!("{at} {is_written}")),
        Root::Local(_) | Root::Global(_) => None,
    };
    let mut all: Vec<String> = uses.iter().filter_map(of_argument).collect();
    all.sort_unstable();
    all.join(", ")
}

struct Visit<'a> {
    module: &'a Module,
    function: &'a Function,
    known: &'a HashMap<Handle<Function>, Uses>,
    uses: Uses,
    rejections: &'a mut Vec<Rejection>,
}

impl Visit<'_> {
    fn uses(mut self) -> Uses {
        let function = self.function;
        for (_, expression) in function.expressions.iter() {
            if let Expression::Load { pointer } = expression {
                self.touch(*pointer, false);
            }
        }
        self.block(&function.body);
        self.uses
    }

    fn touch(&mut self, pointer: Handle<Expression>, is_written: Written) {
        if let Some(root @ (Root::Argument(_) | Root::Global(_))) = self.root(pointer) {
            *self.uses.entry(root).or_default() |= is_written;
        }
    }

    fn block(&mut self, block: &Block) {
        for (statement, span) in block.span_iter() {
            match statement {
                Statement::Store { pointer, .. } | Statement::Atomic { pointer, .. } => {
                    self.touch(*pointer, true);
                }
                Statement::WorkGroupUniformLoad { pointer, .. } => self.touch(*pointer, false),
                Statement::Call { function, arguments, .. } => self.call(*function, arguments, *span),
                _ => ir::blocks(statement).for_each(|inner| self.block(inner)),
            }
        }
    }

    fn call(&mut self, callee: Handle<Function>, arguments: &[Handle<Expression>], span: Span) {
        let Some(uses) = self.known.get(&callee) else { return };
        let callee = self.module.functions[callee].name.as_deref().unwrap_or_default();
        let mut passed: HashMap<Root, (Written, usize)> = HashMap::new();
        for (at, argument) in arguments.iter().enumerate() {
            let Some(root) = self.root(*argument) else { continue };
            let Some(is_written) = uses.get(&Root::Argument(at as u32)).copied() else { continue };
            let name = self.name(root);
            if let Some((other, before)) =
                passed.get(&root).filter(|(other, _)| *other || is_written).copied()
            {
                let writer = if is_written { at } else { before };
                let message = format!(
                    "\"{callee}\" is given \"{name}\" twice, as its arguments {} and {}, and writes to {}",
                    before + 1,
                    at + 1,
                    if other && is_written { "both".to_owned() } else { format!("argument {}", writer + 1) },
                );
                self.reject(message, span, "pass a copy of the value in place of one of the pointers");
            } else if let Root::Global(variable) = root
                && let Some(own) = uses.get(&root)
                && (*own || is_written)
            {
                let message = format!(
                    "\"{callee}\" is given \"{name}\", which it {} by that name too",
                    if *own { "writes to" } else { "reads" },
                );
                let help = "pass no pointer to what the function uses itself, or use the pointer alone in it";
                self.reject(message, span, help);
                let place = self.module.global_variables.get_span(variable).to_range();
                let label = place.map(|range| (range, format!("\"{name}\" is declared here")));
                self.rejections.last_mut().into_iter().for_each(|one| one.labels.extend(label.clone()));
            }
            let entry = passed.entry(root).or_insert((is_written, at));
            entry.0 |= is_written;
            self.touch(*argument, is_written);
        }
        for (root, is_written) in uses {
            if matches!(root, Root::Global(_)) {
                *self.uses.entry(*root).or_default() |= is_written;
            }
        }
    }

    fn reject(&mut self, message: String, span: Span, help: &str) {
        self.rejections.push(Rejection::new(codes::POINTER_ALIAS, message, span).help(help));
    }

    fn name(&self, root: Root) -> String {
        let name = match root {
            Root::Argument(at) => self.function.arguments.get(at as usize).and_then(|each| each.name.clone()),
            Root::Local(variable) => self.function.local_variables[variable].name.clone(),
            Root::Global(variable) => self.module.global_variables[variable].name.clone(),
        };
        name.unwrap_or_default()
    }

    fn root(&self, pointer: Handle<Expression>) -> Option<Root> {
        match self.function.expressions[ir::base(self.function, pointer)] {
            Expression::LocalVariable(variable) => Some(Root::Local(variable)),
            Expression::GlobalVariable(variable) => Some(Root::Global(variable)),
            Expression::FunctionArgument(at) => {
                let ty = self.function.arguments.get(at as usize)?.ty;
                let is_pointer = self.module.types[ty].inner.pointer_space().is_some();
                is_pointer.then_some(Root::Argument(at))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::analysis;

    fn messages(body: &str) -> Vec<String> {
        let text = format!(
            "var<private> own: f32;
             var<private> other: f32;
             fn copy(to: ptr<function, f32>, source: ptr<function, f32>) {{ *to = *source; }}
             fn sum(a: ptr<function, f32>, b: ptr<function, f32>) -> f32 {{ return *a + *b; }}
             fn add(to: ptr<private, f32>) {{ *to += own; }}
             fn through(a: ptr<function, f32>, b: ptr<function, f32>) {{ copy(a, b); }}
             fn same(a: ptr<function, f32>) {{ copy(a, a); }}
             @compute @workgroup_size(1) fn main() {{ var x = 0.0; var y = 1.0; {body} }}"
        )
        .replace("fn same", if body.contains("same") { "fn same" } else { "fn unused" })
        .replace("{ copy(a, a); }", if body.contains("same") { "{ copy(a, a); }" } else { "{}" });
        let module = naga::front::wgsl::parse_str(&text).expect("WGSL");
        analysis(&module).1.into_iter().map(|found| found.message).collect()
    }

    #[test]
    fn two_pointers_to_one_variable_are_found_where_one_is_written() {
        assert_eq!(
            messages("copy(&x, &x);"),
            ["\"copy\" is given \"x\" twice, as its arguments 1 and 2, and writes to argument 1"]
        );
        assert_eq!(messages("let p = &x; through(p, &x);").len(), 1);
        assert_eq!(messages("same(&x);").len(), 1);
        assert_eq!(messages("add(&own);"), ["\"add\" is given \"own\", which it reads by that name too"]);
    }

    #[test]
    fn what_is_only_read_or_is_something_else_passes() {
        for body in ["copy(&x, &y);", "_ = sum(&x, &x);", "add(&other);", "through(&y, &x);"] {
            assert_eq!(messages(body), [] as [String; 0], "{body}");
        }
    }
}
