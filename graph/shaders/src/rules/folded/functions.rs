//! Built-in functions and constructors of values known at creation.

use super::super::steps::Steps;
use super::value::{Kind, Number, Value, unified};

/// The outcome of a call with constant arguments.
pub(super) enum Called {
    /// The value of the call.
    Value(Value),
    /// The value cannot be followed.
    Unknown,
    /// The message and the help text for a call that WGSL does not allow.
    Invalid(String, &'static str),
}

impl From<Option<Value>> for Called {
    fn from(value: Option<Value>) -> Self {
        value.map_or(Self::Unknown, Self::Value)
    }
}

/// Computes a call of a built-in function or constructor. `list` is the template list of the name, as `<f32>`, or empty.
pub(super) fn call(name: &str, list: &str, arguments: Vec<Value>) -> Called {
    match name {
        "f32" | "i32" | "u32" => scalar(name, arguments).into(),
        "array" if list.is_empty() => array(arguments).into(),
        "bitcast" => cast(list, &arguments),
        "fma" | "dot" | "inverseSqrt" => stepped(name, arguments),
        "abs" | "min" | "max" | "clamp" => ordered(name, arguments).into(),
        "sqrt" | "floor" | "ceil" | "trunc" => rounded(name, arguments).into(),
        "select" => select(arguments).into(),
        _ => vector(name, list, arguments).into(),
    }
}

fn kind(name: &str) -> Option<Kind> {
    Some(match name {
        "f32" | "f" => Kind::F32,
        "i32" | "i" => Kind::I32,
        "u32" | "u" => Kind::U32,
        "bool" => Kind::Bool,
        _ => return None,
    })
}

/// Converts a number to the type of a constructor.
fn number(to: Kind, from: Kind, part: Number) -> Option<Number> {
    Some(match (to, part) {
        (Kind::F32, Number::Whole(whole)) => Number::Real(f64::from(whole as f32)),
        (Kind::F32, Number::Real(real)) => {
            let real = f64::from(real as f32);
            return real.is_finite().then_some(Number::Real(real));
        }
        (Kind::F32, Number::Bool(truth)) => Number::Real(f64::from(u8::from(truth))),
        (Kind::I32 | Kind::U32, Number::Bool(truth)) => Number::Whole(i64::from(truth)),
        (Kind::I32, Number::Whole(whole)) if from == Kind::Int => {
            Number::Whole(i64::from(i32::try_from(whole).ok()?))
        }
        (Kind::U32, Number::Whole(whole)) if from == Kind::Int => {
            Number::Whole(i64::from(u32::try_from(whole).ok()?))
        }
        (Kind::I32, Number::Whole(whole)) => Number::Whole(i64::from(whole as i32)),
        (Kind::U32, Number::Whole(whole)) => Number::Whole(i64::from(whole as u32)),
        // Values near the ends of the range depend on rounding.
        (Kind::I32, Number::Real(real)) if real.abs() < 2e9 => Number::Whole(real.trunc() as i64),
        (Kind::U32, Number::Real(real)) if (0.0..4e9).contains(&real) => Number::Whole(real.trunc() as i64),
        (Kind::Bool, Number::Bool(truth)) => Number::Bool(truth),
        _ => return None,
    })
}

fn scalar(name: &str, arguments: Vec<Value>) -> Option<Value> {
    let kind = kind(name)?;
    match &arguments[..] {
        [value] if value.is_scalar => Some(Value::scalar(kind, number(kind, value.kind, value.parts[0])?)),
        _ => None,
    }
}

/// An array of scalars without a written type.
fn array(arguments: Vec<Value>) -> Option<Value> {
    if !arguments.iter().all(|argument| argument.is_scalar) {
        return None;
    }
    let arguments = unified(arguments)?;
    Some(Value::vector(arguments.first()?.kind, arguments.iter().map(|one| one.parts[0]).collect()))
}

fn vector(name: &str, list: &str, arguments: Vec<Value>) -> Option<Value> {
    let rest = name.strip_prefix("vec")?;
    let size = rest.get(..1)?.parse::<usize>().ok().filter(|size| (2..=4).contains(size))?;
    let written = match (rest.get(1..)?, list) {
        ("", "") => None,
        ("", list) => Some(kind(list.strip_prefix('<')?.strip_suffix('>')?.trim())?),
        (letter, _) => Some(kind(letter)?),
    };
    let (kind, parts) = match written {
        Some(kind) => {
            let part = |from: Kind, part: &Number| number(kind, from, *part);
            let parts =
                arguments.iter().flat_map(|one| one.parts.iter().map(move |each| part(one.kind, each)));
            (kind, parts.collect::<Option<Vec<_>>>()?)
        }
        None => {
            let arguments = unified(arguments.clone())?;
            (arguments.first()?.kind, arguments.into_iter().flat_map(|one| one.parts).collect())
        }
    };
    match &arguments[..] {
        [only] if only.is_scalar => Some(Value::vector(kind, vec![*parts.first()?; size])),
        _ if parts.len() == size => Some(Value::vector(kind, parts)),
        _ => None,
    }
}

/// A bit cast, of which only the conversion of numbers without a type is followed.
fn cast(list: &str, arguments: &[Value]) -> Called {
    let [Value { kind: Kind::Int, parts, .. }] = arguments else { return Called::Unknown };
    let is_unsigned = list.contains("u32");
    let fits = |whole: i64| i32::try_from(whole).is_ok() || (is_unsigned && u32::try_from(whole).is_ok());
    let found = parts.iter().find_map(|part| match part {
        Number::Whole(whole) if !fits(*whole) => Some(*whole),
        _ => None,
    });
    let Some(whole) = found else { return Called::Unknown };
    let (message, help) = super::without_type(whole);
    Called::Invalid(message, help)
}

/// Functions with steps that naga does not look at.
fn stepped(name: &str, arguments: Vec<Value>) -> Called {
    let Some(arguments) = unified(arguments) else { return Called::Unknown };
    let Some(first) = arguments.first() else { return Called::Unknown };
    let (kind, is_scalar, is_of_wholes) = (first.kind, first.is_scalar, name == "dot" && !first.is_float());
    if is_of_wholes {
        return dot_of_wholes(&arguments).into();
    }
    let to = if kind == Kind::Int { Kind::Float } else { kind };
    let converted: Option<Vec<Value>> = arguments.into_iter().map(|value| value.converted(to)).collect();
    let reals: Option<Vec<Vec<f64>>> = converted.and_then(|values| values.iter().map(Value::reals).collect());
    let Some(reals) = reals else { return Called::Unknown };
    let mut steps = Steps::new(to == Kind::Float);
    let (parts, is_scalar): (Vec<f64>, bool) = match (name, &reals[..]) {
        ("fma", [one, other, added]) => {
            let factors = one.iter().zip(other).zip(added);
            let part = |((one, other), added): ((&f64, &f64), &f64)| {
                let product = steps.step(*one, "*", *other);
                steps.step(product, "+", *added)
            };
            (factors.map(part).collect(), is_scalar)
        }
        ("dot", [one, other]) => (vec![steps.dot(one, other)], true),
        ("inverseSqrt", [values]) => {
            if let Some(value) = values.iter().find(|value| **value <= 0.0) {
                let message = format!("\"inverseSqrt\" takes values above 0, and one is {value}");
                return Called::Invalid(message, "take the square root of a value above 0");
            }
            (values.iter().map(|value| steps.round(1.0 / value.sqrt())).collect(), is_scalar)
        }
        _ => return Called::Unknown,
    };
    if let Some((message, help)) = super::super::constant_arguments::beyond(name, steps) {
        return Called::Invalid(message, help);
    }
    Called::Value(Value { kind: to, parts: parts.into_iter().map(Number::Real).collect(), is_scalar })
}

fn dot_of_wholes(arguments: &[Value]) -> Option<Value> {
    let [one, other] = arguments else { return None };
    // The sums of concrete integers wrap, and are left out.
    if one.kind != Kind::Int {
        return None;
    }
    let products = one.wholes()?.into_iter().zip(other.wholes()?);
    let products = products.map(|(one, other)| one.checked_mul(other)).collect::<Option<Vec<_>>>()?;
    let sum = products.into_iter().try_fold(0_i64, i64::checked_add)?;
    Some(Value::scalar(one.kind, Number::Whole(sum)))
}

/// Functions that only compare numbers.
fn ordered(name: &str, arguments: Vec<Value>) -> Option<Value> {
    let arguments = unified(arguments)?;
    let first = arguments.first()?;
    let (kind, count) = (first.kind, first.parts.len());
    if arguments.iter().any(|one| one.parts.len() != count || one.is_scalar != first.is_scalar) {
        return None;
    }
    let part = |at: usize| {
        let parts: Vec<Number> = arguments.iter().map(|one| one.parts[at]).collect();
        match (name, &parts[..]) {
            ("abs", [Number::Whole(whole)]) if kind == Kind::I32 => {
                Some(Number::Whole(i64::from((*whole as i32).wrapping_abs())))
            }
            ("abs", [Number::Whole(whole)]) => Some(Number::Whole(whole.wrapping_abs())),
            ("abs", [Number::Real(real)]) => Some(Number::Real(real.abs())),
            ("min", [Number::Whole(one), Number::Whole(other)]) => Some(Number::Whole(*one.min(other))),
            ("max", [Number::Whole(one), Number::Whole(other)]) => Some(Number::Whole(*one.max(other))),
            ("min", [Number::Real(one), Number::Real(other)]) => Some(Number::Real(one.min(*other))),
            ("max", [Number::Real(one), Number::Real(other)]) => Some(Number::Real(one.max(*other))),
            ("clamp", [Number::Whole(value), Number::Whole(low), Number::Whole(high)]) => {
                (low <= high).then(|| Number::Whole(*value.clamp(low, high)))
            }
            ("clamp", [Number::Real(value), Number::Real(low), Number::Real(high)]) => {
                (low <= high).then(|| Number::Real(value.clamp(*low, *high)))
            }
            _ => None,
        }
    };
    let parts = (0..count).map(part).collect::<Option<_>>()?;
    Some(Value { kind, parts, is_scalar: first.is_scalar })
}

/// Functions of one float whose result is near the argument.
fn rounded(name: &str, arguments: Vec<Value>) -> Option<Value> {
    let [value]: [Value; 1] = arguments.try_into().ok()?;
    let value = if value.kind == Kind::Int { value.converted(Kind::Float)? } else { value };
    let steps = value.steps();
    let part = |real: f64| match name {
        "sqrt" => (real >= 0.0).then(|| steps.round(real.sqrt())),
        "floor" => Some(real.floor()),
        "ceil" => Some(real.ceil()),
        _ => Some(real.trunc()),
    };
    let parts = value.reals()?.into_iter().map(|real| part(real).map(Number::Real));
    Some(Value { parts: parts.collect::<Option<_>>()?, ..value })
}

fn select(arguments: Vec<Value>) -> Option<Value> {
    let [reject, accept, condition]: [Value; 3] = arguments.try_into().ok()?;
    let [reject, accept]: [Value; 2] = unified(vec![reject, accept])?.try_into().ok()?;
    if condition.truth()? { Some(accept) } else { Some(reject) }
}
