//! Values known at creation: numbers and vectors of them, and their operators.
//!
//! Each operation returns `None` for what is no valid WGSL, which naga rejects, and for what is not followed here.

use super::super::steps::Steps;

/// The type of the components of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Bool,
    /// Integers without a type, as `1`.
    Int,
    /// Floats without a type, as `1.0`.
    Float,
    I32,
    U32,
    F32,
}

/// One component of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Number {
    Bool(bool),
    Whole(i64),
    Real(f64),
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Value {
    pub(super) kind: Kind,
    pub(super) parts: Vec<Number>,
    pub(super) is_scalar: bool,
}

impl Value {
    pub(super) fn scalar(kind: Kind, number: Number) -> Self {
        Self { kind, parts: vec![number], is_scalar: true }
    }

    pub(super) fn vector(kind: Kind, parts: Vec<Number>) -> Self {
        Self { kind, parts, is_scalar: false }
    }

    pub(super) fn is_float(&self) -> bool {
        matches!(self.kind, Kind::Float | Kind::F32)
    }

    /// The components as floats; `None` for other kinds.
    pub(super) fn reals(&self) -> Option<Vec<f64>> {
        let real = |part: &Number| if let Number::Real(real) = part { Some(*real) } else { None };
        self.parts.iter().map(real).collect()
    }

    /// The components as integers; `None` for other kinds.
    pub(super) fn wholes(&self) -> Option<Vec<i64>> {
        let whole = |part: &Number| if let Number::Whole(whole) = part { Some(*whole) } else { None };
        self.parts.iter().map(whole).collect()
    }

    /// The value of a scalar `bool`; `None` for other values.
    pub(super) fn truth(&self) -> Option<bool> {
        match self.parts[..] {
            [Number::Bool(truth)] if self.is_scalar => Some(truth),
            _ => None,
        }
    }

    /// Begins steps in the type of the value.
    pub(super) fn steps(&self) -> Steps {
        Steps::new(self.kind == Kind::Float)
    }

    /// Converts a value as WGSL does without being told: numbers without a type to those that a type holds.
    pub(super) fn converted(self, to: Kind) -> Option<Self> {
        if self.kind == to {
            return Some(self);
        }
        let part = |part: &Number| match (self.kind, to, *part) {
            (Kind::Int, Kind::I32, Number::Whole(whole)) => {
                i32::try_from(whole).ok().map(|_| Number::Whole(whole))
            }
            (Kind::Int, Kind::U32, Number::Whole(whole)) => {
                u32::try_from(whole).ok().map(|_| Number::Whole(whole))
            }
            (Kind::Int, Kind::Float, Number::Whole(whole)) => Some(Number::Real(whole as f64)),
            (Kind::Int, Kind::F32, Number::Whole(whole)) => Some(Number::Real(f64::from(whole as f32))),
            (Kind::Float, Kind::F32, Number::Real(real)) => {
                let real = f64::from(real as f32);
                real.is_finite().then_some(Number::Real(real))
            }
            _ => None,
        };
        let parts = self.parts.iter().map(part).collect::<Option<_>>()?;
        Some(Self { kind: to, parts, ..self })
    }
}

/// The kind that two values have after WGSL's conversions; `None` if there is none.
pub(super) fn common(one: Kind, other: Kind) -> Option<Kind> {
    let rank = |kind: Kind| match kind {
        Kind::Int => 0,
        Kind::Float => 1,
        _ => 2,
    };
    let (low, high) = if rank(one) <= rank(other) { (one, other) } else { (other, one) };
    match (low, high) {
        _ if low == high => Some(high),
        (Kind::Int, Kind::Float | Kind::F32 | Kind::I32 | Kind::U32) | (Kind::Float, Kind::F32) => Some(high),
        _ => None,
    }
}

/// Converts several values to their common kind.
pub(super) fn unified(values: Vec<Value>) -> Option<Vec<Value>> {
    let mut kinds = values.iter().map(|value| value.kind);
    let first = kinds.next()?;
    let kind = kinds.try_fold(first, common)?;
    values.into_iter().map(|value| value.converted(kind)).collect()
}

/// Computes each component of a result. A scalar goes with each component of a vector.
fn each(
    one: &Value,
    other: &Value,
    kind: Kind,
    mut of: impl FnMut(Number, Number) -> Option<Number>,
) -> Option<Value> {
    let count = one.parts.len().max(other.parts.len());
    let fits = |value: &Value| value.is_scalar || value.parts.len() == count;
    let part = |value: &Value, at: usize| value.parts.get(if value.is_scalar { 0 } else { at }).copied();
    if !fits(one) || !fits(other) {
        return None;
    }
    let parts = (0..count).map(|at| of(part(one, at)?, part(other, at)?)).collect::<Option<_>>()?;
    Some(Value { kind, parts, is_scalar: one.is_scalar && other.is_scalar })
}

