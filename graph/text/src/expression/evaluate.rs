//! The evaluator of expressions. Every operation is checked: a result that is not finite is an error at its place.

use std::ops::Range;

use super::{
    BinaryOperator, ErrorKind, Expression, ExpressionError, ExpressionKind, FUNCTIONS, Reference,
    UnaryOperator, UnknownName, Value,
};
use crate::diagnostic::list_of;

const MAX_LIST: usize = 65_536;

/// The names that an expression can use, with their values.
pub trait Scope {
    /// Returns the value of a name, which may contain dots. `None` if the name has no value.
    fn lookup(&self, name: &str) -> Option<Value>;
    /// Borrows the value of a name, to avoid copies of lists and strings. `None` if the value cannot be borrowed;
    /// [`Self::lookup`] is then used.
    fn borrow(&self, _name: &str) -> Option<&Value> {
        None
    }
    /// Translates a reference written in this scope to the name at the top level of the pipeline. The two names differ
    /// in subgraphs.
    fn reference(&self, reference: &Reference) -> Reference {
        reference.clone()
    }
    /// All visible names, from which suggestions for misspelt names are made.
    fn names(&self) -> Vec<String>;
    /// Returns `true` if a name is declared, but has no value because its declaration has an error of its own.
    fn is_broken(&self, _name: &str) -> bool {
        false
    }
    /// The words of the enumeration `name`; `None` if the name does not belong to an enumeration.
    fn words(&self, _name: &str) -> Option<&[String]> {
        None
    }
    /// The visible names that begin with `head` and a dot, from which suggestions are made. Empty if `head` has no
    /// members or does not exist.
    fn members(&self, _head: &str) -> Vec<String> {
        Vec::new()
    }
}

/// Implements a scope by a function that returns the value of a name; the scope lists no names.
impl<F: Fn(&str) -> Option<Value>> Scope for F {
    fn lookup(&self, name: &str) -> Option<Value> {
        self(name)
    }

    fn names(&self) -> Vec<String> {
        Vec::new()
    }
}

/// Evaluates an expression in a scope.
///
/// # Errors
/// The first error, with its byte range in the source string.
pub fn evaluate(expression: &Expression, scope: &dyn Scope) -> Result<Value, ExpressionError> {
    let range = || expression.range.clone();
    match &expression.kind {
        ExpressionKind::Literal(value) => Ok(value.clone()),
        ExpressionKind::Name(name) => scope.lookup(name).ok_or_else(|| unknown_name(name, range(), scope)),
        ExpressionKind::Reference(reference) => Ok(Value::Reference(scope.reference(reference))),
        ExpressionKind::Unary(UnaryOperator::Not, operand) => Ok(Value::Bool(!boolean(operand, scope)?)),
        ExpressionKind::Unary(UnaryOperator::Negate, operand) => {
            elementwise(&evaluate(operand, scope)?, &Value::Number(-1.0), range(), &|a, b| Ok(a * b))
        }
        ExpressionKind::Binary(operator, left, right) => binary(*operator, left, right, scope, range()),
        ExpressionKind::Conditional(condition, yes, no) => {
            if boolean(condition, scope)? {
                evaluate(yes, scope)
            } else {
                evaluate(no, scope)
            }
        }
        ExpressionKind::Call(name, arguments) => call(name, arguments, scope, range()),
        ExpressionKind::Index(list, index) => {
            let evaluated;
            let elements = match seen(list, scope) {
                Some(elements) => elements,
                None => {
                    evaluated = evaluate(list, scope)?;
                    &evaluated
                }
            };
            let at = number(index, scope)?;
            if let Value::Reference(reference) = elements {
                return round(reference, at, index).map(Value::Reference);
            }
            let Value::List(elements) = elements else {
                return Err(type_error(list.range.clone(), "only a list has elements"));
            };
            if at.fract() != 0.0 || at < 0.0 || at >= elements.len() as f64 {
                let name = match &list.kind {
                    ExpressionKind::Name(name) => Some(name),
                    _ => None,
                };
                return Err(without_element(name, elements.len(), at, range(), index.range.clone()));
            }
            Ok(elements[at as usize].clone())
        }
        ExpressionKind::List(elements) => {
            let mut list = Vec::new();
            let mut size = 0;
            for element in elements {
                let value = evaluate(element, scope)?;
                size += size_of(&value);
                if size > MAX_LIST {
                    return Err(arithmetic(range(), format!("a list has at most {MAX_LIST} elements")));
                }
                list.push(value);
            }
            Ok(Value::List(list))
        }
    }
}

