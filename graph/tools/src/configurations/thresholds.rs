//! The values of a number at which expressions change.
//!
//! A condition such as `w > 1.0 && w < 2.0` divides the range of `w`; one value of each part, and the bounds
//! themselves, show everything that it can do. Each comparison that mentions the number is looked at as a function of
//! it alone, the other settings at their defaults: left side less right side, which changes its sign at a bound. The
//! root of its straight line through two points is one, and so is each change of sign between 64 points of the range,
//! by bisection. The literals of such an expression are tried as well.
//!
//! Limits: bounds that move with another setting are found for its default, and bounds that lie closer together than a
//! 64th of the range may be missed where the function is no straight line.

use std::collections::BTreeMap;

use umbragraph_pipeline::expression::{BinaryOperator, Expression, ExpressionKind, Value, evaluate};

/// The number of equal parts into which a range is divided to look for changes of sign.
const POINTS: usize = 64;
/// The maximum number of bounds (values at which an expression changes) that are kept for one number.
const MAX_BOUNDS: usize = 64;

/// A numeric parameter with its declared range, and the defaults of all settings.
pub(super) struct Number<'a> {
    pub(super) name: &'a str,
    pub(super) default: f64,
    pub(super) min: Option<f64>,
    pub(super) max: Option<f64>,
    pub(super) defaults: &'a BTreeMap<String, Value>,
}

impl Number<'_> {
    /// Returns a function from a setting's name to its value: `value` for this number, the default for all others.
    fn with(&self, value: f64) -> impl Fn(&str) -> Option<Value> {
        move |name: &str| {
            if name == self.name { Some(Value::Number(value)) } else { self.defaults.get(name).cloned() }
        }
    }

    /// The whole numbers on and next to each value at which `expressions` change, and the ends of the range. All lie
    /// within the range, in increasing order.
    pub(super) fn whole_values(&self, expressions: &[Expression]) -> Vec<f64> {
        let beside = |bound: f64| [bound.floor() - 1.0, bound.floor(), bound.ceil(), bound.ceil() + 1.0];
        let found = self.bounds(expressions).into_iter().flat_map(beside);
        self.within(found.collect())
    }

    /// The values at which `expressions` change, a value beyond the outermost ones, the ends of the range, and the
    /// midpoints between neighbours. All lie within the range, in increasing order.
    pub(super) fn real_values(&self, expressions: &[Expression]) -> Vec<f64> {
        let mut found = self.bounds(expressions);
        if found.is_empty() {
            return self.within(found);
        }
        let beyond = [found.first().map(|min| min - 1.0), found.last().map(|max| max + 1.0)];
        found.extend(beyond.into_iter().flatten());
        let found = self.within(found);
        let between = found.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0);
        let all = found.iter().copied().chain(between).collect();
        self.within(all)
    }

    /// Adds the ends of the range to `values`, and returns those within the range in increasing order, without
    /// duplicates.
    fn within(&self, mut values: Vec<f64>) -> Vec<f64> {
        values.extend([self.min, self.max].into_iter().flatten());
        values.retain(|value| {
            self.min.is_none_or(|min| *value >= min) && self.max.is_none_or(|max| *value <= max)
        });
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    }

    fn bounds(&self, expressions: &[Expression]) -> Vec<f64> {
        let mut found = Vec::new();
        for expression in expressions.iter().filter(|expression| mentions(expression, self.name)) {
            expression.visit(&mut |inner| match &inner.kind {
                ExpressionKind::Literal(Value::Number(number)) => found.push(*number),
                ExpressionKind::Binary(operator, left, right)
                    if is_comparison(*operator) && mentions(inner, self.name) =>
                {
                    self.roots(left, right, &mut found);
                }
                _ => {}
            });
        }
        found.retain(|bound| bound.is_finite());
        found.sort_by(f64::total_cmp);
        found.dedup();
        found.truncate(MAX_BOUNDS);
        found
    }

    /// Adds to `found` the values of the number at which two sides of a comparison are equal or change their order.
    fn roots(&self, left: &Expression, right: &Expression, found: &mut Vec<f64>) {
        let difference = |value: f64| {
            let scope = self.with(value);
            Some(evaluate(left, &scope).ok()?.number()? - evaluate(right, &scope).ok()?.number()?)
        };
        if let (Some(here), Some(next)) = (difference(self.default), difference(self.default + 1.0))
            && here != next
        {
            // Rounding must not move a bound that is a short decimal.
            let root = self.default - here / (next - here);
            found.push((root * 1e6).round() / 1e6);
        }
        let (Some(min), Some(max)) = (self.min, self.max) else { return };
        let at = |point: usize| min + (max - min) * (point as f64 / POINTS as f64);
        for point in 0..POINTS {
            let (mut low, mut high) = (at(point), at(point + 1));
            let (Some(below), Some(above)) = (difference(low), difference(high)) else { continue };
            if above == 0.0 {
                found.push(high);
                continue;
            }
            if below == 0.0 || below.signum() == above.signum() {
                continue;
            }
            for _ in 0..60 {
                let middle = f64::midpoint(low, high);
                match difference(middle) {
                    Some(value) if value != 0.0 && value.signum() == below.signum() => low = middle,
                    Some(value) if value != 0.0 => high = middle,
                    _ => {
                        high = middle;
                        break;
                    }
                }
            }
            found.push((high * 1e6).round() / 1e6);
        }
    }
}

