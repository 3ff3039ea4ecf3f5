//! Parameters as coordinates between 0 and 1, in which an optimiser searches.
//!
//! | type | coordinate |
//! |---|---|
//! | number | linear over its range; where that spans two decades or more, logarithmic; from 0 on, `(e^(k·u) − 1) / (e^k − 1)` of the range with k = ln 10⁴, so that four decades and 0 are reached |
//! | whole number | the same, rounded |
//! | boolean | true from 0.5 on |
//! | list | one for each element; where elements have an order, they are put in it |
//!
//! Numbers are rounded to three digits, so that what is written is what was scored. Coordinates beyond the ends are
//! mirrored at them.

use crate::codes;
use umbragraph::diagnostic::{Diagnostic, list_of};
use umbragraph::low_level::expression::Value;
use umbragraph::low_level::language::{Order, ParameterDeclaration, ParameterType};
use umbragraph::low_level::pipeline::TypedPipeline;
use umbragraph::low_level::source::Span;

/// A value of `--over`: a parameter's name, and optionally a narrower range.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Over {
    pub(crate) name: String,
    pub(crate) range: Option<[f64; 2]>,
}

impl Over {
    /// Parses `NAME`, or `NAME=MIN..MAX`.
    ///
    /// # Errors
    /// An invalid range.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let Some((name, range)) = text.split_once('=') else {
            return Ok(Self { name: text.to_owned(), range: None });
        };
        let ends = range.split_once("..").and_then(|(min, max)| {
            let [min, max] = [min, max].map(|end| end.parse::<f64>().ok().filter(|end| end.is_finite()));
            min.zip(max).filter(|(min, max)| min < max)
        });
        match ends {
            Some((min, max)) => Ok(Self { name: name.to_owned(), range: Some([min, max]) }),
            None => Err(format!("\"{range}\" is no range: write NAME=MIN..MAX, such as far=1..100")),
        }
    }
}

/// The ratio of the largest to the smallest value between which the scale of a range from 0 is roughly logarithmic.
const DECADES: f64 = 1e4;

/// The mapping of a coordinate from 0 to 1 to a value in the range.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Scale {
    Linear,
    Logarithmic,
    /// Roughly logarithmic, for ranges that begin at 0.
    Warped,
}

/// A parameter whose value is searched.
#[derive(Clone, Debug)]
pub(crate) struct Tuned {
    pub(crate) name: String,
    /// The value at the start of the search.
    pub(crate) start: Value,
    is_bool: bool,
    whole: bool,
    order: Option<Order>,
    range: [f64; 2],
    scale: Scale,
}

impl Tuned {
    /// Creates the search range of a parameter. `place` is the source place of its name on the command line.
    ///
    /// # Errors
    /// An unknown parameter, or one without an order or a range.
    pub(crate) fn of(over: &Over, pipeline: &TypedPipeline, place: Span) -> Result<Self, Diagnostic> {
        let error = |message: String| Diagnostic::error(codes::TUNE, place, message);
        let name = &over.name;
        let Some(parameter) = pipeline.parameters.get(name) else {
            if pipeline.features.contains_key(name) {
                let help = format!("give it a value with --feature {name}=…, and tune once for each");
                return Err(error(format!("\"{name}\" is a feature, not a parameter")).help(help));
            }
            let known = pipeline.parameters.keys().map(String::as_str);
            let written = Some(place.inside(0..name.len()));
            return Err(error(format!("there is no parameter \"{name}\"")).suggest(
                name,
                known,
                written,
                |names| format!("the parameters are {}", list_of(names)),
            ));
        };
        let ParameterDeclaration { parameter_type, min, max, order, .. } = &parameter.declaration;
        let whole =
            matches!(parameter_type, ParameterType::U32 | ParameterType::I32 | ParameterType::U32List);
        let is_bool = *parameter_type == ParameterType::Bool;
        if *parameter_type == ParameterType::Enum {
            let words = list_of(&parameter.declaration.values);
            let help = format!(
                "its words ({words}) have no order: give it one with --set {name}=…, and tune once for each"
            );
            return Err(error(format!("the parameter \"{name}\" is an enumeration")).help(help));
        }
        let [low, high] = over.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let range = match (is_bool, min, max) {
            (true, ..) => [0.0, 1.0],
            (false, Some(min), Some(max)) => [min.max(low), max.min(high)],
            (false, ..) if over.range.is_some() => {
                [min.unwrap_or(low).max(low), max.unwrap_or(high).min(high)]
            }
            _ => {
                let message = format!("the parameter \"{name}\" has no range");
                return Err(error(message).help(format!("say one: --over {name}=MIN..MAX")));
            }
        };
        if range[0] >= range[1] {
            let message = format!("the range of \"{name}\" holds {} at most", count(range));
            return Err(error(message).help(format!("the parameter takes {} to {}", show(*min), show(*max))));
        }
        let scale = match range {
            [min, max] if min > 0.0 && max / min >= 100.0 => Scale::Logarithmic,
            [0.0, max] if !(is_bool || whole && max < 100.0) => Scale::Warped,
            _ => Scale::Linear,
        };
        let tuned = Self {
            name: name.clone(),
            start: parameter.value.clone(),
            is_bool,
            whole,
            order: *order,
            range,
            scale,
        };
        if tuned.width() == 0 {
            return Err(error(format!("the list \"{name}\" has no elements")).help("give it some with --set"));
        }
        Ok(tuned)
    }

    /// Returns the number of search coordinates, one for each number of the value.
    pub(crate) fn width(&self) -> usize {
        match &self.start {
            Value::List(list) => list.len(),
            _ => 1,
        }
    }