/// Evaluates an expression into `to`, and returns `true` if that value changed. The memory of lists in `to` is reused
/// for list literals and named lists; other lists and strings are allocated anew.
///
/// # Errors
/// The errors of [`evaluate`]. Some elements of a list in `to` may already be updated then.
pub fn evaluate_into(
    expression: &Expression,
    scope: &dyn Scope,
    to: &mut Value,
) -> Result<bool, ExpressionError> {
    if let (ExpressionKind::List(items), Value::List(list)) = (&expression.kind, &mut *to)
        && items.len() == list.len()
    {
        let mut is_changed = false;
        for (item, to) in items.iter().zip(list) {
            is_changed |= evaluate_into(item, scope, to)?;
        }
        return Ok(is_changed);
    }
    match seen(expression, scope) {
        Some(value) if value == to => Ok(false),
        Some(value) => {
            to.assign(value);
            Ok(true)
        }
        None => {
            let value = evaluate(expression, scope)?;
            Ok(std::mem::replace(to, value) != *to)
        }
    }
}

/// The error for an index `at` that a list does not have. `name` is the name of the list, if it has one.
fn without_element(
    name: Option<&String>,
    count: usize,
    at: f64,
    range: Range<usize>,
    index: Range<usize>,
) -> ExpressionError {
    let Some(name) = name else {
        return arithmetic(index, format!("the list has {count} elements, and no element {at}"));
    };
    let message = format!("\"{name}\" has {count} elements, and no element {at}");
    let help = match count.checked_sub(1) {
        None => "the list is empty: guard the index with len(list) > 0".to_owned(),
        Some(0) => format!("its one element is {name}[0]"),
        Some(last) => {
            format!("its elements are {name}[0] to {name}[{last}]; the last is {name}[len({name}) - 1]")
        }
    };
    ExpressionError { help: Some(help), ..arithmetic(range, message) }
}

/// Returns the reference to the version of a resource that iteration `at` (from 0) of a loop wrote.
fn round(reference: &Reference, at: f64, index: &Expression) -> Result<Reference, ExpressionError> {
    let Some(pass) = reference.version.as_ref().filter(|version| *version != "0") else {
        let error = type_error(index.range.clone(), "only the version that a loop wrote has rounds");
        let help = Some(format!("write the name of the loop: &{}@LOOP[0]", reference.resource));
        return Err(ExpressionError { help, ..error });
    };
    if at.fract() != 0.0 || at < 0.0 {
        let error = arithmetic(index.range.clone(), format!("there is no round {at}"));
        return Err(ExpressionError { help: Some("rounds are counted from 0".to_owned()), ..error });
    }
    Ok(Reference { version: Some(format!("{pass}.{at}")), ..reference.clone() })
}

/// Borrows the value of a literal, or of a name if the scope can lend a reference to its value. `None` for other
/// expressions.
fn seen<'a>(expression: &'a Expression, scope: &'a dyn Scope) -> Option<&'a Value> {
    match &expression.kind {
        ExpressionKind::Literal(value) => Some(value),
        ExpressionKind::Name(name) => scope.borrow(name),
        _ => None,
    }
}

/// The number of values in a value: the value itself and, for a list, all nested elements.
fn size_of(value: &Value) -> usize {
    match value {
        Value::List(list) => 1 + list.iter().map(size_of).sum::<usize>(),
        _ => 1,
    }
}

/// Creates the error for a name that has no value in a scope.
pub fn unknown_name(name: &str, range: Range<usize>, scope: &dyn Scope) -> ExpressionError {
    let members = name.rsplit_once('.').map_or_else(Vec::new, |(head, _)| scope.members(head));
    let known = if members.is_empty() { scope.names() } else { members };
    let kind = if scope.is_broken(name) { ErrorKind::Follows } else { ErrorKind::UnknownName };
    let unknown = Some(Box::new(UnknownName { name: name.to_owned(), known, is_complete: false }));
    ExpressionError { unknown, ..ExpressionError::new(kind, range, format!("there is no \"{name}\"")) }
}

fn type_error(range: Range<usize>, message: impl Into<String>) -> ExpressionError {
    ExpressionError::new(ErrorKind::Type, range, message)
}

fn arithmetic(range: Range<usize>, message: impl Into<String>) -> ExpressionError {
    ExpressionError::new(ErrorKind::Arithmetic, range, message)
}

fn boolean(expression: &Expression, scope: &dyn Scope) -> Result<bool, ExpressionError> {
    match evaluate(expression, scope)? {
        Value::Bool(value) => Ok(value),
        other => Err(unwanted(expression, "a boolean", &other)),
    }
}

