//! Loops that nothing leaves, and functions that can end without their result.
//!
//! WGSL asks of every statement how control leaves it: to the next statement, by `break`, `continue` or `return`. A
//! `loop` that control does not leave at all is an error when the module is created, and so is a function with a result
//! whose end control can reach. `discard` does not count, since the invocation goes on as a helper. Conditions are not
//! evaluated: `while true` counts as leaving.
//!
//! Source: *WebGPU Shading Language*, "Behaviors".

use naga::{Block, Function, Module, Span, Statement};

use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;

/// The ways in which control flow can leave a statement: WGSL's "behavior".
#[derive(Clone, Copy, Default)]
struct Behavior {
    next: bool,
    breaks: bool,
    continues: bool,
    returns: bool,
}

impl Behavior {
    const NEXT: Self = Self { next: true, breaks: false, continues: false, returns: false };

    fn or(self, other: Self) -> Self {
        Self {
            next: self.next | other.next,
            breaks: self.breaks | other.breaks,
            continues: self.continues | other.continues,
            returns: self.returns | other.returns,
        }
    }
}

/// Returns rejections of loops that control flow cannot leave, and of functions that can end without returning their
/// result. An inner loop comes before an outer one.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    ir::functions(module).flat_map(of_function).collect()
}

fn of_function(function: &Function) -> Vec<Rejection> {
    let mut found = Vec::new();
    let behavior = of_block(&function.body, &mut found);
    if function.result.is_some() && behavior.next && found.is_empty() {
        let name = function.name.as_deref().unwrap_or("the entry point");
        let message = format!("not every way through \"{name}\" ends with a \"return\"");
        let help = "return a value at the end";
        let last = function.body.span_iter().last().map_or(Span::UNDEFINED, |(_, span)| *span);
        found.push(Rejection::new(codes::WGSL_INVALID, message, last).help(help));
    }
    found
}

fn of_block(block: &Block, found: &mut Vec<Rejection>) -> Behavior {
    let mut all = Behavior::NEXT;
    for (statement, span) in block.span_iter() {
        // What is never reached has to be sound, too.
        let behavior = of_statement(statement, *span, found);
        if all.next {
            all = Behavior { next: false, ..all }.or(behavior);
        }
    }
    all
}

fn of_statement(statement: &Statement, span: Span, found: &mut Vec<Rejection>) -> Behavior {
    let mut of_block = |block: &Block| of_block(block, found);
    match statement {
        Statement::Break => Behavior { breaks: true, ..Behavior::default() },
        Statement::Continue => Behavior { continues: true, ..Behavior::default() },
        Statement::Return { .. } => Behavior { returns: true, ..Behavior::default() },
        Statement::Block(inner) => of_block(inner),
        Statement::If { accept, reject, .. } => of_block(accept).or(of_block(reject)),
        Statement::Switch { cases, .. } => {
            // A case that falls through is one more selector of the next.
            let cases = cases.iter().filter(|case| !case.fall_through);
            let all = cases.fold(Behavior::default(), |all, case| all.or(of_block(&case.body)));
            Behavior { next: all.next | all.breaks, breaks: false, ..all }
        }
        Statement::Loop { body, continuing, break_if } => {
            let all = of_block(body).or(of_block(continuing));
            let next = all.breaks | break_if.is_some();
            if !next && !all.returns {
                let help = "leave it by \"break\", \"break if\" or \"return\"";
                found.push(Rejection::new(codes::WGSL_INVALID, "nothing leaves this loop", span).help(help));
            }
            Behavior { next, returns: all.returns, ..Behavior::default() }
        }
        _ => Behavior::NEXT,
    }
}
