//! Counts the operations of one function.

use std::collections::HashMap;
use std::ops::Range;

use naga::valid::{FunctionInfo, ModuleInfo};
use naga::{
    AddressSpace, ArraySize, BinaryOperator, Block, Expression, Function, Handle, MathFunction, Module,
    Statement, TypeInner,
};

use super::live::Lives;
use super::trips::{self, Known};
use super::{Call, Operations, Spent, UNKNOWN_TRIPS};
use crate::written::ir;

/// Counts the operations of a validated function, without those of the functions that it calls.
pub(crate) fn of(module: &Module, function: &Function, info: &FunctionInfo) -> Spent<String> {
    let mut walk = Walk::new(module, function, info);
    walk.block(&function.body, 1);
    walk.finish()
}

/// Returns byte ranges of a module's WGSL, each with its cost in scalar operations, for one entry point and the
/// functions that it calls. A range can occur several times.
pub(crate) fn lines(module: &Module, info: &ModuleInfo, entry_point: &str) -> Vec<(Range<usize>, u64)> {
    let entries = module.entry_points.iter().enumerate().filter(|(_, entry)| entry.name == entry_point);
    let mut open: Vec<(&Function, &FunctionInfo, u64)> =
        entries.map(|(at, entry)| (&entry.function, info.get_entry_point(at), 1)).collect();
    // A function stands behind those that it calls, so callers are done before.
    let mut times: HashMap<&str, u64> = HashMap::new();
    let mut handles: Vec<_> = module.functions.iter().collect();
    let mut found = Vec::new();
    loop {
        for (function, info, often) in std::mem::take(&mut open) {
            let mut walk = Walk::new(module, function, info);
            walk.block(&function.body, often);
            found.append(&mut walk.places);
            for (callee, often) in walk.calls.iter().map(|(call, _)| (call.callee, call.times)) {
                let known = times.entry(callee).or_default();
                *known = known.saturating_add(often);
            }
        }
        let Some((handle, function)) = handles.pop() else { return found };
        let name = function.name.as_deref().unwrap_or_default();
        open.extend(times.get(name).map(|often| (function, &info[handle], *often)));
    }
}

struct Walk<'m> {
    module: &'m Module,
    function: &'m Function,
    info: &'m FunctionInfo,
    operations: Operations,
    /// The calls, each with the time at which it happens, as counted by [`Lives`].
    calls: Vec<(Call<&'m str>, usize)>,
    known: Known,
    lives: Lives,
    /// The costs of byte ranges of the WGSL in scalar operations.
    places: Vec<(Range<usize>, u64)>,
}

impl<'m> Walk<'m> {
    fn new(module: &'m Module, function: &'m Function, info: &'m FunctionInfo) -> Self {
        let mut walk = Self {
            module,
            function,
            info,
            operations: Operations::default(),
            calls: Vec::new(),
            known: Known::new(),
            lives: Lives::default(),
            places: Vec::new(),
        };
        for (handle, expression) in function.expressions.iter() {
            if matches!(expression, Expression::FunctionArgument(_)) {
                walk.lives.make(handle, walk.scalars(handle));
            }
        }
        for (variable, _) in function.local_variables.iter() {
            walk.known.insert(variable, trips::initial(module, function, variable));
        }
        walk
    }

    fn finish(self) -> Spent<String> {
        let locals = self.function.local_variables.iter();
        let locals: u64 =
            locals.map(|(_, each)| scalars_of(self.module, &self.module.types[each.ty].inner)).sum();
        let alive = self.lives.alive();
        let registers = locals + alive.iter().max().copied().unwrap_or_default();
        let call = |(call, at): (Call<&str>, usize)| Call {
            callee: call.callee.to_owned(),
            times: call.times,
            live: locals + alive.get(at).copied().unwrap_or_default(),
        };
        Spent { operations: self.operations, registers, calls: self.calls.into_iter().map(call).collect() }
    }

