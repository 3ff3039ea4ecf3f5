//! naga's intermediate form, as far as more than one reader here goes through it.

use naga::{
    Block, Expression, Function, FunctionArgument, Handle, ImageQuery, Module, SampleLevel, Statement,
    SwitchCase, Type, TypeInner,
};

/// Iterates over the ordinary functions of a module, then over the functions of its entry points.
pub(crate) fn functions(module: &Module) -> impl Iterator<Item = &Function> {
    let functions = module.functions.iter().map(|(_, function)| function);
    functions.chain(module.entry_points.iter().map(|entry_point| &entry_point.function))
}

/// Iterates over the blocks directly inside a statement.
pub(crate) fn blocks(statement: &Statement) -> impl Iterator<Item = &Block> {
    let (first, second, cases): (_, _, &[SwitchCase]) = match statement {
        Statement::Block(inner) => (Some(inner), None, &[]),
        Statement::If { accept, reject, .. } => (Some(accept), Some(reject), &[]),
        Statement::Loop { body, continuing, .. } => (Some(body), Some(continuing), &[]),
        Statement::Switch { cases, .. } => (None, None, cases),
        _ => (None, None, &[]),
    };
    first.into_iter().chain(second).chain(cases.iter().map(|case| &case.body))
}

/// The expression that decides which blocks of a statement run, or whether a loop ends; `None` for statements without
/// one.
pub(crate) fn condition(statement: &Statement) -> Option<Handle<Expression>> {
    match statement {
        Statement::If { condition, .. } => Some(*condition),
        Statement::Switch { selector, .. } => Some(*selector),
        Statement::Loop { break_if, .. } => *break_if,
        _ => None,
    }
}

/// Iterates over the operands of an expression, except for the constant offset of a texture sample. `None` for
/// unsupported kinds of expressions.
pub(crate) fn operands(expression: &Expression) -> Option<impl Iterator<Item = Handle<Expression>>> {
    let mut components: &[Handle<Expression>] = &[];
    let mut operands = [None; 7];
    let mut set = |given: &[Option<Handle<Expression>>]| operands[..given.len()].copy_from_slice(given);
    match *expression {
        Expression::Literal(_)
        | Expression::Constant(_)
        | Expression::Override(_)
        | Expression::ZeroValue(_)
        | Expression::FunctionArgument(_)
        | Expression::GlobalVariable(_)
        | Expression::LocalVariable(_)
        | Expression::CallResult(_)
        | Expression::AtomicResult { .. }
        | Expression::WorkGroupUniformLoadResult { .. } => {}
        Expression::Compose { components: ref all, .. } => components = all,
        Expression::AccessIndex { base: only, .. }
        | Expression::Splat { value: only, .. }
        | Expression::Swizzle { vector: only, .. }
        | Expression::Load { pointer: only }
        | Expression::Unary { expr: only, .. }
        | Expression::Derivative { expr: only, .. }
        | Expression::Relational { argument: only, .. }
        | Expression::As { expr: only, .. }
        | Expression::ArrayLength(only) => set(&[Some(only)]),
        Expression::Access { base, index } => set(&[Some(base), Some(index)]),
        Expression::Binary { left, right, .. } => set(&[Some(left), Some(right)]),
        Expression::Select { condition, accept, reject } => {
            set(&[Some(condition), Some(accept), Some(reject)]);
        }
        Expression::Math { arg, arg1, arg2, arg3, .. } => set(&[Some(arg), arg1, arg2, arg3]),
        Expression::ImageSample { image, sampler, coordinate, array_index, level, depth_ref, .. } => {
            let (level, other) = match level {
                SampleLevel::Exact(level) | SampleLevel::Bias(level) => (Some(level), None),
                SampleLevel::Gradient { x, y } => (Some(x), Some(y)),
                SampleLevel::Auto | SampleLevel::Zero => (None, None),
            };
            set(&[Some(image), Some(sampler), Some(coordinate), array_index, depth_ref, level, other]);
        }
        Expression::ImageLoad { image, coordinate, array_index, sample, level } => {
            set(&[Some(image), Some(coordinate), array_index, sample, level]);
        }
        Expression::ImageQuery { image, query: ImageQuery::Size { level } } => set(&[Some(image), level]),
        Expression::ImageQuery { image, .. } => set(&[Some(image)]),
        _ => return None,
    }
    Some(operands.into_iter().flatten().chain(components.iter().copied()))
}

/// The expression at the start of a chain of index and member accesses: `a` for `a.b[1]`.
pub(crate) fn base(function: &Function, mut part: Handle<Expression>) -> Handle<Expression> {
    while let Expression::Access { base, .. } | Expression::AccessIndex { base, .. } =
        function.expressions[part]
    {
        part = base;
    }
    part
}

/// The type of the variable or argument that holds an image; `None` for other expressions.
pub(crate) fn image<'m>(
    module: &'m Module,
    function: &Function,
    image: Handle<Expression>,
) -> Option<&'m TypeInner> {
    let ty = match function.expressions[base(function, image)] {
        Expression::GlobalVariable(variable) => module.global_variables[variable].ty,
        Expression::FunctionArgument(at) => function.arguments.get(at as usize)?.ty,
        _ => return None,
    };
    Some(&module.types[ty].inner)
}

/// An input or output of an entry point with a binding: a location or a built-in value.
pub(crate) struct Bound<'m> {
    pub(crate) name: &'m str,
    pub(crate) ty: Handle<Type>,
    pub(crate) binding: &'m naga::Binding,
    /// The structure with this member; `None` for an argument or result itself.
    pub(crate) owner: Option<Handle<Type>>,
}

/// The inputs of an entry point: arguments with a location or built-in value, and such members of structure arguments.
pub(crate) fn inputs<'m>(module: &'m Module, function: &'m Function) -> Vec<Bound<'m>> {
    function.arguments.iter().flat_map(|argument| inputs_of(module, argument)).collect()
}

/// The inputs in one argument of an entry point: the argument itself, or the members of a structure.
pub(crate) fn inputs_of<'m>(module: &'m Module, argument: &'m FunctionArgument) -> Vec<Bound<'m>> {
    bound(module, argument.name.as_deref(), argument.ty, argument.binding.as_ref())
}

/// The outputs of an entry point: a result with a location or built-in value, or such members of a structure.
pub(crate) fn outputs<'m>(module: &'m Module, function: &'m Function) -> Vec<Bound<'m>> {
    let results = function.result.iter();
    results.flat_map(|result| bound(module, None, result.ty, result.binding.as_ref())).collect()
}

fn bound<'m>(
    module: &'m Module,
    name: Option<&'m str>,
    ty: Handle<Type>,
    binding: Option<&'m naga::Binding>,
) -> Vec<Bound<'m>> {
    let bound = |name: Option<&'m str>, ty, binding, owner| {
        Some(Bound { name: name.unwrap_or_default(), ty, binding: binding?, owner })
    };
    match &module.types[ty].inner {
        TypeInner::Struct { members, .. } if binding.is_none() => {
            let members = members.iter();
            members
                .filter_map(|each| bound(each.name.as_deref(), each.ty, each.binding.as_ref(), Some(ty)))
                .collect()
        }
        _ => bound(name, ty, binding, None).into_iter().collect(),
    }
}
