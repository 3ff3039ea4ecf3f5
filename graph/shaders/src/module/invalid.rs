//! naga's validation errors in the words of WGSL: types in WGSL's spelling, the place of the cause, and a way out.
//!
//! naga names types as its own data, and some errors without a place. Errors that are missing in this table keep
//! naga's text.

use std::collections::HashSet;
use std::ops::Range;

use naga::common::wgsl::TypeContext as _;
use naga::front::Typifier;
use naga::proc::{ResolveContext, TypeResolution};
use naga::valid::{
    Disalignment, EntryPointError, ExpressionError, FunctionError, GlobalUse, GlobalVariableError, TypeError,
    ValidationError, VaryingError,
};
use naga::{
    AddressSpace, BinaryOperator, Binding, Block, BuiltIn, DerivativeAxis, EntryPoint, Expression, Function,
    GlobalVariable, Handle, ImageClass, ImageDimension, Interpolation, Module, SampleLevel, ScalarKind,
    ShaderStage, Span, Statement, StorageAccess, Type, TypeInner, VectorSize,
};

use crate::written::ir;

/// The message, place and way out of a validation error.
#[derive(Default)]
pub(super) struct Explained {
    pub(super) message: String,
    /// The place of the cause; `None` if naga's place is the best one.
    pub(super) range: Option<Range<usize>>,
    pub(super) labels: Vec<(Range<usize>, String)>,
    pub(super) help: Option<String>,
    /// The member, of the structure at `range`, that is at fault.
    pub(super) member: Option<String>,
}

impl Explained {
    fn new(message: String) -> Self {
        Self { message, ..Self::default() }
    }

    fn at(self, span: Span) -> Self {
        Self { range: span.to_range(), ..self }
    }

    fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.extend(span.to_range().map(|range| (range, text.into())));
        self
    }

    fn help(self, text: impl Into<String>) -> Self {
        Self { help: Some(text.into()), ..self }
    }
}

/// Explains a validation error of naga; `None` for errors that this table does not have.
pub(super) fn explain(module: &Module, error: &ValidationError) -> Option<Explained> {
    match error {
        ValidationError::Type { source: TypeError::InvalidDynamicArray(member, ty), .. } => {
            let message = format!("\"{member}\" is an array without a length, and not the last member");
            let length = match module.types[*ty].inner {
                TypeInner::Array { base, .. } => {
                    format!(", or give it a length: array<{}, N>", spelled(module, base))
                }
                _ => String::new(),
            };
            Some(
                Explained::new(message)
                    .help(format!("move \"{member}\" to the end of the structure{length}")),
            )
        }
        ValidationError::GlobalVariable {
            handle,
            source:
                GlobalVariableError::Alignment(AddressSpace::Uniform, _, Disalignment::ArrayStride { stride, .. }),
            ..
        } => array_in_uniform(module, *handle, *stride),
        ValidationError::GlobalVariable {
            handle,
            name,
            source: GlobalVariableError::Alignment(_, _, Disalignment::NonHostShareable),
        } => bool_in_buffer(module, module.global_variables[*handle].ty, name),
        ValidationError::Function { handle, name, source } => {
            in_function(module, &module.functions[*handle], name, source)
        }
        ValidationError::EntryPoint { stage, name, source } => {
            let mut entries = module.entry_points.iter();
            let entry = entries.find(|entry| entry.stage == *stage && entry.name == *name)?;
            match source {
                EntryPointError::Function(source) => in_function(module, &entry.function, name, source),
                EntryPointError::ForbiddenStageOperations => forbidden(module, entry),
                EntryPointError::InvalidGlobalUsage(variable, used) => usage(module, entry, *variable, *used),
                EntryPointError::Argument(_, VaryingError::InvalidInterpolationForInteger) => {
                    interpolated(module, &ir::inputs(module, &entry.function))
                }
                EntryPointError::Result(VaryingError::InvalidInterpolationForInteger) => {
                    interpolated(module, &ir::outputs(module, &entry.function))
                }
                _ => None,
            }
        }
        _ => None,
    }
}