/// Computes a unary operator of a value.
pub(super) fn unary(operator: &str, value: Value) -> Option<Value> {
    let part = |part: &Number| match (operator, value.kind, *part) {
        ("!", _, Number::Bool(truth)) => Some(Number::Bool(!truth)),
        ("-", Kind::Int, Number::Whole(whole)) => whole.checked_neg().map(Number::Whole),
        ("-", Kind::I32, Number::Whole(whole)) => {
            Some(Number::Whole(i64::from((whole as i32).wrapping_neg())))
        }
        ("-", _, Number::Real(real)) => Some(Number::Real(-real)),
        ("~", Kind::U32, Number::Whole(whole)) => Some(Number::Whole(i64::from(!(whole as u32)))),
        ("~", _, Number::Whole(whole)) => Some(Number::Whole(!whole)),
        _ => None,
    };
    let parts = value.parts.iter().map(part).collect::<Option<_>>()?;
    Some(Value { parts, ..value })
}

/// Computes a binary operator of two values. Adds steps on floats to `steps`, whose result is then of no use if one
/// leaves the range.
pub(super) fn binary(operator: &str, one: Value, other: Value, steps: &mut Steps) -> Option<Value> {
    if ["<<", ">>"].contains(&operator) {
        let kind = one.kind;
        return each(&one, &other, kind, |one, other| shifted(operator, kind, one, other));
    }
    let [one, other]: [Value; 2] = unified(vec![one, other])?.try_into().ok()?;
    let kind = one.kind;
    if ["==", "!=", "<", ">", "<=", ">="].contains(&operator) {
        return each(&one, &other, Kind::Bool, |one, other| compared(operator, one, other));
    }
    *steps = one.steps();
    each(&one, &other, kind, |one, other| match (one, other) {
        (Number::Real(one), Number::Real(other)) if ["+", "-", "*", "/", "%"].contains(&operator) => {
            Some(Number::Real(steps.step(one, operator, other)))
        }
        (Number::Whole(one), Number::Whole(other)) => whole(operator, kind, one, other).map(Number::Whole),
        (Number::Bool(one), Number::Bool(other)) => match operator {
            "&" | "&&" => Some(Number::Bool(one && other)),
            "|" | "||" => Some(Number::Bool(one || other)),
            _ => None,
        },
        _ => None,
    })
}

fn compared(operator: &str, one: Number, other: Number) -> Option<Number> {
    let order = match (one, other) {
        (Number::Whole(one), Number::Whole(other)) => one.cmp(&other),
        (Number::Real(one), Number::Real(other)) => one.partial_cmp(&other)?,
        (Number::Bool(one), Number::Bool(other)) => one.cmp(&other),
        _ => return None,
    };
    Some(Number::Bool(match operator {
        "==" => order.is_eq(),
        "!=" => order.is_ne(),
        "<" => order.is_lt(),
        ">" => order.is_gt(),
        "<=" => order.is_le(),
        _ => order.is_ge(),
    }))
}

/// Computes an operator of two integers. Concrete ones wrap; others have to fit 64 bits.
fn whole(operator: &str, kind: Kind, one: i64, other: i64) -> Option<i64> {
    let value = match operator {
        "+" => i128::from(one) + i128::from(other),
        "-" => i128::from(one) - i128::from(other),
        "*" => i128::from(one) * i128::from(other),
        "/" => i128::from(one).checked_div(i128::from(other))?,
        "%" => i128::from(one).checked_rem(i128::from(other))?,
        "&" => i128::from(one & other),
        "|" => i128::from(one | other),
        "^" => i128::from(one ^ other),
        _ => return None,
    };
    match kind {
        Kind::I32 => Some(i64::from(value as i32)),
        Kind::U32 => Some(i64::from(value as u32)),
        _ => i64::try_from(value).ok(),
    }
}

fn shifted(operator: &str, kind: Kind, one: Number, other: Number) -> Option<Number> {
    let (Number::Whole(one), Number::Whole(by)) = (one, other) else { return None };
    let bits = if kind == Kind::Int { 64 } else { 32 };
    let by = u32::try_from(by).ok().filter(|by| *by < bits)?;
    if operator == ">>" {
        return Some(Number::Whole(one >> by));
    }
    let value = i128::from(one) << by;
    let fits = match kind {
        Kind::I32 => i32::try_from(value).is_ok(),
        Kind::U32 => u32::try_from(value).is_ok(),
        _ => i64::try_from(value).is_ok(),
    };
    fits.then_some(Number::Whole(value as i64))
}
