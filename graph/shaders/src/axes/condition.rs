//! Conditions on one axis, as constraints write them: `sscs`, `!sscs`, `filter=evsm`, `filter!=evsm`.
//!
//! A bare name is true where a boolean axis is; the other forms compare with a value of the axis. A value is read as
//! the kind of its axis wants it, so `taps=16` is an integer and `filter=16` a name.

use std::fmt;

use super::axis::{Axis, AxisKind};
use umbragraph_text::diagnostic::{AxisValue, AxisValues};

/// A condition on one axis.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Condition {
    /// The axis.
    pub axis: String,
    /// The value that is compared with.
    pub value: AxisValue,
    /// Whether the axis has to have the value, or must not.
    pub equal: bool,
}

impl Condition {
    /// Splits a condition into the name of its axis, the text of its value (none for a bare name) and whether it wants
    /// equality.
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

    /// Reads a condition on a known axis.
    ///
    /// # Errors
    /// The error in words.
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

    /// Whether the condition holds. An axis without a value makes it false.
    pub fn holds(&self, values: &AxisValues) -> bool {
        values.get(&self.axis).is_some_and(|value| self.accepts(value))
    }

    /// Whether the condition holds for a value of its axis.
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

/// Reads the text of a value as the kind of an axis wants it.
pub(crate) fn parse_value(text: &str, kind: &AxisKind) -> Option<AxisValue> {
    let value = match kind {
        AxisKind::Bool => AxisValue::Bool(text.parse().ok()?),
        AxisKind::Integer { .. } => AxisValue::Integer(text.parse().ok()?),
        AxisKind::Enum(_) | AxisKind::TextureFormat(_) => AxisValue::Name(text.to_owned()),
    };
    kind.contains(&value).then_some(value)
}
