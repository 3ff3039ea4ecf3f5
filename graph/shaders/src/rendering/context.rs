//! Values of axes as the template engine sees them.

use minijinja::value::Value;

use umbragraph_text::diagnostic::{AxisValue, AxisValues};

/// Creates a minijinja context that contains only these axis values.
pub(crate) fn fixed_context(values: &AxisValues) -> Value {
    Value::from_pairs(values.iter().map(|(name, value)| (name.as_str(), to_template_value(value))))
}

/// Converts an axis value to a minijinja value.
pub(crate) fn to_template_value(value: &AxisValue) -> Value {
    match value {
        AxisValue::Bool(value) => Value::from(*value),
        AxisValue::Integer(value) => Value::from(*value),
        AxisValue::Name(name) => Value::from(name.as_str()),
    }
}
