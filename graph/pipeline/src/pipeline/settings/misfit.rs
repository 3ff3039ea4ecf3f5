//! Values that break the declaration of their parameter: type, range and order.

use umbragraph_text::diagnostic::{Code, codes, list_of};
use umbragraph_text::expression::Value;
use umbragraph_text::language::{Order, ParameterDeclaration, ParameterType};

/// The reason for which a value is invalid: diagnostic code, message and help text.
pub(super) type Misfit = (Code, String, String);

/// The reason to reject a new value of a live parameter, as diagnostic code, message and help text. `None` for a valid
/// value. `before` is the previous, valid value.
pub fn rejected(
    name: &str,
    declaration: &ParameterDeclaration,
    value: &Value,
    before: &Value,
) -> Option<(Code, String, String)> {
    if !is_alike(value, before) {
        let message = match (value, before) {
            (Value::List(given), Value::List(before)) if given.len() != before.len() => {
                format!("\"{name}\" has {} elements, and is given {}", before.len(), given.len())
            }
            _ => format!("the parameter \"{name}\" is {}, this is {}", before.kind_name(), value.kind_name()),
        };
        let help = "what is live keeps its type and length; plan again for another".to_owned();
        return Some((codes::SETTING_TYPE, message, help));
    }
    let whole = matches!(
        declaration.parameter_type,
        ParameterType::U32 | ParameterType::I32 | ParameterType::U32List
    );
    match value {
        Value::Number(number) => misfit(name, declaration, *number, whole),
        Value::List(list) => {
            let mut numbers = list.iter().filter_map(Value::number);
            let found = numbers.find_map(|number| misfit(name, declaration, number, whole));
            found.or_else(|| misplaced(name, declaration, list).map(|(_, misfit)| misfit))
        }
        Value::Text(word) if !declaration.values.contains(word) => {
            let help = format!("the words are {}", list_of(&declaration.values));
            Some((codes::SETTING_TYPE, format!("\"{name}\" is never \"{word}\""), help))
        }
        Value::Text(_) | Value::Bool(_) | Value::Reference(_) => None,
    }
}

/// The first element of a list that breaks the declared order, with its index; `None` if the list is in order.
pub(super) fn misplaced(
    name: &str,
    declaration: &ParameterDeclaration,
    numbers: &[Value],
) -> Option<(usize, Misfit)> {
    for (at, pair) in numbers.windows(2).enumerate() {
        let [Value::Number(before), Value::Number(after)] = pair else { continue };
        let (follows, word) = match declaration.order {
            Some(Order::StrictlyIncreasing) => (before < after, "increase"),
            Some(Order::StrictlyDecreasing) => (before > after, "decrease"),
            None => (true, ""),
        };
        if !follows {
            let message =
                format!("the elements of \"{name}\" must strictly {word}, but {after} follows {before}");
            let help = "sort the list and remove what appears twice".to_owned();
            return Some((at + 1, (codes::SETTING_ORDER, message, help)));
        }
    }
    None
}

/// The first rule of the declaration that a number or list element breaks; `None` if it breaks none.
pub(super) fn misfit(
    name: &str,
    declaration: &ParameterDeclaration,
    number: f64,
    whole: bool,
) -> Option<Misfit> {
    if !number.is_finite() {
        let message = format!("the parameter \"{name}\" is {number}");
        return Some((codes::SETTING_RANGE, message, "numbers are finite".to_owned()));
    }
    if whole && number.fract() != 0.0 {
        let message = format!("the parameter \"{name}\" takes whole numbers, not {number}");
        let help = format!("write {} or {}", number.floor(), number.ceil());
        return Some((codes::SETTING_TYPE, message, help));
    }
    let is_unsigned = matches!(declaration.parameter_type, ParameterType::U32 | ParameterType::U32List);
    let (lowest, highest) = match (whole, is_unsigned) {
        (true, true) => (Some(0.0), f64::from(u32::MAX)),
        (true, false) => (Some(f64::from(i32::MIN)), f64::from(i32::MAX)),
        (false, _) => (None, f64::from(f32::MAX)),
    };
    let low = declaration.min.or(lowest);
    let high = declaration.max.unwrap_or(highest);
    let limit = f64::from(f32::MAX);
    let (bound, value) = match (low.unwrap_or(-limit).max(-limit), high.min(limit)) {
        (min, _) if number < min => ("below its minimum", min),
        (_, max) if number > max => ("above its maximum", max),
        _ => return None,
    };
    let unit = declaration.unit.as_deref().filter(|unit| *unit != "1");
    let unit = unit.map(|unit| format!(" {unit}")).unwrap_or_default();
    let range = match low {
        Some(low) => format!("{low} to {high}{unit}"),
        None => format!("up to {high}{unit}"),
    };
    let message = format!("\"{name}\" is {number}, {bound} of {value}{unit}");
    Some((codes::SETTING_RANGE, message, format!("the range is {range}")))
}

/// Returns `true` if two values have the same type and, for lists, the same length and types of elements.
pub fn is_alike(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::List(a), Value::List(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_alike(a, b))
        }
        _ => std::mem::discriminant(a) == std::mem::discriminant(b),
    }
}
