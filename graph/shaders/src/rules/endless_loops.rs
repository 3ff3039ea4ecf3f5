//! Loops that nothing leaves.
//!
//! WGSL asks of every statement that control can go on behind it, or leave the function: a `loop` without `break`,
//! `break if` or `return` is an error when the module is created. `discard` does not count, since the invocation goes on as a
//! helper. Conditions are not evaluated: `while true` counts as leaving.
//!
//! Source: *WebGPU Shading Language*, "Behaviors".

use naga::{Block, Module, Statement};

use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;

/// The loops of a module that nothing leaves, the innermost of nested ones first.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    let functions = module.functions.iter().map(|(_, function)| &function.body);
    let bodies = functions.chain(module.entry_points.iter().map(|entry| &entry.function.body));
    let mut found = Vec::new();
    bodies.for_each(|body| visit(body, &mut found));
    found
}

fn visit(block: &Block, found: &mut Vec<Rejection>) {
    for (statement, span) in block.span_iter() {
        ir::blocks(statement).for_each(|inner| visit(inner, found));
        if let Statement::Loop { body, continuing, break_if } = statement
            && break_if.is_none()
            && !leaves(body, true)
            && !leaves(continuing, true)
        {
            let help = "leave it by \"break\", \"break if\" or \"return\"";
            found.push(Rejection::new(codes::WGSL_INVALID, "nothing leaves this loop", *span).help(help));
        }
    }
}

/// Whether a block holds a `return`, or a `break` of the loop or switch that it is the body of.
fn leaves(block: &Block, breaks: bool) -> bool {
    block.iter().any(|statement| match statement {
        Statement::Return { .. } => true,
        Statement::Break => breaks,
        _ => {
            let own = breaks && !matches!(statement, Statement::Loop { .. } | Statement::Switch { .. });
            ir::blocks(statement).any(|inner| leaves(inner, own))
        }
    })
}
