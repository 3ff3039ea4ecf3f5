//! Whether a full-screen pass is certain to write every texel.
//!
//! For vertices 0 to 2 its vertex stage must produce one triangle that contains all of clip space, with any bindings.
//! Its fragment stage must always write: no `discard`, no `sample_mask`. An interpreter runs naga's form of the vertex
//! stage for the three indices: literals, constants, vectors and structures, arithmetic and conversions.
//!
//! Limits: a stage with control flow, calls, bindings, overrides or inputs other than `vertex_index` never counts as
//! covering.

use naga::valid::ModuleInfo;
use naga::{
    BinaryOperator, Binding, BuiltIn, Expression, Function, Handle, Literal, Module, ScalarKind, Statement,
};

use crate::written::ir;
use crate::written::ir::Bound;

/// A value of the interpreter that runs the vertex stage.
#[derive(Clone, Debug, PartialEq)]
enum Value {
    Float(f32),
    Sint(i32),
    Uint(u32),
    Composite(Vec<Value>),
}

/// Returns `true` if the fragments of an entry point write all samples: no `discard`, no `sample_mask`.
pub(super) fn keeps_all(module: &Module, info: &ModuleInfo, at: usize) -> bool {
    let mut outputs = ir::outputs(module, &module.entry_points[at].function).into_iter();
    let mask = Binding::BuiltIn(BuiltIn::SampleMask);
    !info.get_entry_point(at).may_kill && outputs.all(|output| *output.binding != mask)
}

/// Returns `true` if vertices 0 to 2 of a vertex stage form one triangle that contains all of clip space.
pub(super) fn covers(module: &Module, at: usize) -> bool {
    let function = &module.entry_points[at].function;
    let outputs = ir::outputs(module, function);
    // Distances to planes of the shader's own clip the triangle.
    if outputs.iter().any(|output| *output.binding == Binding::BuiltIn(BuiltIn::ClipDistances)) {
        return false;
    }
    let is_position =
        |output: &Bound<'_>| matches!(output.binding, Binding::BuiltIn(BuiltIn::Position { .. }));
    let Some(place) = outputs.iter().position(is_position) else { return false };
    let is_member = outputs[place].owner.is_some();
    let corner = |index: u32| {
        let returned = Run { module, function, index }.value(returned(function)?)?;
        let position = if is_member { returned.at(place)? } else { returned };
        let Value::Composite(values) = position else { return None };
        match values[..] {
            [Value::Float(x), Value::Float(y), Value::Float(z), Value::Float(w)] => {
                (w == 1.0 && (0.0..=1.0).contains(&z)).then_some([x, y])
            }
            _ => None,
        }
    };
    let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else { return false };
    let side =
        |a: [f32; 2], b: [f32; 2], p: [f32; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let turn = side(a, b, c);
    let is_inside =
        |p: [f32; 2]| [side(a, b, p), side(b, c, p), side(c, a, p)].iter().all(|s| s * turn >= 0.0);
    turn != 0.0 && [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].into_iter().all(is_inside)
}

/// The expression that a function without control flow returns; `None` if it has control flow.
fn returned(function: &Function) -> Option<Handle<Expression>> {
    match function.body.iter().find(|statement| !matches!(statement, Statement::Emit(_)))? {
        Statement::Return { value } => *value,
        _ => None,
    }
}

struct Run<'a> {
    module: &'a Module,
    function: &'a Function,
    /// The vertex index, 0 to 2.
    index: u32,
}

