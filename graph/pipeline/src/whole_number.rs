//! Whole numbers among the values of expressions.

use std::ops::RangeInclusive;

use umbragraph_text::expression::Value;

/// Returns the value as a whole number; `None` if it is not a number, has a fraction or lies outside of the range.
pub fn whole_number(value: &Value, range: RangeInclusive<u32>) -> Option<u32> {
    let number = value.number().filter(|number| number.fract() == 0.0)?;
    (f64::from(*range.start())..=f64::from(*range.end())).contains(&number).then_some(number as u32)
}