fn spelled(module: &Module, ty: Handle<Type>) -> String {
    module.to_ctx().type_to_string(ty)
}

fn spelled_inner(module: &Module, inner: &TypeInner) -> String {
    module.to_ctx().type_resolution_to_string(&TypeResolution::Value(inner.clone()))
}

/// The type of an expression, and its spelling; `None` if it has none.
fn type_of(module: &Module, function: &Function, one: Handle<Expression>) -> Option<(TypeInner, String)> {
    let context = ResolveContext::with_locals(module, &function.local_variables, &function.arguments);
    let mut types = Typifier::new();
    types.grow(one, &function.expressions, &context).ok()?;
    let inner = types.get(one, &module.types).clone();
    Some((inner, module.to_ctx().type_resolution_to_string(&types[one])))
}

fn name_of(module: &Module, variable: Handle<GlobalVariable>) -> &str {
    module.global_variables[variable].name.as_deref().unwrap_or_default()
}

fn in_function(module: &Module, function: &Function, name: &str, error: &FunctionError) -> Option<Explained> {
    let span = |one: Handle<Expression>| function.expressions.get_span(one);
    match error {
        FunctionError::Expression { source, handle } => expression(module, function, *handle, source),
        FunctionError::InvalidIfType(condition) => {
            let (inner, ty) = type_of(module, function, *condition)?;
            let explained = Explained::new(format!("the condition of `if` is a bool, and this is {ty}"));
            let zero = match inner {
                TypeInner::Scalar(scalar) => zero_of(scalar.kind)?,
                _ => return Some(explained),
            };
            Some(explained.help(format!("compare it: `!= {zero}`")))
        }
        FunctionError::InvalidSwitchType(selector) => {
            let (_, ty) = type_of(module, function, *selector)?;
            let message = format!("the value of `switch` is an i32 or u32, and this is {ty}");
            Some(Explained::new(message))
        }
        FunctionError::InvalidReturnType { expression: None, expected_ty: Some(ty) } => {
            let ty = spelled(module, *ty);
            let message = format!("\"{name}\" returns {ty}, but a way through it ends without a `return`");
            let help = match has_loop(&function.body) {
                false => format!("write a `return` of {ty} at the end of \"{name}\""),
                true => format!(
                    "write a `return` of {ty} behind the loop: naga does not see that a loop ends every way"
                ),
            };
            Some(Explained::new(message).help(help))
        }
        FunctionError::InvalidReturnType { expression: Some(value), expected_ty } => {
            let (_, ty) = type_of(module, function, *value)?;
            let declared = match expected_ty {
                Some(declared) => format!("is declared to return {}", spelled(module, *declared)),
                None => "is declared without a return type".to_owned(),
            };
            let message = format!("this is {ty}, but \"{name}\" {declared}");
            Some(Explained::new(message).help("change one of the two"))
        }
        FunctionError::InvalidStorePointer(pointer) => {
            let root = ir::base(function, *pointer);
            let Expression::GlobalVariable(variable) = function.expressions[root] else { return None };
            read_only(module, variable)
        }
        FunctionError::InvalidStoreTypes { pointer, value } => {
            let (_, value) = type_of(module, function, *value)?;
            let (inner, _) = type_of(module, function, *pointer)?;
            let target = match inner {
                TypeInner::Pointer { base, .. } => spelled(module, base),
                TypeInner::ValuePointer { size: None, scalar, .. } => {
                    spelled_inner(module, &TypeInner::Scalar(scalar))
                }
                TypeInner::ValuePointer { size: Some(size), scalar, .. } => {
                    spelled_inner(module, &TypeInner::Vector { size, scalar })
                }
                _ => return None,
            };
            let explained = Explained::new(format!("a value of type {value} is assigned to {target}"));
            Some(explained.at(span(*pointer)).help("WGSL converts no value by itself: convert it"))
        }
        FunctionError::PipelineInputRegularFunction { .. } | FunctionError::PipelineOutputRegularFunction => {
            let message =
                format!("\"{name}\" has @location or @builtin, which entry points have, and is none");
            let stage = stage_of(function);
            Some(Explained::new(message).help(format!("write {stage} before `fn {name}`")))
        }
        FunctionError::InvalidImageStore(source) => coordinates(module, function, source, "textureStore"),
        _ => None,
    }
}

