//! Arguments of built-in functions that are constants outside of what the function takes.
//!
//! WGSL makes such a call an error when the module is created, although nothing runs yet; naga looks only at calls
//! whose arguments are all constant. Rejected here, as browsers do:
//!
//! | call | rejected |
//! |---|---|
//! | `clamp(e, low, high)` | low above high |
//! | `smoothstep(low, high, x)` | low equal to high, or a step beyond the largest f32 |
//! | `extractBits`, `insertBits` | offset + count above 32 |
//! | `ldexp(e1, e2)` | e2 above 128 |
//! | `pack2x16float`, `quantizeToF16` | a value beyond ±65,504 |
//! | `unpack2x16float`, `bitcast<f32>` | bits of an infinity or of no number |
//! | `mix`, `reflect`, `determinant`, `ldexp` of constants | a value beyond the largest f32 |
//! | `faceForward`, `refract` of constants | a step beyond the largest f32 |
//!
//! A `let` is no constant, whatever its value. Source: *WebGPU Shading Language*, "Built-in Functions".

use naga::{Arena, Expression, Function, Handle, Literal, MathFunction, Module, ScalarKind, TypeInner};

use super::steps::Steps;
use crate::codes;
use crate::written::ir;
use crate::written::rejection::Rejection;

/// Returns rejections of calls of built-in functions whose constant arguments are outside the function's domain.
pub(crate) fn found(module: &Module) -> Vec<Rejection> {
    let globals = module.global_expressions.iter().filter_map(|(handle, expression)| {
        let (message, help) = infinite(expression)?;
        let place = module.global_expressions.get_span(handle);
        Some(Rejection::new(codes::WGSL_INVALID, message, place).help(help))
    });
    let in_functions = ir::functions(module).flat_map(|function| {
        let calls = Constants { module, function };
        function.expressions.iter().filter_map(move |(handle, _)| calls.rejection(handle)).collect::<Vec<_>>()
    });
    globals.chain(in_functions).collect()
}

/// The message and the help text for an infinite `f16` literal, which naga accepts as the result of a conversion;
/// `None` for other expressions.
fn infinite(expression: &Expression) -> Option<(String, &'static str)> {
    let Expression::Literal(Literal::F16(value)) = expression else { return None };
    let is_infinite = !f32::from(*value).is_finite();
    is_infinite.then(|| {
        ("the value does not fit in an f16, which ends at 65,504".to_owned(), "take a smaller value")
    })
}

/// An evaluator for constant expressions in a function.
pub(super) struct Constants<'m> {
    pub(super) module: &'m Module,
    pub(super) function: &'m Function,
}