    fn inner(&self, at: Handle<Expression>) -> &'m TypeInner {
        self.info[at].ty.inner_with(&self.module.types)
    }

    fn scalars(&self, at: Handle<Expression>) -> u64 {
        scalars_of(self.module, self.inner(at))
    }

    fn count(&mut self, found: Operations, times: u64, place: naga::Span) {
        self.operations.add(found, times);
        let cost = found.weighted().saturating_mul(times);
        self.places.extend(place.to_range().filter(|_| cost > 0).map(|place| (place, cost)));
    }

    fn block(&mut self, block: &Block, times: u64) {
        for (statement, span) in block.span_iter() {
            self.statement(statement, *span, times);
        }
    }

    fn statement(&mut self, statement: &Statement, span: naga::Span, times: u64) {
        self.lives.tick();
        ir::condition(statement).into_iter().for_each(|condition| self.lives.use_it(condition));
        let mut found = Operations::default();
        match statement {
            Statement::Emit(range) => {
                for handle in range.clone().filter(|handle| self.info[*handle].ref_count > 0) {
                    self.lives.tick();
                    let expression = &self.function.expressions[handle];
                    ir::operands(expression).into_iter().flatten().for_each(|one| self.lives.use_it(one));
                    self.lives.make(handle, self.scalars(handle));
                    let found = self.expression(expression, handle);
                    self.count(found, times, self.function.expressions.get_span(handle));
                }
                return;
            }
            Statement::If { .. } | Statement::Switch { .. } => found.branches = 1,
            Statement::Store { pointer, value } => {
                [pointer, value].into_iter().for_each(|one| self.lives.use_it(*one));
                if let Expression::LocalVariable(variable) = self.function.expressions[*pointer] {
                    let constant = trips::constant(self.module, self.function, *value);
                    self.known.insert(variable, constant);
                }
                if self.is_shared(*pointer) {
                    found.writes = self.scalars(*value);
                }
            }
            Statement::ImageStore { image, coordinate, array_index, value } => {
                [*image, *coordinate, *value]
                    .into_iter()
                    .chain(*array_index)
                    .for_each(|one| self.lives.use_it(one));
                found.writes = 4;
            }
            Statement::Atomic { pointer, value, result, .. } => {
                [pointer, value].into_iter().for_each(|one| self.lives.use_it(*one));
                result.iter().for_each(|one| self.lives.make(*one, self.scalars(*one)));
                found.atomics = 1;
            }
            Statement::ImageAtomic { .. } => found.atomics = 1,
            Statement::WorkGroupUniformLoad { result, .. } => {
                self.lives.make(*result, self.scalars(*result));
                found.reads = self.scalars(*result);
            }
            Statement::Return { value } => value.iter().for_each(|one| self.lives.use_it(*one)),
            Statement::Call { function, arguments, result } => {
                arguments.iter().for_each(|one| self.lives.use_it(*one));
                for argument in arguments {
                    // It may write what it is given a pointer to.
                    let base = ir::base(self.function, *argument);
                    if let Expression::LocalVariable(variable) = self.function.expressions[base] {
                        self.known.insert(variable, None);
                    }
                }
                let callee = self.module.functions[*function].name.as_deref().unwrap_or_default();
                self.calls.push((Call { callee, times, live: 0 }, self.lives.now()));
                self.lives.tick();
                result.iter().for_each(|one| self.lives.make(*one, self.scalars(*one)));
            }
            Statement::Loop { body, continuing, break_if } => {
                let trips = trips::trips(self.module, self.function, (body, continuing), &self.known);
                found.unknown_loops = u64::from(trips.is_none());
                self.count(found, times, span);
                let inside = times.saturating_mul(trips.unwrap_or(UNKNOWN_TRIPS));
                let began = self.lives.now();
                self.forget(statement);
                [body, continuing].into_iter().for_each(|block| self.block(block, inside));
                self.lives.tick();
                self.lives.end_loop(began);
                let branches = u64::from(break_if.is_some());
                self.count(Operations { branches, ..Operations::default() }, inside, span);
                self.forget(statement);
                return;
            }
            _ => {}
        }
        self.count(found, times, span);
        let is_certain = matches!(statement, Statement::Block(_));
        for inner in ir::blocks(statement) {
            // No block of a branch sees the values that another stored.
            let before = (!is_certain).then(|| self.known.clone());
            self.block(inner, times);
            self.known = before.unwrap_or_else(|| std::mem::take(&mut self.known));
        }
        if !is_certain {
            self.forget(statement);
        }
    }

    /// Marks as unknown the local variables that the blocks of a statement write, since the blocks may run any number
    /// of times.
    fn forget(&mut self, statement: &Statement) {
        for block in ir::blocks(statement) {
            let written = |variable: &_| trips::writes(self.function, block, *variable);
            self.known
                .iter_mut()
                .filter(|(variable, _)| written(variable))
                .for_each(|(_, known)| *known = None);
        }
    }

    /// Returns `true` if a pointer refers to memory that is shared between invocations or with the host.
    fn is_shared(&self, pointer: Handle<Expression>) -> bool {
        let space = match self.inner(pointer) {
            TypeInner::Pointer { space, .. } | TypeInner::ValuePointer { space, .. } => *space,
            _ => return false,
        };
        !matches!(space, AddressSpace::Function | AddressSpace::Private)
    }

    fn expression(&self, expression: &Expression, own: Handle<Expression>) -> Operations {
        let scalars = self.scalars(own);
        let mut found = Operations::default();
        match *expression {
            Expression::Load { pointer } if self.is_shared(pointer) => found.reads = scalars,
            Expression::ImageSample { depth_ref: Some(_), .. } => found.comparisons = 1,
            Expression::ImageSample { .. } => found.samples = 1,
            Expression::ImageLoad { .. } => found.texture_reads = 1,
            Expression::Access { .. } | Expression::ImageQuery { .. } | Expression::ArrayLength(_) => {
                found.arithmetic = 1;
            }
            Expression::Unary { .. } | Expression::Select { .. } | Expression::Derivative { .. } => {
                found.arithmetic = scalars;
            }
            Expression::As { convert: Some(_), .. } => found.arithmetic = scalars,
            Expression::Relational { argument, .. } => found.arithmetic = self.scalars(argument),
            Expression::Binary { op, left, right } => {
                found.arithmetic = self.binary(op, [left, right], scalars);
            }
            Expression::Math { fun, arg, .. } => found.arithmetic = math(fun, self.scalars(arg), scalars),
            _ => {}
        }
        found
    }

    fn binary(&self, op: BinaryOperator, sides: [Handle<Expression>; 2], scalars: u64) -> u64 {
        let inner = |side: Handle<Expression>| match *self.inner(side) {
            TypeInner::Matrix { columns, rows, .. } => Some((columns as u64, rows as u64)),
            _ => None,
        };
        match (op, inner(sides[0]), inner(sides[1])) {
            (BinaryOperator::Multiply, Some((columns, _)), _) if scalars != self.scalars(sides[0]) => {
                2 * columns * scalars
            }
            (BinaryOperator::Multiply, Some((columns, _)), Some(_)) => 2 * columns * scalars,
            (BinaryOperator::Multiply, None, Some((_, rows))) if scalars != self.scalars(sides[1]) => {
                2 * rows * scalars
            }
            (BinaryOperator::Divide | BinaryOperator::Modulo, ..) => 4 * scalars,
            _ => scalars,
        }
    }
}