/// Explains the coordinates of a texture function that have the wrong type.
fn coordinates(
    module: &Module,
    function: &Function,
    error: &ExpressionError,
    called: &str,
) -> Option<Explained> {
    let ExpressionError::InvalidImageCoordinateType(dimension, value) = error else { return None };
    let (_, ty) = type_of(module, function, *value)?;
    let of = |scalar: &str| match dimension {
        ImageDimension::D1 => scalar.to_owned(),
        ImageDimension::D2 => format!("vec2<{scalar}>"),
        ImageDimension::D3 | ImageDimension::Cube => format!("vec3<{scalar}>"),
    };
    let (wanted, help) = match called {
        "textureSample" => {
            (of("f32"), format!("write {}(…), from 0 to 1, or textureLoad for texels", of("f32")))
        }
        _ => (
            format!("{} or {}", of("i32"), of("u32")),
            format!("write {}(…), or textureSampleLevel for coordinates from 0 to 1", of("i32")),
        ),
    };
    let message = format!("the coordinates of {called} are {wanted} here, and this is {ty}");
    Some(Explained::new(message).at(function.expressions.get_span(*value)).help(help))
}

/// Explains a boolean in a uniform or storage buffer of the type `ty`, which has the name `variable` or stands in it.
fn bool_in_buffer(module: &Module, ty: Handle<Type>, variable: &str) -> Option<Explained> {
    let is_bool = |ty: Handle<Type>| module.types[ty].inner.scalar_kind() == Some(ScalarKind::Bool);
    match &module.types[ty].inner {
        TypeInner::Struct { members, .. } => members.iter().find_map(|member| {
            let name = member.name.as_deref()?;
            if !is_bool(member.ty) {
                return bool_in_buffer(module, member.ty, name);
            }
            let message = format!(
                "\"{name}\" of \"{variable}\" is a bool, which no uniform or storage buffer can hold"
            );
            let help = format!("declare `{name}: u32`, and read `{variable}.{name} != 0u`");
            let explained = Explained::new(message).at(module.types.get_span(ty)).help(help);
            Some(Explained { member: Some(name.to_owned()), ..explained })
        }),
        TypeInner::Array { base, .. } => bool_in_buffer(module, *base, variable),
        _ => None,
    }
}