impl Constants<'_> {
    fn rejection(&self, handle: Handle<Expression>) -> Option<Rejection> {
        let (message, help) = match self.function.expressions[handle] {
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                self.math(fun, [Some(arg), arg1, arg2, arg3])?
            }
            Expression::As { expr, kind: ScalarKind::Float, convert: None } => {
                let literals = self.literals(&self.function.expressions, expr)?;
                let bits = literals.into_iter().find_map(|literal| {
                    match literal {
                        Literal::U32(bits) => Some(bits),
                        Literal::I32(bits) => Some(bits.cast_unsigned()),
                        _ => None,
                    }
                    .filter(|bits| !f32::from_bits(*bits).is_finite())
                })?;
                let message = format!("the bits 0x{bits:08x} are no finite f32");
                (message, "compare bits as integers, or take the bits of a finite number")
            }
            ref other => infinite(other)?,
        };
        let place = self.function.expressions.get_span(handle);
        Some(Rejection::new(codes::WGSL_INVALID, message, place).help(help))
    }

    fn math(
        &self,
        fun: MathFunction,
        arguments: [Option<Handle<Expression>>; 4],
    ) -> Option<(String, &'static str)> {
        let argument = |at: usize| arguments[at].and_then(|argument| self.values(argument));
        let pairs = |one: usize, other: usize| Some(argument(one)?.into_iter().zip(argument(other)?));
        Some(match fun {
            MathFunction::Clamp => {
                let (low, high) = pairs(1, 2)?.find(|(low, high)| low > high)?;
                let message = format!("\"clamp\" has the low bound {low} above the high bound {high}");
                (message, "exchange the bounds")
            }
            MathFunction::SmoothStep => {
                if let Some((low, _)) = pairs(0, 1)?.find(|(low, high)| low == high) {
                    (format!("\"smoothstep\" has both edges at {low}"), "use \"step\", or edges apart")
                } else {
                    let mut steps = self.steps(arguments[0]?)?;
                    let x = argument(2);
                    for (at, (low, high)) in pairs(0, 1)?.enumerate() {
                        steps.smoothstep(low, high, x.as_ref().and_then(|x| x.get(at)).copied());
                    }
                    beyond("smoothstep", steps)?
                }
            }
            MathFunction::FaceForward => {
                argument(0)?;
                let mut steps = self.steps(arguments[1]?)?;
                steps.dot(&argument(1)?, &argument(2)?);
                beyond("faceForward", steps)?
            }
            MathFunction::Refract => {
                let mut steps = self.steps(arguments[0]?)?;
                steps.refract(&argument(0)?, &argument(1)?, *argument(2)?.first()?);
                beyond("refract", steps)?
            }
            MathFunction::ExtractBits | MathFunction::InsertBits => {
                let first = if fun == MathFunction::ExtractBits { 1 } else { 2 };
                let (offset, count) =
                    pairs(first, first + 1)?.find(|(offset, count)| offset + count > 32.0)?;
                let message =
                    format!("the offset {offset} and the count {count} of bits are more than 32 together");
                (message, "take fewer bits, or a smaller offset")
            }
            MathFunction::Ldexp => {
                let too_large = argument(1)?.into_iter().find(|exponent| *exponent > 128.0);
                if let Some(exponent) = too_large {
                    (format!("\"ldexp\" has the exponent {exponent}, above 128"), "no f32 is so large")
                } else {
                    let values = pairs(0, 1)?.map(|(value, exponent)| value * exponent.exp2());
                    overflow("ldexp", values)?
                }
            }
            MathFunction::Mix => {
                let (one, other, share) = (argument(0)?, argument(1)?, argument(2)?);
                let shares = share.iter().chain(share.iter().cycle().filter(|_| share.len() == 1));
                let parts = one.iter().zip(&other).zip(shares);
                let steps = |((one, other), share): ((&f64, &f64), &f64)| {
                    [one * (1.0 - share), other * share, one * (1.0 - share) + other * share]
                };
                overflow("mix", parts.flat_map(steps))?
            }
            MathFunction::Reflect => {
                let (incident, normal) = (argument(0)?, argument(1)?);
                let dot: f64 = incident.iter().zip(&normal).map(|(one, other)| one * other).sum();
                let steps = incident
                    .iter()
                    .zip(&normal)
                    .flat_map(|(incident, normal)| [dot, 2.0 * dot * normal, incident - 2.0 * dot * normal]);
                overflow("reflect", steps)?
            }
            MathFunction::Determinant => overflow("determinant", determinant_steps(&argument(0)?))?,
            MathFunction::Pack2x16float | MathFunction::QuantizeToF16 => {
                let value = argument(0)?.into_iter().find(|value| value.abs() > 65_504.0)?;
                (format!("{value} does not fit in a half, which ends at 65,504"), "clamp the value first")
            }
            MathFunction::Unpack2x16float => {
                let halves = |bits: f64| [bits as u32 & 0xffff, bits as u32 >> 16];
                let half = argument(0)?.into_iter().flat_map(halves).find(|half| half & 0x7c00 == 0x7c00)?;
                (format!("the bits 0x{half:04x} are no finite half"), "take the bits of a finite number")
            }
            _ => return None,
        })
    }

    /// Begins steps in the type of a constant argument; `None` if it is not an `f32`.
    fn steps(&self, argument: Handle<Expression>) -> Option<Steps> {
        let first = *self.literals(&self.function.expressions, argument)?.first()?;
        matches!(first, Literal::F32(_)).then(Steps::default)
    }

    /// The components of a constant expression; `None` if it is not constant, or is the value of a `let`.
    pub(super) fn values(&self, handle: Handle<Expression>) -> Option<Vec<f64>> {
        self.literals(&self.function.expressions, handle)?.into_iter().map(number).collect()
    }

    fn literals(&self, arena: &Arena<Expression>, handle: Handle<Expression>) -> Option<Vec<Literal>> {
        let is_local = std::ptr::eq(arena, &self.function.expressions);
        if is_local && self.function.named_expressions.contains_key(&handle) {
            return None;
        }
        match &arena[handle] {
            Expression::Literal(literal) => Some(vec![*literal]),
            Expression::Constant(constant) => {
                self.literals(&self.module.global_expressions, self.module.constants[*constant].init)
            }
            Expression::Splat { size, value } => {
                Some(vec![*self.literals(arena, *value)?.first()?; *size as usize])
            }
            Expression::Compose { components, .. } => {
                let parts = components.iter().map(|component| self.literals(arena, *component));
                Some(parts.collect::<Option<Vec<_>>>()?.concat())
            }
            Expression::ZeroValue(ty) => match self.module.types[*ty].inner {
                TypeInner::Scalar(scalar) => Some(vec![Literal::zero(scalar)?]),
                TypeInner::Vector { size, scalar } => Some(vec![Literal::zero(scalar)?; size as usize]),
                _ => None,
            },
            _ => None,
        }
    }
}

