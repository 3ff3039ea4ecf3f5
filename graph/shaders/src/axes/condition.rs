//! Conditions on one axis, as constraints write them: `sscs`, `!sscs`, `filter=evsm`, `filter!=evsm`.
//!
//! A bare name is true where a boolean axis is; the other forms compare with a value of the axis. A value is read as
//! the kind of its axis wants it, so `taps=16` is an integer and `filter=16` a name.

use std::fmt;

use super::axis::{Axis, AxisKind};
use umbragraph_text::diagnostic::{AxisValue, AxisValues};

/// A condition of a constraint: an axis has, or does not have, a certain value.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Condition {
    /// The name of the axis.
    pub axis: String,
    /// The value that the axis is compared with.
    pub value: AxisValue,
    /// `true` if the axis must have the value, `false` if it must have any other.
    pub equal: bool,
}

impl Condition {
    /// Splits a condition into three parts: the axis's name, the value (`None` for a bare name), and whether equality
    /// is required.
    pub(super) fn split(text: &str) -> (&str, Option<&str>, bool) {
        if let Some((name, value)) = text.split_once("!=") {
            return (name.trim(), Some(value.trim()), false);
        }
        if let Some((name, value)) = text.split_once('=') {
            return (name.trim(), Some(value.trim()), true);
        }
        match text.trim().strip_prefix('!') {
            Some(name) => (name.trim(), None, false),
            None => (text.trim(), None, true),
        }
    }

    /// Parses a condition on a known axis.
    ///
    /// # Errors
    /// A message if the value does not fit the axis, or if a non-boolean axis is compared with no value.
    pub(super) fn read(text: &str, axis: &Axis) -> Result<Self, String> {
        let (_, value, equal) = Self::split(text);
        let value = match (value, &axis.kind) {
            (None, AxisKind::Bool) => AxisValue::Bool(true),
            (None, kind) => {
                return Err(format!(
                    "\"{}\" is no boolean axis: compare it with a value ({})",
                    axis.name,
                    kind.describe()
                ));
            }
            (Some(value), kind) => parse_value(value, kind).ok_or_else(|| {
                format!("\"{value}\" is no value of \"{}\" ({})", axis.name, kind.describe())
            })?,
        };
        Ok(Self { axis: axis.name.clone(), value, equal })
    }

    /// Returns `true` if the condition holds for these axis values, and `false` if they contain no value for the axis.
    pub fn holds(&self, values: &AxisValues) -> bool {
        values.get(&self.axis).is_some_and(|value| self.accepts(value))
    }

    /// Returns `true` if the condition holds when the axis has this value.
    pub fn accepts(&self, value: &AxisValue) -> bool {
        (*value == self.value) == self.equal
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (&self.value, self.equal) {
            (AxisValue::Bool(value), equal) if *value == equal => f.write_str(&self.axis),
            (AxisValue::Bool(_), _) => write!(f, "!{}", self.axis),
            (value, true) => write!(f, "{}={value}", self.axis),
            (value, false) => write!(f, "{}!={value}", self.axis),
        }
    }
}

/// Parses a value according to the type of its axis; `None` if the axis does not allow the value.
pub(crate) fn parse_value(text: &str, kind: &AxisKind) -> Option<AxisValue> {
    let value = match kind {
        AxisKind::Bool => AxisValue::Bool(text.parse().ok()?),
        AxisKind::Integer { .. } => AxisValue::Integer(text.parse().ok()?),
        AxisKind::Enum(_) | AxisKind::TextureFormat(_) => AxisValue::Name(text.to_owned()),
    };
    kind.contains(&value).then_some(value)
}