/// Explains an integer that is handed from stage to stage without `@interpolate(flat)`.
fn interpolated(module: &Module, variables: &[ir::Bound<'_>]) -> Option<Explained> {
    let integer = |kind| matches!(kind, Some(ScalarKind::Sint | ScalarKind::Uint));
    let variable = variables.iter().find(|variable| {
        let is_flat =
            matches!(variable.binding, Binding::Location { interpolation: Some(Interpolation::Flat), .. });
        let is_located = matches!(variable.binding, Binding::Location { .. });
        is_located && !is_flat && integer(module.types[variable.ty].inner.scalar_kind())
    })?;
    let Binding::Location { location, .. } = variable.binding else { return None };
    let (name, ty) = (variable.name, spelled(module, variable.ty));
    let message = format!("\"{name}\" at @location({location}) is {ty}, and integers are not interpolated");
    let help = format!("write `@location({location}) @interpolate(flat) {name}: {ty}`");
    let explained = Explained::new(message).help(help);
    let member = variable.owner.map(|_| name.to_owned());
    Some(match variable.owner {
        Some(owner) => Explained { member, ..explained.at(module.types.get_span(owner)) },
        None => explained,
    })
}

/// The attribute of the stage for which a function has inputs and outputs.
fn stage_of(function: &Function) -> &'static str {
    let is_built_in = |binding: &Option<Binding>, is_it: &dyn Fn(BuiltIn) -> bool| matches!(binding, Some(Binding::BuiltIn(built_in)) if is_it(*built_in));
    let is_of_compute = |one: BuiltIn| {
        matches!(
            one,
            BuiltIn::GlobalInvocationId
                | BuiltIn::LocalInvocationId
                | BuiltIn::LocalInvocationIndex
                | BuiltIn::WorkGroupId
                | BuiltIn::NumWorkGroups
        )
    };
    let is_of_vertices = |one: BuiltIn| matches!(one, BuiltIn::VertexIndex | BuiltIn::InstanceIndex);
    let mut arguments = function.arguments.iter();
    if arguments.clone().any(|argument| is_built_in(&argument.binding, &is_of_compute)) {
        return "@compute @workgroup_size(8, 8)";
    }
    let is_position = |one: BuiltIn| matches!(one, BuiltIn::Position { .. });
    let result = function.result.as_ref();
    if arguments.any(|argument| is_built_in(&argument.binding, &is_of_vertices))
        || result.is_some_and(|result| is_built_in(&result.binding, &is_position))
    {
        return "@vertex";
    }
    "@fragment (or @vertex)"
}

fn zero_of(kind: ScalarKind) -> Option<&'static str> {
    match kind {
        ScalarKind::Float => Some("0.0"),
        ScalarKind::Uint => Some("0u"),
        ScalarKind::Sint => Some("0"),
        _ => None,
    }
}

fn expression(
    module: &Module,
    function: &Function,
    place: Handle<Expression>,
    error: &ExpressionError,
) -> Option<Explained> {
    let span = |one: Handle<Expression>| function.expressions.get_span(one);
    match error {
        ExpressionError::InvalidIndexType(index) => {
            let (inner, ty) = type_of(module, function, *index)?;
            let explained = Explained::new(format!("an index is i32 or u32, and this is {ty}"));
            let is_float = matches!(inner, TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Float);
            let explained = if is_float { explained.help("convert it: `u32(…)`") } else { explained };
            Some(match span(*index).to_range() {
                Some(_) => explained.at(span(*index)),
                None => explained.at(span(place)),
            })
        }
        ExpressionError::InvalidBinaryOperandTypes { op, lhs_expr, lhs_type, rhs_expr, rhs_type } => {
            let [left, right] = [lhs_type, rhs_type].map(|ty| spelled_inner(module, ty));
            let message = format!("WGSL has no `{left} {} {right}`", sign(*op));
            let explained = Explained::new(message).at(span(place)).label(span(*lhs_expr), left.as_str());
            let explained = explained.label(span(*rhs_expr), right.as_str());
            let help = operands(*op, lhs_type, rhs_type, &[left, right]);
            Some(Explained { help, ..explained })
        }
        ExpressionError::SelectValuesTypeMismatch { accept, reject } => {
            let [accept, reject] = [accept, reject].map(|ty| spelled_inner(module, ty));
            let message =
                format!("`select` chooses between values of one type, and these are {reject} and {accept}");
            Some(Explained::new(message).help("convert one of the two"))
        }
        ExpressionError::SelectConditionNotABool { actual } => {
            let actual = spelled_inner(module, actual);
            let message = format!("the condition of `select` is a bool, and this is {actual}");
            Some(
                Explained::new(message)
                    .help("the condition is the last argument: select(if_false, if_true, condition)"),
            )
        }
        error => {
            let called = match &function.expressions[place] {
                Expression::ImageSample { .. } => "textureSample",
                Expression::ImageLoad { .. } => "textureLoad",
                _ => return None,
            };
            coordinates(module, function, error, called)
        }
    }
}