fn is_comparison(operator: BinaryOperator) -> bool {
    use BinaryOperator as B;
    matches!(operator, B::Equal | B::NotEqual | B::Less | B::LessEqual | B::Greater | B::GreaterEqual)
}

/// Returns `true` if an expression contains a name, or a member of it (`NAME.MEMBER`).
pub(super) fn mentions(expression: &Expression, name: &str) -> bool {
    let mut found = false;
    expression.visit(&mut |inner| {
        if let ExpressionKind::Name(other) = &inner.kind {
            found |= other == name || other.split('.').next() == Some(name);
        }
    });
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbragraph_pipeline::expression::parse;

    #[test]
    fn a_value_of_every_part_of_the_range_and_every_bound_is_found() {
        let defaults: BTreeMap<String, Value> =
            [("x".to_owned(), Value::Number(1.0)), ("other".to_owned(), Value::Number(7.0))].into();
        let number =
            Number { name: "x", default: 1.0, min: Some(0.0), max: Some(1000.0), defaults: &defaults };
        for (condition, shown) in [
            ("x == 23", &[22.0, 23.0, 24.0][..]),
            ("x * 2 + 1 > 47", &[23.0, 24.0]),
            ("x > 100 && x < 102", &[100.0, 101.0, 102.0]),
            ("x * x >= 200", &[14.0, 15.0]),
            ("floor(x / 10) == 3", &[]),
            ("x < other ? x == 5 : x > 900", &[4.0, 5.0, 6.0, 7.0, 8.0, 900.0, 901.0]),
        ] {
            let expressions = [parse(condition).unwrap()];
            let whole = number.whole_values(&expressions);
            for value in shown {
                assert!(whole.contains(value), "{condition}: {value} is not in {whole:?}");
            }
            assert!(whole.iter().all(|value| value.fract() == 0.0 && (0.0..=1000.0).contains(value)));
            // Both outcomes are shown by whole numbers and by real ones.
            for values in [whole, number.real_values(&expressions)] {
                let outcome = |value: f64| evaluate(&expressions[0], &number.with(value)).unwrap();
                let holds = |wanted| values.iter().any(|value| outcome(*value) == Value::Bool(wanted));
                assert!(holds(true) && holds(false), "{condition}: {values:?}");
            }
        }
        assert_eq!(number.real_values(&[parse("y > 3").unwrap()]), [0.0, 1000.0]);
    }
}