fn number(expression: &Expression, scope: &dyn Scope) -> Result<f64, ExpressionError> {
    match evaluate(expression, scope)? {
        Value::Number(value) => Ok(value),
        other => Err(unwanted(expression, "a number", &other)),
    }
}

fn unwanted(expression: &Expression, wanted: &str, found: &Value) -> ExpressionError {
    type_error(expression.range.clone(), format!("{wanted} is wanted, this is {}", found.kind_name()))
}

fn finite(value: f64, range: Range<usize>) -> Result<f64, ExpressionError> {
    if value.is_finite() { Ok(value) } else { Err(arithmetic(range, "the result is not a finite number")) }
}

fn binary(
    operator: BinaryOperator,
    left: &Expression,
    right: &Expression,
    scope: &dyn Scope,
    range: Range<usize>,
) -> Result<Value, ExpressionError> {
    use BinaryOperator as Op;
    match operator {
        Op::And => return Ok(Value::Bool(boolean(left, scope)? && boolean(right, scope)?)),
        Op::Or => return Ok(Value::Bool(boolean(left, scope)? || boolean(right, scope)?)),
        _ => {}
    }
    if let (Op::Equal | Op::NotEqual, Some(a), Some(b)) = (operator, seen(left, scope), seen(right, scope))
        && std::mem::discriminant(a) == std::mem::discriminant(b)
    {
        return Ok(Value::Bool((a == b) == (operator == Op::Equal)));
    }
    let (a, b) = (evaluate(left, scope)?, evaluate(right, scope)?);
    let compare = |test: fn(f64, f64) -> bool| match (&a, &b) {
        (Value::Number(a), Value::Number(b)) => Ok(Value::Bool(test(*a, *b))),
        _ => Err(type_error(
            range.clone(),
            format!("{} and {} cannot be ordered", a.kind_name(), b.kind_name()),
        )),
    };
    match operator {
        Op::Equal | Op::NotEqual => {
            if std::mem::discriminant(&a) != std::mem::discriminant(&b) {
                let message = format!("{} is never equal to {}", a.kind_name(), b.kind_name());
                return Err(type_error(range, message));
            }
            Ok(Value::Bool((a == b) == (operator == Op::Equal)))
        }
        Op::Less => compare(|a, b| a < b),
        Op::LessEqual => compare(|a, b| a <= b),
        Op::Greater => compare(|a, b| a > b),
        Op::GreaterEqual => compare(|a, b| a >= b),
        Op::Add => elementwise(&a, &b, range, &|a, b| Ok(a + b)),
        Op::Subtract => elementwise(&a, &b, range, &|a, b| Ok(a - b)),
        Op::Multiply => elementwise(&a, &b, range, &|a, b| Ok(a * b)),
        Op::Divide | Op::Remainder => {
            let at = right.range.clone();
            elementwise(&a, &b, range, &move |a, b| {
                if b == 0.0 {
                    return Err(arithmetic(at.clone(), "this is a division by zero"));
                }
                Ok(if operator == Op::Divide { a / b } else { a.rem_euclid(b) })
            })
        }
        Op::And | Op::Or => Err(type_error(range, "a boolean is wanted")),
    }
}

/// Applies an operation to two numbers, to each element of a list and a number, or to pairs of elements of two lists of
/// equal length.
fn elementwise(
    a: &Value,
    b: &Value,
    range: Range<usize>,
    operation: &dyn Fn(f64, f64) -> Result<f64, ExpressionError>,
) -> Result<Value, ExpressionError> {
    let pair = |(a, b)| elementwise(a, b, range.clone(), operation);
    let list = |elements: Result<_, _>| elements.map(Value::List);
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => Ok(Value::Number(finite(operation(*a, *b)?, range)?)),
        (Value::List(all), Value::Number(_)) => list(all.iter().map(|a| pair((a, b))).collect()),
        (Value::Number(_), Value::List(all)) => list(all.iter().map(|b| pair((a, b))).collect()),
        (Value::List(a), Value::List(b)) if a.len() == b.len() => list(a.iter().zip(b).map(pair).collect()),
        (Value::List(a), Value::List(b)) => Err(type_error(
            range,
            format!("a list of {} and one of {} elements do not fit", a.len(), b.len()),
        )),
        _ => {
            Err(type_error(range, format!("{} and {} cannot be computed with", a.kind_name(), b.kind_name())))
        }
    }
}