impl Run<'_> {
    fn value(&self, of: Handle<Expression>) -> Option<Value> {
        self.evaluate(&self.function.expressions[of], &|handle| self.value(handle))
    }

    fn constant(&self, of: Handle<Expression>) -> Option<Value> {
        self.evaluate(&self.module.global_expressions[of], &|handle| self.constant(handle))
    }

    fn evaluate(
        &self,
        expression: &Expression,
        value: &dyn Fn(Handle<Expression>) -> Option<Value>,
    ) -> Option<Value> {
        Some(match *expression {
            Expression::Literal(Literal::F32(number)) => Value::Float(number),
            Expression::Literal(Literal::I32(number)) => Value::Sint(number),
            Expression::Literal(Literal::U32(number)) => Value::Uint(number),
            Expression::Constant(handle) => self.constant(self.module.constants[handle].init)?,
            Expression::FunctionArgument(0) => {
                let index = Binding::BuiltIn(BuiltIn::VertexIndex);
                let argument = self.function.arguments.first()?;
                Value::Uint((argument.binding.as_ref() == Some(&index)).then_some(self.index)?)
            }
            Expression::Compose { ty, ref components } => {
                let parts = components.iter().map(|part| value(*part)).collect::<Option<Vec<_>>>()?;
                // A vector of vectors is one vector.
                let is_vector = matches!(self.module.types[ty].inner, naga::TypeInner::Vector { .. });
                Value::Composite(if is_vector {
                    parts.into_iter().flat_map(Value::flat).collect()
                } else {
                    parts
                })
            }
            Expression::Splat { size, value: of } => Value::Composite(vec![value(of)?; size as usize]),
            Expression::AccessIndex { base, index } => value(base)?.at(index as usize)?,
            Expression::Access { base, index } => match value(index)? {
                Value::Uint(index) => value(base)?.at(index as usize)?,
                Value::Sint(index) => value(base)?.at(usize::try_from(index).ok()?)?,
                _ => return None,
            },
            Expression::As { expr, kind, convert: Some(4) } => value(expr)?.convert(kind)?,
            Expression::Binary { op, left, right } => value(left)?.combine(op, &value(right)?)?,
            _ => return None,
        })
    }
}

impl Value {
    fn flat(self) -> Vec<Self> {
        match self {
            Value::Composite(parts) => parts,
            scalar => vec![scalar],
        }
    }

    fn at(self, place: usize) -> Option<Self> {
        match self {
            Value::Composite(mut parts) => (place < parts.len()).then(|| parts.swap_remove(place)),
            _ => None,
        }
    }

    fn convert(self, kind: ScalarKind) -> Option<Self> {
        Some(match (self, kind) {
            (Value::Composite(parts), kind) => {
                Value::Composite(parts.into_iter().map(|part| part.convert(kind)).collect::<Option<_>>()?)
            }
            (Value::Uint(number), ScalarKind::Float) => Value::Float(number as f32),
            (Value::Sint(number), ScalarKind::Float) => Value::Float(number as f32),
            (Value::Uint(number), ScalarKind::Sint) => Value::Sint(number.cast_signed()),
            (Value::Sint(number), ScalarKind::Uint) => Value::Uint(number.cast_unsigned()),
            (same @ Value::Float(_), ScalarKind::Float)
            | (same @ Value::Sint(_), ScalarKind::Sint)
            | (same @ Value::Uint(_), ScalarKind::Uint) => same,
            _ => return None,
        })
    }

    fn combine(self, op: BinaryOperator, other: &Self) -> Option<Self> {
        use BinaryOperator as B;
        Some(match (self, other) {
            (Value::Composite(a), Value::Composite(b)) => {
                let pairs = a.into_iter().zip(b).map(|(a, b)| a.combine(op, b));
                Value::Composite(pairs.collect::<Option<_>>()?)
            }
            (Value::Composite(a), b) => {
                Value::Composite(a.into_iter().map(|a| a.combine(op, b)).collect::<Option<_>>()?)
            }
            (a, Value::Composite(b)) => {
                Value::Composite(b.iter().map(|b| a.clone().combine(op, b)).collect::<Option<_>>()?)
            }
            (Value::Float(a), Value::Float(b)) => Value::Float(match op {
                B::Add => a + b,
                B::Subtract => a - b,
                B::Multiply => a * b,
                B::Divide => a / b,
                _ => return None,
            }),
            (Value::Sint(a), Value::Sint(b)) => Value::Sint(match op {
                B::Add => a.wrapping_add(*b),
                B::Subtract => a.wrapping_sub(*b),
                B::Multiply => a.wrapping_mul(*b),
                B::Divide => a.checked_div(*b)?,
                B::Modulo => a.checked_rem(*b)?,
                B::And => a & b,
                _ => return None,
            }),
            (Value::Sint(a), Value::Uint(b)) => Value::Sint(match op {
                B::ShiftLeft => a.checked_shl(*b)?,
                B::ShiftRight => a.checked_shr(*b)?,
                _ => return None,
            }),
            (Value::Uint(a), Value::Uint(b)) => Value::Uint(match op {
                B::Add => a.wrapping_add(*b),
                B::Subtract => a.wrapping_sub(*b),
                B::Multiply => a.wrapping_mul(*b),
                B::Divide => a.checked_div(*b)?,
                B::Modulo => a.checked_rem(*b)?,
                B::And => a & b,
                B::ShiftLeft => a.checked_shl(*b)?,
                B::ShiftRight => a.checked_shr(*b)?,
                _ => return None,
            }),
            _ => return None,
        })
    }
}
