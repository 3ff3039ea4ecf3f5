//! The values that an axis may still have.

use super::axis::AxisKind;
use umbragraph_text::diagnostic::AxisValue;

/// The values that an axis can have within a space of axis values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Domain {
    /// All integers of a range, both ends included.
    Range(i64, i64),
    /// An explicit list of values, in order.
    Values(Vec<AxisValue>),
}

impl Domain {
    /// Returns the domain of all values that the type of an axis allows.
    pub(crate) fn of(kind: &AxisKind) -> Self {
        match kind {
            AxisKind::Bool => Self::Values(vec![false.into(), true.into()]),
            AxisKind::Enum(names) | AxisKind::TextureFormat(names) => {
                Self::Values(names.iter().cloned().map(AxisValue::Name).collect())
            }
            AxisKind::Integer { min, max } => Self::Range(*min, *max),
        }
    }

    pub(crate) fn count(&self) -> u64 {
        match self {
            Domain::Range(min, max) if min > max => 0,
            Domain::Range(min, max) => max.abs_diff(*min).saturating_add(1),
            Domain::Values(values) => values.len() as u64,
        }
    }

    pub(crate) fn value(&self, index: u64) -> Option<AxisValue> {
        match self {
            Domain::Range(min, max) => {
                min.checked_add_unsigned(index).filter(|value| value <= max).map(AxisValue::Integer)
            }
            Domain::Values(values) => values.get(usize::try_from(index).ok()?).cloned(),
        }
    }

    pub(super) fn contains(&self, value: &AxisValue) -> bool {
        match (self, value) {
            (Domain::Range(min, max), AxisValue::Integer(value)) => (min..=max).contains(&value),
            (Domain::Range(..), _) => false,
            (Domain::Values(values), value) => values.contains(value),
        }
    }
}