fn call(
    name: &str,
    arguments: &[Expression],
    scope: &dyn Scope,
    range: Range<usize>,
) -> Result<Value, ExpressionError> {
    let Some(function) = FUNCTIONS.iter().find(|function| function.name == name) else {
        let known: Vec<String> = FUNCTIONS.iter().map(|function| function.name.to_owned()).collect();
        return Err(ExpressionError {
            range: range.start..range.start + name.len(),
            kind: ErrorKind::UnknownName,
            message: format!("there is no function \"{name}\""),
            help: Some(format!("the functions are {}", list_of(&known))),
            unknown: Some(Box::new(UnknownName { name: name.to_owned(), known, is_complete: true })),
        });
    };
    let (min, max) = function.arguments;
    if !(min..=max).contains(&arguments.len()) {
        let wanted = if min == max { min.to_string() } else { format!("{min} or more") };
        return Err(type_error(range, format!("{name} takes {wanted} arguments, not {}", arguments.len())));
    }
    if let "min" | "max" = name {
        return extreme(name, arguments, scope);
    }
    // No other function has more.
    let mut values = [const { Value::Bool(false) }; 3];
    for (value, argument) in values.iter_mut().zip(arguments) {
        *value = evaluate(argument, scope)?;
    }
    let map = |function: &dyn Fn(f64) -> f64| {
        elementwise(&values[0], &Value::Number(0.0), range.clone(), &|a, _| Ok(function(a)))
    };
    let wanted = |kind: &str| type_error(arguments[0].range.clone(), format!("{name} wants {kind}"));
    match name {
        "abs" => map(&f64::abs),
        "ceil" => map(&f64::ceil),
        "floor" => map(&f64::floor),
        "round" => map(&f64::round),
        "exp2" => map(&f64::exp2),
        "log2" => map(&f64::log2),
        "sqrt" => map(&f64::sqrt),
        "len" => match &values[0] {
            Value::List(list) if list.len() <= MAX_LIST => Ok(Value::Number(list.len() as f64)),
            _ => Err(wanted("a list")),
        },
        "mip_count" => {
            let sides =
                values[0].numbers().filter(|sides| !sides.is_empty()).ok_or_else(|| wanted("a size"))?;
            let max = sides.into_iter().fold(0.0, f64::max);
            if max < 1.0 {
                return Err(arithmetic(arguments[0].range.clone(), "a size below 1 has no mip levels"));
            }
            Ok(Value::Number(max.log2().floor() + 1.0))
        }
        "align" => {
            let at = arguments[1].range.clone();
            elementwise(&values[0], &values[1], range.clone(), &move |value, step| {
                if step <= 0.0 {
                    return Err(arithmetic(at.clone(), "the step of align is above zero"));
                }
                Ok((value / step).ceil() * step)
            })
        }
        "clamp" => {
            let low = elementwise(&values[0], &values[1], range.clone(), &|a, b| Ok(a.max(b)))?;
            elementwise(&low, &values[2], range.clone(), &|a, b| Ok(a.min(b)))
        }
        _ => Err(wanted("another name")),
    }
}

/// Evaluates `min` or `max`: the smallest or greatest of the numbers and list elements in the arguments.
fn extreme(name: &str, arguments: &[Expression], scope: &dyn Scope) -> Result<Value, ExpressionError> {
    let pick = if name == "min" { f64::min } else { f64::max };
    let mut found: Option<f64> = None;
    let wanted = |argument: &Expression, kind: &str| {
        type_error(argument.range.clone(), format!("{name} wants {kind}"))
    };
    for argument in arguments {
        let mut take = |value: &Value| {
            let number = value.number().ok_or_else(|| wanted(argument, "numbers"))?;
            found = Some(found.map_or(number, |found| pick(found, number)));
            Ok(())
        };
        match evaluate(argument, scope)? {
            Value::List(list) => list.iter().try_for_each(take)?,
            value => take(&value)?,
        }
    }
    found.map(Value::Number).ok_or_else(|| wanted(&arguments[0], "at least one number"))
}

#[cfg(test)]
mod tests {
    use super::super::parse;
    use super::*;

    struct Names;

    impl Scope for Names {
        fn lookup(&self, name: &str) -> Option<Value> {
            match name {
                "far" => Some(Value::List([10.0, 30.0].map(Value::Number).to_vec())),
                "size" => Some(Value::Number(2048.0)),
                "viewport.width" => Some(Value::Number(1281.0)),
                "mode" => Some(Value::Text("soft".into())),
                _ => None,
            }
        }