fn sign(operator: BinaryOperator) -> &'static str {
    use BinaryOperator as Op;
    match operator {
        Op::Add => "+",
        Op::Subtract => "-",
        Op::Multiply => "*",
        Op::Divide => "/",
        Op::Modulo => "%",
        Op::Equal => "==",
        Op::NotEqual => "!=",
        Op::Less => "<",
        Op::LessEqual => "<=",
        Op::Greater => ">",
        Op::GreaterEqual => ">=",
        Op::And => "&",
        Op::ExclusiveOr => "^",
        Op::InclusiveOr => "|",
        Op::LogicalAnd => "&&",
        Op::LogicalOr => "||",
        Op::ShiftLeft => "<<",
        Op::ShiftRight => ">>",
    }
}

/// A way to write an operation whose operands do not fit; `None` if there is no certain one.
fn operands(
    operator: BinaryOperator,
    left: &TypeInner,
    right: &TypeInner,
    names: &[String; 2],
) -> Option<String> {
    use BinaryOperator as Op;
    let is_number =
        |kind: ScalarKind| matches!(kind, ScalarKind::Float | ScalarKind::Sint | ScalarKind::Uint);
    let vector_for_matrix = |matrix: VectorSize, vector: VectorSize, scalar: &str| match (matrix, vector) {
        (VectorSize::Quad, VectorSize::Tri) => Some(format!(
            "write vec4<{scalar}>(v, 1.0) for a point v, and vec4<{scalar}>(v, 0.0) for a direction"
        )),
        (VectorSize::Tri, VectorSize::Quad) => Some("write v.xyz of the vector v".to_owned()),
        _ => None,
    };
    let scalar_name = |name: &str| if name.contains("f16") { "f16" } else { "f32" };
    match (left, right) {
        (TypeInner::Matrix { columns, .. }, TypeInner::Vector { size, scalar })
            if operator == Op::Multiply && scalar.kind == ScalarKind::Float =>
        {
            vector_for_matrix(*columns, *size, scalar_name(&names[1]))
        }
        (TypeInner::Vector { size, scalar }, TypeInner::Matrix { rows, .. })
            if operator == Op::Multiply && scalar.kind == ScalarKind::Float =>
        {
            vector_for_matrix(*rows, *size, scalar_name(&names[0]))
        }
        _ => {
            let (left_scalar, right_scalar) = (left.scalar()?, right.scalar()?);
            let [left_size, right_size] = [left, right].map(|ty| match ty {
                TypeInner::Scalar(_) => Some(1),
                TypeInner::Vector { size, .. } => Some(*size as u8),
                _ => None,
            });
            let (left_size, right_size) = (left_size?, right_size?);
            if matches!(operator, Op::ShiftLeft | Op::ShiftRight) {
                let is_shift = left_size == right_size
                    && matches!(left_scalar.kind, ScalarKind::Sint | ScalarKind::Uint)
                    && right_scalar.kind == ScalarKind::Sint;
                let name = names[1].replace("i32", "u32");
                return is_shift.then(|| format!("the right side of a shift is unsigned: `{name}(…)`"));
            }
            let is_arithmetic =
                matches!(operator, Op::Add | Op::Subtract | Op::Multiply | Op::Divide | Op::Modulo);
            let is_comparison = matches!(
                operator,
                Op::Equal | Op::NotEqual | Op::Less | Op::LessEqual | Op::Greater | Op::GreaterEqual
            );
            let is_fitting = left_size == right_size || is_arithmetic && (left_size == 1 || right_size == 1);
            let differ = left_scalar.kind != right_scalar.kind
                && left_scalar.width == right_scalar.width
                && is_number(left_scalar.kind)
                && is_number(right_scalar.kind);
            if !(is_fitting && differ && (is_arithmetic || is_comparison)) {
                return None;
            }
            // A float stays one; of two integers the right one changes.
            let (from, to) = match right_scalar.kind {
                ScalarKind::Float => (&names[0], &names[1]),
                _ => (&names[1], &names[0]),
            };
            let component = to.rsplit('<').next().unwrap_or(to).trim_end_matches('>');
            let target = match from.split_once('<') {
                Some((vector, _)) => format!("{vector}<{component}>"),
                None => component.to_owned(),
            };
            Some(format!("WGSL converts no value by itself: write `{target}(…)` around the {from}"))
        }
    }
}