/// The cost of a WGSL built-in function in scalar operations. `argument` and `result` are the numbers of scalars in its
/// first argument and in its result.
fn math(fun: MathFunction, argument: u64, result: u64) -> u64 {
    use MathFunction as M;
    match fun {
        M::Pow => 8 * result,
        M::Cos
        | M::Cosh
        | M::Sin
        | M::Sinh
        | M::Tan
        | M::Tanh
        | M::Acos
        | M::Asin
        | M::Atan
        | M::Atan2
        | M::Asinh
        | M::Acosh
        | M::Atanh
        | M::Exp
        | M::Exp2
        | M::Log
        | M::Log2
        | M::Sqrt
        | M::InverseSqrt => 4 * result,
        M::Dot => 2 * argument,
        M::Length | M::Distance => 2 * argument + 4,
        M::Normalize => 3 * argument + 4,
        M::Cross => 9,
        M::Mix => 2 * result,
        M::SmoothStep => 9 * result,
        M::Reflect | M::Refract | M::FaceForward => 4 * argument,
        M::Inverse => 8 * result,
        M::Determinant => 3 * argument,
        _ => result,
    }
}

/// The number of scalars in a value of this type; 0 for textures, samplers, pointers and runtime-sized arrays.
fn scalars_of(module: &Module, inner: &TypeInner) -> u64 {
    let of = |ty| scalars_of(module, &module.types[ty].inner);
    match *inner {
        TypeInner::Scalar(_) | TypeInner::Atomic(_) => 1,
        TypeInner::Vector { size, .. } => size as u64,
        TypeInner::Matrix { columns, rows, .. } => columns as u64 * rows as u64,
        TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
            of(base).saturating_mul(count.get().into())
        }
        TypeInner::Struct { ref members, .. } => {
            members.iter().fold(0, |sum: u64, member| sum.saturating_add(of(member.ty)))
        }
        _ => 0,
    }
}