    /// Returns the coordinates of a value, each from 0 to 1.
    pub(crate) fn coordinates(&self, value: &Value) -> Vec<f64> {
        let of = |value: &Value| match value {
            Value::Bool(on) => 0.25 + 0.5 * f64::from(*on),
            value => self.coordinate(value.number().unwrap_or(self.range[0])),
        };
        match value {
            Value::List(list) => list.iter().map(of).collect(),
            value => vec![of(value)],
        }
    }

    /// Returns the value at the given coordinates.
    pub(crate) fn value(&self, coordinates: &[f64]) -> Value {
        if self.is_bool {
            return Value::Bool(coordinates.first().is_some_and(|at| mirrored(*at) >= 0.5));
        }
        let mut numbers: Vec<f64> = coordinates.iter().map(|at| self.number(mirrored(*at))).collect();
        if let Some(order) = self.order {
            self.arrange(&mut numbers, order);
        }
        match &self.start {
            Value::List(_) => Value::List(numbers.into_iter().map(Value::Number).collect()),
            _ => Value::Number(numbers.first().copied().unwrap_or_default()),
        }
    }

    fn coordinate(&self, number: f64) -> f64 {
        let [min, max] = self.range;
        let number = number.clamp(min, max);
        let part = (number - min) / (max - min);
        match self.scale {
            Scale::Linear => part,
            Scale::Logarithmic => (number / min).ln() / (max / min).ln(),
            Scale::Warped => (part * (DECADES - 1.0)).ln_1p() / DECADES.ln(),
        }
    }

    fn number(&self, at: f64) -> f64 {
        let [min, max] = self.range;
        let number = match self.scale {
            Scale::Linear => min + (max - min) * at,
            Scale::Logarithmic => min * (max / min).powf(at),
            Scale::Warped => max * (at * DECADES.ln()).exp_m1() / (DECADES - 1.0),
        };
        let number = if self.whole { number.round() } else { rounded(number) };
        number.clamp(if self.whole { min.ceil() } else { min }, if self.whole { max.floor() } else { max })
    }

    /// Sorts numbers as the parameter requires, each strictly beyond the previous one.
    fn arrange(&self, numbers: &mut [f64], order: Order) {
        numbers.sort_by(f64::total_cmp);
        let step = |number: f64| {
            if self.whole { number + 1.0 } else { rounded(number.abs().max(1e-6) * 0.01) + number }
        };
        for at in 1..numbers.len() {
            if numbers[at] <= numbers[at - 1] {
                numbers[at] = if self.whole { step(numbers[at - 1]) } else { rounded(step(numbers[at - 1])) };
            }
        }
        if order == Order::StrictlyDecreasing {
            numbers.reverse();
        }
    }
}

/// Rounds to three significant digits.
fn rounded(number: f64) -> f64 {
    format!("{number:.2e}").parse().unwrap_or(number)
}

/// Reflects a coordinate into the range from 0 to 1; 0.5 if it is not finite.
fn mirrored(at: f64) -> f64 {
    if !at.is_finite() {
        return 0.5;
    }
    let at = at.rem_euclid(2.0);
    if at <= 1.0 { at } else { 2.0 - at }
}

fn count([min, max]: [f64; 2]) -> &'static str {
    if min == max { "one value" } else { "no value" }
}

fn show(end: Option<f64>) -> String {
    end.map_or_else(|| "any".to_owned(), |end| end.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tuned(range: [f64; 2], scale: Scale, start: Value) -> Tuned {
        Tuned { name: "one".to_owned(), start, is_bool: false, whole: false, order: None, range, scale }
    }

    #[test]
    fn what_a_value_is_encoded_as_gives_it_again() {
        for (range, scale) in
            [([-2.0, 3.0], Scale::Linear), ([0.1, 1e5], Scale::Logarithmic), ([0.0, 0.1], Scale::Warped)]
        {
            for number in [range[0], range[1], 0.005_f64.clamp(range[0], range[1]), 0.0_f64.max(range[0])] {
                let one = tuned(range, scale, Value::Number(number));
                let Value::Number(again) = one.value(&one.coordinates(&one.start)) else {
                    panic!("a number")
                };
                assert!((again - number).abs() <= 0.006 * number.abs(), "{number} {again} {scale:?}");
            }
        }
        let warped = tuned([0.0, 0.1], Scale::Warped, Value::Number(0.0));
        assert!(matches!(warped.value(&[0.25]), Value::Number(number) if (5e-5..2e-4).contains(&number)));
    }

    #[test]
    fn lists_are_put_in_their_order_and_stay_in_range() {
        let list = Value::List(vec![Value::Number(1.0); 3]);
        let one =
            Tuned { order: Some(Order::StrictlyIncreasing), ..tuned([0.1, 1e5], Scale::Logarithmic, list) };
        for coordinates in [[0.9, 0.1, 0.5], [0.4, 0.4, 0.4], [-0.2, 1.3, 7.1]] {
            let numbers = one.value(&coordinates).numbers().unwrap();
            assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]), "{numbers:?}");
            assert!(numbers.iter().all(|number| (0.1..=1e5).contains(number)), "{numbers:?}");
        }
        let whole = Tuned { whole: true, ..tuned([1.0, 64.0], Scale::Linear, Value::Number(8.0)) };
        assert_eq!(whole.value(&[0.34]), Value::Number(22.0));
    }

    #[test]
    fn ranges_are_read_and_others_are_rejected() {
        assert_eq!(Over::parse("far=1..100").unwrap().range, Some([1.0, 100.0]));
        assert_eq!(Over::parse("far").unwrap(), Over { name: "far".to_owned(), range: None });
        for wrong in ["far=1", "far=2..1", "far=..", "far=1..inf"] {
            assert!(Over::parse(wrong).is_err(), "{wrong}");
        }
    }
}