/// Returns `true` if a block contains a loop.
fn has_loop(block: &Block) -> bool {
    block.iter().any(|one| matches!(one, Statement::Loop { .. }) || ir::blocks(one).any(has_loop))
}

/// Explains a write to a variable that shaders only read.
fn read_only(module: &Module, handle: Handle<GlobalVariable>) -> Option<Explained> {
    let name = name_of(module, handle);
    let (space, help) = match module.global_variables[handle].space {
        AddressSpace::Storage { access } if !access.contains(StorageAccess::STORE) => {
            let help = "declare it var<storage, read_write>, and write it in a compute or fragment stage";
            ("var<storage, read>", help)
        }
        AddressSpace::Uniform => {
            ("var<uniform>", "copy it into a `var` of the function, and change the copy")
        }
        _ => return None,
    };
    let message = format!("\"{name}\" is written here, but it is {space}, which shaders only read");
    let declared = module.global_variables.get_span(handle);
    Some(Explained::new(message).label(declared, "declared here").help(help))
}

/// Explains an array of a uniform whose elements are closer than 16 bytes.
fn array_in_uniform(module: &Module, variable: Handle<GlobalVariable>, stride: u32) -> Option<Explained> {
    let is_it = |ty: Handle<Type>| matches!(module.types[ty].inner, TypeInner::Array { stride: own, .. } if own == stride);
    let name = name_of(module, variable);
    let ty = module.global_variables[variable].ty;
    let (what, array) = match &module.types[ty].inner {
        _ if is_it(ty) => (String::new(), ty),
        TypeInner::Struct { members, .. } => {
            let member = members.iter().find(|member| is_it(member.ty))?;
            (format!("\"{}\" of ", member.name.as_deref()?), member.ty)
        }
        _ => return None,
    };
    let message = format!(
        "the elements of {} are {stride} bytes apart in {what}the uniform \"{name}\", where they have to be a \
         multiple of 16",
        spelled(module, array)
    );
    let explained = Explained::new(message).label(module.types.get_span(array), "the array");
    let explained = explained.label(module.types.get_span(ty), "the type of the uniform");
    let help = "naga does not know \"uniform_buffer_standard_layout\": use elements of 16 bytes, as vec4<f32>, or a \
                storage buffer";
    Some(explained.help(help))
}

/// Explains an operation that the stage of an entry point does not have.
fn forbidden(module: &Module, entry: &EntryPoint) -> Option<Explained> {
    let mut seen = HashSet::new();
    let (span, operation, help) = operation(module, &entry.function, entry.stage, &mut seen)?;
    let stage = match entry.stage {
        ShaderStage::Vertex => "vertex",
        ShaderStage::Fragment => "fragment",
        ShaderStage::Compute => "compute",
        _ => return None,
    };
    let only = if entry.stage == ShaderStage::Fragment { "compute" } else { "fragment" };
    let only = if operation.contains("arrier") || operation.contains("workgroup") { "compute" } else { only };
    let message = format!(
        "{operation} exists in {only} stages only, and \"{}\" is a {stage} stage that runs it",
        entry.name
    );
    Some(Explained::new(message).at(span).help(help))
}

/// The maximum number of called functions in which an operation is looked for.
const MAX_FUNCTIONS: usize = 256;