        fn names(&self) -> Vec<String> {
            ["far", "size", "viewport.width", "mode"].map(str::to_owned).to_vec()
        }
    }

    fn run(text: &str) -> Result<Value, ExpressionError> {
        evaluate(&parse(text)?, &Names)
    }

    #[test]
    fn expressions_have_the_precedence_of_arithmetic() {
        for (text, value) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("-2 - -3", 1.0),
            ("10 - 4 - 3", 3.0),
            ("2 * 3 % 4", 2.0),
            ("size / 2", 1024.0),
            ("ceil(viewport.width / 16)", 81.0),
            ("align(viewport.width, 8)", 1288.0),
            ("len(far)", 2.0),
            ("far[1]", 30.0),
            ("max(far)", 30.0),
            ("mip_count([size, 1])", 12.0),
            ("clamp(5, 0, 3)", 3.0),
            ("1 < 2 && !false ? 4 : 5", 4.0),
            ("mode == 'soft' ? 1e2 : 0.5", 100.0),
        ] {
            assert_eq!(run(text), Ok(Value::Number(value)), "{text}");
        }
        assert_eq!(run("far / 2"), Ok(Value::List(vec![Value::Number(5.0), Value::Number(15.0)])));
    }

    #[test]
    fn errors_are_found_at_their_place() {
        for (text, range, kind) in [
            ("size / (2 - 2)", 7..14, ErrorKind::Arithmetic),
            ("1e308 * 10", 0..10, ErrorKind::Arithmetic),
            ("sqrt(-1)", 0..8, ErrorKind::Arithmetic),
            ("far[2]", 0..6, ErrorKind::Arithmetic),
            ("sise + 1", 0..4, ErrorKind::UnknownName),
            ("flor(1)", 0..4, ErrorKind::UnknownName),
            ("1 + ", 4..4, ErrorKind::Syntax),
            ("(1", 2..2, ErrorKind::Syntax),
            ("1 2", 2..3, ErrorKind::Syntax),
            ("mode + 1", 0..8, ErrorKind::Type),
            ("size ? 1 : 2", 0..4, ErrorKind::Type),
            ("min()", 0..5, ErrorKind::Type),
        ] {
            let error = run(text).unwrap_err();
            assert_eq!((error.range.clone(), error.kind), (range, kind), "{text}: {}", error.message);
        }
        let unknown = run("2 * sise").unwrap_err();
        assert_eq!(unknown.range, 4..8);
        assert!(unknown.unknown.is_some_and(|unknown| unknown.known.iter().any(|name| name == "size")));
    }

    #[test]
    fn deep_nesting_is_an_error_and_not_a_stack_overflow() {
        assert_eq!(run(&format!("1{}", "+1".repeat(2000))).unwrap_err().kind, ErrorKind::Syntax);
        assert_eq!(run(&format!("1{}", "+1".repeat(100))), Ok(Value::Number(101.0)));
        assert_eq!(run(&format!("far{}", "[0]".repeat(1000))).unwrap_err().kind, ErrorKind::Syntax);
        for text in ["(".repeat(4000), "-".repeat(4000), "[".repeat(4000), "!".repeat(4000)] {
            assert_eq!(run(&text).unwrap_err().kind, ErrorKind::Syntax);
        }
    }

    #[test]
    fn a_list_is_evaluated_in_the_memory_of_the_one_before() {
        let memory = |value: &Value| match value {
            Value::List(list) => list.as_ptr(),
            _ => std::ptr::null(),
        };
        for text in ["[size, far[0], 2]", "[far, [1, size]]"] {
            let expression = parse(text).unwrap();
            let wanted = evaluate(&expression, &Names).unwrap();
            let mut value = wanted.clone();
            assert_eq!(evaluate_into(&expression, &Names, &mut value), Ok(false), "{text}");
            let Value::List(list) = &mut value else { panic!("{text}") };
            list[0] = Value::Number(-1.0);
            let before = memory(&value);
            assert_eq!(evaluate_into(&expression, &Names, &mut value), Ok(true), "{text}");
            assert_eq!((&value, memory(&value)), (&wanted, before), "{text}");
        }
        let mut value = Value::Bool(false);
        let doubled = parse("far * 2").unwrap();
        assert_eq!(evaluate_into(&doubled, &Names, &mut value), Ok(true));
        assert_eq!(evaluate_into(&doubled, &Names, &mut value), Ok(false));
        assert!(evaluate_into(&parse("[1, 1 / 0]").unwrap(), &Names, &mut value).is_err());
    }
}