/// The message and the help text for the first step that leaves the range of its type; `None` if no step does.
fn beyond(function: &str, steps: Steps) -> Option<(String, &'static str)> {
    let step = steps.beyond?;
    Some((
        format!("\"{function}\" of these constants computes {step}, which is beyond the range of its type"),
        "take values closer to 1",
    ))
}

/// The message and the help text for the first value outside the range of `f32`; `None` if all values fit.
fn overflow(function: &str, mut values: impl Iterator<Item = f64>) -> Option<(String, &'static str)> {
    let value = values.find(|value| value.abs() > f64::from(f32::MAX))?;
    Some((
        format!("\"{function}\" of these constants is {value:e}, which no f32 holds"),
        "take smaller values",
    ))
}

/// The intermediate products and sums of a determinant; the last is its value. `values` is a square matrix, column by
/// column.
fn determinant_steps(values: &[f64]) -> impl Iterator<Item = f64> {
    let side = values.len().isqrt();
    let mut steps = Vec::new();
    expand(values, side, &mut steps);
    steps.into_iter()
}

/// Computes a determinant by expansion along the first column. `values` is the matrix column by column, `side` its
/// number of rows. Adds every intermediate product and sum to `steps`.
fn expand(values: &[f64], side: usize, steps: &mut Vec<f64>) -> f64 {
    if side <= 1 {
        return values.first().copied().unwrap_or_default();
    }
    let mut sum = 0.0;
    for row in 0..side {
        let is_of_minor = |(at, _): &(usize, &f64)| *at >= side && at % side != row;
        let minor: Vec<f64> =
            values.iter().enumerate().filter(is_of_minor).map(|(_, value)| *value).collect();
        let product = values[row] * expand(&minor, side - 1, steps);
        sum += if row % 2 == 0 { product } else { -product };
        steps.extend([product, sum]);
    }
    sum
}

fn number(literal: Literal) -> Option<f64> {
    Some(match literal {
        Literal::F64(value) | Literal::AbstractFloat(value) => value,
        Literal::F32(value) => f64::from(value),
        Literal::F16(value) => f64::from(f32::from(value)),
        Literal::U32(value) => f64::from(value),
        Literal::I32(value) => f64::from(value),
        Literal::AbstractInt(value) | Literal::I64(value) => value as f64,
        Literal::U64(value) => value as f64,
        _ => return None,
    })
}