/// The first operation of a function, or of those that it calls and that are not in `seen`, that a stage does not have:
/// its place, its name and a way without it.
fn operation(
    module: &Module,
    function: &Function,
    stage: ShaderStage,
    seen: &mut HashSet<Handle<Function>>,
) -> Option<(Span, &'static str, &'static str)> {
    if stage != ShaderStage::Fragment {
        for (handle, expression) in function.expressions.iter() {
            let (name, help) = match expression {
                Expression::ImageSample { level: SampleLevel::Auto, depth_ref: Some(_), .. } => {
                    ("textureSampleCompare", "use textureSampleCompareLevel, which reads mip level 0")
                }
                Expression::ImageSample { level: SampleLevel::Auto, .. } => {
                    ("textureSample", "use textureSampleLevel, whose last argument is the mip level: 0.0")
                }
                Expression::ImageSample { level: SampleLevel::Bias(_), .. } => {
                    ("textureSampleBias", "use textureSampleLevel, whose last argument is the mip level: 0.0")
                }
                Expression::Derivative { axis, .. } => (
                    match axis {
                        DerivativeAxis::X => "dpdx",
                        DerivativeAxis::Y => "dpdy",
                        DerivativeAxis::Width => "fwidth",
                    },
                    "a derivative compares neighbouring fragments: compute the difference from what you read",
                ),
                _ => continue,
            };
            return Some((function.expressions.get_span(handle), name, help));
        }
    }
    in_block(module, &function.body, stage, seen)
}

fn in_block(
    module: &Module,
    block: &Block,
    stage: ShaderStage,
    seen: &mut HashSet<Handle<Function>>,
) -> Option<(Span, &'static str, &'static str)> {
    const BARRIER: &str =
        "only the invocations of a workgroup wait for one another: remove it, or use a compute pass";
    for (statement, span) in block.span_iter() {
        let found = match statement {
            Statement::Kill if stage != ShaderStage::Fragment => {
                Some((*span, "`discard`", "`return` ends an invocation in other stages"))
            }
            Statement::ControlBarrier(_) | Statement::MemoryBarrier(_) if stage != ShaderStage::Compute => {
                Some((*span, "a barrier", BARRIER))
            }
            Statement::WorkGroupUniformLoad { .. } if stage != ShaderStage::Compute => {
                Some((*span, "workgroupUniformLoad", BARRIER))
            }
            Statement::Call { function, .. } if seen.len() < MAX_FUNCTIONS && seen.insert(*function) => {
                operation(module, &module.functions[*function], stage, seen)
            }
            _ => ir::blocks(statement).find_map(|block| in_block(module, block, stage, seen)),
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

/// Explains an access to a storage texture that its declaration does not allow.
fn usage(
    module: &Module,
    entry: &EntryPoint,
    handle: Handle<GlobalVariable>,
    used: GlobalUse,
) -> Option<Explained> {
    let variable = &module.global_variables[handle];
    let TypeInner::Image { class: ImageClass::Storage { access, .. }, .. } = module.types[variable.ty].inner
    else {
        return None;
    };
    let declared = module.global_variables.get_span(handle);
    let name = name_of(module, handle);
    let entry_name = &entry.name;
    if used.contains(GlobalUse::READ) && !access.contains(StorageAccess::LOAD) {
        let message = format!(
            "\"{entry_name}\" reads the storage texture \"{name}\", which is declared for `write` alone"
        );
        let help =
            "declare it read_write, which r32float, r32sint and r32uint allow, or read another texture";
        let explained = Explained::new(message).help(help);
        let functions = ir::functions(module);
        let place =
            functions.flat_map(|function| function.expressions.iter().map(move |one| (function, one)));
        let mut reads = place.filter_map(|(function, (place, expression))| match expression {
            Expression::ImageLoad { image, .. } => {
                let root = ir::base(function, *image);
                let is_it =
                    matches!(function.expressions[root], Expression::GlobalVariable(one) if one == handle);
                is_it.then(|| function.expressions.get_span(place))
            }
            _ => None,
        });
        return Some(match reads.next() {
            Some(span) => explained.at(span).label(declared, "declared here"),
            None => explained.at(declared),
        });
    }
    if used.contains(GlobalUse::WRITE) && !access.contains(StorageAccess::STORE) {
        let message = format!(
            "\"{entry_name}\" writes the storage texture \"{name}\", which is declared for `read` alone"
        );
        return Some(Explained::new(message).at(declared).help("declare it `write`"));
    }
    None
}
