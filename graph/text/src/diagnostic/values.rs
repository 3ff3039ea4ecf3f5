//! Values of axes.
//!
//! An axis is what a template may vary in. Its value is a boolean, an integer, or a name: a member of an enumeration or
//! a texture format. In JSON the three are the three plain types, so a configuration reads
//! `{ "sscs": true, "taps": 16, "filter": "pcss" }`.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// The value of one axis, that is, of one variation parameter of a shader template.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(untagged)]
pub enum AxisValue {
    /// A value of a boolean axis.
    Bool(bool),
    /// A value of an integer axis.
    Integer(i64),
    /// A member of an enumeration, or the name of a texture format.
    Name(String),
}

/// Values of the axes (variation parameters) of a shader template, by the names of the axes.
pub type AxisValues = BTreeMap<String, AxisValue>;

impl fmt::Display for AxisValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AxisValue::Bool(value) => value.fmt(f),
            AxisValue::Integer(value) => value.fmt(f),
            AxisValue::Name(name) => f.write_str(name),
        }
    }
}

impl From<bool> for AxisValue {
    fn from(value: bool) -> Self {
        AxisValue::Bool(value)
    }
}

impl From<i64> for AxisValue {
    fn from(value: i64) -> Self {
        AxisValue::Integer(value)
    }
}

impl From<&str> for AxisValue {
    fn from(name: &str) -> Self {
        AxisValue::Name(name.to_owned())
    }
}

/// Returns the values of those axes for whose names `is_wanted` returns `true`.
pub fn select_axes(values: &AxisValues, is_wanted: impl Fn(&str) -> bool) -> AxisValues {
    let wanted = values.iter().filter(|(name, _)| is_wanted(name));
    wanted.map(|(name, value)| (name.clone(), value.clone())).collect()
}

/// Returns the values as one line sorted by name, such as `a=true, b=pcss`; `no axes` if there are none.
pub fn describe(values: &AxisValues) -> String {
    if values.is_empty() {
        return "no axes".to_owned();
    }
    let pairs: Vec<String> = values.iter().map(|(name, value)| format!("{name}={value}")).collect();
    pairs.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_the_plain_types_of_json() {
        let json = r#"{"filter":"pcss","sscs":true,"taps":16}"#;
        let values: AxisValues = serde_json::from_str(json).unwrap();
        assert_eq!(values["taps"], AxisValue::Integer(16));
        assert_eq!(serde_json::to_string(&values).unwrap(), json);
        assert_eq!(describe(&values), "filter=pcss, sscs=true, taps=16");
        assert!(serde_json::from_str::<AxisValue>("1.5").is_err());
        assert!(serde_json::from_str::<AxisValue>("18446744073709551615").is_err());
    }
}
