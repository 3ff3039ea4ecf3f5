//! The number of texture reads of an entry point: a measure of a shader's cost that depends on no machine.
//!
//! It counts samples, gathers, comparisons and loads on the path with the most of them. Reads in a loop count once per
//! iteration if its condition compares with a constant or an override (counting from 0), else once.
//!
//! Limits: early returns and breaks are not followed; a loop with a data-dependent end, such as the number of lights,
//! counts as one iteration.

use std::collections::HashMap;

use naga::back::PipelineConstants;
use naga::valid::Capabilities;
use naga::{BinaryOperator, Block, Expression, Function, Handle, Literal, Module, ScalarKind, Statement};

use super::compile::ShaderModule;
use crate::module::wgsl;

/// Returns the number of texture reads on the path through an entry point with the most reads; 0 if the entry point
/// does not exist. Loops with an unknown number of iterations count once.
pub fn texture_reads(module: &ShaderModule, entry_point: &str) -> u64 {
    wgsl::with_stack(|| {
        let parsed = wgsl::parse(&module.wgsl).ok()?;
        let info = wgsl::validate(&parsed, Capabilities::all()).ok()?;
        let constants: PipelineConstants =
            module.constants.iter().map(|(name, value)| (name.clone(), *value)).collect();
        let (resolved, _) = wgsl::resolve_overrides(&parsed, &info, &constants).ok()?;
        let entry = resolved.entry_points.iter().find(|entry| entry.name == entry_point)?;
        let mut count = Count { module: &resolved, known: HashMap::new() };
        Some(count.block(&entry.function, &entry.function.body))
    })
    .unwrap_or(0)
}

struct Count<'m> {
    module: &'m Module,
    known: HashMap<Handle<Function>, u64>,
}

impl Count<'_> {
    /// Counts the texture reads of a function, including those of called functions. Recursion terminates, since WGSL
    /// functions cannot call themselves.
    fn function(&mut self, handle: Handle<Function>) -> u64 {
        if let Some(known) = self.known.get(&handle) {
            return *known;
        }
        let module = self.module;
        let function = &module.functions[handle];
        let reads = self.block(function, &function.body);
        self.known.insert(handle, reads);
        reads
    }

    fn block(&mut self, function: &Function, block: &Block) -> u64 {
        block.iter().map(|statement| self.statement(function, statement)).fold(0, u64::saturating_add)
    }

    fn statement(&mut self, function: &Function, statement: &Statement) -> u64 {
        match statement {
            Statement::Emit(range) => {
                let is_read = |handle: &Handle<Expression>| {
                    let expression = &function.expressions[*handle];
                    matches!(expression, Expression::ImageSample { .. } | Expression::ImageLoad { .. })
                };
                range.clone().filter(is_read).count() as u64
            }
            Statement::Call { function: callee, .. } => self.function(*callee),
            Statement::Block(block) => self.block(function, block),
            Statement::If { accept, reject, .. } => {
                self.block(function, accept).max(self.block(function, reject))
            }
            Statement::Switch { cases, .. } => {
                cases.iter().map(|case| self.block(function, &case.body)).max().unwrap_or(0)
            }
            Statement::Loop { body, continuing, .. } => {
                let round = self.block(function, body).saturating_add(self.block(function, continuing));
                round.saturating_mul(self.rounds(function, body).unwrap_or(1))
            }
            _ => 0,
        }
    }

    /// The number of iterations of a loop that ends when a counter reaches a constant; `None` if unknown.
    fn rounds(&self, function: &Function, body: &Block) -> Option<u64> {
        body.iter().find_map(|statement| match statement {
            Statement::If { condition, reject, .. }
                if matches!(reject.iter().next(), Some(Statement::Break)) =>
            {
                self.end(function, *condition)
            }
            _ => None,
        })
    }

    fn end(&self, function: &Function, condition: Handle<Expression>) -> Option<u64> {
        let Expression::Binary { op, right, .. } = function.expressions[condition] else { return None };
        let end = self.constant(function, right)?;
        match op {
            BinaryOperator::Less | BinaryOperator::NotEqual => Some(end),
            BinaryOperator::LessEqual => Some(end.saturating_add(1)),
            _ => None,
        }
    }

    fn constant(&self, function: &Function, handle: Handle<Expression>) -> Option<u64> {
        let literal = match &function.expressions[handle] {
            Expression::Literal(literal) => *literal,
            Expression::Constant(constant) => {
                match self.module.global_expressions[self.module.constants[*constant].init] {
                    Expression::Literal(literal) => literal,
                    _ => return None,
                }
            }
            Expression::As { expr, kind: ScalarKind::Uint | ScalarKind::Sint, .. } => {
                return self.constant(function, *expr);
            }
            Expression::Binary { op: BinaryOperator::Multiply, left, right } => {
                return self.constant(function, *left)?.checked_mul(self.constant(function, *right)?);
            }
            _ => return None,
        };
        match literal {
            Literal::U32(value) => Some(value.into()),
            Literal::I32(value) => value.try_into().ok(),
            Literal::F32(value) => Some(value as u64),
            Literal::AbstractInt(value) => value.try_into().ok(),
            _ => None,
        }
    }
}
